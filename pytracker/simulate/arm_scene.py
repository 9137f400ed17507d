"""What of a simulated arm is chosen: movement, body, cameras, sensor, and what is wrong with them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pytracker._core import InputError
from pytracker.rotation import Triple
from pytracker.simulate.arm_senses import SENSES
from pytracker.simulate.kinds import check_kind
from pytracker.simulate.patterns import PATTERNS

__all__ = ["ArmScene"]

MOST_FRAMES = 100_000


@dataclass(frozen=True, kw_only=True)
class ArmScene:
    """What is simulated. Raises `InputError` when out of range.

    Attributes:
        pattern: `circle`, `rectangle`, `reach` or `gesture`.
        duration_s: length, s.
        period_s: one turn of the pattern, s.
        centre_m: centre of the pattern, world, m.
        radius_m: radius of the circle; half the width of the rectangle; reach of the targets, m.
        shoulder_m: shoulder joint, world, m.
        upper_arm_m: shoulder to elbow, m.
        forearm_m: elbow to wrist, m.
        elbow_swing: direction towards which the elbow hangs.
        cameras: how many; further ones stand turned by 90° about the vertical.
        frame_rate_hz: camera rate, Hz.
        imu_rate_hz: IMU rate, Hz.
        acc_noise: accelerometer noise, m/s² per sample and axis.
        acc_bias: length of the accelerometer's constant bias, in a random direction, m/s².
        gyr_noise: gyroscope noise, rad/s per sample and axis.
        gyr_bias: length of the gyroscope's constant bias, rad/s.
        orientation_error_deg: RMS angle of the orientation's error, half of it constant, half slow.
        shoulder_motion_m: RMS motion of the shoulder, m.
        patch_offset_m: patch centre in the sensor frame, m from the wrist.
        occlusions: (from, to) in s, when something hides the patch.
        distractor: whether something of the patch's colour moves in the background.
        dropped_imu: share of IMU samples that are missing.
        dropped_frames: share of frames in whose place the one before is shown again.
        clutter_noise: standard deviation of the image noise, grey levels.
        worn: as bad as life (`pytracker.simulate.worn`): sensor, strap, shoulder, clock, lengths and camera are off,
            the IMU gives 60 Hz.
        senses: what there is besides: patches on `shoulder` and `elbow`, a sensor on the `upper_arm` (which is worn).
    """

    pattern: str = "circle"
    duration_s: float = 20.0
    period_s: float = 4.0
    centre_m: Triple = (0.05, 0.30, 0.0)
    radius_m: float = 0.15
    shoulder_m: Triple = (0.10, 0.0, 0.25)
    upper_arm_m: float = 0.30
    forearm_m: float = 0.25
    elbow_swing: Triple = (1.0, 0.0, -0.2)
    cameras: int = 1
    frame_rate_hz: float = 25.0
    imu_rate_hz: float = 100.0
    acc_noise: float = 0.03
    acc_bias: float = 0.1
    gyr_noise: float = 0.01
    gyr_bias: float = 0.005
    orientation_error_deg: float = 1.0
    shoulder_motion_m: float = 0.0
    patch_offset_m: Triple = (0.0, 0.0, 0.0)
    occlusions: tuple[tuple[float, float], ...] = ()
    distractor: bool = False
    dropped_imu: float = 0.0
    dropped_frames: float = 0.0
    clutter_noise: float = 4.0
    worn: bool = False
    senses: tuple[str, ...] = ()

    kind: ClassVar[str] = "arm"

    def __post_init__(self) -> None:
        """Check kinds and ranges."""
        for field in dataclasses.fields(self):
            check_kind(field.name, getattr(self, field.name), field.default)
        for name, is_good, expected in self._ranges():
            if not is_good:
                raise InputError(f"{name} is {getattr(self, name)!r}, expected {expected}")

    def _ranges(self) -> Iterator[tuple[str, bool, str]]:
        """What must hold: parameter, whether it does, what is expected."""
        yield "pattern", self.pattern in PATTERNS, f"one of: {', '.join(PATTERNS)}"
        for name in ("duration_s", "period_s", "radius_m", "upper_arm_m", "forearm_m", "frame_rate_hz", "imu_rate_hz"):
            yield name, getattr(self, name) > 0, "a positive number"
        for name in ("acc_noise", "acc_bias", "gyr_noise", "gyr_bias", "orientation_error_deg", "clutter_noise"):
            yield name, getattr(self, name) >= 0, "0 or more"
        for name in ("dropped_imu", "dropped_frames"):
            yield name, 0 <= getattr(self, name) < 1, "a share from 0 to below 1"
        frames = self.duration_s * self.frame_rate_hz
        yield "duration_s", 1 <= frames <= MOST_FRAMES, f"1 to {MOST_FRAMES} frames at {self.frame_rate_hz} frames/s"
        yield "elbow_swing", bool(np.linalg.norm(self.elbow_swing) > 0), "a direction"
        yield "occlusions", all(start < end for start, end in self.occlusions), "(from, to) with from before to, s"
        yield "cameras", 1 <= self.cameras <= 4, "1 to 4"
        senses = set(self.senses)
        is_good = senses <= set(SENSES) and len(senses) == len(self.senses)
        yield "senses", is_good, f"any of: {', '.join(SENSES)}, each once"
