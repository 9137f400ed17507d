"""Keypoints of wrists beside all skin, of somebody whose wrists are bare: guesses, of a detector that sees no hand.

Some put a hand that they do not see at the hip that is near, or where it was, as sure of it as of any other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.evidence.picture.silhouette import Region
from pytracker.rotation import Array

__all__ = ["WristsOnSkin"]

BESIDE_M = 0.06
"""Points of wrists so far from skin are beside it: of seven right clips of people none is by more than 2.5 cm."""
SPREADS = 3.0
"""Nor is a detector's that is spread by a third as much."""
NEAR_M = 0.025
MOSTLY, LEAST_FRAMES = 0.5, 10
"""In more than this share of so many frames, at least, the nearer wrist of who is bare lies on skin: in long sleeves
hands begin 6 to 8 cm on."""
_WRISTS = [KEYPOINTS.index(f"{side}_wrist") for side in ("left", "right")]


class WristsOnSkin:
    """Frame by frame, as they come.

    Args:
        px_per_m: pixels of the picture that are a metre where the person is.
    """

    def __init__(self, px_per_m: float) -> None:
        self._px_per_m = px_per_m
        self._asked = self._bare = 0
        self.left_out = 0
        """How many points were."""

    def beside(self, points: Array, skin: Region | None) -> list[int]:
        """Which of a person's points lie beside all skin while the other wrist's is on it.

        `points` are u, v and standard deviation in the picture, px `(9, 3)`, `skin` its skin; None where it has none.
        """
        off = np.full(len(_WRISTS), np.nan) if skin is None else self._off_skin(points[_WRISTS, :2], skin[0])
        if not np.isfinite(off).any():
            return []
        self._asked += 1
        self._bare += bool(np.nanmin(off) < NEAR_M)
        if self._asked < LEAST_FRAMES or self._bare <= MOSTLY * self._asked or not np.nanmin(off) < NEAR_M:
            return []
        limit = np.maximum(BESIDE_M, SPREADS * points[_WRISTS, 2] / self._px_per_m)
        found = [wrist for wrist, is_beside in zip(_WRISTS, off > limit, strict=True) if is_beside]
        self.left_out += len(found)
        return found

    def _off_skin(self, wrists: Array, distance_px: NDArray[np.float32]) -> Array:
        """Metres `(2,)`; NaN where not seen, or outside the picture."""
        height, width = distance_px.shape
        off = np.full(len(wrists), np.nan)
        for k, (u, v) in enumerate(np.rint(wrists)):
            if 0 <= u < width and 0 <= v < height:
                off[k] = distance_px[int(v), int(u)] / self._px_per_m
        return off
