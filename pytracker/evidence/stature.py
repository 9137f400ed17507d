"""Whether a person is as tall in the foreground as at first: who comes nearer leaves the model behind.

What `trunk` asks of keypoints, of a video alone: from the crown above the tracked head down to the feet. Arms that are
raised do not count; feet that the picture cuts off tell nothing.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker.evidence.borne_out import COLUMN_M
from pytracker.evidence.trunk import NEARER, against_first
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["StatureSeen"]

RIM_PX = 2
"""A foreground that ends so near the rim of the picture goes on beyond it."""
FARTHER = "bends, squats or goes farther off than is tracked"
TALLER = 1.10
SHORTER = 0.82
"""Of people who stand where they are it is 0.90 to 1.05 times as tall as at first."""


class StatureSeen:
    """How tall the foreground shows a person, against the pose."""

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._time_s: list[float] = []
        self._tall_m: list[float] = []

    def look(self, time_s: float, joints: Mapping[str, Array], foreground: Image) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and its foreground `(H, W)`, 255 where the person is."""
        self._time_s.append(time_s)
        self._tall_m.append(self._tall(joints, foreground))

    def _tall(self, joints: Mapping[str, Array], foreground: Image) -> float:
        """From crown to feet, m as of the tracked distance; NaN where either is not seen."""
        (u, _), px_per_m = self._camera.project(joints["head"][None])[0], self._camera.px_per_m(joints["root"][None])[0]
        if not np.isfinite([u, px_per_m]).all() or px_per_m <= 0.0:
            return float("nan")
        reach = round(COLUMN_M * px_per_m)
        above = np.flatnonzero(foreground[:, max(0, round(u) - reach) : max(0, round(u) + reach + 1)].any(axis=1))
        rows = np.flatnonzero(foreground.any(axis=1))
        if not len(above) or above[0] < RIM_PX or rows[-1] >= len(foreground) - RIM_PX:
            return float("nan")
        return float((rows[-1] - above[0]) / px_per_m)

    def reasons(self) -> list[str]:
        """Of every frame; empty where nothing speaks against it, and where feet were not seen at first."""
        recent = against_first(np.array(self._time_s), np.array(self._tall_m).reshape(-1, 1))[:, 0]
        return [NEARER if ratio > TALLER else FARTHER if ratio < SHORTER else "" for ratio in recent]
