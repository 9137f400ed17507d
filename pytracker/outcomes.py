"""What became of each of many recordings, in a table that a later run reads again: `index.csv`."""

from __future__ import annotations

import csv
import hashlib
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pytracker._core import InputError
from pytracker.methods.method import Method
from pytracker.output import MADE_HERE

__all__ = ["EARLIER", "Outcome", "check_index", "read_outcomes", "run_of", "table_of"]

EARLIER = "of an earlier run; --force does it again"
"""What is said of those that are not done again."""
COLUMNS = ("recording", "result", "failed", "frames", "valid", "error_m", "said", "folder", "run")
OLDER = COLUMNS[:-1]
"""Those of a table that does not say of which run its rows are."""
BETWEEN = " | "
STALE, STALE_AND_FAILED = "of an earlier run, another than this: ", "of an earlier run, which had failed: "
"""How what is said of a stale one begins, which was of use, or was not."""


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
        run: what stands for method, settings and seed (`run_of`); empty where it is not known.
        is_earlier: whether an earlier run left it.
        stale: why it is not what this run would have found, where an earlier one left it and it stays.
    """

    recording: Path
    result: str = ""
    frames: int = 0
    valid: float = 0.0
    error_m: float | None = None
    said: tuple[str, ...] = ()
    failed: bool = False
    run: str = ""
    is_earlier: bool = False
    stale: str = ""

    @property
    def has_failed(self) -> bool:
        """Whether there is no track of use of this run."""
        return self.failed or bool(self.stale)

    @property
    def words(self) -> tuple[str, ...]:
        """All that is said of it, whether it is of an earlier run too."""
        stale = f"{STALE_AND_FAILED if self.failed else STALE}{self.stale}" if self.stale else EARLIER
        return (stale, *self.said) if self.is_earlier else self.said


def table_of(outcomes: Sequence[Outcome], out: Path) -> str:
    """As CSV; folders as seen from `out`."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in outcomes:
        error = "" if one.error_m is None else f"{one.error_m:.4f}"
        cells = one.result, one.has_failed, one.frames, f"{one.valid:.4f}", error, BETWEEN.join(one.words)
        where = _plain(_seen_from(out, one.recording))
        writer.writerow([_plain(one.recording.resolve().name), *cells, where, one.run])
    return text.getvalue()


def run_of(method: Method, seed: int) -> str:
    """The same for the same method with the same settings, and the same seed."""
    words = f"{type(method).__name__} {sorted(method.parameters().items())} {seed}"
    return hashlib.sha256(words.encode()).hexdigest()[:12]


def check_index(out: Path, *, force: bool) -> None:
    """Raise `InputError` where `out` holds an index that is no table of outcomes, or is the report of one recording.

    What is neither is replaced with `force`.
    """
    if (out / MADE_HERE).is_file():
        raise InputError(f"{out}: holds the result of one recording, expected another folder for those of several")
    there = next((name for name in ("index.html", "index.csv") if (out / name).exists()), None)
    if there is None or force or _header(out / "index.csv")[: len(OLDER)] == list(OLDER):
        return
    raise InputError(
        f"{out / there}: was not written by pytracker, expected a folder without (or --force to replace it)"
    )


def _header(path: Path) -> list[str]:
    try:
        with path.open(encoding="utf-8-sig") as file:
            return file.readline().rstrip("\r\n").split(",")
    except (OSError, ValueError):
        return []


def read_outcomes(out: Path) -> dict[Path, Outcome]:
    """What an earlier run said of results that are still in `out`, by their recordings; empty where none has been."""
    try:
        rows = list(csv.DictReader((out / "index.csv").read_text(encoding="utf-8-sig").splitlines()))
        found = [_of_row(out, row) for row in rows if row["result"] and (out / row["result"]).is_dir()]
    except (OSError, KeyError, ValueError, TypeError):
        return {}  # none of ours: it is written anew
    return {one.recording.resolve(): one for one in found}


def _of_row(out: Path, row: dict[str, str]) -> Outcome:
    said = row["said"].split(BETWEEN) if row["said"] else []
    # What was stale then may be right for this run.
    was_of_use = any(words.startswith(STALE) for words in said)
    starts = (EARLIER, STALE, STALE_AND_FAILED)
    return Outcome(
        recording=out / row["folder"].removeprefix("'"),
        result=row["result"],
        frames=int(row["frames"]),
        valid=float(row["valid"]),
        error_m=float(row["error_m"]) if row["error_m"] else None,
        said=tuple(words for words in said if not words.startswith(starts)),
        failed=row["failed"] == "True" and not was_of_use,
        run=row.get("run") or "",
        is_earlier=True,
    )


def _seen_from(out: Path, folder: Path) -> str:
    # Beside each other they may be moved together.
    return Path(os.path.relpath(folder.resolve(), out.resolve())).as_posix()


def _plain(cell: str) -> str:
    """A cell that begins like a formula is none."""
    return f"'{cell}" if cell.startswith(("=", "+", "-", "@")) else cell
