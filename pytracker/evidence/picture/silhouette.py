"""What a frame shows of a body: foreground, its edges, and blobs of skin (Li & Kulić IV-C2). Frame by frame.

Foreground by background subtraction in colour, without the cast shadow; Canny inside it, dilated; skin in YCrCb
inside it (`skin`). All on eight-bit images, blobs by their contours, and whatever can be about the person alone,
which is what makes it fast.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.evidence.picture.skin import Skin
from pytracker.evidence.picture.thresholds import SilhouetteParameters
from pytracker.formats.video import Image, as_image
from pytracker.rotation import Array

__all__ = ["BodyEvidence", "Region", "Silhouette", "check_order"]

Region = tuple[NDArray[np.float32], Array]
"""Distances from a mask, and points on it."""

Near = tuple[slice, slice]
"""Rows and columns about the person, beyond which nothing that is asked of their pixels changes."""

REGION_POINTS = 64
"""So many points, evenly chosen, stand for a mask."""
COLOURFUL, LEAST_COLOURFUL = 20, 0.01
"""Of 255, blue beside red; share of a background that has such colour."""
EXCHANGED = 0.3
"""Where red and blue are exchanged a frame is so much nearer to the background the other way round; as recordings of
people are, six times as far."""


@dataclass(frozen=True, eq=False)
class BodyEvidence:
    """What one frame shows, in pixels of the picture that it was found in; keypoints are in the frame's.

    Attributes:
        foreground: 255 where the person is `(H, W)`.
        edges: 255 on a detected edge `(H, W)`.
        skin: 255 on skin `(H, W)`, before blobs are filtered.
        blobs: centres of skin blobs, px `(B, 2)`.
        skin_region: distance of every pixel from skin `(H, W)`, px, and some points on it `(P, 2)`, px. It has skin
            that differs from the background in colour alone, which `skin` has not.
        foreground_region: the same of the foreground.
        keypoints: of each person that a detector found u, v and standard deviation, px `(P, 9, 3)`, in the order of
            `pytracker._core.KEYPOINTS`; NaN where a joint was not seen.
        image: the frame that it was seen in, blue, green and red; None where there is none.
        shrunk: how many times smaller than the frame the picture was made (`pytracker.evidence.picture.smaller`).
    """

    foreground: Image
    edges: Image
    skin: Image
    blobs: Array
    skin_region: Region | None = None
    foreground_region: Region | None = None
    keypoints: Array | None = None
    image: Image | None = None
    shrunk: int = 1


def _region(mask: Image, near: Near) -> Region | None:
    """A mask, empty elsewhere than `near`, as distances, good to a pixel, and points; None where it is empty."""
    if not cv2.countNonZero(mask[near]):
        return None
    found = np.asarray(cv2.findNonZero(mask[near])).reshape(-1, 2)
    height, width = mask.shape
    # At half the size it takes a quarter of the time, and nothing that is asked needs more.
    small = cv2.resize(mask, ((width + 1) // 2, (height + 1) // 2), interpolation=cv2.INTER_NEAREST)
    apart = np.asarray(cv2.distanceTransform(cv2.bitwise_not(small), cv2.DIST_L2, 3), dtype=np.float32)
    # Of a mask that is gone at half the size there is no distance: nothing is farther than the picture is large.
    halves = 2.0 * np.minimum(apart, np.float32(np.hypot(*small.shape)))
    distance = np.asarray(cv2.resize(halves, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)
    picked = np.linspace(0, len(found) - 1, min(REGION_POINTS, len(found))).astype(int)
    return distance, found[picked] + np.array([near[1].start, near[0].start], dtype=np.float64)


def _gained(gains: Array) -> Image | None:
    """What becomes of every value of blue, green and red `(1, 256, 3)`, by gains `(3,)`; None where it stays."""
    if (gains == 1.0).all():
        return None
    return as_image(np.clip(np.rint(np.arange(256.0)[:, None] * gains), 0, 255))[None]


def check_order(image: Image, background: Image) -> None:
    """Raises `InputError` where red and blue of a frame are the background's blue and red: live sources give RGB."""
    own, behind = image.astype(np.int16), background.astype(np.int16)
    is_colourful = np.abs(behind[..., 0] - behind[..., 2]) > COLOURFUL
    if is_colourful.mean() < LEAST_COLOURFUL:
        return
    off, exchanged = (float(np.median(np.abs(of - behind).sum(axis=2)[is_colourful])) for of in (own, own[..., ::-1]))
    if off > COLOURFUL and exchanged < EXCHANGED * off:
        raise InputError(
            f"frame differs from the background by {off:.0f} of 765 where that has colour, and by {exchanged:.0f} with "
            "red and blue exchanged, expected blue, green, red in this order, as OpenCV has them"
        )


