"""The clock of an IMU's CSV, in seconds: units that are not said, rows that have only a rate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.formats.imu.names import Column
from pytracker.formats.text import Table

__all__ = ["as_it_went", "seconds", "unit_of"]

UNITS_S = ((0.2, 1.0), (200.0, 1e-3), (2e5, 1e-6), (np.inf, 1e-9))
"""Samples that are less than so far apart are counted in this unit, s: no sensor gives fewer than five in a second, or
more than five in a millisecond."""
TURNS = (2.0**16, *(of * 10.0**-k for of in (2.0**32, 86400e6) for k in (0, 3, 6)))
"""Where counters begin again: of 16 bits; of 32 and of a day, and the same as thousandths and millionths."""
SLACK = 5
"""So many samples before and after it may be lost: another session begins elsewhere."""
WHOLE = 1000
"""No counter turns within so many samples."""
PAUSES = 50
"""Of so many steps one may be a pause."""
LONG_UNITS_S = ((5.8e-7, 86400.0), (1.4e-5, 3600.0))
"""Samples that are less than so far apart on average, too, are counted in days, of 20 Hz at least, or in hours."""
HOUR_S = 3600.0
SET_BY = {
    12 * HOUR_S: "for one of 12 hours without AM and PM",
    HOUR_S: "to have been set back by an hour",
}
"""What a clock is behind by, s, from some sample on, and why."""
DATES = (2e4, 7e4)
"""Days since 1900, of 1954 to 2091: a spreadsheet's dates."""
CALLED = {
    86400.0: "days", 3600.0: "hours", 1e-3: "milliseconds", 1e-4: "tenths of a millisecond", 1e-6: "microseconds",
    1e-7: "ticks of 100 ns", 1e-9: "nanoseconds",
}  # fmt: skip
TENTHS = {1e-3: 1e-4, 1e-6: 1e-7}
"""Units of which there are tenths too, and those."""
SLOW_HZ = 21.0
"""An IMU that is slower by this unit may count in tenths of it: .NET's ticks are of 100 ns."""
TICKS_SINCE = ((6.2e17, 6.6e17), (1.3e17, 1.4e17))
"""Ticks of 100 ns since the year 1, and since 1601, in this century; nanoseconds since 1970 are 1.4e18 and more."""
MOSTLY = 0.9
"""A clock that goes on by one from row to row, so often, may count samples."""
RATE_TOLERANCE = 0.05
"""A unit gives a stated rate to this share."""


def seconds(table: Table, column: Column | None, rate_hz: float | None) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Of every row `(M,)`, and what is odd. `column` is what the clock's name says; None where it is `time_s`.

    A clock whose unit is not said is in the one that gives a rate that an IMU has. Without a clock rows follow at
    `rate_hz`.
    """
    column_of_times = table.columns("time_s")
    if column_of_times is None:
        assert rate_hz is not None
        return np.arange(len(table.lines)) / rate_hz, ()
    clock, wrapped = _unwrapped(table, column_of_times[:, 0])
    if column is None or column.has_unit:
        return clock * (1.0 if column is None else column.factor), wrapped
    counts = bool((np.diff(clock) == 1.0).mean() > MOSTLY) if len(clock) > 1 else False
    usual, unit_s = unit_of(clock, rate_hz)
    if counts and rate_hz is not None and abs(usual * unit_s * rate_hz - 1.0) > RATE_TOLERANCE:
        return clock / rate_hz, (*wrapped, f"{table.path}: its clock counts samples: taken at {rate_hz:g} Hz")
    is_told = rate_hz is not None and abs(usual * unit_s * rate_hz - 1.0) < RATE_TOLERANCE
    if unit_s == 1.0 or is_told:
        return clock * unit_s, wrapped
    hz = 1.0 / (usual * unit_s)
    words = (
        f"{table.path}: its clock does not say its unit: taken as {CALLED[unit_s]}, of {hz:.4g} Hz; "
        "time_ms, time_us or time_ns would say it, or rate_hz"
    )
    if counts:
        words += ". Or does it count samples? rate_hz would say how fast"
    if hz < SLOW_HZ and unit_s in TENTHS:
        words += f". Or is it in {CALLED[TENTHS[unit_s]]}, of {10 * hz:.4g} Hz? rate_hz would say it"
    return clock * unit_s, (*wrapped, words)


def _unwrapped(table: Table, clock: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """The same, going on where a counter began again at 0; and a word on that."""
    steps = np.diff(clock)
    usual = float(np.median(steps)) if len(steps) else 0.0
    out, said = clock.copy(), []
    for k in np.flatnonzero(steps < 0):
        is_near = (turn for turn in TURNS if turn > WHOLE * usual and clock[k] > turn - SLACK * usual)
        turn = next((turn for turn in is_near if 0 < steps[k] + turn <= SLACK * usual), None)
        if turn is not None:
            out[k + 1 :] += turn
            said.append(
                f"{table.path}:{table.lines[k + 1]}: its clock goes from {clock[k]:g} to {clock[k + 1]:g}: "
                f"taken to have begun again after {turn:.10g}"
            )
    return out, tuple(said)


def as_it_went(table: Table, clock: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Times of dates or of day, s, going on where one of 12 hours began again, or was set back; and a word on that.

    One that was set forward by an hour looks like a pause, and is left.
    """
    steps = np.diff(clock)
    usual = float(np.median(steps)) if len(steps) else 0.0
    out, said = clock.copy(), []
    if not 0 < usual < UNITS_S[0][0]:
        return clock, ()
    for k in np.flatnonzero(steps < 0):
        for by, words in SET_BY.items():
            if 0.5 * usual < steps[k] + by <= SLACK * usual:
                out[k + 1 :] += by
                said.append(f"{table.path}:{table.lines[k + 1]}: its clock goes by {steps[k]:.6g} s: taken {words}")
    return out, tuple(said)


def unit_of(clock: NDArray[np.float64], rate_hz: float | None = None) -> tuple[float, float]:
    """Its usual step, and the unit, s, in which that gives the rate, or else one that an IMU has.

    Where samples come in bursts, that is the mean step but for a few pauses.
    """
    steps = np.sort(np.diff(clock[np.isfinite(clock)]))
    usual = float(steps[: len(steps) - max(1, len(steps) // PAUSES)].mean()) if len(steps) > 1 else float(steps.sum())
    if rate_hz is not None:
        for unit_s in (1.0, *CALLED):
            if abs(usual * unit_s * rate_hz - 1.0) < RATE_TOLERANCE:
                return usual, unit_s
    if any(least < clock[0] < most for least, most in TICKS_SINCE):
        return usual, 1e-7
    if (longer := _longer_unit(clock, usual)) is not None:
        return usual, longer
    return usual, next(unit_s for limit, unit_s in UNITS_S if usual < limit)


def _longer_unit(clock: NDArray[np.float64], usual: float) -> float | None:
    """A day or an hour, s, of a clock whose steps are usually so long; None of one that is in seconds or less."""
    # Samples that come in bursts are near each other within these, not on average.
    step = max(usual, float(np.ptp(clock[np.isfinite(clock)])) / max(1, len(clock) - 1))
    if not (usual > 0 and step < LONG_UNITS_S[-1][0]):
        return None
    if DATES[0] < clock[0] < DATES[1]:
        return 86400.0
    return next(unit_s for limit, unit_s in LONG_UNITS_S if step < limit)
