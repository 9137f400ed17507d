"""What the hand does on the table, in units of the pattern's radius about its centre.

The rehabilitation exercises that Tao & Hu name (IV-A): a circle, a rectangle, reaching for targets.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pytracker.rotation import Array

__all__ = ["PATTERNS"]

RAMP_S = 0.5


def _circle(time_s: Array, period_s: float) -> Array:
    """Counter-clockwise from the right, at rest at first, at full speed after `RAMP_S`."""
    ramp = np.clip(time_s, 0.0, RAMP_S)
    # The integral of (1 - cos(pi t / RAMP)) / 2: speed and acceleration are continuous.
    travelled = 0.5 * (ramp - RAMP_S / np.pi * np.sin(np.pi * ramp / RAMP_S)) + np.maximum(time_s - RAMP_S, 0.0)
    angle = 2 * np.pi * travelled / period_s
    return np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)


def _through(corners: Array, time_s: Array, period_s: float) -> Array:
    """From corner to corner and back to the first in one period, minimum jerk, at rest in each."""
    sides = len(corners)
    position = np.maximum(time_s, 0.0) / period_s * sides
    side = np.floor(position).astype(int)
    u = (position - side)[:, None]
    eased = u**3 * (10 - 15 * u + 6 * u**2)
    start, end = corners[side % sides], corners[(side + 1) % sides]
    return np.asarray(start + eased * (end - start))


def _rectangle(time_s: Array, period_s: float) -> Array:
    """Counter-clockwise from the near right corner, 3 wide to 2 deep."""
    depth = 2.0 / 3.0
    corners = np.array([[1.0, -depth, 0.0], [1.0, depth, 0.0], [-1.0, depth, 0.0], [-1.0, -depth, 0.0]])
    return _through(corners, time_s, period_s)


def _reach(time_s: Array, period_s: float) -> Array:
    """From home out to three targets in turn and back, slightly above the table."""
    home = np.array([0.0, -1.0, 0.0])
    targets = np.array([[-0.8, 0.6, 0.3], [0.0, 1.0, 0.5], [0.8, 0.6, 0.3]])
    corners = np.concatenate([np.stack([home, target]) for target in targets])
    return _through(corners, time_s, 3 * period_s)


def _gesture(time_s: Array, period_s: float) -> Array:
    """Freely about, above the table, livelier than an exercise.

    Three waves an axis without a common period, from rest.
    """
    ramp = 1.0 - np.exp(-0.5 * (np.maximum(time_s, 0.0) / RAMP_S) ** 2)
    phase = 2 * np.pi * np.maximum(time_s, 0.0)[:, None] / (0.6 * period_s)
    waves = np.array([[1.0, 1.618, 0.414], [0.732, 1.414, 0.577], [0.854, 1.236, 0.382]])
    swing = np.stack([(np.sin(phase * waves[d]) * [0.5, 0.25, 0.25]).sum(axis=1) for d in range(3)], axis=1)
    return np.asarray(ramp[:, None] * swing * [1.6, 0.8, 1.3] + [0.0, -0.2, 1.2])


PATTERNS: dict[str, Callable[[Array, float], Array]] = {
    "circle": _circle,
    "rectangle": _rectangle,
    "reach": _reach,
    "gesture": _gesture,
}
"""Pattern by name: (times `(T,)`, period in s) to positions `(T, 3)` in radii."""
