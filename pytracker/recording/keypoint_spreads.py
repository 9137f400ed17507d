"""How far a detector's keypoints are spread, which the data show, and which of them are guesses.

A detector's confidence has no unit. What it is worth shows in how much the points of that confidence jump from frame
to frame: their second difference, whose spread is the square root of 6 times theirs.
"""

from __future__ import annotations

import dataclasses
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
    spread, of = _spreads(keypoints)
    height = _height_px(keypoints.points)
    spread[int(of[np.isfinite(keypoints.points[..., 0])].max(initial=0))] = 0.0  # there are no better ones
    is_guess = (spread > ANYWHERE_SHARE * height)[of] & np.isfinite(keypoints.points[..., 0])
    if not is_guess.any():
        return keypoints, ()
    points = np.where(is_guess[..., None], np.nan, keypoints.points)
    least = EDGES[int(of[is_guess].max()) + 1]
    jump = f"{float(spread[of[is_guess]].max()):.0f} px about their places"
    words = (
        f"{path}: {int(is_guess.sum())} points of a confidence of at most {least:g} lie anywhere (they jump by {jump}, "
        f"of a person {height:.0f} px tall): left out, as not seen"
    )
    return dataclasses.replace(keypoints, points=points), (words,)


def _spreads(keypoints: Keypoints) -> tuple[Array, NDArray[np.intp]]:
    """Standard deviation of each class of confidence, px, and the class of every point `(T, P, 9)`."""
    confidence = keypoints.points[..., 2]
    worst = max(LEAST_PX, WORST_SHARE * _height_px(keypoints.points))
    known, spread = 0.0, np.full(len(EDGES) - 1, np.nan)
    # From the surest on, beside none that is less sure: what is less sure is no better.
    for k in reversed(range(len(EDGES) - 1)):
        jumps = _jumps(keypoints, least=EDGES[k])[confidence <= EDGES[k + 1]]
        inside = jumps[np.isfinite(jumps)]
        if len(inside) >= ENOUGH:
            known = max(known, LEAST_PX, float(SD_OF_MEDIAN * np.median(inside) / np.sqrt(6.0)))
        spread[k] = known or worst
    return spread, np.clip(np.searchsorted(EDGES, confidence, side="left") - 1, 0, len(EDGES) - 2)


def _jumps(keypoints: Keypoints, least: float) -> Array:
    """Size along an axis of second differences over frames, px `(T, P, 9)`, of points surer than `least`; else NaN."""
    uv, frames = np.where(keypoints.points[..., 2:] > least, keypoints.points[..., :2], np.nan), keypoints.frames
    jumps = np.full(uv.shape[:3], np.nan)
    if len(frames) >= 3:
        second = uv[2:] - 2.0 * uv[1:-1] + uv[:-2]
        second[(frames[2:] - frames[:-2]) != 2] = np.nan
        jumps[1:-1] = np.abs(second).mean(axis=-1)
    return jumps


def _height_px(points: Array) -> float:
    """How tall what is seen is, px: the median over frames."""
    v = points[:, :, :, 1]
    with np.errstate(invalid="ignore"):
        spans = [float(np.nanmax(row) - np.nanmin(row)) for row in v.reshape(len(v), -1) if np.isfinite(row).any()]
    return float(np.median(spans)) if spans else 0.0
