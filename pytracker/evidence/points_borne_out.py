"""Whether keypoints bear a pose out, where there is no picture to ask: arms where their points are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker._core import KEYPOINTS
from pytracker.evidence.borne_out import ARMS, WINDOW_S
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["PointsBorneOut", "median_of_known"]

LIMBS = (*ARMS, "left_shoulder", "right_shoulder")
"""Joints that every detector means alike; heads and hips it does not."""
ELSEWHERE_M = 0.15
"""A joint so far from its point is not where it is thought to be; right ones are 2 to 4 cm off."""


def median_of_known(rows: Array) -> Array:
    """Column by column, of what is known: one wild point says nothing; NaN where nothing is."""
    known = np.isfinite(rows)
    return np.array([np.median(rows[of, k]) if (of := known[:, k]).any() else np.nan for k in range(rows.shape[1])])


class PointsBorneOut:
    """What the frames so far say of the pose."""

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._time_s: list[float] = []
        self._off_m: list[list[float]] = []

    def look(self, time_s: float, joints: Mapping[str, Array], keypoints: Array | None) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and the points of everyone in it `(P, 9, 3)`, px."""
        self._time_s.append(time_s)
        self._off_m.append(self._apart_m(joints, keypoints))

    def _apart_m(self, joints: Mapping[str, Array], keypoints: Array | None) -> list[float]:
        """How far each of `LIMBS` is from its point across the picture, m; NaN where it is not seen.

        Of several people the one whose points are nearest.
        """
        if keypoints is None or not len(keypoints):
            return [np.nan] * len(LIMBS)
        places = np.stack([joints[name] for name in LIMBS])
        at = [KEYPOINTS.index(name) for name in LIMBS]
        apart = np.linalg.norm(keypoints[:, at, :2] - self._camera.project(places), axis=2)
        apart = apart / self._camera.px_per_m(places)
        means = [float(np.nanmean(person)) if np.isfinite(person).any() else np.inf for person in apart]
        return [float(x) for x in apart[int(np.argmin(means))]]

    @property
    def median_off_m(self) -> Array:
        """How far the points are off in every frame so far, the median of `LIMBS` `(T,)`, m; NaN where none is seen."""
        return median_of_known(np.array(self._off_m).reshape(-1, len(LIMBS)).T)

    def reasons(self) -> list[dict[str, str]]:
        """Of every frame, in words, by joint; `""` is the frame. Those are left out that nothing speaks against."""
        time_s, off = np.array(self._time_s), np.array(self._off_m).reshape(-1, len(LIMBS))
        first = np.searchsorted(time_s, time_s - WINDOW_S, side="right")
        reasons: list[dict[str, str]] = []
        for k in range(len(time_s)):
            row = median_of_known(off[first[k] : k + 1])
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
