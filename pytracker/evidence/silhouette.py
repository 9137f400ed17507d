"""What a frame shows of a body: foreground, its edges, and blobs of skin (Li & Kulić IV-C2). Frame by frame.

Foreground by background subtraction in colour, without the cast shadow; Canny inside it, dilated; skin in YCrCb
inside it, opened and filtered by size and shape. All on eight-bit images, and blobs by their contours, which is
what makes it fast.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.video import Frame, Image, frames
from pytracker.rotation import Array

__all__ = ["BodyEvidence", "Silhouette", "SilhouetteParameters", "median_background", "read_background"]

MEDIAN_FRAMES = 61
"""Frames, evenly chosen, that a median background is made of."""

Region = tuple[NDArray[np.float32], Array]
"""Distances from a mask, and points on it."""

REGION_POINTS = 64
"""So many points, evenly chosen, stand for a mask."""

RIM_PX = 5
"""Twice as far as blur and interpolation mix colours, and one."""


@dataclass(frozen=True, kw_only=True)
class SilhouetteParameters:
    """Every threshold. Areas are in square metres at the person, so that they hold for any camera.

    Attributes:
        gains: of blue, green and red, before anything else is done: of a camera that took another light for white, and
            where it is dim (`complexion`).
        colour: whether the background is subtracted in colour (largest channel) or in grey (paper Fig. 3).
        foreground_level: difference from the background, of 255, from which a pixel is foreground.
        region_chroma: difference of Cr or Cb from which a pixel may belong to the region of skin: arms before a wall as
            bright as they are differ in colour alone, which has a fraction of brightness's noise. Edges, blobs and the
            foreground are the paper's.
        shadow_darkest: a shadow keeps at least this share of the background's brightness.
        shadow_chroma: and its Cr and Cb differ by less than this, of 255. 0: no shadow is taken off.
        open_px: foreground that is narrower is noise, px.
        least_area_m2: smaller pieces of foreground are noise.
        canny_low: lower threshold of Canny.
        canny_high: upper threshold.
        dilate_px: edges are widened to this many pixels.
        skin_cr: range of Cr of skin, of 255.
        skin_cb: range of Cb.
        skin_reddest: most redness of skin, (Cr - 128) / Y: unlike Cr itself it stays as it is in the shade, and tells
            red and orange clothes from skin of any tone.
        skin_darkest: least Y of skin.
        skin_area_m2: least and largest area of a blob.
        skin_growth_m: skin is taken so far beyond the foreground, and gaps so wide in it are closed.
        skin_elongation: longer side over shorter side, at most.
        bare_arm_m: a blob that is longer than this, and at least `bare_arm_elongation` times as long as wide, is a hand
            with a bare forearm: both its ends may be the hand.
        bare_arm_elongation: see there.
        hand_m: length of a hand.
    """

    gains: tuple[float, float, float] = (1.0, 1.0, 1.0)
    colour: bool = True
    foreground_level: int = 26
    region_chroma: int = 12
    shadow_darkest: float = 0.5
    shadow_chroma: int = 3
    open_px: int = 3
    least_area_m2: float = 0.003
    canny_low: int = 50
    canny_high: int = 120
    dilate_px: int = 3
    skin_cr: tuple[int, int] = (135, 166)
    skin_cb: tuple[int, int] = (95, 126)
    skin_reddest: float = 0.35
    skin_darkest: int = 50
    skin_area_m2: tuple[float, float] = (0.0012, 0.06)
    skin_growth_m: float = 0.05
    skin_elongation: float = 7.0
    bare_arm_m: float = 0.26
    bare_arm_elongation: float = 2.2
    hand_m: float = 0.18


@dataclass(frozen=True, eq=False)
class BodyEvidence:
    """What one frame shows.

    Attributes:
        foreground: 255 where the person is `(H, W)`.
        edges: 255 on a detected edge `(H, W)`.
        skin: 255 on skin `(H, W)`, before blobs are filtered.
        blobs: centres of skin blobs, px `(B, 2)`.
        areas_px: their areas `(B,)`.
        skin_region: distance of every pixel from skin `(H, W)`, px, and some points on it `(P, 2)`, px. It has skin
            that differs from the background in colour alone, which `skin` has not.
        foreground_region: the same of the foreground.
        keypoints: of each person that a detector found u, v and standard deviation, px `(P, 9, 3)`, in the order of
            `pytracker._core.KEYPOINTS`; NaN where a joint was not seen.
        image: the frame that it was seen in, `(H, W, 3)`, blue, green and red; None where there is none.
    """

    foreground: Image
    edges: Image
    skin: Image
    blobs: Array
    areas_px: Array
    skin_region: Region | None = None
    foreground_region: Region | None = None
    keypoints: Array | None = None
    image: Image | None = None


def median_background(source: Iterable[Frame], wanted: int = MEDIAN_FRAMES) -> Image:
    """The median of evenly chosen frames `(H, W, 3)`: the background, where the person moves enough."""
    kept: list[Image] = []
    step = 1
    for frame in source:
        if frame.index % step == 0:
            kept.append(frame.image.copy())
        if len(kept) >= 2 * wanted:
            # A clip of unknown length: keep every second one, and take half as many from here on.
            kept, step = kept[::2], 2 * step
    if not kept:
        raise InputError("median_background was given no frame, expected at least one")
    return np.asarray(np.median(np.stack(kept), axis=0), dtype=np.uint8)


def read_background(path: Path) -> Image:
    """An image, or the median of a clip. Raises `InputError`."""
    return median_background(frames(path))


def _image(array: Any) -> Image:
    """What OpenCV gives, as the eight-bit image that it is."""
    return np.asarray(array, dtype=np.uint8)


def _region(mask: Image) -> Region | None:
    """A mask as distances, good to a pixel, and points; None where it is empty."""
    if not cv2.countNonZero(mask):
        return None
    found = np.asarray(cv2.findNonZero(mask)).reshape(-1, 2)
    height, width = mask.shape
    # At half the size it takes a quarter of the time, and nothing that is asked needs more.
    small = cv2.resize(mask, ((width + 1) // 2, (height + 1) // 2), interpolation=cv2.INTER_NEAREST)
    halves = cv2.distanceTransform(cv2.bitwise_not(small), cv2.DIST_L2, 3)
    distance = 2.0 * np.asarray(cv2.resize(halves, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)
    picked = np.linspace(0, len(found) - 1, min(REGION_POINTS, len(found))).astype(int)
    return distance, np.ascontiguousarray(found[picked], dtype=np.float64)


def _gained(gains: tuple[float, float, float]) -> Image | None:
    """What becomes of every value of blue, green and red, `(1, 256, 3)`; None where it stays."""
    if gains == (1.0, 1.0, 1.0):
        return None
    return _image(np.clip(np.rint(np.arange(256.0)[:, None] * gains), 0, 255))[None]


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
        self._in_white_light = _gained(self.parameters.gains)
        lit = self._lit(background)
        self.px2_per_m2 = px_per_m * px_per_m
        self._background = lit
        self._grey = cv2.cvtColor(lit, cv2.COLOR_BGR2GRAY)
        self._y, self._cr, self._cb = cv2.split(cv2.cvtColor(lit, cv2.COLOR_BGR2YCrCb))
        self._darkest = cv2.convertScaleAbs(self._y, alpha=self.parameters.shadow_darkest)
        self._dilation = np.ones((self.parameters.dilate_px,) * 2, np.uint8)
        growth = 2 * round(0.5 * self.parameters.skin_growth_m * px_per_m) + 1
        self._growth = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (growth, growth))
        self._opening = np.ones((self.parameters.open_px,) * 2, np.uint8)

    def __call__(self, image: Image) -> BodyEvidence:
        """Evidence of one frame, BGR `(H, W, 3)`. Raises `InputError` for another size than the background's."""
        if image.shape != self.background.shape:
            raise InputError(f"frame is {image.shape}, expected {self.background.shape} as the background")
        smooth = cv2.blur(self._lit(image), (3, 3))
        y, cr, cb = (_image(plane) for plane in cv2.split(cv2.cvtColor(smooth, cv2.COLOR_BGR2YCrCb)))
        mask = self._differs(_image(smooth), y, cr, cb)
        foreground = self._pieces(mask)
        edges = self._edges(y, foreground)
        of_skin = self._coloured_as_skin(y, cr, cb)
        skin = self._skin(of_skin, foreground)
        blobs, areas = self._blobs(skin)
        person = self._pieces(_image(cv2.bitwise_or(mask, self._differs_in_colour(cr, cb))))
        skin_region = _region(self._skin(of_skin, person))
        return BodyEvidence(foreground, edges, skin, blobs, areas, skin_region, _region(foreground), image=image)

    def _lit(self, image: Image) -> Image:
        """As it is in white light, and light enough."""
        return image if self._in_white_light is None else _image(cv2.LUT(image, self._in_white_light))

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
        return _image(mask)

    def _differs_in_colour(self, cr: Image, cb: Image) -> Image:
        """From the background, however bright it is."""
        chroma = cv2.max(cv2.absdiff(cr, self._cr), cv2.absdiff(cb, self._cb))
        _, mask = cv2.threshold(chroma, self.parameters.region_chroma - 1, 255, cv2.THRESH_BINARY)
        return _image(mask)

    def _pieces(self, mask: Image) -> Image:
        """What is large enough of it. Whole outlines: what they enclose belongs to them."""
        mask = _image(cv2.morphologyEx(mask, cv2.MORPH_OPEN, self._opening))
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

    def _places(self, contour: Any, sides: Sequence[float]) -> list[tuple[float, float]]:
        """Where a head or a hand may be in a blob: in its middle; at either end where it is a bare arm."""
        p = self.parameters
        px_per_m = self.px2_per_m2**0.5
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
        p = self.parameters
        reddest = cv2.convertScaleAbs(y, alpha=p.skin_reddest, beta=128)
        red = cv2.bitwise_and(cv2.compare(cr, reddest, cv2.CMP_GT), cv2.inRange(cr, p.skin_cr[0], 255))
        red = cv2.morphologyEx(red, cv2.MORPH_OPEN, self._opening)
        return _image(cv2.dilate(red, np.ones((RIM_PX, RIM_PX), np.uint8)))

    def _coloured_as_skin(self, y: Image, cr: Image, cb: Image) -> Image:
        p = self.parameters
        mask = cv2.bitwise_and(cv2.inRange(cr, *p.skin_cr), cv2.inRange(cb, *p.skin_cb))
        mask = cv2.bitwise_and(mask, cv2.inRange(y, p.skin_darkest, 255))
        mask = cv2.bitwise_and(mask, cv2.bitwise_not(self._too_red(y, cr)))
        return _image(cv2.morphologyEx(mask, cv2.MORPH_OPEN, self._opening))

    def _skin(self, coloured: Image, foreground: Image) -> Image:
        """What is coloured as skin on the foreground and a little beyond it."""
        # A face that the background took for its own still shows in part: it grows from there.
        mask = cv2.bitwise_and(coloured, cv2.dilate(cv2.bitwise_and(coloured, foreground), self._growth))
        return _image(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, self._growth))

    def _blobs(self, skin: Image) -> tuple[Array, Array]:
        """Centres of what may be a head or a hand, px `(B, 2)`, and areas of their blobs, px² `(B,)`."""
        p = self.parameters
        contours, _ = cv2.findContours(skin, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        centres, areas = [], []
        for contour in contours:
            # The area of pixels, not of the polygon through their centres.
            area = cv2.contourArea(contour) + 0.5 * len(contour) + 1
            if not p.skin_area_m2[0] <= area / self.px2_per_m2 <= p.skin_area_m2[1]:
                continue
            _, sides, _ = cv2.minAreaRect(contour)
            if max(sides) + 1 > p.skin_elongation * (min(sides) + 1):
                continue
            places = self._places(contour, sides)
            centres += places
            areas += [area] * len(places)
        return np.array(centres, dtype=float).reshape(-1, 2), np.array(areas)
