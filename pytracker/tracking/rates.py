"""Whether an arm's video and its sensor go at the rates that are given: at others a track is off, and as sure of it."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.rates import find_rate
from pytracker.formats.imu_gravity import GRAVITY
from pytracker.rotation import rotate
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import where_of

__all__ = ["OTHER_RATE_S", "of_rates"]

OTHER_RATE_S = 5.0
"""By so much another rate must lay a sensor over the picture better: right ones, worn and captured too, do by 3.6."""


def of_rates(track: ArmTrack) -> tuple[str, ...]:
    """A sentence where the sensor moves as the patch does at another rate."""
    imu, sightings = track.recording.imus[0], track.sightings
    acceleration = rotate(imu.q_world_segment, imu.acc) - np.array([0.0, 0.0, GRAVITY])
    rate = find_rate(sightings.time_s, sightings.pixels[:, 0], imu.time_s, acceleration)
    if rate is None or rate.gain_s < OTHER_RATE_S:
        return ()
    goes = f"{abs(rate.slower):.1%} {'slower' if rate.slower > 0 else 'faster'}"
    return (
        f"{where_of(track.recording)}: the patch moves as the IMU does where the IMU's clock goes {goes} than the "
        f"video's ({rate.explained:.1%} of its way in the picture is explained then, {rate.as_given:.1%} as it is): "
        "check the video's frame rate and the IMU's rate_hz or drift_ppm",
    )
