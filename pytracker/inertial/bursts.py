"""Times at which samples arrived, several at once, as by Bluetooth: put back to an even rate where they had one."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from pytracker.inertial.log import ImuLog
from pytracker.inertial.whole_seconds import counts_seconds, in_seconds
from pytracker.rotation import Array

__all__ = ["comes_in_bursts", "evened"]

BURSTS = 3.0
"""Samples that are this many times farther apart on average than they usually are come in bursts."""
PAUSES, FEW_PAUSES = 0.005, 3
"""So many intervals, as a share and at least, may be pauses."""
LATE = 2.5
"""Of an even rate nothing is later than so many times the usual wait for a burst: else samples were lost."""
AT_ONCE = 0.15
"""Within a burst samples are no farther apart than so much of their even distance."""
MOST_WAIT_S = 1.0
"""No radio waits longer for what it sends at once."""
PAUSE = 4.0
"""Whoever waits so many times as long pauses."""
REPEATING, FEW_STEPS = 0.01, 5
"""Of a coarse clock so many times repeat, as a share and at least; of a sensor that is awake no more values do."""
FEW = 20
"""Fewer samples have no rate."""


def comes_in_bursts(log: ImuLog) -> bool:
    """Whether time stamps are those of arrival, several samples at once: rates cannot be told from them.

    Bursts come all along; a few pauses, however long, are gaps.
    """
    interval = np.sort(np.diff(log.time_s))
    pauses = max(FEW_PAUSES, int(PAUSES * len(interval)))
    return len(interval) > pauses and bool(interval[:-pauses].mean() > BURSTS * np.median(interval))


def evened(log: ImuLog) -> ImuLog:
    """The log with samples of bursts at an even rate, each as late as it can have been measured, and a word on it.

    Between longer pauses each stretch is put back on its own. Where some samples of one were lost, which has no even
    rate then, all times stay those of arrival.
    """
    interval = np.diff(log.time_s)
    if (interval < 0).any():
        return log
    if not comes_in_bursts(log):
        return _stepping(_once(log)) if (interval == 0).any() else log
    if counts_seconds(log.time_s):
        time_s, kept, words = in_seconds(log.time_s)
        return dataclasses.replace(log, time_s=time_s, warnings=(*log.warnings, f"{log.path}: {words}")).kept(kept)
    usual, mean = float(np.median(interval)), float(interval.mean())
    words = (
        f"{log.path}: samples come in bursts (usual interval {usual:.6f} s, mean {mean:.6f} s), expected the times at "
        "which they were measured, not those at which they arrived"
    )
    wait_s = float(np.median(interval[interval > BURSTS * usual]))
    ends = [0, *(np.flatnonzero(interval > PAUSE * wait_s) + 1), len(log.time_s)]
    put = [_evenly(log.time_s[a:b], wait_s) for a, b in itertools.pairwise(ends)] if wait_s <= MOST_WAIT_S else []
    time_s = np.concatenate([np.empty(0), *(part for part in put if part is not None)])
    even_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    # A sensor that measures now and then, at true times, has its own period within.
    is_even = len(time_s) == len(log.time_s) and usual <= AT_ONCE * even_s and (np.diff(time_s) > 0).all()
    if not is_even:
        return dataclasses.replace(log, warnings=(*log.warnings, words))
    rate_hz = 1.0 / even_s
    return dataclasses.replace(
        log, time_s=time_s, warnings=(*log.warnings, f"{words}: they are put at an even {rate_hz:.4g} Hz")
    )


def _once(log: ImuLog) -> ImuLog:
    """The log without rows that were written twice, and a word on them; all of it where values often repeat."""
    said = [values for values in (log.acc, log.gyr, log.q_world_sensor) if values is not None]
    same = np.all([(values[1:] == values[:-1]).all(axis=1) for values in said], axis=0)
    again = np.append(False, same & (np.diff(log.time_s) == 0))
    if not again.any() or (same & ~again[1:]).mean() > REPEATING:
        return log
    words = f"{log.path}:{log.lines[np.argmax(again)]}: {int(again.sum())} rows are written twice: each is taken once"
    return dataclasses.replace(log, warnings=(*log.warnings, words)).kept(~again)


def _stepping(log: ImuLog) -> ImuLog:
    """The log with times of a coarse clock, of which some are the same, put even, and a word on it."""
    interval = np.diff(log.time_s)
    repeated = interval == 0
    if repeated.sum() < FEW_STEPS or repeated.mean() < REPEATING or not (interval > 0).any():
        return log
    step_s = float(np.median(interval[interval > 0]))
    even = _evenly(log.time_s, step_s)
    if even is None or not (np.diff(even) > 0).all():
        return log
    # Whether a step is told by its end or its beginning is not known.
    time_s = even + float(np.mean(log.time_s - even))
    rate_hz = 1.0 / float(np.median(np.diff(even)))
    words = (
        f"{log.path}: the clock goes in steps of {step_s:.4g} s, several samples to one: they are put at an even "
        f"{rate_hz:.4g} Hz"
    )
    return dataclasses.replace(log, time_s=time_s, warnings=(*log.warnings, words))


def _evenly(time_s: Array, wait_s: float) -> Array | None:
    """Times at an even rate, none later than it arrived; None where some were lost."""
    number = np.arange(len(time_s))
    if len(time_s) < FEW:
        return None
    slope, start = np.polyfit(number, time_s - time_s[0], 1)
    line = time_s[0] + start + slope * number
    late = time_s - line
    return None if np.ptp(late) > LATE * wait_s else np.asarray(line + late.min())
