"""Which axis is up in a calibration's world, as its camera sees it."""

from __future__ import annotations

import numpy as np

from pytracker.rotation import Array

__all__ = ["AS_TRC", "axis_up", "words_of"]

AS_TRC = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""How Pose2Sim turns points of its calibration's world for its TRC files."""
CLEAR = 0.8
"""An axis that is more of what is up in the picture is up; where a camera looks down by 37° or more, it may not be."""
LOOKS_UP = 0.26
"""A camera that would look up along it by more (15°) rather looks down steeply, and the axis is level."""


def axis_up(rotation: Array) -> str:
    """Which axis of the world is up in the picture of a camera with `rotation` `(3, 3)`, world to camera.

    `x`, `y` or `z`, with a minus where it points down; empty where the camera looks up, down or askew.
    """
    # v runs down the picture.
    up = -np.asarray(rotation, dtype=float)[1]
    axis = int(np.argmax(np.abs(up)))
    sign = 1.0 if up[axis] > 0 else -1.0
    if abs(up[axis]) < CLEAR or sign * np.asarray(rotation, dtype=float)[2, axis] > LOOKS_UP:
        return ""
    return ("" if sign > 0 else "-") + "xyz"[axis]


def words_of(turn: Array) -> str:
    """What x, y, z are of the world before it was turned `(3, 3)`, by quarter turns: `x, z, -y`."""
    largest = np.argmax(np.abs(turn), axis=1)
    return ", ".join(("-" if turn[k, axis] < 0 else "") + "xyz"[axis] for k, axis in enumerate(largest))
