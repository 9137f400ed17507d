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
"""Length times width of who goes farther off: a trunk that bends is shorter, one that turns narrower."""
ALIKE = 1.08
"""What is larger or smaller by so much in length, width and hips alike is nearer or farther off, wherever it is."""
MOVED = 0.3
"""Hips that are so far from where they were at first, in lengths of the trunk, went there: those of people who bend or
turn where they stand stay within 0.17, of people who walk across a picture they are 0.4 to 1 off. Those that go down
in the picture while the trunk is smaller sit down."""
OFTEN = 0.15
"""A trunk that is larger or smaller in so many of the frames has changed its distance."""


def distance_changes(recording: BodyRecording) -> bool:
    """Whether keypoints show that a person comes nearer or goes farther off, to a camera that can tell.

    Who bends where they stand is smaller too; but their hips are not, and stay in their place.
    """
    view = recording.view
    if view.keypoints is None or not isinstance(view.camera, Camera):
        return False
    rate_hz = rate_of(view)
    first = {name: rows[0] for name, rows in recording.skeleton.joints(recording.initial[None]).items()}
    trunk = TrunkSeen(view.camera)
    for frame, people in zip(view.keypoints.frames, view.keypoints.points, strict=True):
        trunk.look(frame / rate_hz, first, followed(view.camera, first, people)[0])
    sizes = trunk.sizes()
    length, width, _ = sizes.T
    all_larger, all_smaller = sizes.min(axis=1) > ALIKE, sizes.max(axis=1) < 1.0 / ALIKE
    right, down = trunk.hips_moved().T
    is_nearer = _is_nearer(length, width) & ((np.hypot(right, down) > MOVED) | all_larger)
    went_off = np.hypot(right, np.minimum(down, 0.0)) > MOVED
    is_farther = (length < 1.0) & (length * width < LEAVING) & (went_off | all_smaller)
    return float(np.mean(is_nearer | is_farther)) > OFTEN


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
        self._sizes: list[tuple[float, float, float]] = []
        self._hips: list[Array] = []

    def look(self, time_s: float, joints: Mapping[str, Array], points: Array | None) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and the points of who is followed `(9, 3)`, px."""
        self._time_s.append(time_s)
        self._sizes.append(self._size(joints, points))
        self._hips.append(np.full((2, 2), np.nan) if points is None else _neck_and_hips(points))

    def _size(self, joints: Mapping[str, Array], points: Array | None) -> tuple[float, float, float]:
        """Seen over tracked, length, width and hips of the trunk; NaN where not all of its corners are seen.

        Hips, which are no joints that are tracked, over its length.
        """
        if points is None:
            return np.nan, np.nan, np.nan
        left, right, root = self._camera.project(
            np.stack([joints[n] for n in ("left_shoulder", "right_shoulder", "root")])
        )
        neck = 0.5 * (left + right)
        left_seen, right_seen, left_hip, right_hip = points[CORNERS, :2]
        middle, hips = _neck_and_hips(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            tall = np.linalg.norm(neck - root)
            length = np.linalg.norm(middle - hips) / tall
            width = np.linalg.norm(left_seen - right_seen) / np.linalg.norm(left - right)
            across = np.linalg.norm(left_hip - right_hip) / tall
        return float(length), float(width), float(across)

    def sizes(self) -> Array:
        """Seen over tracked, length, width and hips `(T, 3)`, against those of the first frames; NaN where not seen."""
        return against_first(np.array(self._time_s), np.array(self._sizes).reshape(-1, 3))

    def hips_moved(self) -> Array:
        """How far right and down the hips are of where they were at first, in lengths of the trunk `(T, 2)`."""
        time_s, seen = np.array(self._time_s), np.array(self._hips).reshape(-1, 2, 2)
        lengths = np.linalg.norm(seen[:, 0] - seen[:, 1], axis=1, keepdims=True)
        lately = np.array([median_of_known(seen[first : k + 1, 1]) for k, first in enumerate(first_rows(time_s))])
        moved = lately.reshape(-1, 2) - at_first(time_s, seen[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(moved / at_first(time_s, lengths))

    def reasons(self) -> list[str]:
        """Of every frame; empty where nothing speaks against it."""
        sizes = self.sizes()[:, :2]
        nearer = _is_nearer(*sizes.T)
        return [NEARER if near else _said(*size) for near, size in zip(nearer, sizes, strict=True)]


def _neck_and_hips(points: Array) -> Array:
    """Middles of shoulders and hips `(2, 2)`, px."""
    left, right, left_hip, right_hip = points[CORNERS, :2]
    return np.stack([0.5 * (left + right), 0.5 * (left_hip + right_hip)])


def _said(length: float, width: float) -> str:
    if length < SHORTER:
        return FARTHER
    return "turns farther than is tracked" if width < NARROWER else ""
