"""Pieces of the foreground: the person, and what else stands there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.formats.video import Image
from pytracker.rotation import Array

__all__ = ["Pieces", "pieces_of"]

GAP_M = 0.06
"""Clothes of the wall's colour part a person into pieces that are no farther apart, m: these are one."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Numbered from 1; 0 is what is behind them.

    Attributes:
        labels: `(h, w)`, of the part of the picture that has any.
        corner: left upper corner of that part, px `(2,)`.
        sizes: `(L,)`, px.
        middles: `(L, 2)`, px.
    """

    labels: NDArray[np.int32]
    corner: tuple[int, int]
    sizes: Array
    middles: Array

    def share(self, label: int, mask: NDArray[Any]) -> float:
        """Of a piece, that which a mask `(H, W)` of the whole picture has."""
        (left, top), (height, width) = self.corner, self.labels.shape
        within = np.asarray(mask[top : top + height, left : left + width] > 0)
        return float(within[self.labels == label].mean())

    def at(self, points: Array) -> NDArray[np.int32]:
        """Labels of points `(P, 2)`, px, `(P,)`."""
        columns, rows = np.rint(points - np.array(self.corner)).astype(int).T
        height, width = self.labels.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        found = np.zeros(len(points), np.int32)
        found[inside] = self.labels[rows[inside], columns[inside]]
        return found

    def about(self, places: Array, reach_px: int) -> list[int]:
        """Labels, 0 among them, within so many px of places `(P, 2)`, px."""
        height, width = self.labels.shape
        found: set[int] = set()
        for u, v in (places - np.array(self.corner))[np.isfinite(places).all(axis=1)]:
            left, top = (int(np.clip(x, 0, most - 1)) for x, most in ((u, width), (v, height)))
            rows = slice(max(0, top - reach_px), top + reach_px + 1)
            found.update(np.unique(self.labels[rows, max(0, left - reach_px) : left + reach_px + 1]).tolist())
        return sorted(found)


def pieces_of(foreground: Image, px_per_m: float) -> Pieces:
    """Of a mask `(H, W)`."""
    gap = 2 * round(0.5 * GAP_M * px_per_m) + 1
    left, top, width, height = cv2.boundingRect(foreground)
    # A margin, as what is beyond the edge closes nothing.
    corner = max(0, left - gap), max(0, top - gap)
    part = foreground[corner[1] : top + height + gap, corner[0] : left + width + gap]
    whole = cv2.morphologyEx(part, cv2.MORPH_CLOSE, np.ones((gap, gap), np.uint8))
    _, labels, stats, middles = cv2.connectedComponentsWithStats(whole)
    sizes = np.asarray(stats)[:, cv2.CC_STAT_AREA].astype(float)
    return Pieces(np.asarray(labels, np.int32), corner, sizes, np.asarray(middles) + np.array(corner))
