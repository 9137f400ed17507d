"""Many recordings, one after the other or side by side: each leaves a folder of its own, and one page leads to all.

A recording that fails stops no other: its row says why.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

from pytracker._core import InputError, TrackingError
from pytracker.methods.method import Method
from pytracker.outcomes import Outcome, read_outcomes, table_of
from pytracker.output import write_whole
from pytracker.recording.load import load
from pytracker.recording.recording import Recording
from pytracker.report.page import filled
from pytracker.report.write import write_report
from pytracker.scores.agreement import disagreement
from pytracker.scores.evaluate import evaluate
from pytracker.tracking.doubts import is_unusable, unbelieved
from pytracker.tracking.track import track
from pytracker.tracking.tracks import Track

__all__ = ["track_all"]


def track_all(
    folders: Sequence[Path],
    out: Path,
    method_of: Callable[[Recording], Method],
    *,
    seed: int = 0,
    page: bool = True,
    force: bool = False,
    jobs: int = 1,
    done: Callable[[Outcome], None] | None = None,
) -> list[Outcome]:
    """Track every recording into `out`/<its name>, `jobs` at a time, then write `out`/index.html and index.csv.

    `method_of` gives the method for a recording (it is sent to other processes). `done` is called with each
    outcome as it comes, in the order of `folders`. What an earlier run left of a recording stays as it is without
    `force`, and what it left of others stays in the table.
    """
    out.mkdir(parents=True, exist_ok=True)
    names, earlier = _names(folders), read_outcomes(out)
    known = {} if force else {folder: folder.resolve() for folder in folders if folder.resolve() in earlier}
    stays = {folder: replace(earlier[where], recording=folder) for folder, where in known.items()}
    outcomes = []
    threads = None if jobs == 1 else 1
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        tasks = [
            stays.get(folder) or pool.submit(_one, folder, out, name, method_of, seed, page, force, threads)
            for folder, name in zip(folders, names, strict=True)
        ]
        try:
            for task in tasks:
                outcomes.append(task if isinstance(task, Outcome) else task.result())
                if done is not None:
                    done(outcomes[-1])
        except BaseException:
            # Whoever stops it does not wait for the recordings in flight.
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.terminate()
            raise
    results, places = {one.result for one in outcomes}, {folder.resolve() for folder in folders}
    others = [one for where, one in earlier.items() if where not in places and one.result not in results]
    listed = [*outcomes, *others]
    write_whole(out / "index.csv", table_of(listed, out))
    write_whole(out / "index.html", filled("batch.html", title="Recordings", outcomes=listed))
    return outcomes


def _names(folders: Sequence[Path]) -> list[str]:
    """The folders' own names, numbered where two are alike."""
    names: list[str] = []
    for folder in folders:
        name = folder.resolve().name or "recording"
        alike = sum(other == name or other.startswith(f"{name}-") for other in names)
        names.append(f"{name}-{alike + 1}" if name in names else name)
    return names


def _one(
    folder: Path,
    out: Path,
    name: str,
    method_of: Callable[[Recording], Method],
    seed: int,
    page: bool,
    force: bool,
    threads: int | None,
) -> Outcome:
    try:
        recording = load(folder)
        try:
            result: Track = track(recording, method_of(recording), seed, threads=threads)
        except TrackingError as error:
            if error.track is None:
                raise
            result = error.track
        write_report([result], out / name, force=force, page=page)
    except (InputError, TrackingError, OSError, MemoryError) as error:
        left = (f"{name} holds what an earlier run found",) if (out / name).is_dir() else ()
        return Outcome(folder, said=(str(error) or type(error).__name__, *left), failed=True)
    doubts = (*result.doubts, *disagreement(result, recording.truth))
    said = (*((result.lost,) if result.lost else ()), *unbelieved(result), *recording.warnings, *doubts)
    failed = bool(result.lost) or is_unusable(result)
    return Outcome(folder, name, len(result.valid), float(result.valid.mean()), _error_m(result), said, failed)


def _error_m(result: Track) -> float | None:
    try:
        return evaluate(result, result.recording.truth).figure_m(result.judged_by)
    except InputError:
        return None
