"""Whose first pose it is: of the people in the first frames of a detector's keypoints one, joint by joint."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.rotation import Array
from pytracker.setup.poses.keypoints import LEAST_SEEN

__all__ = ["first_person", "first_row"]

AT_FIRST = 5
"""A joint that a detector missed in the first frame is where it is seen in the next ones."""


def first_person(points: Array) -> tuple[Array, int]:
    """Of whoever is largest in the first frame each joint where it was first seen `(9, 3)`; and how many are there.

    `points` are those of all frames and people, `(T, P, 9, 3)`: u, v, confidence, in any order of people. From frame to
    frame one is who is nearest.
    """
    frames = points[:AT_FIRST]
    start = next((k for k, frame in enumerate(frames) if max(_height(one) for one in frame) > 0), 0)
    people = int((_seen(frames[start]).sum(axis=1) >= LEAST_SEEN).sum())
    person = frames[start][int(np.argmax([_height(one) for one in frames[start]]))].copy()
    for frame in frames[start + 1 :]:
        apart = [_apart(one, person) for one in frame]
        if min(apart) < np.inf:
            same, missed = frame[int(np.argmin(apart))], ~_seen(person)
            person[missed] = same[missed]
    return person, people


def first_row(points: Array) -> int | None:
    """The first frame `(T, P, 9, 3)` in which enough of somebody is seen to find a pose; None where there is none."""
    enough = (_seen(points).sum(axis=2) >= LEAST_SEEN).any(axis=1)
    return int(np.argmax(enough)) if enough.any() else None


def _seen(points: Array) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(points[..., :2]).all(axis=-1))


def _apart(one: Array, other: Array) -> float:
    """How far two people `(9, 3)` are apart in the picture, px; infinite where no joint is seen of both."""
    off = np.linalg.norm(one[:, :2] - other[:, :2], axis=1)
    return float(np.nanmedian(off)) if np.isfinite(off).any() else np.inf


def _height(person: Array) -> float:
    """How large somebody is in the picture, by keypoints `(9, 3)`, px."""
    seen = person[_seen(person), :2]
    return float(np.linalg.norm(np.ptp(seen, axis=0))) if len(seen) else -1.0
