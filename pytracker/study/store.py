"""What is done of a study, on disk: a file a run, written whole; and the table that is made of them."""

from __future__ import annotations

import csv
import dataclasses
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytracker._core import InputError
from pytracker.methods import Method
from pytracker.output import MADE_HERE
from pytracker.study.execute import COLUMNS, Result, Row
from pytracker.study.plan import Run

__all__ = ["Store", "StudyTable"]

PARTIAL = ".partial"


class Store:
    """Results by key in `<out>/runs`. Raises `InputError` where `out` holds something else."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.runs = out / "runs"
        if out.exists() and not self.runs.is_dir() and not (out.is_dir() and not any(out.iterdir())):
            raise InputError(f"{out}: already exists and is no study, expected a new folder or one of a study")
        self.runs.mkdir(parents=True, exist_ok=True)
        (out / MADE_HERE).touch()
        for left in self.runs.glob(f"*{PARTIAL}"):  # by a run that was killed while it wrote
            left.unlink(missing_ok=True)

    def load(self, run: Run) -> Result | None:
        """What is known of a run; None where it is not done, failed before, or its file is not readable."""
        try:
            found = json.loads(self._path(run).read_text("utf-8"))
            result = Result(found["status"], found["error"], tuple(found["rows"]))
        except (OSError, ValueError, KeyError, TypeError):
            return None
        return result if result.status in ("ok", "lost") else None

    def save(self, run: Run, result: Result) -> None:
        """Keep what became of a run: whole or not at all."""
        self.write(self._path(run), json.dumps(dataclasses.asdict(result), allow_nan=False))

    def write(self, path: Path, text: str) -> None:
        """A file under its name only when it is whole."""
        partial = path.with_name(f"{path.name}.{os.getpid()}{PARTIAL}")
        partial.write_text(text, "utf-8", newline="")
        partial.replace(path)

    def _path(self, run: Run) -> Path:
        return self.runs / f"{run.key}.json"


@dataclass(frozen=True)
class StudyTable:
    """A study's table: one row a run and joint, in the order of the study.

    Attributes:
        columns: `recording, method`, `particles` and every other parameter that is not at its default somewhere in the
            study, `seed, status, error`, then what was measured (`study.execute.COLUMNS`), in metres or as a share.
        rows: by column; None where there is no value.
    """

    columns: tuple[str, ...]
    rows: tuple[Row, ...]

    def where(self, **values: Any) -> list[Row]:
        """The rows that have these values; `method` is a name, or a `Method` with all its parameters."""
        method = values.get("method")
        if isinstance(method, Method):
            parameters = self.columns[2 : self.columns.index("seed")]
            values |= {"method": method.name, **{p: _value(getattr(method, p, None)) for p in parameters}}
        return [row for row in self.rows if all(row[column] == value for column, value in values.items())]

    def values(self, column: str, **values: Any) -> list[float]:
        """Numbers of a column in those rows, in order of the seeds; NaN where there is none."""
        found = (row[column] for row in self.where(**values))
        return [float(x) if isinstance(x, int | float) else float("nan") for x in found]

    def count(self, status: str) -> int:
        """How many runs ended so: `ok`, `lost` or `failed`."""
        names = self.columns[: self.columns.index("status")]
        return len({tuple(row[name] for name in names) for row in self.where(status=status)})

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
        try:
            import pyarrow as pa  # noqa: PLC0415
            import pyarrow.parquet as pq  # noqa: PLC0415
        except ImportError:
            raise InputError("Parquet needs pyarrow, expected pytracker[parquet] to be installed") from None
        pq.write_table(pa.table({column: [row[column] for row in self.rows] for column in self.columns}), path)


def make_table(runs: Sequence[Run], results: Mapping[str, Result]) -> StudyTable:
    """The table of `runs`, each with its result by key."""
    parameters = _parameters({run.method: None for run in runs})
    rows = [
        {
            "recording": run.recording.name,
            "method": run.method.name,
            **{name: _value(getattr(run.method, name, None)) for name in parameters},
            "seed": run.seed,
            "status": results[run.key].status,
            "error": results[run.key].error,
            **found,
        }
        for run in runs
        for found in results[run.key].rows or ({column: None for column in COLUMNS},)
    ]
    return StudyTable(("recording", "method", *parameters, "seed", "status", "error", *COLUMNS), tuple(rows))


def _parameters(methods: Iterable[Method]) -> list[str]:
    """Those that are not at their default somewhere, `particles` first."""
    names = {"particles": None}
    for method in methods:
        names |= {
            field.name: None for field in dataclasses.fields(method) if getattr(method, field.name) != field.default
        }
    return list(names)


def _value(value: Any) -> str | float | int | None:
    if isinstance(value, bool):
        return str(value).lower()
    return value if value is None or isinstance(value, str | float | int) else json.dumps(value)


def _cell(value: str | float | int | None) -> str:
    if value is None:
        return ""
    return f"{value:.9g}" if isinstance(value, float) else str(value)
