"""Noise that every sensor has: one that repeats itself hangs, one with too much of it is disturbed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.inertial.bursts import comes_in_bursts
from pytracker.inertial.log import ImuLog
from pytracker.series import noise_sd

__all__ = ["check_noise", "repeats"]

Float = NDArray[np.float64]

HANGS_S = 1.0
"""A sensor that repeats itself for longer hangs, s."""
AXES = "xyz"
FROZEN_BESIDE = {"acc": 0.5, "gyr": 0.25}
"""An axis that stays the same while the others vary by so much (m/s², rad/s, standard deviation) is frozen."""
NOISE_RAD_S = 0.15
"""A gyroscope with more noise from sample to sample is worse than any that is worn."""


def check_noise(log: ImuLog) -> list[str]:
    """Warns of a gyroscope that is mostly noise, told from how much neighbouring samples differ beyond their trend."""
    if log.gyr is None or len(log.gyr) < 50 or comes_in_bursts(log):
        return []
    noise = noise_sd(log.gyr)
    axis = int(np.argmax(noise))
    limit = max(NOISE_RAD_S, 0.3 * float(log.gyr[:, axis].std()) if np.median(np.diff(log.time_s)) > 0.015 else 0.0)
    if noise[axis] <= limit:
        return []
    return [
        f"{log.path}: the gyroscope's {AXES[axis]} is noise of {noise[axis]:.2f} rad/s from sample to sample, "
        f"expected less than {limit:.2f}: is it in other units than rad/s, or disturbed?"
    ]


def repeats(log: ImuLog) -> list[str]:
    """Warns of an IMU that says the same for long, or of one axis of it: noise never does, a sensor that hangs does."""
    return _all_repeat(log) or _one_repeats(log)


def _one_repeats(log: ImuLog) -> list[str]:
    for name, beside in FROZEN_BESIDE.items():
        values = getattr(log, name)
        for axis in range(3) if values is not None else ():
            a, b = _longest_same(log, values[:, [axis]])
            lasted = log.time_s[b] - log.time_s[a]
            if lasted <= HANGS_S or np.all(values[:, axis] == values[0, axis]):
                continue
            if np.delete(values[a : b + 1], axis, axis=1).std(axis=0).max() > beside:
                return [
                    f"{log.path}:{log.lines[a]}: {name}_{AXES[axis]} stays {values[a, axis]:.4g} for "
                    f"{lasted:.3f} s while the other axes move, expected some change: did it hang?"
                ]
    return []


def _longest_same(log: ImuLog, values: Float) -> tuple[int, int]:
    """First and last sample of the longest time without any change in `values` `(M, K)`."""
    changes = np.flatnonzero(np.any(np.diff(values, axis=0) != 0, axis=1)) + 1
    starts, ends = np.concatenate([[0], changes]), np.concatenate([changes - 1, [len(log.time_s) - 1]])
    longest = int(np.argmax(log.time_s[ends] - log.time_s[starts]))
    return int(starts[longest]), int(ends[longest])


def _all_repeat(log: ImuLog) -> list[str]:
    said = [values for values in (log.acc, log.gyr, log.mag) if values is not None]
    a, b = _longest_same(log, np.hstack(said))
    lasted = log.time_s[b] - log.time_s[a]
    if lasted <= HANGS_S:
        return []
    return [
        f"{log.path}:{log.lines[a]}: every reading stays the same for {lasted:.3f} s, expected some noise: "
        "did the sensor hang?"
    ]
