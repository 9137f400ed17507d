"""Keypoints that nobody saw: held by a detector that lost the person, or filled in between two that were seen.

Pipelines fill gaps by straight lines. A detector's points tremble: none goes straight on, to the last digit, for long.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import Keypoints
from pytracker.rotation import Array

__all__ = ["as_seen", "without_filled", "without_repeats"]

REPEATS = 10
"""So many frames in a row that hold the same points, or a straight line, were not looked at one by one."""
STRAIGHT_PX = 0.005
"""Second differences of points that are filled in are no larger, but for digits that are rounded."""
ROUNDED = 3.0
"""So many units of the last digit a second difference of rounded numbers may be off."""
TREMBLE = 20.0
"""Those of a joint's other points are usually so many times larger: else straightness tells nothing."""


def as_seen(path: Path, keypoints: Keypoints) -> tuple[Keypoints, tuple[str, ...]]:
    """The same without points that were held or filled in; words on them."""
    kept, held = without_repeats(path, keypoints)
    kept, filled = without_filled(path, kept)
    return kept, (*held, *filled)


def without_repeats(path: Path, keypoints: Keypoints) -> tuple[Keypoints, tuple[str, ...]]:
    """The same without rows that repeat the row before to the last digit, again and again; and a word on them.

    Whole pixels may stay the same where somebody stands still.
    """
    rows = keypoints.points.reshape(len(keypoints.points), -1)
    is_seen = np.asarray(np.isfinite(rows).any(axis=1))
    same = np.zeros(len(rows), dtype=bool)
    same[1:] = ((rows[1:] == rows[:-1]) | (np.isnan(rows[1:]) & np.isnan(rows[:-1]))).all(axis=1) & is_seen[1:]
    places = keypoints.points[..., :2]
    if not same.any() or bool(np.all(places[np.isfinite(places)] == np.rint(places[np.isfinite(places)]))):
        return keypoints, ()
    long = _runs(same)
    if not long:
        return keypoints, ()
    points = keypoints.points.copy()
    for a, b in long:
        points[a : b + 1] = np.nan
    a, b = max(long, key=lambda run: run[1] - run[0])
    words = (
        f"{path}: in {sum(b - a + 1 for a, b in long)} frames the keypoints repeat those of the frame before to the "
        f"last digit, longest in frames {keypoints.frames[a]} to {keypoints.frames[b]}: held, not seen, and left out"
    )
    return dataclasses.replace(keypoints, points=points), (words,)


def without_filled(path: Path, keypoints: Keypoints) -> tuple[Keypoints, tuple[str, ...]]:
    """The same without joints that go straight on, to the last digit, again and again; and a word on them."""
    pixels, frames = keypoints.points[..., :2], keypoints.frames
    if len(frames) < REPEATS + 2:
        return keypoints, ()
    bent = np.linalg.norm(pixels[2:] - 2.0 * pixels[1:-1] + pixels[:-2], axis=-1)
    bent[(np.diff(frames)[1:] != 1) | (np.diff(frames)[:-1] != 1)] = np.inf
    most = max(STRAIGHT_PX, ROUNDED * _last_digit(pixels))
    points, longest, count = keypoints.points.copy(), (0, 0, 0), 0
    for person, joint in np.ndindex(bent.shape[1:]):
        of_joint = bent[:, person, joint]
        seen = of_joint[np.isfinite(of_joint) & (of_joint > most)]
        if not len(seen) or np.median(seen) < TREMBLE * most:
            continue
        for a, b in _runs(of_joint <= most):
            # What it goes on from was seen, and what it comes to, but for a point that is held.
            is_held = float(np.linalg.norm(pixels[b + 2, person, joint] - pixels[a, person, joint])) <= most
            length = b + 1 + is_held - a
            points[a + 1 : a + 1 + length, person, joint] = np.nan
            count += length
            longest = max(longest, (length, a + 1, joint))
    if not count:
        return keypoints, ()
    length, first, joint = longest
    name, last = KEYPOINTS[joint].replace("_", " "), frames[first] + length - 1
    words = (
        f"{path}: {count} keypoints lie on a straight line with those of the frames about them, to {most:.3f} px, most "
        f"in a row of the {name} in frames {frames[first]} to {last}: filled in or held, not seen, and left out"
    )
    return dataclasses.replace(keypoints, points=points), (words,)


def _runs(is_so: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last of what is so for `REPEATS` frames in a row."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], is_so, [False]])))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2) if b - a >= REPEATS]


def _last_digit(pixels: Array) -> float:
    """What all numbers are multiples of: a power of ten, 0 where none of them down to a thousandth is it."""
    seen = pixels[np.isfinite(pixels)]
    units = (1.0, 0.1, 0.01, 0.001)
    return next((unit for unit in units if np.allclose(seen / unit, np.rint(seen / unit), atol=1e-4)), 0.0)