class Silhouette:
    """Extracts evidence; holds what does not change from frame to frame.

    Args:
        background: the scene without the person, BGR `(H, W, 3)`.
        px_per_m: pixels per metre at the person.
        parameters: thresholds.
    """

    def __init__(self, background: Image, px_per_m: float, parameters: SilhouetteParameters | None = None) -> None:
        """Raises `InputError` for a background that is no colour image, or a scale that is not positive."""
        if background.ndim != 3 or background.shape[2] != 3 or background.dtype != np.uint8:
            raise InputError(f"background is {background.dtype} {background.shape}, expected uint8 (H, W, 3)")
        if not (np.isfinite(px_per_m) and px_per_m > 0):
            raise InputError(f"px_per_m is {px_per_m}, expected a positive number")
        self.parameters = parameters or SilhouetteParameters()
        self.background = background
        gains = np.array(self.parameters.gains)
        # What is too bright for skin's thresholds is not made darker for those of the background, which count levels.
        self._too_bright = min(1.0, float(np.exp(np.log(gains).mean())))
        self._in_white_light = _gained(gains / self._too_bright)
        lit = self._lit(background)
        self.px2_per_m2 = px_per_m * px_per_m
        self._background = lit
        self._grey = cv2.cvtColor(lit, cv2.COLOR_BGR2GRAY)
        self._y, self._cr, self._cb = cv2.split(cv2.cvtColor(lit, cv2.COLOR_BGR2YCrCb))
        self._darkest = cv2.convertScaleAbs(self._y, alpha=self.parameters.shadow_darkest)
        self._dilation = np.ones((self.parameters.dilate_px,) * 2, np.uint8)
        self._skin = Skin(self.parameters, px_per_m)
        self._opening = np.ones((self.parameters.open_px,) * 2, np.uint8)

    def __call__(self, image: Image) -> BodyEvidence:
        """Evidence of a frame, BGR `(H, W, 3)`. Raises `InputError` for another size or type than the background's."""
        if image.dtype != np.uint8:
            raise InputError(f"frame is of {image.dtype}, expected uint8, 0 to 255")
        if image.shape != self.background.shape:
            raise InputError(f"frame is {image.shape}, expected {self.background.shape} as the background")
        smooth = cv2.blur(self._lit(image), (3, 3))
        y, cr, cb = (as_image(plane) for plane in cv2.split(cv2.cvtColor(smooth, cv2.COLOR_BGR2YCrCb)))
        mask = self._differs(as_image(smooth), y, cr, cb)
        foreground = self._pieces(mask)
        person = self._pieces(as_image(cv2.bitwise_or(mask, self._differs_in_colour(cr, cb))))
        near = self._near(as_image(cv2.bitwise_or(foreground, person)))
        edges, skin, region = (np.zeros_like(mask) for _ in range(3))
        edges[near] = self._edges(y[near], foreground[near])
        coloured = self._skin.coloured(*self._as_skin(y[near], cr[near], cb[near]))
        skin[near] = self._skin.on(foreground[near], coloured)
        region[near] = self._skin.on(person[near], coloured)
        blobs = self._skin.blobs(skin[near], (near[1].start, near[0].start))
        regions = _region(region, near), _region(foreground, near)
        return BodyEvidence(foreground, edges, skin, blobs, *regions, image=image)

    def _near(self, person: Image) -> Near:
        """The box about a mask, and as far beyond it as what is asked of its pixels reaches."""
        left, top, width, height = cv2.boundingRect(person)
        reach = self._skin.reach_px + self.parameters.dilate_px
        return slice(max(0, top - reach), top + height + reach), slice(max(0, left - reach), left + width + reach)

    def _lit(self, image: Image) -> Image:
        """As it is in white light, and light enough."""
        return image if self._in_white_light is None else as_image(cv2.LUT(image, self._in_white_light))

    def _as_skin(self, y: Image, cr: Image, cb: Image) -> tuple[Image, Image, Image]:
        """Luma and chroma of the picture, so bright that faces are as they usually are."""
        if self._too_bright == 1.0:
            return y, cr, cb
        scale, grey = self._too_bright, 128.0 * (1.0 - self._too_bright)
        return (
            as_image(cv2.convertScaleAbs(y, alpha=scale)),
            as_image(cv2.convertScaleAbs(cr, alpha=scale, beta=grey)),
            as_image(cv2.convertScaleAbs(cb, alpha=scale, beta=grey)),
        )

    def _differs(self, image: Image, y: Image, cr: Image, cb: Image) -> Image:
        """From the background, and is no shadow on it."""
        p = self.parameters
        if p.colour:
            b, g, r = cv2.split(cv2.absdiff(image, self._background))
            difference = cv2.max(cv2.max(b, g), r)
        else:
            difference = cv2.absdiff(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), self._grey)
        _, mask = cv2.threshold(difference, p.foreground_level - 1, 255, cv2.THRESH_BINARY)
        if p.shadow_chroma > 0:
            chroma = cv2.max(cv2.absdiff(cr, self._cr), cv2.absdiff(cb, self._cb))
            _, grey = cv2.threshold(chroma, p.shadow_chroma - 1, 255, cv2.THRESH_BINARY_INV)
            darker = cv2.bitwise_and(cv2.compare(y, self._y, cv2.CMP_LT), cv2.compare(y, self._darkest, cv2.CMP_GT))
            mask = cv2.bitwise_and(mask, cv2.bitwise_not(cv2.bitwise_and(grey, darker)))
        return as_image(mask)

    def _differs_in_colour(self, cr: Image, cb: Image) -> Image:
        """From the background, however bright it is."""
        chroma = cv2.max(cv2.absdiff(cr, self._cr), cv2.absdiff(cb, self._cb))
        _, mask = cv2.threshold(chroma, self.parameters.region_chroma - 1, 255, cv2.THRESH_BINARY)
        return as_image(mask)

    def _pieces(self, mask: Image) -> Image:
        """What is large enough of it. Whole outlines: what they enclose belongs to them."""
        mask = as_image(cv2.morphologyEx(mask, cv2.MORPH_OPEN, self._opening))
        least = self.parameters.least_area_m2 * self.px2_per_m2
        contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        small = [c for c in contours if cv2.contourArea(c) < least]
        if len(small) == len(contours):
            return np.zeros_like(mask)
        cv2.drawContours(mask, small, -1, 0, cv2.FILLED)
        return np.asarray(mask, dtype=np.uint8)

    def _edges(self, y: Image, foreground: Image) -> Image:
        p = self.parameters
        # Outside it is black, so that the outline is an edge too.
        edges = cv2.Canny(cv2.bitwise_and(y, foreground), p.canny_low, p.canny_high)
        return np.asarray(cv2.dilate(edges, self._dilation), dtype=np.uint8)
