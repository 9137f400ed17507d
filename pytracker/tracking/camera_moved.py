"""Frames by a camera that does not stand where it did at first: all in them is off by as much."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.recording.recording import BodyView, View
from pytracker.rotation import Array

__all__ = ["MOVED", "camera_moved"]

MOVED = "the camera has moved"
MOST_M = 0.03
"""Less does no harm where the subject is."""


def camera_moved(view: View | BodyView, time_s: Array, at_m: Array) -> NDArray[np.bool_]:
    """Which frames, at recording times `(T,)`, may show a subject that is about `at_m` `(T, 3)` farther beside."""
    if view.moves is None:
        return np.zeros(len(time_s), dtype=bool)
    px_per_m = float(np.nanmedian(view.camera.px_per_m(at_m)))
    return view.moves.are_beside(time_s - view.start_s, MOST_M * px_per_m)
