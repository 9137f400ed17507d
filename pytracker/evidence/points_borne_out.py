"""Whether keypoints bear a pose out, where there is no picture to ask: arms where their points are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker.evidence.borne_out import ARMS
from pytracker.evidence.followed import LIMBS, limbs_off_m
from pytracker.evidence.lately import first_rows, median_of_known
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["PointsBorneOut"]

ELSEWHERE_M = 0.15
"""A joint so far from its point is not where it is thought to be; right ones are 2 to 4 cm off."""


class PointsBorneOut:
    """What the frames so far say of the pose."""

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._time_s: list[float] = []
        self._off_m: list[Array] = []

    def look(self, time_s: float, joints: Mapping[str, Array], points: Array | None) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and the points of who is followed `(9, 3)`, px."""
        self._time_s.append(time_s)
        none = np.full(len(LIMBS), np.nan)
        self._off_m.append(none if points is None else limbs_off_m(self._camera, joints, points[None])[0])

    @property
    def median_off_m(self) -> Array:
        """How far the points are off in every frame so far, the median of `LIMBS` `(T,)`, m; NaN where none is seen."""
        return median_of_known(np.array(self._off_m).reshape(-1, len(LIMBS)).T)

    def reasons(self) -> list[dict[str, str]]:
        """Of every frame, in words, by joint; `""` is the frame. Those are left out that nothing speaks against."""
        time_s, off = np.array(self._time_s), np.array(self._off_m).reshape(-1, len(LIMBS))
        reasons: list[dict[str, str]] = []
        for k, first in enumerate(first_rows(time_s)):
            row = median_of_known(off[first : k + 1])
            if np.isnan(row).all():
                reasons.append({"": "no keypoints of the arms"})
                continue
            words = {}
            for name, off_m in zip(ARMS, row, strict=False):
                if np.isnan(off_m):
                    words[name] = "no keypoint"
                elif off_m > ELSEWHERE_M:
                    words[name] = "its keypoint is elsewhere"
            reasons.append(words)
        return reasons
