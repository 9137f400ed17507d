"""Whether the samples of a file are those of several sensors in turn: they jump to and fro, and come back."""

from __future__ import annotations

import numpy as np

from pytracker._core import InputError
from pytracker.formats.imu_log import ImuLog
from pytracker.rotation import Array

__all__ = ["check_interleaved"]

MOST_SENSORS = 4
FARTHER = 4.0
"""One sensor's neighbouring samples lie at most as far from each other as those two or more apart, but for noise."""
LEAST = {"acc": 1.0, "q_world_sensor": 0.1}
"""Sensors that differ by less may as well be one, m/s² and of a quaternion's numbers."""
QUARTILE = 0.75
"""Of how far samples are apart: two of a sensor may follow each other now and then."""
ENOUGH = 20


def check_interleaved(log: ImuLog) -> None:
    """Raises `InputError` where samples of some sensors alternate."""
    for name, least in LEAST.items():
        values = getattr(log, name)
        if values is None or len(values) < ENOUGH:
            continue
        apart = {lag: _apart(values, lag, is_turn=name == "q_world_sensor") for lag in range(1, MOST_SENSORS + 1)}
        of = next((lag for lag in range(2, MOST_SENSORS + 1) if apart[1] > max(least, FARTHER * apart[lag])), None)
        if of is not None:
            what = "the acceleration" if name == "acc" else "the orientation"
            raise InputError(
                f"{log.path}:{log.lines[0]}: {what} jumps by {apart[1]:.3g} from sample to sample and comes back after "
                f"{of} ({apart[of]:.3g}), expected one sensor's: are the rows those of {of} sensors in turn? "
                "Write a file for each"
            )


def _apart(values: Array, lag: int, *, is_turn: bool) -> float:
    """How far samples that are `lag` apart usually are from each other; of a turn q and -q are one."""
    off = np.linalg.norm(values[lag:] - values[:-lag], axis=1)
    if is_turn:
        off = np.minimum(off, np.linalg.norm(values[lag:] + values[:-lag], axis=1))
    return float(np.quantile(off, QUARTILE))
