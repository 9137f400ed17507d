"""Calibrations of laboratories have their z axis up, a body's world its y axis: the camera is turned to it."""

from __future__ import annotations

import numpy as np

from pytracker.rotation import Array

__all__ = ["as_trc", "as_z_up", "axis_up"]

CLEAR = 0.7
"""An axis that is so much of what is up in the picture is up: no camera is rolled farther."""


def axis_up(rotation: Array) -> str:
    """Which axis of the world is up in the picture of a camera with `rotation` `(3, 3)`, world to camera.

    `x`, `y` or `z`, with a minus where it points down; empty where the camera looks up, down or askew.
    """
    # v runs down the picture.
    up = -np.asarray(rotation, dtype=float)[1]
    axis = int(np.argmax(np.abs(up)))
    if abs(up[axis]) < CLEAR:
        return ""
    return ("" if up[axis] > 0 else "-") + "xyz"[axis]


def as_z_up(rotation: Array) -> Array:
    """The camera in the world whose x, y, z are x, z, -y: as `[truth] up = "z"` turns points."""
    return np.asarray(np.asarray(rotation) @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]))


def as_trc(rotation: Array) -> Array:
    """The camera in the world whose x, y, z are y, z, x: as Pose2Sim turns the points of its TRC files."""
    return np.asarray(np.asarray(rotation)[:, [1, 2, 0]])
