"""Of which frames a table's rows are: by a column of their numbers, of their pictures' names, or of times."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.rotation import Array

__all__ = ["Rows", "frames_of", "numbers_of", "rows_of"]

Numbers = NDArray[np.int64]

FRAME = re.compile(
    r"((video|image|img|picture)[ _]?)?(frame|fr?(?=[ _]?n))s?[ _]?(id|idx|index|no|nr|num|number|count)?[ _.]?#?"
)
"""A column that counts frames."""
PICTURE = re.compile(r"\.(png|jpe?g|bmp|tiff?|webp)$", re.IGNORECASE)
"""What names one does too."""
NAMED_FRAME = re.compile(r"frame[ _#-]*(\d+)", re.IGNORECASE)
"""What says which it is itself."""
SIZE = re.compile(r"\d+\s*[xX]\s*\d+")
"""How large it is."""
APPENDED = re.compile(r"(\.mp4)?\.rf\.[0-9a-z]+(?=\.)", re.IGNORECASE)
"""What Roboflow puts behind it."""
INDEX = ("", "index", "idx", "id", "unnamed: 0")
"""What the first column is called that pandas wrote as its index."""
TIME = re.compile(
    r"((frame|video|media|current|pts)[ _]?)?(time[ _]?(stamp)?|elapsed([ _]?time)?|pts|t)"
    r"([ _]*(in[ _])?[(\[]?(?P<unit>s|secs?|seconds|ms|msec|us|ns)[)\]]?)?|(pos[ _]?)?(?P<alone>secs?|seconds|ms|msec)"
)
"""A column of their times."""
OF_DAY = re.compile(r"(?:(\d+):)?(\d+):(\d+(?:\.\d+)?)")
DATED = re.compile(r"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d)(\.\d+)?(Z|[+-]\d\d:\d\d)?")
"""A time with its date, as ISO 8601 has it."""
MOST_FRAMES = 100_000_000
UNITS_S = ((0.5, 1.0), (500.0, 1e-3), (5e5, 1e-6), (np.inf, 1e-9))
"""Frames that are less than so far apart are in this unit, s: no detector is slower than two a second."""
SAID_S = {"s": 1.0, "sec": 1.0, "secs": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "ns": 1e-9}
LONGEST_S = 24 * 3600.0
"""Times that begin later are those of a clock, not of the video."""


@dataclass(frozen=True)
class Rows:
    """Of which frame each row is.

    Attributes:
        frames: by its number, or one by one `(T,)`.
        time_s: since the video began `(T,)`, s; None where there are no times, or numbers say it.
        warnings: what is odd.
    """

    frames: Numbers
    time_s: Array | None = None
    warnings: tuple[str, ...] = ()


def rows_of(path: Path, header: Sequence[str], rows: Sequence[Sequence[str]], others: Sequence[int]) -> Rows:
    """By whichever of the columns says it; `others` are those that hold no keypoints. Raises `InputError`."""
    names = [name.lower() for name in header]
    # What is the same in all rows counts none: how many frames there are, or one picture's name.
    columns = {k: [row[k] for row in rows] for k in others}
    columns = {k: column for k, column in columns.items() if len(rows) < 2 or len(set(column)) > 1}
    timing = next((k for k in columns if TIME.fullmatch(names[k])), None)
    counting = [k for k in columns if FRAME.fullmatch(names[k])]
    counting += [k for k in columns if any(PICTURE.search(cell) for cell in columns[k][:1])]
    if not counting and timing is None and 0 in columns and names[0] in INDEX and _increases(columns[0]):
        counting = [0]
    if counting:
        return Rows(frames_of(path, columns[counting[0]]))
    by_row = np.arange(len(rows), dtype=np.int64)
    if timing is not None:
        said, column = TIME.fullmatch(names[timing]), columns[timing]
        is_said = any(OF_DAY.fullmatch(cell) or DATED.fullmatch(cell) for cell in column)
        unit = "s" if is_said else said and (said["unit"] or said["alone"])
        return Rows(by_row, *_times(path, np.array([_time(cell) for cell in column]), SAID_S.get(unit or "")))
    unknown = [
        header[k] or f"column {k + 1}" for k in columns if len(rows) > 1 and _increases(columns[k], are_whole=False)
    ]
    words = f"{path}: {', '.join(unknown)[:120]} says nothing that is known, expected frame or time_s: rows are counted"
    return Rows(by_row, None, (words,) if unknown else ())


def frames_of(path: Path, column: Sequence[str]) -> Numbers:
    """Numbers of frames, or those in names such as `labeled-data/trial/img0041.png`.

    Rows are counted where all is empty. Raises `InputError` where they are no whole numbers, or do not increase.
    """
    if not any(column):
        return np.arange(len(column), dtype=np.int64)
    found = np.array([_number(cell) for cell in column])
    if not np.isfinite(found).any():
        found = np.array([np.nan if number is None else number for number in numbers_of(column)], dtype=np.float64)
    is_whole = np.isfinite(found) & (found == np.rint(found)) & (found >= 0) & (found <= MOST_FRAMES)
    is_next = np.concatenate([is_whole[:1], is_whole[1:] & (np.diff(found) > 0)])
    if not is_next.all():
        k = int(np.argmin(is_next))
        is_what = column[k][:60] or "not there"
        # Of several people one may follow below the other, too.
        again = is_whole[k] and k > 0 and found[k] in found[:k]
        hint = " (several people in a frame? Keep the rows of one)" if again else ""
        raise InputError(
            f"{path}: the frame of its row {k + 1} is {is_what}, expected whole numbers that increase{hint}"
        )
    return found.astype(np.int64)


def numbers_of(names: Sequence[str]) -> list[int | None]:
    """The number in names of pictures, in any order, that is another in each of them; else the last; None of none.

    Of several numbers that which goes in the smallest steps. Names may say a picture's size, its time, and what a tool
    appends. What stands behind "frame" is the frame's, where it is another in each.
    """
    called = [NAMED_FRAME.findall(name) for name in names]
    if len(names) > 1 and all(called) and len({found[-1] for found in called}) == len(names):
        return [int(found[-1]) for found in called]
    runs = [re.findall(r"\d+", PICTURE.sub("", APPENDED.sub("", SIZE.sub("", name)))) for name in names]
    steps: dict[int, float] = {}
    for k in range(min(map(len, runs), default=0)):
        values = sorted({int(found[k]) for found in runs})
        if len(values) == len(runs) > 1:
            steps[k] = float(np.median(np.diff(np.array(values, dtype=np.float64))))
    counting = min(steps, key=lambda k: (steps[k], -k)) if steps else -1
    return [int(found[counting]) if found else None for found in runs]


def _increases(column: Sequence[str], *, are_whole: bool = True) -> bool:
    """Whether numbers do, cell by cell."""
    found = np.array([_number(cell) for cell in column])
    is_whole = not are_whole or bool((found == np.rint(found)).all())
    return bool(np.isfinite(found).all() and is_whole and (np.diff(found) > 0).all())


def _number(cell: str) -> float:
    """What a cell says, in seconds where it is a time of day; NaN where it is none."""
    if of_day := OF_DAY.fullmatch(cell):
        return 3600 * int(of_day[1] or 0) + 60 * int(of_day[2]) + float(of_day[3])
    try:
        return float(cell)
    except ValueError:
        return np.nan


def _time(cell: str) -> float:
    """The same, or since 1970 where it is a time with its date, s."""
    dated = DATED.fullmatch(cell)
    if dated is None:
        return _number(cell)
    try:
        # Whatever the zone is: since when they count does not matter.
        moment = datetime.fromisoformat(dated[1]).replace(tzinfo=timezone.utc)
    except ValueError:  # such as the 31st of February
        return np.nan
    return moment.timestamp() + float(dated[2] or 0.0)


def _times(path: Path, column: Array, said_s: float | None) -> tuple[Array | None, tuple[str, ...]]:
    """Seconds since the video began; None where they do not increase. And what is odd.

    Where the unit is not said, it is one that gives a rate that detectors have.
    """
    steps = np.diff(column)
    if not len(steps):
        return None, ()
    if not np.isfinite(column).all() or not (steps > 0).all() or column[0] < 0:
        k = int(np.argmin(np.concatenate([[column[0] >= 0], steps > 0])))
        words = f"{path}: the time of its row {k + 1} is {column[k]:g}, expected times that increase: rows are counted"
        return None, (f"{words} as frames instead",)
    unit_s = said_s or next(unit for limit, unit in UNITS_S if np.median(steps) < limit)
    if column[0] * unit_s <= LONGEST_S:
        return np.asarray(column * unit_s), ()
    words = f"{path}: its times begin at {column[0]:.15g}, as a clock's: its first row is taken to be the first frame's"
    return np.asarray((column - column[0]) * unit_s), (words,)
