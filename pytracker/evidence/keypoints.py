"""A detector's keypoints as evidence: each with a spread that the data show.

A detector's confidence has no unit. What it is worth shows in how much the points of that confidence jump from frame
to frame: their second difference, whose spread is the square root of 6 times theirs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pytracker.formats.keypoints.read import Keypoints
from pytracker.rotation import Array
from pytracker.series import SD_OF_MEDIAN

__all__ = ["PointsEvidence", "with_spreads"]

LEAST_PX = 0.5
"""No detector is better."""
WORST_SHARE = 0.05
"""Where too few points are there to tell, a spread of this share of the person's height in the picture."""
EDGES = (0.0, 0.3, 0.5, 0.7, 0.9, np.inf)
"""Confidences between which points are taken to be alike."""
ENOUGH = 30


@dataclass(frozen=True, eq=False)
class PointsEvidence:
    """What is known of a frame of which there is no picture.

    Attributes:
        keypoints: as of `pytracker.evidence.BodyEvidence`; None where a detector found nobody.
        edges: none.
        blobs: none `(0, 2)`.
        skin_region: none.
        foreground_region: none.
        shrunk: 1: of no picture.
    """

    keypoints: Array | None
    edges: None = None
    blobs: Array = field(default_factory=lambda: np.zeros((0, 2)))
    skin_region: None = None
    foreground_region: None = None
    shrunk: int = 1


def with_spreads(keypoints: Keypoints) -> Array:
    """u, v and standard deviation, px, of each person `(T, P, 9, 3)`, row for row of `keypoints.frames`."""
    points = keypoints.points.copy()
    confidence = keypoints.points[..., 2]
    jumps = _jumps(keypoints)
    worst = max(LEAST_PX, WORST_SHARE * _height_px(points))
    known, spread = 0.0, np.full(len(EDGES) - 1, np.nan)
    # From the surest on: what is less sure is no better.
    for k in reversed(range(len(EDGES) - 1)):
        inside = jumps[(confidence > EDGES[k]) & (confidence <= EDGES[k + 1]) & np.isfinite(jumps)]
        if len(inside) >= ENOUGH:
            known = max(known, LEAST_PX, float(SD_OF_MEDIAN * np.median(inside) / np.sqrt(6.0)))
        spread[k] = known or worst
    within = np.clip(np.searchsorted(EDGES, confidence, side="left") - 1, 0, len(EDGES) - 2)
    points[..., 2] = np.where(np.isfinite(points[..., 0]), spread[within], np.nan)
    return points


def _jumps(keypoints: Keypoints) -> Array:
    """Size along an axis of every point's second difference over frames, px `(T, P, 9)`; NaN where unknown."""
    uv, frames = keypoints.points[..., :2], keypoints.frames
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
