"""Whether the samples of a file are those of several sensors in turn: they jump to and fro, and come back."""

from __future__ import annotations

import numpy as np

from pytracker._core import InputError
from pytracker.inertial.log import ImuLog
from pytracker.rotation import Array, rotate

__all__ = ["check_interleaved"]

MOST_SENSORS = 4
FARTHER = 4.0
"""One sensor's neighbouring samples lie at most as far from each other as those two or more apart, but for noise."""
LEAST = {"acc": 1.0, "q_world_sensor": 0.1}
"""Sensors that differ by less may as well be one, m/s² and of a rotation's numbers."""
QUARTILE = 0.75
"""Of how far samples are apart: two of a sensor may follow each other now and then."""
ALWAYS = 0.25
"""So much of that each sensor's mean is off the others', all along."""
ENOUGH = 20


def check_interleaved(log: ImuLog) -> list[str]:
    """Raises `InputError` where orientations of some sensors alternate; a word where accelerations do.

    An arm that trembles at half the rate, or a third, jumps to and fro as well; its orientation hardly does.
    """
    if log.q_world_sensor is not None:
        turned = np.concatenate([rotate(log.q_world_sensor, axis) for axis in np.eye(3)], axis=1)
        if words := _alternates(log, turned, "the orientation", LEAST["q_world_sensor"]):
            raise InputError(f"{words}? Write a file for each")
    words = "" if log.acc is None else _alternates(log, log.acc, "the acceleration", LEAST["acc"])
    return [f"{words}, or does the arm tremble as fast?"] if words else []


def _alternates(log: ImuLog, values: Array, what: str, least: float) -> str:
    """In words that samples jump to and fro between several places; empty where they do not."""
    if len(values) < ENOUGH:
        return ""
    apart = {lag: _apart(values, lag) for lag in range(1, MOST_SENSORS + 1)}
    for lag in range(2, MOST_SENSORS + 1):
        comes_back = apart[1] > max(least, FARTHER * apart[lag])
        if comes_back and _between(values, lag) > ALWAYS * apart[1]:
            return (
                f"{log.path}:{log.lines[0]}: {what} jumps by {apart[1]:.3g} from sample to sample and comes back after "
                f"{lag} ({apart[lag]:.3g}), expected one sensor's: are the rows those of {lag} sensors in turn"
            )
    return ""


def _apart(values: Array, lag: int) -> float:
    """How far samples that are `lag` apart usually are from each other."""
    return float(np.quantile(np.linalg.norm(values[lag:] - values[:-lag], axis=1), QUARTILE))


def _between(values: Array, count: int) -> float:
    """How far the means of every `count`-th sample lie apart, over the whole file."""
    means = [values[k::count].mean(axis=0) for k in range(count)]
    return max(float(np.linalg.norm(a - b)) for a in means for b in means)
