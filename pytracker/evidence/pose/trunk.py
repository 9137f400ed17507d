"""Whether the trunk is as large in the picture as it is tracked: who comes nearer, or bends, leaves the model behind.

Distance, lean and turn of a body are what one camera tells least, and are not among the channels that are tracked by
default; keypoints of shoulders and hips tell all the same that they have changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pytracker._core import KEYPOINTS
from pytracker.evidence.points.followed import followed
from pytracker.evidence.pose.lately import AtFirst, Lately, median_of_known
from pytracker.recording.body_view import rate_of
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.recording.recording import BodyRecording
from pytracker.rotation import Array

__all__ = ["NEARER", "Trunk", "TrunkSeen", "distance_changes"]

CORNERS = [KEYPOINTS.index(f"{side}_{joint}") for joint in ("shoulder", "hip") for side in ("left", "right")]
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


@dataclass(frozen=True)
class Trunk:
    """How a trunk is seen lately, against its first frames and against what is tracked; NaN where it is not seen.

    Attributes:
        length, width: of the trunk, seen over tracked, over the same of the first frames.
        hips: how wide they are, which are no joints that are tracked, over its length, over the same.
        right, down: how far they are of where they were at first, in lengths of the trunk.
    """

    length: float
    width: float
    hips: float
    right: float
    down: float

    @property
    def is_nearer(self) -> bool:
        """Larger one way or the other, and on the whole: hips at the picture's edge make a trunk long and narrow."""
        return (self.length > LARGER or self.width > LARGER) and self.length * self.width > LARGER

    @property
    def words(self) -> str:
        """What that speaks against who stands where they are; empty where it does not."""
        if self.is_nearer:
            return NEARER
        if self.length < SHORTER:
            return FARTHER
        return "turns farther than is tracked" if self.width < NARROWER else ""

    @property
    def left_its_place(self) -> bool:
        """Whether it is nearer or farther off, and not bent where it stands."""
        sizes = (self.length, self.width, self.hips)
        if self.is_nearer:
            return float(np.hypot(self.right, self.down)) > MOVED or bool(np.min(sizes) > ALIKE)
        if not (self.length < 1.0 and self.length * self.width < LEAVING):
            return False
        return float(np.hypot(self.right, min(self.down, 0.0))) > MOVED or bool(np.max(sizes) < 1.0 / ALIKE)


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
    left = [
        trunk.look(frame / rate_hz, first, followed(view.camera, first, people)[0]).left_its_place
        for frame, people in zip(view.keypoints.frames, view.keypoints.points, strict=True)
    ]
    return float(np.mean(left)) > OFTEN


class TrunkSeen:
    """How large keypoints show the trunk, against the pose.

    Args:
        camera: what sees it.
    """

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._lately, self._first = Lately(), AtFirst()

    def look(self, time_s: float, joints: Mapping[str, Array], points: Array | None) -> Trunk:
        """Take a frame's mean joints, `(3,)` each, world, m, and the points of who is followed `(9, 3)`, px."""
        row = np.full(6, np.nan) if points is None else self._seen(joints, points[CORNERS, :2])
        self._first.take(time_s, row)
        lately, first = median_of_known(self._lately.take(time_s, row)), self._first.median
        with np.errstate(divide="ignore", invalid="ignore"):
            length, width, hips = lately[:3] / first[:3]
            right, down = (lately[4:] - first[4:]) / first[3]
        return Trunk(float(length), float(width), float(hips), float(right), float(down))

    def _seen(self, joints: Mapping[str, Array], corners: Array) -> Array:
        """Length, width and hips, seen over tracked; its length, and where the hips are, px; by `CORNERS` `(4, 2)`."""
        left, right, root = self._camera.project(
            np.stack([joints[n] for n in ("left_shoulder", "right_shoulder", "root")])
        )
        left_seen, right_seen, left_hip, right_hip = corners
        middle, hips = 0.5 * (left_seen + right_seen), 0.5 * (left_hip + right_hip)
        length_px = float(np.linalg.norm(middle - hips))
        with np.errstate(divide="ignore", invalid="ignore"):
            tall = np.linalg.norm(0.5 * (left + right) - root)
            width = np.linalg.norm(left_seen - right_seen) / np.linalg.norm(left - right)
            sizes = np.array([length_px / tall, width, np.linalg.norm(left_hip - right_hip) / tall])
        sizes[~(np.isfinite(sizes) & (sizes > 0.0))] = np.nan
        return np.array([*sizes, length_px, *hips])
