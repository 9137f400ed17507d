"""How far off the wrists may be for all that a frame's skin says: every way that both forearms may point is weighed.

Particles may agree on one of several ways that explain a frame equally well, and bands then know of that one only: of
folded arms, a hand before the belly, a forearm towards the camera. So the question is put to the frame anew, and of
both arms at once: of arms that are taken for each other each is where the other one leaves it to be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.picture.silhouette import Region
from pytracker.rotation import Array

__all__ = ["Forearm", "Line", "distance_at", "to_line", "with_hand", "wrists_may_be_off"]

BEYOND_WRIST = 1.35
"""A hand goes on from the forearm by so much of it."""
RADIUS_M = 0.06
"""Half-width of a forearm, with what skin is taken to be too wide."""
HEAD_M = 0.11
"""The same of a head."""
REACH_M = 0.10
"""As far off as any."""
LOSS = 45.0
"""Log-likelihood lost by skin that nobody wears: half as much again as `skin_loss`, chosen on clips of people."""
OFF = 0.25
"""Share of it that a forearm loses which is nowhere on skin."""
POINTS = 32
"""So many points of the skin are asked."""

FORESHORTENED = np.linspace(0.06, 0.98, 6)
"""Lengths of a forearm in the picture, as shares of its own."""
# Of all ways to point, so many are so much foreshortened: the area of a ring on a sphere.
LOG_RING = np.log(FORESHORTENED / np.sqrt(1.0 - FORESHORTENED**2))
TURNS = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
DIRECTIONS = np.stack([np.cos(TURNS), np.sin(TURNS)], axis=1)
WAYS = (FORESHORTENED[:, None, None] * DIRECTIONS).reshape(-1, 2)
"""From an elbow to its wrist, in forearms."""
LOG_PRIOR = np.repeat(LOG_RING, len(TURNS))
ALONG = np.array([0.25, 0.5, 0.75, 1.0, 1.18, BEYOND_WRIST, BEYOND_WRIST])
"""Where on forearm and hand it is looked for skin; hands count most, sleeves may be long."""


Line = tuple[Array, Array]
"""Its ends, px."""


@dataclass(frozen=True, eq=False)
class Forearm:
    """One that is asked about.

    Attributes:
        elbow: where it begins, px `(2,)`.
        wrist: where it is taken to end, px `(2,)`.
        whole_px: how long it is where it lies across the picture, px.
        is_known: something else than skin tells where it points.
    """

    elbow: Array
    wrist: Array
    whole_px: float
    is_known: bool = False

    def ways(self) -> tuple[Array, Array]:
        """Wrists that it may have, px `(N, 2)`, and the logarithms of their prior weights `(N,)`."""
        if self.is_known:
            return self.wrist[None], np.zeros(1)
        return self.elbow + self.whole_px * WAYS, LOG_PRIOR


def wrists_may_be_off(
    skin: Region, px_per_m: float, forearms: tuple[Forearm, Forearm], head: Line
) -> tuple[float, float]:
    """How far off either wrist may be, px: the root mean square distance from it of all places that the skin leaves it.

    `head` wears skin too. NaN where a place is no number.
    """
    numbers = [px_per_m, *np.ravel(head), *(x for arm in forearms for x in (*arm.elbow, *arm.wrist, arm.whole_px))]
    if not np.isfinite(numbers).all():
        return float("nan"), float("nan")
    distance, points = skin
    points = points[:: max(1, len(points) // POINTS)]
    reach_px = REACH_M * px_per_m
    on_head = _beyond(to_line(points, *head), HEAD_M * px_per_m, reach_px)
    left, right = forearms
    (of_left, left_prior), (of_right, right_prior) = left.ways(), right.ways()
    lost = OFF * len(points) * np.add.outer(_off_skin(left, distance, reach_px), _off_skin(right, distance, reach_px))
    by_left = np.minimum(_unexplained(left, points, px_per_m), on_head).T
    # Point by point, which keeps within the cache what is as large as both arms' ways together.
    for point_by_left, point_by_right in zip(by_left, _unexplained(right, points, px_per_m).T, strict=True):
        lost += np.minimum.outer(point_by_left, point_by_right)
    log_weights = left_prior[:, None] + right_prior - LOSS / len(points) * lost
    weights = np.exp(log_weights - log_weights.max())
    weights /= weights.sum()
    return (
        float(np.sqrt(weights.sum(axis=1) @ ((of_left - left.wrist) ** 2).sum(axis=1))),
        float(np.sqrt(weights.sum(axis=0) @ ((of_right - right.wrist) ** 2).sum(axis=1))),
    )


def distance_at(distance_px: NDArray[np.float32], at: Array) -> float:
    """Of a pixel from a mask, px; NaN outside the picture, where nothing is known, and of what is not seen."""
    if not np.isfinite(at).all():
        return float("nan")
    u, v = (round(float(x)) for x in at)
    height, width = distance_px.shape
    return float(distance_px[v, u]) if 0 <= u < width and 0 <= v < height else float("nan")


def with_hand(forearm: Line) -> Line:
    """A forearm as far as its hand goes."""
    elbow, wrist = forearm
    return elbow, elbow + BEYOND_WRIST * (wrist - elbow)


def to_line(points: Array, start: Array, end: Array) -> Array:
    """Distances of points `(P, 2)` from lines with ends, `(2,)` or `(N, 1, 2)`: `(P,)` or `(N, P)`."""
    apart, along = points - start, end - start
    u, v, along_u, along_v = apart[..., 0], apart[..., 1], along[..., 0], along[..., 1]
    share = np.clip((u * along_u + v * along_v) / np.maximum(along_u**2 + along_v**2, 1e-9), 0.0, 1.0)
    return np.asarray(np.sqrt((u - share * along_u) ** 2 + (v - share * along_v) ** 2))


def _beyond(apart_px: Array, radius_px: float, reach_px: float) -> NDArray[np.float32]:
    """How much of a point is not explained by what is so far away: 0 within its radius, 1 from its reach on."""
    return np.clip((apart_px - radius_px) / reach_px, 0.0, 1.0).astype(np.float32)


def _unexplained(forearm: Forearm, points: Array, px_per_m: float) -> NDArray[np.float32]:
    """The same of points on skin, by each way of a forearm `(N, P)`."""
    elbow, tips = with_hand((forearm.elbow, forearm.ways()[0][:, None]))
    return _beyond(to_line(points, elbow, tips), RADIUS_M * px_per_m, REACH_M * px_per_m)


def _off_skin(forearm: Forearm, distance: NDArray[np.float32], reach_px: float) -> Array:
    """How much of each way of a forearm lies beside skin `(N,)`."""
    on_arm = forearm.elbow + ALONG[:, None, None] * (forearm.ways()[0] - forearm.elbow)
    return np.asarray(np.clip(_looked_up(distance, on_arm) / reach_px, 0.0, 1.0).mean(axis=0))


def _looked_up(distance: NDArray[np.float32], places: Array) -> Array:
    """Of places `(..., 2)`; of those outside the picture that of its rim."""
    height, width = distance.shape
    columns = np.clip(np.rint(places[..., 0]).astype(int), 0, width - 1)
    rows = np.clip(np.rint(places[..., 1]).astype(int), 0, height - 1)
    return np.asarray(distance[rows, columns], dtype=float)
