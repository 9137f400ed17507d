"""Whether the trunk is as large in the picture as it is tracked: who comes nearer, or bends, leaves the model behind.

Distance, lean and turn of a body are what one camera tells least, and are not among the channels that are tracked by
default; keypoints of shoulders and hips tell all the same that they have changed.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.evidence.followed import followed
from pytracker.evidence.lately import first_rows, median_of_known
from pytracker.recording.body_view import rate_of
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.recording.recording import BodyRecording
from pytracker.rotation import Array

__all__ = ["NEARER", "TrunkSeen", "against_first", "at_first", "distance_changes"]

CORNERS = [KEYPOINTS.index(f"{side}_{joint}") for joint in ("shoulder", "hip") for side in ("left", "right")]
FIRST_S = 0.25
"""What is seen in the first frames is how large a person is whose pose is given."""
LARGER = 1.08
"""So much longer or wider than at first is no trunk of people who stand where they are: 0.96 to 1.06 on real ones."""
SHORTER = 0.88
"""Nor so much shorter, unless it bends: 0.90 to 1.05."""
NARROWER = 0.7
"""Nor narrower, unless it turns: 0.78 to 1.06."""


NEARER = "comes nearer than is tracked"
FARTHER = "bends or goes farther off than is tracked"
LEAVING = 0.87
"""Length times width: a trunk that bends is shorter, one that turns narrower."""
OFTEN = 0.25
"""A trunk that is larger or smaller in so many of the frames has changed its distance."""


def distance_changes(recording: BodyRecording) -> bool:
    """Whether keypoints show that a person comes nearer or goes farther off, to a camera that can tell."""
    view = recording.view
    if view.keypoints is None or not isinstance(view.camera, Camera):
        return False
    rate_hz = rate_of(view)
    first = {name: rows[0] for name, rows in recording.skeleton.joints(recording.initial[None]).items()}
    trunk = TrunkSeen(view.camera)
    for frame, people in zip(view.keypoints.frames, view.keypoints.points, strict=True):
        trunk.look(frame / rate_hz, first, followed(view.camera, first, people)[0])
    length, width = trunk.ratios().T
    return float(np.mean(_is_nearer(length, width) | ((length < 1.0) & (length * width < LEAVING)))) > OFTEN


def _is_nearer(length: Array, width: Array) -> NDArray[np.bool_]:
    """Larger one way or the other, and on the whole: hips at the picture's edge make a trunk long and narrow."""
    return np.asarray(((length > LARGER) | (width > LARGER)) & (length * width > LARGER))


def against_first(time_s: Array, sizes: Array) -> Array:
    """Sizes `(T, K)` lately, over those of the first frames; NaN, larger and smaller than nothing, where not seen."""
    sizes = np.where(np.isfinite(sizes) & (sizes > 0.0), sizes, np.nan)
    usual = at_first(time_s, sizes)
    lately = [median_of_known(sizes[first : k + 1]) / usual for k, first in enumerate(first_rows(time_s))]
    return np.array(lately).reshape(sizes.shape)


def at_first(time_s: Array, sizes: Array) -> Array:
    """Sizes of the first frames `(K,)`; NaN where not seen."""
    return np.asarray(median_of_known(sizes[time_s <= time_s[:1] + FIRST_S]))


class TrunkSeen:
    """How large keypoints show the trunk, against the pose."""

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._time_s: list[float] = []
        self._ratios: list[tuple[float, float]] = []

    def look(self, time_s: float, joints: Mapping[str, Array], points: Array | None) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and the points of who is followed `(9, 3)`, px."""
        self._time_s.append(time_s)
        self._ratios.append(self._ratio(joints, points))

    def _ratio(self, joints: Mapping[str, Array], points: Array | None) -> tuple[float, float]:
        """Seen over tracked, length and width of the trunk; NaN where not all of its corners are seen."""
        if points is None:
            return np.nan, np.nan
        left, right, root = self._camera.project(
            np.stack([joints[n] for n in ("left_shoulder", "right_shoulder", "root")])
        )
        neck = 0.5 * (left + right)
        left_seen, right_seen, left_hip, right_hip = points[CORNERS, :2]
        middle, hips = 0.5 * (left_seen + right_seen), 0.5 * (left_hip + right_hip)
        with np.errstate(divide="ignore", invalid="ignore"):
            length = np.linalg.norm(middle - hips) / np.linalg.norm(neck - root)
            width = np.linalg.norm(left_seen - right_seen) / np.linalg.norm(left - right)
        return float(length), float(width)

    def ratios(self) -> Array:
        """Seen over tracked, length and width `(T, 2)`, against those of the first frames; NaN where not seen."""
        return against_first(np.array(self._time_s), np.array(self._ratios).reshape(-1, 2))

    def reasons(self) -> list[str]:
        """Of every frame; empty where nothing speaks against it."""
        ratios = self.ratios()
        nearer = _is_nearer(*ratios.T)
        return [NEARER if near else _said(*ratio) for near, ratio in zip(nearer, ratios, strict=True)]


def _said(length: float, width: float) -> str:
    if length < SHORTER:
        return FARTHER
    return "turns farther than is tracked" if width < NARROWER else ""
