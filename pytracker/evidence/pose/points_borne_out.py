"""Whether keypoints bear a pose out, where there is no picture to ask: arms where their points are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker.evidence.points.followed import ARMS, LIMBS, limbs_off_m
from pytracker.evidence.pose.lately import Lately, median_of_known
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["PointsBorneOut", "median_off_m", "worst_arm_off_m"]

SIDES = ("left", "right")
ELSEWHERE_M = 0.15
"""A joint so far from its point is not where it is thought to be; right ones are 2 to 4 cm off."""


class PointsBorneOut:
    """What the frames so far say of the pose."""

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._lately = Lately()

    def look(self, time_s: float, joints: Mapping[str, Array], points: Array | None) -> dict[str, str]:
        """Take a frame's mean joints, `(3,)` each, world, m, and the points of who is followed `(9, 3)`, px.

        In words what lately speaks against joints, by joint; `""` is the frame. Those are left out that nothing speaks
        against.
        """
        lately = median_of_known(self._lately.take(time_s, _off_m(self._camera, joints, points)))
        if np.isnan(lately).all():
            return {"": "no keypoints of the arms"}
        words = {}
        for name, off_m in zip(ARMS, lately, strict=False):
            if np.isnan(off_m):
                words[name] = "no keypoint"
            elif off_m > ELSEWHERE_M:
                words[name] = "its keypoint is elsewhere"
        return words


def median_off_m(camera: Camera | WeakPerspective, joints: Mapping[str, Array], points: Array | None) -> float:
    """How far points `(9, 3)`, px, are off joints, the median of `LIMBS`, m; NaN where none is seen."""
    return float(median_of_known(_off_m(camera, joints, points)[:, None])[0])


def worst_arm_off_m(camera: Camera | WeakPerspective, joints: Mapping[str, Array], points: Array | None) -> float:
    """The same of the three joints of the arm of which it is larger."""
    off_m = _off_m(camera, joints, points)
    of_each = median_of_known(np.stack([off_m[[name.startswith(side) for name in LIMBS]] for side in SIDES], axis=1))
    return float(np.fmax(*of_each))


def _off_m(camera: Camera | WeakPerspective, joints: Mapping[str, Array], points: Array | None) -> Array:
    """Of each of `LIMBS` `(6,)`, m; NaN where not seen."""
    return np.full(len(LIMBS), np.nan) if points is None else limbs_off_m(camera, joints, points[None])[0]
