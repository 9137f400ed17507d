"""Whether a video and an IMU go at the same rate: a patch's way laid over the IMU's as lags are, at other rates too.

A video whose frame rate is told wrongly, or a sensor's file whose rate is, has a clock that is right at one moment
only. As with a lag neither camera, heading nor mount need to be known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pytracker.evidence.lag import EDGE_S, GRID_S, banded, explained_by
from pytracker.rotation import Array

__all__ = ["Rate", "find_rate"]

MOST, STEP = 0.25, 0.005
"""From 24 frames/s for 30, to rates so near that a minute does not tell them apart."""
FIRST_S = 60.0
LAG_S = 0.6
"""No lag is looked for (`pytracker.evidence.lag` does): clocks are right at some moment."""
LEAST_S = 8.0
"""Shorter ones fit at many a rate."""
LEAST_EXPLAINED = 0.6
"""Where less is explained at any rate, something else is wrong, or nothing moves."""


@dataclass(frozen=True)
class Rate:
    """The rate that lays the IMU over the picture best.

    Attributes:
        slower: by so large a share more time passes between the IMU's samples than is given.
        explained: share of the movement in the picture that the IMU's movement explains at that rate.
        as_given: the same at the rates that are given.
        gain_s: logarithm of how many times more is left unexplained as given, times the seconds that are compared.
    """

    slower: float
    explained: float
    as_given: float
    gain_s: float


def find_rate(frame_s: Array, pixels: Array, imu_s: Array, acceleration: Array) -> Rate | None:
    """The best rate; none where too little is seen or explained, or where the best may lie beyond those that are tried.

    `pixels` `(T, 2)` are where the patch was at `frame_s`; `acceleration` `(M, 3)` is the IMU's at `imu_s`, by the
    video's clock as far as it is known, in an earth frame without gravity.
    """
    first = frame_s <= frame_s[0] + FIRST_S
    seen = np.isfinite(pixels[first]).all(axis=1)
    if seen.sum() < 2 or seen.mean() * np.ptp(frame_s[first]) < LEAST_S or len(imu_s) < 2:
        return None
    edge = round(EDGE_S / GRID_S)
    camera_s, camera = banded(frame_s[first], pixels[first])
    steps = round(MOST / STEP)
    rates = STEP * np.arange(-steps, steps + 1)
    explained = np.array([_explained(camera_s, camera[edge:-edge], imu_s, acceleration, rate) for rate in rates])
    best, given = int(explained.argmax()), steps
    if not explained[best] > LEAST_EXPLAINED or best in (0, len(rates) - 1):
        return None
    compared_s = GRID_S * (len(camera) - 2 * edge)
    left = np.maximum(1.0 - explained[[given, best]], 1e-9)
    gain_s = float(np.log(left[0] / left[1])) * compared_s
    return Rate(float(rates[best]), float(explained[best]), max(float(explained[given]), 0.0), gain_s)


def _explained(camera_s: float, camera: Array, imu_s: Array, acceleration: Array, slower: float) -> float:
    """The largest share that is explained near the given clock, by most of what the camera saw."""
    imu_start, imu = banded(imu_s + slower * (imu_s - camera_s), acceleration, integrations=2)
    edge = round(EDGE_S / GRID_S)
    if len(imu) < 3 * edge:
        return 0.0
    share, overlap = explained_by(camera, imu[edge:-edge])
    # Position k: the camera's first sample is met by the IMU's number k - (len(camera) - 1).
    offsets = camera_s - imu_start - GRID_S * (np.arange(len(share)) - (len(camera) - 1))
    near = (np.abs(offsets) < LAG_S) & (overlap > 0.6 * len(camera))
    return float(share[near].max()) if near.any() else 0.0
