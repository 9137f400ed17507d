"""Worlds whose vertical is another axis than ours: a body's is its y axis, an arm's its z axis."""

from __future__ import annotations

import numpy as np

from pytracker.rotation import Array

__all__ = ["TO_Y", "to_up"]

TO_Y = {
    "x": ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    "-x": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "y": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-y": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "z": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-z": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
}


def to_up(given: str, wanted: str) -> Array:
    """The rotation `(3, 3)` of points from a world whose axis `given` is up to one whose axis `wanted` is."""
    return np.asarray(np.array(TO_Y[wanted], dtype=float).T @ np.array(TO_Y[given], dtype=float))
