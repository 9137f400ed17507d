"""How far a detector's keypoints are spread, which the data show, and which of them are guesses.

A detector's confidence has no unit. What it is worth shows in how much the points of that confidence jump from frame
to frame: their second difference, whose spread is the square root of 6 times theirs.
"""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker.formats.keypoints.read import Keypoints
from pytracker.rotation import Array
from pytracker.series import SD_OF_MEDIAN

__all__ = ["with_spreads", "without_guesses"]

LEAST_PX = 0.5
"""No detector is better."""
WORST_SHARE = 0.05
"""Where too few points are there to tell, a spread of this share of the person's height in the picture."""
ANYWHERE_SHARE = 0.08
"""Points that are spread by more of it are guesses: those of detectors are spread by 0.003 to 0.01."""
TIMES = 5.0
"""They are spread by so many times what the surest are,"""
BENT = 1.5
"""and each lies somewhere else: a fast hand, seen ten times a second, bends by less."""
FEW_JOINTS = 4
"""Of fewer nobody knows how large a person is."""
EDGES = (0.0, 0.3, 0.5, 0.7, 0.9, np.inf)
"""Confidences between which points are taken to be alike."""
ENOUGH = 30


def with_spreads(keypoints: Keypoints) -> Array:
    """u, v and standard deviation, px, of each person `(T, P, 9, 3)`, row for row of `keypoints.frames`."""
    points = keypoints.points.copy()
    spread, of = _spreads(keypoints)
    points[..., 2] = np.where(np.isfinite(points[..., 0]), spread[of], np.nan)
    return points


def without_guesses(path: Path, keypoints: Keypoints) -> tuple[Keypoints, tuple[str, ...]]:
    """The same without points of confidences that lie anywhere; a word on them.

    Some detectors write a place for whatever they did not see.
    """
    size, of = _size_px(keypoints.points), _class_of(keypoints)
    spread, bent = (np.array(row) for row in zip(*_by_class(keypoints), strict=True))
    told = np.flatnonzero(np.isfinite(spread))
    if not len(told) or not size > 0:
        return keypoints, ()
    surest = int(told[-1])
    guessed = (spread > max(ANYWHERE_SHARE * size, TIMES * spread[surest])) & (bent > BENT)
    guessed[surest:] = False  # there are no better ones
    is_guess = guessed[of] & np.isfinite(keypoints.points[..., 0])
    if not is_guess.any():
        return keypoints, ()
    points = np.where(is_guess[..., None], np.nan, keypoints.points)
    least = EDGES[int(of[is_guess].max()) + 1]
    jump = f"{float(spread[of[is_guess]].max()):.0f} px about their places"
    words = (
        f"{path}: {int(is_guess.sum())} points of a confidence of at most {least:g} lie anywhere (they jump by {jump}, "
        f"of a person {size:.0f} px large): left out, as not seen"
    )
    return dataclasses.replace(keypoints, points=points), (words,)


def _spreads(keypoints: Keypoints) -> tuple[Array, NDArray[np.intp]]:
    """Standard deviation of each class of confidence, px, and the class of every point `(T, P, 9)`."""
    worst = max(LEAST_PX, WORST_SHARE * _height_px(keypoints.points))
    known, spread = 0.0, np.full(len(EDGES) - 1, np.nan)
    # From the surest on: what is less sure is no better.
    for k, (found, _) in reversed(list(enumerate(_by_class(keypoints)))):
        known = max(known, LEAST_PX, found) if np.isfinite(found) else known
        spread[k] = known or worst
    return spread, _class_of(keypoints)


def _class_of(keypoints: Keypoints) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(EDGES, keypoints.points[..., 2], side="left") - 1, 0, len(EDGES) - 2)


def _by_class(keypoints: Keypoints) -> list[tuple[float, float]]:
    """Of every class, beside points that are no less sure: the spread, px, and by how much it bends; NaN of few.

    Bends are the square of second differences, of that of first ones: 3 where every place is found anew, little where
    something moves on.
    """
    found = []
    for least, most in itertools.pairwise(EDGES):
        once, twice = _differences(keypoints, least)
        inside = np.isfinite(twice) & (keypoints.points[..., 2] <= most)
        if inside.sum() < ENOUGH:
            found.append((np.nan, np.nan))
            continue
        sizes = [float(np.median(differences[inside])) for differences in (once, twice)]
        found.append((SD_OF_MEDIAN * sizes[1] / np.sqrt(6.0), (sizes[1] / max(sizes[0], 1e-9)) ** 2))
    return found


def _differences(keypoints: Keypoints, least: float) -> tuple[Array, Array]:
    """Sizes along an axis of first and second differences over frames, px `(T, P, 9)` each; NaN where unknown.

    Only points that are surer than `least` are there.
    """
    uv, frames = np.where(keypoints.points[..., 2:] > least, keypoints.points[..., :2], np.nan), keypoints.frames
    once, twice = np.full(uv.shape[:3], np.nan), np.full(uv.shape[:3], np.nan)
    if len(frames) >= 3:
        apart = np.diff(uv, axis=0)
        second = np.diff(apart, axis=0)
        second[(frames[2:] - frames[:-2]) != 2] = np.nan
        twice[1:-1] = np.abs(second).mean(axis=-1)
        once[1:-1] = 0.5 * (np.abs(apart[1:]) + np.abs(apart[:-1])).mean(axis=-1)
    return once, twice


def _size_px(points: Array) -> float:
    """How large what is seen is, px, in height or width: the median over frames; 0 where few joints are seen."""
    seen = [row for row in points.reshape(len(points), -1, 3) if np.isfinite(row[:, 0]).sum() >= FEW_JOINTS]
    sizes = [float(np.ptp(row[np.isfinite(row[:, 0]), :2], axis=0).max()) for row in seen]
    return float(np.median(sizes)) if sizes else 0.0


def _height_px(points: Array) -> float:
    """How tall what is seen is, px: the median over frames."""
    v = points[:, :, :, 1]
    with np.errstate(invalid="ignore"):
        spans = [float(np.nanmax(row) - np.nanmin(row)) for row in v.reshape(len(v), -1) if np.isfinite(row).any()]
    return float(np.median(spans)) if spans else 0.0
