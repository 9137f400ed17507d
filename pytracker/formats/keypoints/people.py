"""Who of several people is who, from frame to frame: detectors list them in any order."""

from __future__ import annotations

import numpy as np

from pytracker.rotation import Array

__all__ = ["in_order"]


def in_order(points: Array) -> Array:
    """The same people `(T, P, K, 3)`, each of them in one place: whoever is nearest to where he was seen last.

    How far two are apart is the median over the joints that both show; u, v and confidence of who is not there are NaN.
    """
    count = points.shape[1]
    if count < 2:
        return points
    ordered, last = np.full_like(points, np.nan), np.full((count, *points.shape[2:3], 2), np.nan)
    for row, people in zip(ordered, points, strict=True):
        for place, person in _places(people, last).items():
            row[place] = people[person]
            seen = np.isfinite(people[person, :, 0])
            last[place] = np.where(seen[:, None], people[person, :, :2], np.nan)
    return ordered


def _places(people: Array, last: Array) -> dict[int, int]:
    """Which of `people` takes each place that is taken, the nearest first; who is new one that nobody had before."""
    there = [k for k, person in enumerate(people) if np.isfinite(person[:, 0]).any()]
    off = np.linalg.norm(people[there, None, :, :2] - last[None], axis=-1)
    is_both = np.isfinite(off).any(axis=-1)
    far = np.full(is_both.shape, np.inf)
    far[is_both] = np.nanmedian(off[is_both], axis=-1)
    places: dict[int, int] = {}
    left = dict(enumerate(there))
    while left and np.isfinite(far).any():
        row, place = (int(k) for k in np.unravel_index(np.argmin(far), far.shape))
        places[place] = left.pop(row)
        far[row], far[:, place] = np.inf, np.inf
    free = sorted(set(range(len(people))) - set(places), key=lambda place: (np.isfinite(last[place]).any(), place))
    return places | dict(zip(free, left.values(), strict=False))
