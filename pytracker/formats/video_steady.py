"""Whether a camera stood still: what is at the picture's left and right edge must stay where it is.

Corners of the first frame are followed into a few others (pyramidal Lucas-Kanade, there and back). People move in the
middle; what moves alike at both edges is the camera.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.formats.video import Image, glimpses

__all__ = ["camera_moves"]

LOOKS = 8
"""So many frames are looked at, over the whole video."""
LONGER_PX = 640
"""Of the pictures that are compared."""
CORNERS = 300
LEAST = 5
"""Corners at either edge; fewer say nothing."""
ALIKE_PX, ALIKE = 1.0, 0.6
"""So many of an edge's corners must have moved alike."""
MOST = 0.005
"""Times the longer side: real cameras on stands have 0.0003, and pictures are coded."""


def camera_moves(video: Path) -> str:
    """In words from when on and by how much; empty where it stood still, or nothing tells. Raises `InputError`."""
    looks = glimpses(video, LOOKS)
    image = next(looks).image
    scale = min(1.0, LONGER_PX / max(image.shape[:2]))
    first = _small(image, scale)
    found = cv2.goodFeaturesToTrack(first, CORNERS, 0.01, 7)
    corners = np.asarray([] if found is None else found, dtype=np.float32).reshape(-1, 1, 2)
    for frame in looks if len(corners) else ():
        moved = _moved(first, _small(frame.image, scale), corners)
        if moved > MOST * max(first.shape):
            return (
                f"the camera moves: at {frame.time_s:.1f} s what is at both edges of the picture is "
                f"{moved / scale:.0f} px beside where it was at first, and the camera is taken to stand still: "
                "everything is off by as much"
            )
    return ""


def _small(image: Image, scale: float) -> cv2.typing.MatLike:
    return cv2.resize(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def _moved(first: cv2.typing.MatLike, other: cv2.typing.MatLike, corners: NDArray[np.float32]) -> float:
    """By how much the edge that moved less did, px; 0 where either does not say."""
    there, seen, _ = cv2.calcOpticalFlowPyrLK(first, other, corners, np.zeros_like(corners))
    back, again, _ = cv2.calcOpticalFlowPyrLK(other, first, there, np.zeros_like(corners))
    is_same = np.linalg.norm((back - corners).reshape(-1, 2), axis=1) < 0.5
    kept = (seen.ravel() == 1) & (again.ravel() == 1) & is_same
    at, moved = np.asarray(corners).reshape(-1, 2)[kept], (there - corners).reshape(-1, 2)[kept]
    width = first.shape[1]
    by_edge = []
    for edge in (at[:, 0] < width / 4, at[:, 0] > 3 * width / 4):
        if edge.sum() < LEAST:
            return 0.0
        middle = np.median(moved[edge], axis=0)
        if (np.linalg.norm(moved[edge] - middle, axis=1) < ALIKE_PX).mean() < ALIKE:
            return 0.0
        by_edge.append(float(np.linalg.norm(middle)))
    return min(by_edge)
