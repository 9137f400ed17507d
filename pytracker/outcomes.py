"""What became of each of many recordings, in a table that a later run reads again: `index.csv`."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["EARLIER", "Outcome", "read_outcomes", "table_of"]

EARLIER = "of an earlier run; --force does it again"
"""What is said of those that are not done again."""
COLUMNS = ("recording", "result", "failed", "frames", "valid", "error_m", "said", "folder")
BETWEEN = " | "


@dataclass(frozen=True)
class Outcome:
    """What became of one recording.

    Attributes:
        recording: its folder.
        result: name of the folder of its result; empty where there is none.
        frames: how many.
        valid: share of them that are valid.
        error_m: 3-D RMS of the wrist of an arm, average of the joints of a body; None without truth.
        said: warnings, doubts, or why it failed.
        failed: whether there is no whole track, or one of which most frames are not valid.
        is_earlier: whether an earlier run left it.
    """

    recording: Path
    result: str = ""
    frames: int = 0
    valid: float = 0.0
    error_m: float | None = None
    said: tuple[str, ...] = ()
    failed: bool = False
    is_earlier: bool = False

    @property
    def words(self) -> tuple[str, ...]:
        """All that is said of it, whether it is of an earlier run too."""
        return (EARLIER, *self.said) if self.is_earlier else self.said


def table_of(outcomes: Sequence[Outcome], out: Path) -> str:
    """As CSV; folders as seen from `out`."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in outcomes:
        error = "" if one.error_m is None else f"{one.error_m:.4f}"
        cells = one.result, one.failed, one.frames, f"{one.valid:.4f}", error, BETWEEN.join(one.words)
        writer.writerow([_plain(one.recording.resolve().name), *cells, _plain(_seen_from(out, one.recording))])
    return text.getvalue()


def read_outcomes(out: Path) -> dict[Path, Outcome]:
    """What an earlier run said of results that are still in `out`, by their recordings; empty where none has been."""
    try:
        rows = list(csv.DictReader((out / "index.csv").read_text(encoding="utf-8").splitlines()))
        found = [_of_row(out, row) for row in rows if row["result"] and (out / row["result"]).is_dir()]
    except (OSError, KeyError, ValueError, TypeError):
        return {}  # none of ours: it is written anew
    return {one.recording.resolve(): one for one in found}


def _of_row(out: Path, row: dict[str, str]) -> Outcome:
    said = row["said"].split(BETWEEN) if row["said"] else []
    return Outcome(
        recording=out / row["folder"].removeprefix("'"),
        result=row["result"],
        frames=int(row["frames"]),
        valid=float(row["valid"]),
        error_m=float(row["error_m"]) if row["error_m"] else None,
        said=tuple(words for words in said if words != EARLIER),
        failed=row["failed"] == "True",
        is_earlier=True,
    )


def _seen_from(out: Path, folder: Path) -> str:
    # Beside each other they may be moved together.
    return Path(os.path.relpath(folder.resolve(), out.resolve())).as_posix()


def _plain(cell: str) -> str:
    """A cell that begins like a formula is none."""
    return f"'{cell}" if cell.startswith(("=", "+", "-", "@")) else cell
