"""Keypoints of a hand or an elbow that stay where they were while it goes on, trembling, and then leap to where it is.

Who rests does not leap: from rest nobody's hand is a hand's length on within a frame.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import Keypoints
from pytracker.rotation import Array

__all__ = ["without_stuck"]

STUCK = ("left_elbow", "right_elbow", "left_wrist", "right_wrist")
OTHERS = ("right_elbow", "left_elbow", "right_wrist", "left_wrist")
SHOULDERS_M, TRUNK_M = 0.36, 0.5
"""Between shoulders, and from shoulder to hip, of an adult: whoever is turned aside shows one of them."""
STILL_M = 0.02
"""So near each other are points that stay, but for some."""
MOSTLY, STILL_SHARE = 0.9, 0.6
LEAST_FRAMES, LEAST_S = 10, 0.25
LEAP_M, MOST_M_S2 = 0.12, 60.0
"""A leap is that long, and longer than any arm gets from rest in the time between its frames."""
EXCHANGED_M = 0.06
"""A leap to where the other side's point was is an exchange of both."""
AFTER, STAYS_AWAY = 5, 0.8
"""The points after it are as far, in the median: one that strays for a frame is no leap."""


def without_stuck(path: Path, keypoints: Keypoints, rate_hz: float) -> tuple[Keypoints, tuple[str, ...]]:
    """The same without joints where they were stuck, of a video of `rate_hz`; and a word on them.

    Of several people, whose order may change from frame to frame, it is as it is.
    """
    if keypoints.points.shape[1] > 1:
        return keypoints, ()
    points = keypoints.points.copy()
    places = _scale(points[:, 0]) * points[:, 0, :, :2]
    stuck: list[tuple[int, int, str]] = []
    for name, other in zip(STUCK, OTHERS, strict=True):
        joint, opposite = KEYPOINTS.index(name), KEYPOINTS.index(other)
        for first, last in _stretches(places[:, joint], places[:, opposite], keypoints.frames, rate_hz):
            points[first : last + 1, 0, joint] = np.nan
            stuck.append((last + 1 - first, first, name))
    if not stuck:
        return keypoints, ()
    length, first, name = max(stuck)
    begin, end = keypoints.frames[first], keypoints.frames[first + length - 1]
    words = (
        f"{path}: {sum(one for one, _, _ in stuck)} keypoints stay where they were and then leap, most in a row of the "
        f"{name.replace('_', ' ')} in frames {begin} to {end}: stuck, not seen, and left out"
    )
    return dataclasses.replace(keypoints, points=points), (words,)


def _scale(points: Array) -> float:
    """Metres a pixel of a person's `(T, 9, 3)`; 0 where neither shoulders nor trunk are seen."""
    of = {name: points[:, KEYPOINTS.index(name), :2] for name in ("left_shoulder", "right_shoulder", "left_hip")}
    lengths = [
        (of["left_shoulder"] - of["right_shoulder"], SHOULDERS_M),
        (of["left_shoulder"] - of["left_hip"], TRUNK_M),
    ]
    seen = [(np.linalg.norm(pixels, axis=-1), m) for pixels, m in lengths]
    px_per_m = [np.nanmedian(px) / m for px, m in seen if np.isfinite(px).any()]
    return float(1.0 / max(px_per_m)) if px_per_m and max(px_per_m) > 0.0 else 0.0


def _stretches(places: Array, others: Array, frames: NDArray[np.int64], rate_hz: float) -> list[tuple[int, int]]:
    """First and last row of each, of places `(T, 2)` and the other side's, m."""
    seen = np.flatnonzero(np.isfinite(places).all(axis=1))
    place, frame = places[seen], frames[seen]
    if len(seen) < LEAST_FRAMES + AFTER:
        return []
    far_m = np.maximum(LEAP_M, 0.5 * MOST_M_S2 * (np.diff(frame) / rate_hz) ** 2)
    found = []
    for last in np.flatnonzero(np.linalg.norm(np.diff(place, axis=0), axis=1) > far_m):
        if last + 1 < LEAST_FRAMES or last + AFTER >= len(seen):
            continue
        stuck = np.median(place[last + 1 - LEAST_FRAMES : last + 1], axis=0)
        is_near = np.linalg.norm(place[: last + 1] - stuck, axis=1) < STILL_M
        after = np.median(place[last + 1 : last + 1 + AFTER], axis=0)
        if is_near[-LEAST_FRAMES:].mean() < MOSTLY or np.linalg.norm(after - stuck) < STAYS_AWAY * far_m[last]:
            continue
        first = _begin(is_near)
        is_exchanged = np.linalg.norm(after - others[seen[last]]) < EXCHANGED_M
        if frame[last] - frame[first] >= LEAST_S * rate_hz and not is_exchanged:
            found.append((int(seen[first]), int(seen[last])))
    return found


def _begin(is_near: NDArray[np.bool_]) -> int:
    """Where a stretch begins at whose end points are near a place."""
    first = len(is_near) - 1
    while first > 0 and is_near[max(first - AFTER, 0) : first].mean() >= STILL_SHARE:
        first -= 1
    return first + int(np.argmax(is_near[first:]))
