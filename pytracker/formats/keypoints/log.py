"""One kind of keypoints for every file format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS, InputError
from pytracker.rotation import Array

__all__ = ["Keypoints", "are_shares", "in_range", "ours", "require_seen"]

MOST_PX = 1e6
LARGEST_SHARE = 1.5
"""Of a picture's width or height: most points lie in it, and the others, such as feet, not far outside."""
NOTHING, MOST = 1e-6, 0.75
"""Of numbers that are larger than the one such a share is looked at."""


@dataclass(frozen=True, eq=False)
class Keypoints:
    """What a detector found.

    Attributes:
        frames: video frame of every row, increasing `(T,)`.
        points: of each person u, v and confidence `(T, P, 9, 3)`, in the order of `KEYPOINTS`; px, pixel centres at
            integers, or shares of the picture; NaN where a joint was not seen.
        is_share: whether u and v are shares of the picture's width and height.
        time_s: time of every row since the video began `(T,)`, s; None where the file has none, or counts frames.
        warnings: what is odd about the rows' frames.
    """

    frames: NDArray[np.int64]
    points: Array
    is_share: bool = False
    time_s: Array | None = None
    warnings: tuple[str, ...] = ()


def in_range(path: Path, found: Array) -> Array:
    """The same. Raises `InputError` for what no picture holds."""
    far = np.abs(found) > MOST_PX
    if far.any():
        raise InputError(f"{path}: keypoints hold {found[far][0]:g}, expected pixels within ±{MOST_PX:g}")
    return found


def are_shares(places: Array) -> bool:
    """Whether places, of any shape, are shares of the picture's width and height: no person is one pixel large.

    Who was not found is zero, less, or no number.
    """
    sizes = places[np.isfinite(places) & (places > NOTHING)]
    return not sizes.size or bool(np.quantile(sizes, MOST) <= LARGEST_SHARE)


def ours(person: Array, order: Sequence[str]) -> Array:
    """The joints of `KEYPOINTS` `(9, 3)`; a head is the middle of both ears, else the nose."""
    # What was not found is written as zero, as minus one, or with no confidence.
    nowhere = np.any([(person[:, :2] == value).all(axis=1) for value in (0, -1)], axis=0)
    none = ~(person[:, 2] > 0) | nowhere | ~np.isfinite(person).all(axis=1)
    person = np.where(none[:, None], np.nan, person)
    found = {name: person[k] for k, name in enumerate(order)}
    out = np.full((len(KEYPOINTS), 3), np.nan)
    for k, name in enumerate(KEYPOINTS):
        if name in found:
            out[k] = found[name]
    ears = [found[ear] for ear in ("left_ear", "right_ear") if ear in found]
    seen = [ear for ear in ears if np.isfinite(ear).all()]
    if len(seen) == 2:
        out[0] = np.mean(seen, axis=0)
    elif "head" not in found and "nose" in found:
        out[0] = found["nose"]
    return out


def require_seen(path: Path, points: Array, confidences: Array) -> Array:
    """Points `(T, ...)` of which some are there; `confidences` are those of the file.

    Raises `InputError` where none is.
    """
    if np.isfinite(points).any():
        return points
    why = "no joint is seen"
    if not np.isfinite(confidences).any():
        why = "every confidence is empty, where points of no confidence have no such column, so that no joint is seen,"
    elif not np.any(confidences > 0):
        why = "every confidence is 0, so that no joint is seen,"
    raise InputError(f"{path}: {why} in any of {len(points)} frames, expected keypoints of a person")
