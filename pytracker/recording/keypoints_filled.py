"""Keypoints that nobody saw: held by a detector that lost the person, or filled in between two that were seen.

Pipelines fill gaps by straight lines. A detector's points tremble: none goes straight on, to the last digit, for long.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import Keypoints
from pytracker.recording.keypoint_spreads import without_guesses
from pytracker.series import last_digit, runs

__all__ = ["as_seen", "without_filled", "without_repeats"]

REPEATS = 10
"""So many frames in a row that hold the same points, or a straight line, were not looked at one by one."""
STRAIGHT_PX = 0.005
"""Second differences of points that are filled in are no larger, but for digits that are rounded."""
ROUNDED = 3.0
"""So many units of the last digit a second difference of rounded numbers may be off."""
DIGITS = 3
"""Numbers of more decimals were computed, not rounded."""
TREMBLE = 20.0
"""Those of a joint's other points are usually so many times larger: else straightness tells nothing."""


def as_seen(path: Path, keypoints: Keypoints) -> tuple[Keypoints, tuple[str, ...]]:
    """The same without points that were guessed, held or filled in; words on them."""
    kept, guessed = without_guesses(path, keypoints)
    kept, held = without_repeats(path, kept)
    kept, filled = without_filled(path, kept)
    return kept, (*guessed, *held, *filled)


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
    long = runs(same, REPEATS)
    if not long:
        return keypoints, ()
    points = keypoints.points.copy()
    for first, after in long:
        points[first:after] = np.nan
    first, after = max(long, key=lambda run: run[1] - run[0])
    words = (
        f"{path}: in {sum(after - first for first, after in long)} frames the keypoints repeat those of the frame "
        f"before to the last digit, longest in frames {keypoints.frames[first]} to {keypoints.frames[after - 1]}: "
        "held, not seen, and left out"
    )
    return dataclasses.replace(keypoints, points=points), (words,)


def without_filled(path: Path, keypoints: Keypoints) -> tuple[Keypoints, tuple[str, ...]]:
    """The same without joints that go straight on, to the last digit, again and again; and a word on them."""
    pixels, frames = keypoints.points[..., :2], keypoints.frames
    if len(frames) < REPEATS + 2:
        return keypoints, ()
    bent = np.linalg.norm(pixels[2:] - 2.0 * pixels[1:-1] + pixels[:-2], axis=-1)
    bent[(np.diff(frames)[1:] != 1) | (np.diff(frames)[:-1] != 1)] = np.inf
    most = max(STRAIGHT_PX, ROUNDED * last_digit(pixels, DIGITS))
    points, longest, count = keypoints.points.copy(), (0, 0, 0), 0
    for person, joint in np.ndindex(bent.shape[1:]):
        of_joint = bent[:, person, joint]
        seen = of_joint[np.isfinite(of_joint) & (of_joint > most)]
        if not len(seen) or np.median(seen) < TREMBLE * most:
            continue
        for first, after in runs(of_joint <= most, REPEATS):
            # What it goes on from was seen, and what it comes to, but for a point that is held.
            is_held = float(np.linalg.norm(pixels[after + 1, person, joint] - pixels[first, person, joint])) <= most
            length = after + is_held - first
            points[first + 1 : first + 1 + length, person, joint] = np.nan
            count += length
            longest = max(longest, (length, first + 1, joint))
    if not count:
        return keypoints, ()
    length, first, joint = longest
    name, last = KEYPOINTS[joint].replace("_", " "), frames[first] + length - 1
    words = (
        f"{path}: {count} keypoints lie on a straight line with those of the frames about them, to {most:.3f} px, most "
        f"in a row of the {name} in frames {frames[first]} to {last}: filled in or held, not seen, and left out"
    )
    return dataclasses.replace(keypoints, points=points), (words,)
