"""How far off a wrist may be for all that a frame's skin says: every way that a forearm may point is weighed by it.

Particles may agree on one of several ways that explain a frame equally well, and bands then know of that one only: of
folded arms, a hand before the belly, a forearm towards the camera. So the question is put to the frame anew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.silhouette import Region
from pytracker.rotation import Array

__all__ = ["Line", "to_line", "with_hand", "wrist_may_be_off"]

BEYOND_WRIST = 1.35
"""A hand goes on from the forearm by so much of it."""
RADIUS_M = 0.06
"""Half-width of a forearm, with what skin is taken to be too wide."""
HEAD_M = 0.11
"""The same of a head."""
REACH_M = 0.10
"""As far off as any."""
LOSS = 30.0
"""Log-likelihood lost by skin that nobody wears, as `skin_loss`."""
OFF = 0.25
"""Share of it that a forearm loses which is nowhere on skin."""

FORESHORTENED = np.linspace(0.06, 0.98, 8)
"""Lengths of a forearm in the picture, as shares of its own."""
# Of all ways to point, so many are so much foreshortened: the area of a ring on a sphere.
LOG_RING = np.log(FORESHORTENED / np.sqrt(1.0 - FORESHORTENED**2))
TURNS = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
DIRECTIONS = np.stack([np.cos(TURNS), np.sin(TURNS)], axis=1)
ALONG = np.array([0.25, 0.5, 0.75, 1.0, 1.18, BEYOND_WRIST, BEYOND_WRIST])
"""Where on forearm and hand it is looked for skin; hands count most, sleeves may be long."""


Line = tuple[Array, Array]
"""Its ends, px."""


def wrist_may_be_off(skin: Region, px_per_m: float, forearm: Line, whole_px: float, head: Line, other: Line) -> float:
    """How far off a wrist may be, px: the root mean square distance from it of all places that the skin leaves to it.

    `forearm` is taken to go from elbow to wrist, and `whole_px` long where it lies across the picture; `head` and the
    `other` forearm wear skin too. NaN where a place is no number.
    """
    if not np.isfinite([whole_px, px_per_m, *np.ravel([forearm, head, other])]).all():
        return float("nan")
    (elbow, wrist), (distance, points) = forearm, skin
    lengths = whole_px * FORESHORTENED
    wrists = elbow + lengths[:, None, None] * DIRECTIONS
    worn = np.minimum(
        to_line(points, *head) - HEAD_M * px_per_m, to_line(points, *with_hand(other)) - RADIUS_M * px_per_m
    )
    from_elbow = points - elbow
    along = from_elbow @ DIRECTIONS.T
    nearest = np.clip(along, 0.0, BEYOND_WRIST * lengths[:, None, None])
    apart = np.sqrt(np.maximum((from_elbow**2).sum(axis=1)[:, None] + nearest * (nearest - 2.0 * along), 0.0))
    beyond = np.minimum(apart - RADIUS_M * px_per_m, worn[:, None])
    on_arm = elbow + ALONG[:, None, None, None] * (wrists - elbow)
    reach_px = REACH_M * px_per_m
    unexplained = np.clip(beyond / reach_px, 0.0, 1.0).mean(axis=1)
    off = np.clip(_looked_up(distance, on_arm) / reach_px, 0.0, 1.0).mean(axis=0)
    log_weights = LOG_RING[:, None] - LOSS * (unexplained + OFF * off)
    weights = np.exp(log_weights - log_weights.max())
    return float(np.sqrt((weights * ((wrists - wrist) ** 2).sum(axis=2)).sum() / weights.sum()))


def with_hand(forearm: Line) -> Line:
    """A forearm as far as its hand goes."""
    elbow, wrist = forearm
    return elbow, elbow + BEYOND_WRIST * (wrist - elbow)


def to_line(points: Array, start: Array, end: Array) -> Array:
    """Distances of points `(P, 2)` from a line with ends."""
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-9), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - share[:, None] * along, axis=1))


def _looked_up(distance: NDArray[np.float32], places: Array) -> Array:
    """Of places `(..., 2)`; of those outside the picture that of its rim."""
    height, width = distance.shape
    columns = np.clip(np.rint(places[..., 0]).astype(int), 0, width - 1)
    rows = np.clip(np.rint(places[..., 1]).astype(int), 0, height - 1)
    return np.asarray(distance[rows, columns], dtype=float)
