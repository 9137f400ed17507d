"""Whether a camera stood still: what is at the picture's left and right edge must stay where it is.

Corners of the first frame are followed into a few others (pyramidal Lucas-Kanade, there and back), from where they
were or, of a camera that turned far, from where all of the picture went (phase correlation). People move in the middle;
what moves alike at both edges is the camera. What is not told is as it was told last.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.formats.video import Image, glimpses
from pytracker.rotation import Array

__all__ = ["CameraMoves", "camera_moves"]

LOOKS = 8
"""So many frames are looked at, over the whole video."""
LONGER_PX = 640
"""Of the pictures that are compared."""
CORNERS = 300
LEAST = 5
"""Corners at either edge; fewer say nothing."""
ALIKE_PX, ALIKE = 1.0, 0.6
"""So many of an edge's corners must have moved alike."""
NEAR_PX = 8.0
"""Corners are followed so far from where they were: what the whole picture did by less is somebody's who moved."""
MOST = 0.005
"""Times the longer side: real cameras on stands have 0.0003, and pictures are coded."""


@dataclass(frozen=True)
class CameraMoves:
    """How far a camera shows everything beside where it did at first, at some times.

    Attributes:
        time_s: of the video's clock, increasing, the first frame's first.
        moved_px: by how much, px of the video; as before where nothing tells.
        longer_px: the longer side of its pictures.
    """

    time_s: tuple[float, ...]
    moved_px: tuple[float, ...]
    longer_px: int

    @property
    def least_px(self) -> float:
        """Less than this is no movement: how well that is told at all."""
        return MOST * self.longer_px

    @property
    def words(self) -> str:
        """From when on and by how much; empty where it stood still."""
        for time_s, moved_px in zip(self.time_s, self.moved_px, strict=True):
            if moved_px > self.least_px:
                return (
                    f"the camera moves: at {time_s:.1f} s what is at both edges of the picture is {moved_px:.0f} px "
                    "beside where it was at first, and the camera is taken to stand still: everything is off by as "
                    "much"
                )
        return ""

    def are_beside(self, time_s: Array, most_px: float) -> NDArray[np.bool_]:
        """Which frames, at times `(T,)` of the video's clock, may show everything farther beside than that.

        Between two looks it may be as at either; what is not told in words is none.
        """
        is_beside = np.array(self.moved_px) > max(most_px, self.least_px)
        after = np.searchsorted(self.time_s, time_s, side="left")
        before = np.searchsorted(self.time_s, time_s, side="right") - 1
        last = len(is_beside) - 1
        return np.asarray(is_beside[np.clip(after, 0, last)] | is_beside[np.clip(before, 0, last)])


def camera_moves(video: Path) -> CameraMoves:
    """Looked at in a few frames. Raises `InputError`."""
    looks = glimpses(video, LOOKS)
    image = next(looks).image
    longer_px = max(image.shape[:2])
    scale = min(1.0, LONGER_PX / longer_px)
    first = _small(image, scale)
    found = cv2.goodFeaturesToTrack(first, CORNERS, 0.01, 7)
    corners = np.asarray([] if found is None else found, dtype=np.float32).reshape(-1, 1, 2)
    time_s, moved = [0.0], [np.zeros(2)]
    for frame in looks if len(corners) else ():
        by = _moved(first, _small(frame.image, scale), corners)
        time_s.append(frame.time_s)
        moved.append(moved[-1] if by is None else by)
    return CameraMoves(tuple(time_s), tuple(float(np.linalg.norm(by)) / scale for by in moved), longer_px)


def _small(image: Image, scale: float) -> cv2.typing.MatLike:
    return cv2.resize(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def _moved(first: cv2.typing.MatLike, other: cv2.typing.MatLike, corners: NDArray[np.float32]) -> Array | None:
    """By how much the edge that moved less did, px `(2,)`; None where either does not say."""
    by = _followed(first, other, corners, np.zeros(2))
    if by is not None:
        return by
    window = cv2.createHanningWindow(first.shape[::-1], cv2.CV_32F)
    whole, _ = cv2.phaseCorrelate(first.astype(np.float32), other.astype(np.float32), window)
    return _followed(first, other, corners, np.array(whole)) if np.linalg.norm(whole) > NEAR_PX else None


def _followed(
    first: cv2.typing.MatLike, other: cv2.typing.MatLike, corners: NDArray[np.float32], about: Array
) -> Array | None:
    """The same, of corners that moved `about` so far `(2,)`: by what both pictures show of either edge."""
    guess, flags = np.asarray(corners + about, dtype=np.float32), cv2.OPTFLOW_USE_INITIAL_FLOW
    there, seen, _ = cv2.calcOpticalFlowPyrLK(first, other, corners, guess.copy(), flags=flags)
    back, again, _ = cv2.calcOpticalFlowPyrLK(
        other, first, there, np.asarray(there - about, dtype=np.float32), flags=flags
    )
    is_same = np.linalg.norm((back - corners).reshape(-1, 2), axis=1) < 0.5
    kept = (seen.ravel() == 1) & (again.ravel() == 1) & is_same
    at, moved = np.asarray(corners).reshape(-1, 2)[kept], (there - corners).reshape(-1, 2)[kept]
    left, right = max(0.0, -about[0]), first.shape[1] - max(0.0, about[0])
    quarter = 0.25 * (right - left)
    by_edge = []
    for edge in (at[:, 0] < left + quarter, at[:, 0] > right - quarter):
        if edge.sum() < LEAST:
            return None
        middle = np.median(moved[edge], axis=0)
        if (np.linalg.norm(moved[edge] - middle, axis=1) < ALIKE_PX).mean() < ALIKE:
            return None
        by_edge.append(middle)
    return np.asarray(min(by_edge, key=lambda by: float(np.linalg.norm(by))))
