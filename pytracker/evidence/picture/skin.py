"""Skin in a picture, by its colour: the pixels, and blobs that may be a head or a hand (Li & Kulić IV-C2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from pytracker.evidence.picture.thresholds import SilhouetteParameters
from pytracker.formats.video import Image, as_image
from pytracker.rotation import Array

__all__ = ["RIM_PX", "Skin"]

RIM_PX = 5
"""Twice as far as blur and interpolation mix colours, and one."""


class Skin:
    """Finds it; holds what does not change from frame to frame.

    Args:
        parameters: thresholds.
        px_per_m: pixels per metre at the person.

    Attributes:
        reach_px: pixels farther off than this have no say in whether one is on skin.
    """

    def __init__(self, parameters: SilhouetteParameters, px_per_m: float) -> None:
        self._parameters = parameters
        self._px_per_m = px_per_m
        growth = 2 * round(0.5 * parameters.skin_growth_m * px_per_m) + 1
        self._growth = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (growth, growth))
        self._opening = np.ones((parameters.open_px,) * 2, np.uint8)
        self.reach_px = 2 * (growth + parameters.open_px + RIM_PX)

    def coloured(self, y: Image, cr: Image, cb: Image) -> Image:
        """255 where luma and chroma `(H, W)` are skin's."""
        p = self._parameters
        mask = cv2.bitwise_and(cv2.inRange(cr, *p.skin_cr), cv2.inRange(cb, *p.skin_cb))
        mask = cv2.bitwise_and(mask, cv2.inRange(y, p.skin_darkest, 255))
        mask = cv2.bitwise_and(mask, cv2.bitwise_not(self._too_red(y, cr)))
        return as_image(cv2.morphologyEx(mask, cv2.MORPH_OPEN, self._opening))

    def on(self, foreground: Image, coloured: Image) -> Image:
        """255 on skin of the foreground and a little beyond it `(H, W)`, of what is coloured as skin."""
        # A face that the background took for its own still shows in part: it grows from there.
        mask = cv2.bitwise_and(coloured, cv2.dilate(cv2.bitwise_and(coloured, foreground), self._growth))
        return as_image(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, self._growth))

    def blobs(self, skin: Image, corner: tuple[int, int]) -> Array:
        """Centres of what may be a head or a hand, px `(B, 2)`.

        `skin` is a part of the picture, whose left upper corner lies at `corner`.
        """
        p = self._parameters
        contours, _ = cv2.findContours(skin, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=corner)
        centres: list[tuple[float, float]] = []
        for contour in contours:
            # The area of pixels, not of the polygon through their centres.
            area = cv2.contourArea(contour) + 0.5 * len(contour) + 1
            if not p.skin_area_m2[0] <= area / self._px_per_m**2 <= p.skin_area_m2[1]:
                continue
            _, sides, _ = cv2.minAreaRect(contour)
            if max(sides) + 1 > p.skin_elongation * (min(sides) + 1):
                continue
            centres += self._places(contour, sides)
        return np.array(centres, dtype=float).reshape(-1, 2)

    def _places(self, contour: Any, sides: Sequence[float]) -> list[tuple[float, float]]:
        """Where a head or a hand may be in a blob: in its middle; at either end where it is a bare arm."""
        p = self._parameters
        px_per_m = self._px_per_m
        length, width = max(sides) + 1, min(sides) + 1
        if length <= p.bare_arm_m * px_per_m or length < p.bare_arm_elongation * width:
            moments = cv2.moments(contour)
            m00 = moments["m00"]
            return [(moments["m10"] / m00, moments["m01"] / m00)] if m00 > 0 else []
        rim = contour[:, 0, :].astype(np.float64)
        vx, vy, _, _ = cv2.fitLine(contour, cv2.DIST_L2, 0, 0.01, 0.01).ravel()
        along = rim @ np.array([vx, vy], dtype=np.float64)
        hand = p.hand_m * px_per_m
        ends = rim[along <= along.min() + hand], rim[along >= along.max() - hand]
        return [(float(end[:, 0].mean()), float(end[:, 1].mean())) for end in ends]

    def _too_red(self, y: Image, cr: Image) -> Image:
        """Clothes that are redder than skin, and their rims, where they mix with what is behind."""
        p = self._parameters
        reddest = cv2.convertScaleAbs(y, alpha=p.skin_reddest, beta=128)
        red = cv2.bitwise_and(cv2.compare(cr, reddest, cv2.CMP_GT), cv2.inRange(cr, p.skin_cr[0], 255))
        red = cv2.morphologyEx(red, cv2.MORPH_OPEN, self._opening)
        return as_image(cv2.dilate(red, np.ones((RIM_PX, RIM_PX), np.uint8)))
