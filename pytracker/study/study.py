"""`run_study(study, out)`: what is not done yet is run, then table and page are written."""

from __future__ import annotations

import json
import platform
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pytracker._core import InputError, __version__
from pytracker.formats.video import OPENCV
from pytracker.output import write_whole
from pytracker.study.fingerprint import fingerprint
from pytracker.study.plan import Study, plain
from pytracker.study.schedule import on_dask, on_threads
from pytracker.study.store import Store, StudyTable, make_table, require_parquet

__all__ = ["run_study"]

StudyProgress = Callable[[int, int], None]
"""Called with (runs done, runs in all)."""


def run_study(
    study: Study,
    out: Path | str,
    *,
    scheduler: str = "",
    workers: int | None = None,
    parquet: bool = False,
    progress: StudyProgress | None = None,
) -> StudyTable:
    """Run what is not done, keep each result at once, write `<out>/table.csv` and a page; returns the table.

    What was done before, by the same build on the same recordings, is not done again; a killed study loses the runs
    in flight. A run that fails is in the table with its error, and is tried again the next time. On `workers` threads
    here, or on the Dask cluster at `scheduler`: the table is the same to the byte. `parquet` writes `table.parquet`
    besides.

    Raises `InputError` where `out` is something else, or what is asked for is not installed.
    """
    if workers is not None and workers < 1:
        raise InputError(f"workers is {workers}, expected 1 or more")
    if parquet:
        require_parquet()
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
        if scheduler:
            coming = on_dask(waiting, scheduler, store.save)
        else:
            coming = on_threads(waiting, workers, store.scratch, store.save)
        for run, result in coming:
            results[run.key] = result
            if progress is not None:
                progress(len(results), total)
    table = make_table(runs, results)
    shutil.rmtree(store.scratch, ignore_errors=True)
    write_whole(out / "table.csv", table.csv())
    write_whole(out / "study.json", _about(study))
    from pytracker.study.page import render  # noqa: PLC0415 - pages are slow to import

    write_whole(out / "index.html", render(study, table))
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
            default=plain,
        )
        + "\n"
    )
