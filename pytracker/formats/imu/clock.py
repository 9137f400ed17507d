"""The clock of an IMU's CSV, in seconds: dates, times of day, units that are not said, rows that have only a rate."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.imu.names import Column
from pytracker.formats.text import Table

__all__ = ["as_seconds", "seconds", "unit_of"]

UNITS_S = ((0.2, 1.0), (200.0, 1e-3), (2e5, 1e-6), (np.inf, 1e-9))
"""Samples that are less than so far apart are counted in this unit, s: no sensor gives fewer than five in a second, or
more than five in a millisecond."""
PAUSES = 50
"""Of so many steps one may be a pause."""
CALLED = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds"}
DATE_OR_TIME = re.compile(r"\d{4}-\d\d-\d\d[ T]|\d\d?:\d\d:")
DATE_AND_TIME = re.compile(r"(\d{4}-\d\d-\d\d[ T]\d\d:\d\d:\d\d(?:\.\d{1,6})?)\d*\s*(?:Z|[+-]\d\d:?\d\d)?")
"""To the microsecond; one recording is in one zone."""
TIME_OF_DAY = re.compile(r"(\d\d?):([0-5]\d):([0-5]\d(?:\.\d+)?)")
DAY_US = 86_400_000_000


def as_seconds(path: Path, lines: list[str], first: int, delimiter: str, clock: int) -> list[str]:
    """The lines; from `first` on with seconds since the first date or time of day, where column `clock` has such.

    Times of day may pass midnight. Raises `InputError` for a date or a time that is none.
    """
    begin = last = None
    counted = list(lines)
    for k in range(first, len(lines)):
        cells = lines[k].split(delimiter)
        cell = cells[clock].strip(' "') if clock < len(cells) else ""
        if not DATE_OR_TIME.match(cell):
            if begin is None and cell:
                return lines
            continue
        at = _microseconds(cell, last)
        if at is None:
            raise InputError(
                f"{path}:{k + 1}: time is {cell[:40]!r}, expected a date and time, a time of day, or seconds"
            )
        begin, last = at if begin is None else begin, at
        cells[clock] = repr((at - begin) / 1e6)
        counted[k] = delimiter.join(cells)
    return counted


def _microseconds(cell: str, last: int | None) -> int | None:
    """Of a date since 1970, or of a time of day since the midnight before the first; None where it is neither."""
    if time := TIME_OF_DAY.fullmatch(cell):
        at = round(1e6 * (3600 * int(time[1]) + 60 * int(time[2]) + float(time[3])))
        # More than half a day back is past midnight; what is less is left to whoever looks at the order.
        return at + DAY_US * max(0, round(((last or 0) - at) / DAY_US)) if int(time[1]) < 24 else None
    said = DATE_AND_TIME.fullmatch(cell)
    try:
        return int(np.datetime64(said[1] if said else "none", "us").astype(np.int64))
    except ValueError:
        return None


def seconds(table: Table, column: Column | None, rate_hz: float | None) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Of every row `(M,)`, and what is odd. `column` is what the clock's name says; None where it is `time_s`.

    A clock whose unit is not said is in the one that gives a rate that an IMU has. Without a clock rows follow at
    `rate_hz`.
    """
    clock = table.columns("time_s")
    if clock is None:
        assert rate_hz is not None
        return np.arange(len(table.lines)) / rate_hz, ()
    if column is None or column.has_unit:
        return clock[:, 0] * (1.0 if column is None else column.factor), ()
    usual, unit_s = unit_of(clock[:, 0])
    if unit_s == 1.0:
        return clock[:, 0], ()
    words = (
        f"{table.path}: its clock does not say its unit: taken as {CALLED[unit_s]}, of {1 / (usual * unit_s):.4g} Hz; "
        f"time_ms, time_us or time_ns would say it"
    )
    return clock[:, 0] * unit_s, (words,)


def unit_of(clock: NDArray[np.float64]) -> tuple[float, float]:
    """Its usual step, and the unit, s, in which that gives a rate that an IMU has.

    Where samples come in bursts, that is the mean step but for a few pauses.
    """
    steps = np.sort(np.diff(clock[np.isfinite(clock)]))
    usual = float(steps[: len(steps) - max(1, len(steps) // PAUSES)].mean()) if len(steps) > 1 else float(steps.sum())
    return usual, next(unit_s for limit, unit_s in UNITS_S if usual < limit)
