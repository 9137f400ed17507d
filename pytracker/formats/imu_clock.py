"""The clock of an IMU's CSV, in seconds: dates, units that are not said, and rows that have none but a rate."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.imu_names import Column
from pytracker.formats.text import Table

__all__ = ["seconds", "without_dates"]

UNITS_S = ((0.2, 1.0), (200.0, 1e-3), (2e5, 1e-6), (np.inf, 1e-9))
"""Samples that are less than so far apart are counted in this unit, s: no sensor gives fewer than five in a second, or
more than five in a millisecond."""
CALLED = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds"}
DATE = re.compile(r"\d{4}-\d\d-\d\d[ T]")
DATE_AND_TIME = re.compile(r"(\d{4}-\d\d-\d\d[ T]\d\d:\d\d:\d\d(?:\.\d{1,6})?)\d*\s*(?:Z|[+-]\d\d:?\d\d)?")
"""To the microsecond; one recording is in one zone."""


def without_dates(path: Path, lines: list[str], first: int, delimiter: str, clock: int) -> list[str]:
    """The lines; from `first` on with seconds since the first date in place of dates, where column `clock` has such.

    Raises `InputError` for a date that is none.
    """
    begin: np.datetime64 | None = None
    counted = list(lines)
    for k in range(first, len(lines)):
        cells = lines[k].split(delimiter)
        cell = cells[clock].strip(' "') if clock < len(cells) else ""
        if not DATE.match(cell):
            if begin is None and cell:
                return lines
            continue
        said = DATE_AND_TIME.fullmatch(cell)
        try:
            at = np.datetime64(said[1] if said else "none", "us")
        except ValueError:
            raise InputError(f"{path}:{k + 1}: time is {cell[:40]!r}, expected a date and time, or seconds") from None
        begin = at if begin is None else begin
        cells[clock] = repr(float((at - begin) / np.timedelta64(1, "s")))
        counted[k] = delimiter.join(cells)
    return counted


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
    steps = np.diff(clock[:, 0])
    usual = float(np.median(steps[np.isfinite(steps)])) if np.isfinite(steps).any() else 0.0
    unit_s = next(unit_s for limit, unit_s in UNITS_S if usual < limit)
    if unit_s == 1.0:
        return clock[:, 0], ()
    words = (
        f"{table.path}: its clock does not say its unit: taken as {CALLED[unit_s]}, of {1 / (usual * unit_s):.4g} Hz; "
        f"time_ms, time_us or time_ns would say it"
    )
    return clock[:, 0] * unit_s, (words,)
