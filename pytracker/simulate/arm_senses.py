"""What else may see or feel a simulated arm: patches on shoulder and elbow, a sensor on the upper arm.

A patch lies on the skin beside its joint; a sensor on muscle and skin that move, as the forearm's does.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pytracker.recording.recording import Imu
from pytracker.rotation import (
    Array,
    axes_to_quaternion,
    conjugate,
    multiply,
    rotate,
)
from pytracker.simulate.worn import RATE_HZ, Worn

__all__ = ["SENSES", "beside", "upper_arm_imu"]

SENSES = ("shoulder", "elbow", "upper_arm")
"""Patches on two joints, and a sensor."""

ON_SKIN_M = 0.03
"""A patch is so far from its joint."""
DIFFERENCE_S = 2e-3
FLESH_S = 0.03
"""No flesh accelerates in less."""
Path = Callable[[Array], Array]
"""Where something is at times `(T,)`: `(T, 3)`, m."""


def beside(rng: np.random.Generator) -> Array:
    """Where a patch lies beside its joint `(3,)`, world, m."""
    away = rng.standard_normal(3)
    return np.asarray(ON_SKIN_M * away / np.linalg.norm(away))


def upper_arm_imu(shoulder: Path, elbow: Path, worn: Worn, gravity: Array, rng: np.random.Generator) -> Imu:
    """What it says, by the clock of the other one; worn as badly as that."""
    time_s = np.arange(round(worn.duration_s * RATE_HZ) + 1) / RATE_HZ
    noise = rng.standard_normal((len(time_s), 6))

    def turned(at: Array) -> Array:
        y = shoulder(at) - elbow(at)
        y /= np.linalg.norm(y, axis=1, keepdims=True)
        z = np.array([0.0, 0.0, 1.0]) - y * y[:, 2:]
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        return np.asarray(axes_to_quaternion(np.cross(y, z), y, z))

    h = DIFFERENCE_S
    by = multiply(conjugate(turned(time_s - h)), turned(time_s + h))
    rate = by[:, 1:] * np.sign(by[:, :1]) / h
    q = multiply(turned(time_s), worn.mount(time_s, np.linalg.norm(rate, axis=1)))
    h = FLESH_S
    acceleration = (elbow(time_s + h) - 2 * elbow(time_s) + elbow(time_s - h)) / h**2
    acc = rotate(conjugate(q), acceleration + gravity) + worn.acceleration(time_s, acceleration) + 0.03 * noise[:, :3]
    measured = multiply(worn.tilt(time_s, np.linalg.norm(rate, axis=1)), q)
    gyr = rate + 0.01 * noise[:, 3:]
    return Imu(time_s=time_s, acc=acc, q_world_segment=measured, gyr=gyr, segment="right_upper_arm")
