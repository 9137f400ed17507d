"""What is done of a study, on disk: a file a run, written whole; and the table that is made of them."""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import json
import math
import os
import platform
import shutil
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError
from pytracker.methods.method import Method
from pytracker.output import MADE_HERE, PARTIAL, is_alive, whole_file, write_whole
from pytracker.study.execute import COLUMNS, Result, Row
from pytracker.study.plan import Run

__all__ = ["Store", "StudyTable", "make_table", "require_parquet"]

SCRATCH = ".scratch-"
STALE_S = 60.0
"""No file takes so long to write."""


class Store:
    """Results by key in `<out>/runs`. Raises `InputError` where `out` holds something else."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.runs = out / "runs"
        mark = out / MADE_HERE
        # A study that was killed at once has the mark and nothing else.
        is_study = mark.is_file() and (self.runs.is_dir() or list(out.iterdir()) == [mark])
        if out.exists() and not is_study and not (out.is_dir() and not any(out.iterdir())):
            raise InputError(f"{out}: already exists and is no study, expected a new folder or one of a study")
        out.mkdir(parents=True, exist_ok=True)
        mark.touch()
        self.runs.mkdir(exist_ok=True)
        self.scratch = out / f"{SCRATCH}{platform.node()}-{os.getpid()}"
        self._sweep()

    def _sweep(self) -> None:
        """Remove what killed processes left: half-written files, simulated recordings."""
        for left in [*self.runs.glob(f"*{PARTIAL}"), *self.out.glob(f"*{PARTIAL}")]:
            with contextlib.suppress(OSError):
                if time.time() - left.stat().st_mtime > STALE_S:
                    left.unlink()
        for left in self.out.glob(f"{SCRATCH}{platform.node()}-*"):
            if not is_alive(left.name.rpartition("-")[2]):
                shutil.rmtree(left, ignore_errors=True)

    def load(self, run: Run) -> Result | None:
        """What is known of a run; None where it is not done, failed before, or its file is not readable."""
        try:
            found = json.loads(self._path(run).read_text("utf-8"))
            result = Result(found["status"], found["error"], found["said"], tuple(found["rows"]))
        except (OSError, ValueError, KeyError, TypeError):
            return None
        is_whole = all(isinstance(row, dict) and tuple(row) == COLUMNS for row in result.rows)
        return result if is_whole and (result.status == "lost" or (result.status == "ok" and result.rows)) else None

    def save(self, run: Run, result: Result) -> None:
        """Keep what became of a run: whole or not at all."""
        write_whole(self._path(run), json.dumps(dataclasses.asdict(result), allow_nan=False))

    def _path(self, run: Run) -> Path:
        return self.runs / f"{run.key}.json"


@dataclass(frozen=True)
class StudyTable:
    """A study's table: one row a run and joint, in the order of the study.

    Attributes:
        columns: `recording, kind, method`, `particles` and every other parameter that is not at its default
            somewhere in the study, `seed, status, error, said`, then what was measured (`study.execute.COLUMNS`), in
            metres or as a share.
        rows: by column; None where there is no value.
    """

    columns: tuple[str, ...]
    rows: tuple[Row, ...]

    def where(self, **values: Any) -> list[Row]:
        """The rows that have these values; `method` is a name, or a `Method` with all its parameters."""
        method = values.get("method")
        if isinstance(method, Method):
            parameters = self.columns[3 : self.columns.index("seed")]
            # What has no column is at its default everywhere.
            if any(p not in parameters for p in _parameters([method]) if p != "particles"):
                return []
            named = {p: _value(getattr(method, p, None)) for p in parameters}
            values |= {"kind": method.kind, "method": method.name, **named}
        return [row for row in self.rows if all(row[column] == value for column, value in values.items())]

    def values(self, column: str, **values: Any) -> list[float]:
        """Numbers of a column in those rows, one a run in the order of the seeds; NaN where a run has none.

        Without `joint` those of all joints together.
        """
        joint = values.pop("joint", "all")
        of_run: dict[tuple[Any, ...], float] = {}
        names = self.columns[: self.columns.index("status")]
        for row in self.where(**values):
            key = tuple(row[name] for name in names)
            value = row[column] if row["joint"] == joint else None
            if isinstance(value, int | float) or key not in of_run:
                of_run[key] = float(value) if isinstance(value, int | float) else math.nan
        return list(of_run.values())

    def count(self, status: str) -> int:
        """How many runs ended so: `ok`, `lost` or `failed`."""
        names = self.columns[: self.columns.index("status")]
        return len({tuple(row[name] for name in names) for row in self.where(status=status)})

    def said(self) -> dict[str, str]:
        """What is said of recordings, by their names, where anything is: of one run each."""
        return {str(row["recording"]): str(row["said"]) for row in reversed(self.rows) if row["said"]}

    def csv(self) -> str:
        """As text: the same bytes for the same study, wherever it ran."""
        lines: list[str] = []

        class Lines:
            def write(self, line: str) -> None:
                lines.append(line)

        writer = csv.writer(Lines(), lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_cell(row[column]) for column in self.columns] for row in self.rows)
        return "".join(lines)

    def write_parquet(self, path: Path) -> None:
        """As Parquet. Raises `InputError` without the `parquet` extra."""
        require_parquet()
        import pyarrow as pa  # noqa: PLC0415 - an extra
        import pyarrow.parquet as pq  # noqa: PLC0415 - an extra

        with whole_file(path) as partial:
            pq.write_table(pa.table({column: [row[column] for row in self.rows] for column in self.columns}), partial)


def require_parquet() -> None:
    """Raises `InputError` without the `parquet` extra: before the work, not after it."""
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415 - an extra
    except ImportError:
        raise InputError("Parquet needs pyarrow: pip install pyarrow") from None


def make_table(runs: Sequence[Run], results: Mapping[str, Result]) -> StudyTable:
    """The table of `runs`, each with its result by key."""
    parameters = _parameters({run.method: None for run in runs})
    rows = [
        {
            "recording": run.recording.name,
            "kind": run.method.kind,
            "method": run.method.name,
            **{name: _value(getattr(run.method, name, None)) for name in parameters},
            "seed": run.seed,
            "status": results[run.key].status,
            "error": results[run.key].error,
            "said": results[run.key].said,
            **found,
        }
        for run in runs
        for found in results[run.key].rows or ({column: None for column in COLUMNS},)
    ]
    return StudyTable(
        ("recording", "kind", "method", *parameters, "seed", "status", "error", "said", *COLUMNS), tuple(rows)
    )


def _parameters(methods: Iterable[Method]) -> list[str]:
    """Those that are not at their default somewhere, `particles` first."""
    names = {"particles": None}
    for method in methods:
        names |= {
            field.name: None for field in dataclasses.fields(method) if getattr(method, field.name) != field.default
        }
    return list(names)


def _value(value: Any) -> str | float | int | None:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return str(value).lower()
    return value if value is None or isinstance(value, str | float | int) else json.dumps(value)


def _cell(value: str | float | int | None) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.9g}"
    # A spreadsheet would run a word that begins like a formula; numbers are no words.
    return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "-", "@", "\t", "\r")) else str(value)
