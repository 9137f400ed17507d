"""What inertial sensors on the arms say at a frame: where their segments point, and how those are rolled."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.silhouette import Orientation
from pytracker.recording import Imu

__all__ = ["Worn"]

STALE_S = 0.1
"""A sample older than this says nothing of a frame."""
ROLL_SD = 0.35
"""Of an upper arm: its muscles turn about the bone, rad.

A forearm turns within itself, which the state does not hold.
"""


class Worn:
    """What the sensors of a body say, frame by frame."""

    def __init__(self, imus: tuple[Imu, ...], sds_rad: tuple[float, ...]) -> None:
        """Sensors with `q_world_segment`, and how well each tells where its segment points, rad."""
        self._imus = tuple(zip(imus, sds_rad, strict=True))

    def __call__(self, time_s: float) -> tuple[Orientation, ...]:
        """At a frame: the latest sample of each that is not stale."""
        said = []
        for imu, sd in self._imus:
            k = int(np.searchsorted(imu.time_s, time_s, side="right")) - 1
            if k >= 0 and time_s - imu.time_s[k] <= STALE_S:
                w, x, y, z = (float(value) for value in imu.q_world_sensor[k])
                said.append((imu.segment, (w, x, y, z), sd, ROLL_SD if "upper" in imu.segment else float("inf")))
        return tuple(said)
