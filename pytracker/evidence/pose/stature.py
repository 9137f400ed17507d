"""Whether a person is as tall in the foreground as at first: who comes nearer leaves the model behind.

What `trunk` asks of keypoints, of a video alone: from the crown above the tracked head down to the feet. Arms that are
raised do not count; feet that the picture cuts off tell nothing.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker.evidence.pose.borne_out import COLUMN_M, CROWN_M
from pytracker.evidence.pose.lately import AtFirst, Lately, median_of_known
from pytracker.evidence.pose.trunk import NEARER
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["StatureSeen"]

RIM_PX = 2
"""A foreground that ends so near the rim of the picture goes on beyond it."""
FARTHER = "bends, squats or goes farther off than is tracked"
FARTHER_OR_HELD = f"{FARTHER}, or the background, a median, holds a part of the person: give one without"
TALLER = 1.10
SHORTER = 0.82
"""Of people who stand where they are it is 0.90 to 1.05 times as tall as at first."""


class StatureSeen:
    """How tall the foreground shows a person, against the pose.

    Args:
        camera: what sees it.
        first: ends of all bones in the first pose `(B, 3)`, world, m.
        head: end of the head there `(3,)`.
        is_median: whether the background is the video's median, which may hold a part of the person.
    """

    def __init__(self, camera: Camera | WeakPerspective, first: Array, head: Array, *, is_median: bool = False) -> None:
        self._farther = FARTHER_OR_HELD if is_median else FARTHER
        self._camera = camera
        lowest, top = float(camera.project(first)[:, 1].max()), float(camera.project(head[None])[0, 1])
        self._model_m = (lowest - top) / float(camera.px_per_m(head[None])[0]) + CROWN_M
        self._lately, self._first = Lately(), AtFirst()

    def look(self, time_s: float, joints: Mapping[str, Array], foreground: Image) -> str:
        """Take a frame's mean joints, `(3,)` each, world, m, and its foreground `(H, W)`, 255 where the person is.

        What lately speaks against it, in words; empty where nothing does, and where feet were not seen at first.
        A background that holds a part of the person shows them shorter than the model at first: they are nearer where
        they are taller than that.
        """
        row = np.array([self._tall(joints, foreground)])
        self._first.take(time_s, row)
        (tall_m,), (first_m,) = median_of_known(self._lately.take(time_s, row)), self._first.median
        held = self._model_m / first_m
        if tall_m / first_m > TALLER * (held if held > TALLER else 1.0):
            return NEARER
        return self._farther if tall_m / first_m < SHORTER else ""

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
        return float((rows[-1] - above[0]) / px_per_m) if rows[-1] > above[0] else float("nan")
