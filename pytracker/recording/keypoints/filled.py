"""Keypoints that nobody saw: held by a detector that lost the person, or filled in between two that were seen.

Pipelines fill gaps by straight lines or cubics. A detector's points tremble: none goes straight on, to the last digit,
for long.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import Keypoints
from pytracker.recording.keypoints.spreads import without_guesses
from pytracker.rotation import Array
from pytracker.series import last_digit, runs

__all__ = ["as_seen", "without_filled", "without_repeats"]

REPEATS = 10
"""So many frames in a row that hold the same points, or a straight line, were not looked at one by one."""
STRAIGHT_PX = 0.005
"""Second differences of points on a line, and fourth ones of those on a cubic, are no larger but for rounded digits."""
EXACT_PX = 1e-9
"""Nothing is exacter."""
COARSE_PX = 0.2
"""Of places that are farther apart one may be held by rounding."""
HELD_ORDER = 2
UNITS = {HELD_ORDER: 3.0, 4: 8.0}
"""So many units of the last digit a difference, by its order, of rounded numbers may be off."""
DIGITS = 3
"""Numbers of more decimals were computed, not rounded."""
TREMBLE = 20.0
"""Those of a joint's other points are usually so many times larger: else straightness tells nothing."""
GOES = 20.0
"""Of points that were low-passed, and tremble less, a line goes on by so many times as much: who is still does not."""
CORNER = 0.2
"""A line that was low-passed begins to bend by less of what is usual, at either end."""
MOST_FILLED = 0.25
"""Nobody fills a larger share of a joint's points by curves, or low-passes them after."""
RINGS = 15
"""So many frames about a corner a low-pass rings, at the most."""


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
    """The same without joints that go on by a straight line, or another cubic, again and again; and a word on them.

    Before they are low-passed, or after: the line's middle stays one.
    """
    pixels, frames = keypoints.points[..., :2], keypoints.frames
    unit = last_digit(pixels, DIGITS)
    filled = np.zeros(pixels.shape[:-1], dtype=bool)
    for person, joint in np.ndindex(filled.shape[1:]):
        for order in UNITS:
            filled[:, person, joint] |= _on_polynomial(pixels[:, person, joint], frames, order, unit)
    filled |= _held_throughout(pixels)
    if not filled.any():
        return keypoints, ()
    points = np.where(filled[..., None], np.nan, keypoints.points)
    length, first, joint = max(
        (after - first, first, joint)
        for person, joint in np.ndindex(filled.shape[1:])
        for first, after in runs(filled[:, person, joint])
    )
    name, last = KEYPOINTS[joint].replace("_", " "), frames[first] + length - 1
    words = (
        f"{path}: {filled.sum()} keypoints lie on a straight line or a cubic with those of the frames about them, most "
        f"in a row of the {name} in frames {frames[first]} to {last}: filled in or held, not seen, and left out"
    )
    return dataclasses.replace(keypoints, points=points), (words,)


def _held_throughout(pixels: Array) -> NDArray[np.bool_]:
    """Which points `(T, P, J)` are of joints that have one place from first to last, while most others have not."""
    seen = np.asarray(np.isfinite(pixels).all(axis=-1))
    highest = np.where(seen[..., None], pixels, -np.inf).max(axis=0)
    lowest = np.where(seen[..., None], pixels, np.inf).min(axis=0)
    is_many, is_one = seen.sum(axis=0) >= REPEATS, (highest == lowest).all(axis=-1)
    # Whole pixels, or halves, may stay the same where somebody stands still.
    steps = np.diff(np.unique(pixels[seen]))
    is_fine = len(steps) > 0 and float(steps[steps > EXACT_PX].min(initial=np.inf)) < COARSE_PX
    moves = (is_many & ~is_one).sum(axis=1, keepdims=True) > (is_many & is_one).sum(axis=1, keepdims=True)
    return np.asarray(seen & is_many & is_one & moves & is_fine)


def _on_polynomial(pixels: Array, frames: NDArray[np.int64], order: int, unit: float) -> NDArray[np.bool_]:
    """Which points `(T,)` of `(T, 2)` lie on one of a lower order with those about them, and between what was seen."""
    found = np.zeros(len(pixels), dtype=bool)
    if len(frames) < REPEATS + order:
        return found
    bent = np.linalg.norm(np.diff(pixels, n=order, axis=0), axis=-1)
    bent[frames[order:] - frames[:-order] != order] = np.inf
    rounding = UNITS[order] * unit
    seen = bent[np.isfinite(bent) & (bent > max(rounding, EXACT_PX))]
    if not len(seen):
        return found
    usual = float(np.median(seen))
    most = max(min(STRAIGHT_PX, usual / TREMBLE), rounding)
    if usual < TREMBLE * most:
        return found
    is_smooth = usual < TREMBLE * STRAIGHT_PX
    if is_smooth and order != HELD_ORDER:
        return found
    for first, after in runs(bent <= most, REPEATS):
        goes_px, last = float(np.linalg.norm(pixels[after - 1 + order] - pixels[first])), after - 1
        is_at_end = first == 0 or after == len(bent)
        if (is_smooth and goes_px < GOES * usual) or (order != HELD_ORDER and is_at_end):
            continue  # nobody goes nowhere by a line, or on by a cubic from one end alone
        before, behind = first, last
        if not is_at_end and max(bent[first - 1], bent[after]) < CORNER * usual:
            before, behind = _to_corner(bent, first, -1, usual), _to_corner(bent, last, 1, usual)
        # What it goes on from was seen, and what it comes to, but for a point that is held.
        is_held = order == HELD_ORDER and goes_px <= most
        found[before + 1 : behind + order + is_held] = True
    # A smoother makes all of it such curves.
    return found & (found.mean() <= MOST_FILLED or not (is_smooth or order != HELD_ORDER))


def _to_corner(bent: Array, k: int, step: int, usual: float) -> int:
    """How far a line goes on that was low-passed: to where it bends as usual."""
    for _ in range(RINGS):
        if not 0 <= k + step < len(bent) or bent[k + step] >= usual:
            break
        k += step
    return k
