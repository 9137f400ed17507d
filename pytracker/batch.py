"""Many recordings, one after the other or side by side: each leaves a folder of its own, and one page leads to all.

A recording that fails stops no other: its row says why.
"""

from __future__ import annotations

import itertools
import multiprocessing
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from pytracker._core import InputError, TrackingError
from pytracker.doubting.doubts import is_unusable, unbelieved
from pytracker.methods.method import Method
from pytracker.outcomes import Outcome, check_index, read_outcomes, run_of, table_of
from pytracker.output import MADE_HERE, check_target, write_whole
from pytracker.recording.load import load
from pytracker.recording.recording import Recording
from pytracker.report.files.metadata import read_run
from pytracker.report.page import filled
from pytracker.report.write import write_report
from pytracker.scores.agreement import against_truth
from pytracker.scores.evaluate import evaluate
from pytracker.tracking.track import track
from pytracker.tracking.tracks import Track

__all__ = ["track_all"]


@dataclass(frozen=True)
class _Task:
    """One recording and what to do with it; sent to another process.

    Attributes:
        folder: of the recording.
        out: where all results are.
        name: of its own there.
        method_of: gives the method.
        seed: of the random streams.
        page: whether a page is drawn.
        force: whether what is there is replaced.
        threads: at most so many; None for all.
        earlier: what an earlier run found.
    """

    folder: Path
    out: Path
    name: str
    method_of: Callable[[Recording], Method]
    seed: int
    page: bool
    force: bool
    threads: int | None
    earlier: Outcome | None


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
    """Track every recording into `out`/<its name>, `jobs` at a time, and write `out`/index.html and index.csv.

    `method_of` gives the method for a recording (it is sent to other processes). `done` is called with each
    outcome as it comes, in the order of `folders`. What an earlier run left of a recording stays as it is without
    `force` (and has failed where it is of other files, another method or another seed), and what it left of others
    stays in the table. Raises `InputError` where `out` holds an index of something else.
    """
    check_index(out, force=force)
    out.mkdir(parents=True, exist_ok=True)
    folders = list({folder.resolve(): folder for folder in folders}.values())
    earlier, threads = read_outcomes(out), None if jobs == 1 else 1
    known = {folder: replace(found, recording=folder) for folder, found in _of(folders, earlier)}
    tasks = [
        _Task(folder, out, name, method_of, seed, page, force, threads, known.get(folder))
        for folder, name in zip(folders, _names(folders, earlier), strict=True)
    ]
    outcomes: list[Outcome] = []
    with closing(_all_done(tasks, jobs)) as found:
        for outcome in found:
            outcomes.append(outcome)
            _write_tables(out, outcomes, earlier)
            if done is not None:
                done(outcome)
    return outcomes


def _write_tables(out: Path, outcomes: Sequence[Outcome], earlier: Mapping[Path, Outcome]) -> None:
    """Of what is done so far, and what an earlier run left of others: whoever stops it loses none of it."""
    results, places = {one.result for one in outcomes}, {one.recording.resolve() for one in outcomes}
    others = [one for where, one in earlier.items() if where not in places and one.result not in results]
    listed = [*outcomes, *others]
    write_whole(out / "index.csv", table_of(listed, out))
    write_whole(out / "index.html", filled("batch.html", title="Recordings", outcomes=listed))


def _of(folders: Sequence[Path], earlier: Mapping[Path, Outcome]) -> Iterator[tuple[Path, Outcome]]:
    return ((folder, earlier[folder.resolve()]) for folder in folders if folder.resolve() in earlier)


@contextmanager
def _workers(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that do the work. Whoever stops it does not wait for the recordings in flight."""
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.terminate()
            raise


def _all_done(tasks: Sequence[_Task], jobs: int) -> Generator[Outcome]:
    """What became of each, in their order. A process that is killed, such as for its memory, stops no other.

    All that are at work end with it: of them the first is done by itself, and the others anew.
    """
    left = list(tasks)
    while left:
        with _workers(jobs) as pool, suppress(BrokenProcessPool):
            for future in [pool.submit(_one, task) for task in left]:
                outcome = future.result()
                left.pop(0)
                yield outcome
        if left:
            yield _alone(left.pop(0))


def _alone(task: _Task) -> Outcome:
    """Of one whose process was killed, or another's beside it: once more, by itself."""
    with _workers(1) as pool:
        try:
            return pool.submit(_one, task).result()
        except BrokenProcessPool:
            words = "its process was killed, or did not start: is there too little memory for it?"
            return _failed(task, words)


def _failed(task: _Task, why: str) -> Outcome:
    """Without a new result; what an earlier run found of it stays."""
    if task.earlier is not None:
        return replace(task.earlier, stale=f"{why}; {task.name} holds what an earlier run found")
    left = (f"{task.name} holds what an earlier run found",) if _is_result(task.out / task.name) else ()
    return Outcome(task.folder, said=(why, *left), failed=True)


def _names(folders: Sequence[Path], earlier: Mapping[Path, Outcome]) -> list[str]:
    """That of an earlier result of theirs, else the folders' own, numbered where something else has them."""
    names = {folder: found.result for folder, found in _of(folders, earlier)}
    taken = {one.result for one in earlier.values()}
    for folder in folders:
        if folder not in names:
            own = folder.resolve().name or "recording"
            numbered = (f"{own}-{number}" for number in itertools.count(2))
            names[folder] = next(name for name in itertools.chain([own], numbered) if name not in taken)
            taken.add(names[folder])
    return [names[folder] for folder in folders]


def _one(task: _Task) -> Outcome:
    folder, out, name = task.folder, task.out, task.name
    try:
        if task.earlier is None:
            check_target(out / name, force=task.force)  # before the work, not after it
        recording = load(folder)
        method = task.method_of(recording)
        run = run_of(method, task.seed)
        if task.earlier is not None and not task.force:
            return _as_it_was(task.earlier, out / name, recording, run)
        try:
            result: Track = track(recording, method, task.seed, threads=task.threads)
        except TrackingError as error:
            if error.track is None:
                raise
            result = error.track
        write_report([result], out / name, force=task.force, page=task.page)
    except (InputError, TrackingError, OSError, MemoryError) as error:
        return _failed(task, str(error) or type(error).__name__)
    doubts = (*result.doubts, *against_truth(result, recording.truth))
    said = (*((result.lost,) if result.lost else ()), *unbelieved(result), *recording.warnings, *doubts)
    failed = bool(result.lost) or is_unusable(result)
    return Outcome(folder, name, len(result.valid), float(result.valid.mean()), _error_m(result), said, failed, run)


def _is_result(folder: Path) -> bool:
    return (folder / MADE_HERE).is_file() and not (folder / "recording.toml").exists()


def _as_it_was(earlier: Outcome, result: Path, recording: Recording, run: str) -> Outcome:
    """What an earlier run found, unless it was another run than this one would be."""
    try:
        read_run(result, recording)
        why = "by another method, other settings or another seed" if earlier.run not in ("", run) else ""
    except InputError as error:
        why = str(error)
    return replace(earlier, stale=f"{why}; --force does it again" if why else "")


def _error_m(result: Track) -> float | None:
    try:
        return evaluate(result, result.recording.truth).figure_m(result.judged_by)
    except InputError:
        return None
