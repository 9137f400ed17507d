"""`run_study(study, out)`: what is not done yet is run, then the table is written."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pytracker._core import __version__
from pytracker.digest import sha256_of
from pytracker.formats.video import OPENCV
from pytracker.study.plan import Study
from pytracker.study.schedule import on_dask, on_threads
from pytracker.study.store import Store, StudyTable, make_table

__all__ = ["fingerprint", "run_study"]

StudyProgress = Callable[[int, int], None]
"""Called with (runs done, runs in all)."""

NO_NUMBERS = ("report", "reproduce", "cli.py", "__main__.py")
"""Parts of the package that change no result."""


@functools.cache
def fingerprint() -> str:
    """What computes the numbers: every file of the package that has a part in them, NumPy and OpenCV."""
    root = Path(__file__).parents[1]
    found = hashlib.sha256(f"{__version__} {np.__version__} {OPENCV}".encode())
    for path in sorted([*root.rglob("*.py"), *root.glob("_core*")]):
        name = path.relative_to(root)
        if name.parts[0] not in NO_NUMBERS and path.suffix in (".py", ".so", ".pyd", ".dylib"):
            found.update(f"{name.as_posix()} {sha256_of(path)}\n".encode())
    return found.hexdigest()


def run_study(
    study: Study,
    out: Path | str,
    *,
    scheduler: str = "",
    workers: int | None = None,
    parquet: bool = False,
    progress: StudyProgress | None = None,
) -> StudyTable:
    """Run what is not done, keep each result at once, write `<out>/table.csv`; returns the table.

    What was done before, by the same build on the same recordings, is not done again; a killed study loses the runs
    in flight. A run that fails is in the table with its error, and is tried again the next time. On `workers` threads
    here, or on the Dask cluster at `scheduler`: the table is the same to the byte. `parquet` writes `table.parquet`
    besides.

    Raises `InputError` where `out` is something else, or what is asked for is not installed.
    """
    out = Path(out)
    store = Store(out)
    runs = list(study.runs(fingerprint()))
    results = {run.key: known for run in runs if (known := store.load(run)) is not None}
    # The same content twice, under two names, is one run.
    waiting = list({run.key: run for run in runs if run.key not in results}.values())
    total = len(results) + len(waiting)
    if progress is not None:
        progress(len(results), total)
    if waiting:
        coming = on_dask(waiting, scheduler, fingerprint) if scheduler else on_threads(waiting, workers)
        for run, result in coming:
            store.save(run, result)
            results[run.key] = result
            if progress is not None:
                progress(len(results), total)
    table = make_table(runs, results)
    store.write(out / "table.csv", table.csv())
    store.write(out / "study.json", _about(study))
    if parquet:
        table.write_parquet(out / "table.parquet")
    return table


def _about(study: Study) -> str:
    """What the table is of."""
    return (
        json.dumps(
            {
                "pytracker": __version__,
                "opencv": OPENCV,
                "numpy": np.__version__,
                "fingerprint": fingerprint(),
                "machine": platform.platform(),
                "seeds": study.seeds,
                "recordings": {
                    recording.name: {
                        "folder": None if recording.folder is None else recording.folder.name,
                        "scene": None if recording.scene is None else vars(recording.scene),
                        "seed": recording.seed,
                        "pixel_sd": recording.pixel_sd,
                    }
                    for recording in study.recordings
                },
                "methods": [{"class": type(method).__name__, **method.parameters()} for method in study.methods],
            },
            indent=2,
        )
        + "\n"
    )
