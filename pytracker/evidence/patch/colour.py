"""What in a picture is of a patch's colour: its chance pixel by pixel, and the pieces of one colour.

The patch's histogram over hue and saturation is weighed against its surroundings, so that skin and table in the first
box count for nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.video import Image
from pytracker.rotation import Array

__all__ = ["Box", "CamshiftParameters", "PatchColour", "Piece"]

Box = tuple[int, int, int, int]
"""x, y, width, height, px."""


@dataclass(frozen=True, kw_only=True)
class CamshiftParameters:
    """Thresholds of the patch tracker.

    Attributes:
        hue_bins: histogram cells over hue (180).
        saturation_bins: histogram cells over saturation (256).
        hue_width: how far from the patch's main hue a pixel of it may be, in OpenCV's half degrees.
        min_saturation: greyer pixels say nothing about hue, 0-255.
        min_value: darker pixels say nothing about hue, 0-255.
        ring: width of the surroundings that the histogram is weighed against, in box sizes.
        purity: back-projection from which a pixel counts as patch, 0-255.
        min_mass: smallest share of the first frame's mass that is still the patch.
        max_mass: largest.
        max_aspect: largest ratio of the long to the short axis, relative to the first frame's.
        max_jump: farthest the centre may move between frames, in patch sizes, beyond its own velocity.
        agree: frames in which a patch found again must hold still enough before it is believed.
    """

    hue_bins: int = 45
    saturation_bins: int = 16
    hue_width: float = 15.0
    min_saturation: int = 60
    min_value: int = 40
    ring: float = 1.0
    purity: int = 128
    min_mass: float = 0.25
    max_mass: float = 3.0
    max_aspect: float = 3.0
    max_jump: float = 1.5
    agree: int = 2


@dataclass(frozen=True, eq=False)
class Piece:
    """Pixels of the patch's colour that are one thing.

    Attributes:
        centre: u and v `(2,)`, px.
        mass: how many they are.
        aspect: of its long to its short axis.
        box: x, y, width, height, px.
    """

    centre: Array
    mass: float
    aspect: float
    box: Box

    @staticmethod
    def of(moments: dict[str, float], mass: float, box: Box, at: tuple[int, int] = (0, 0)) -> Piece:
        """From the moments of some of its pixels, at least one, which are counted from `at` on."""
        centre = np.array([at[i] + moments[name] / moments["m00"] for i, name in enumerate(("m10", "m01"))])
        return Piece(centre, mass, _aspect(moments), box)


class PatchColour:
    """The colour of the patch that a box holds in a frame.

    Raises `InputError` for a box that is not inside the frame or leaves nothing around it.
    """

    def __init__(self, image: Image, box: Box, parameters: CamshiftParameters) -> None:
        self._parameters = parameters
        _check_box(image, box)
        self._histogram = _contrast_histogram(_hsv(image), box, parameters)

    def back_projection(self, image: Image) -> Image:
        """The chance that a pixel is the patch's, 0-255 `(H, W)`, of a picture or a part of one, BGR `(H, W, 3)`."""
        p = self._parameters
        hsv = _hsv(image)
        back = cv2.calcBackProject([hsv], [0, 1], self._histogram, [0, 180, 0, 256], 1)
        coloured = cv2.inRange(hsv, (0, p.min_saturation, p.min_value), (180, 255, 255))
        return np.asarray(cv2.bitwise_and(back, coloured), dtype=np.uint8)

    def pieces(self, back: Image, least_mass: float) -> list[Piece]:
        """Everything of the colour in a back-projection that has so much mass, px."""
        patch = cv2.inRange(back, self._parameters.purity, 255)
        contours, _ = cv2.findContours(patch, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        found = []
        for contour in contours:
            moments = cv2.moments(contour)
            # A contour runs through the middles of pixels: of how many, Pick's theorem has it.
            mass = moments["m00"] + 0.5 * len(contour) + 1.0
            if moments["m00"] >= 1 and mass >= least_mass:
                x, y, w, h = cv2.boundingRect(contour)
                found.append(Piece.of(moments, mass, (x, y, w, h)))
        return found


def _hsv(image: Image) -> Image:
    return np.asarray(cv2.cvtColor(cv2.GaussianBlur(image, (3, 3), 0), cv2.COLOR_BGR2HSV), dtype=np.uint8)


def _check_box(image: Image, box: Box) -> None:
    x, y, w, h = box
    height, width = image.shape[:2]
    if w < 2 or h < 2 or x < 0 or y < 0 or x + w > width or y + h > height:
        raise InputError(
            f"patch box {list(box)} (x, y, width, height), expected at least 2 px wide and high and inside the "
            f"first frame of {width} x {height} px"
        )


def _contrast_histogram(hsv: Image, box: Box, p: CamshiftParameters) -> NDArray[np.float32]:
    """Per cell of hue and saturation, the chance (0-255) that a pixel of it belongs to the patch.

    From how often the cell occurs in the box and in the ring around it, equally weighed.
    """
    x, y, w, h = box
    coloured = cv2.inRange(hsv, (0, p.min_saturation, p.min_value), (180, 255, 255))
    inside = np.zeros(hsv.shape[:2], dtype=np.uint8)
    inside[y : y + h, x : x + w] = 255
    reach_x, reach_y = round(w * (0.5 + p.ring)), round(h * (0.5 + p.ring))
    ring = np.zeros_like(inside)
    ring[max(0, y - reach_y) : y + h + reach_y, max(0, x - reach_x) : x + w + reach_x] = 255
    ring[inside > 0] = 0
    if (ring > 0).sum() < 0.5 * w * h:
        raise InputError(
            f"patch box {list(box)} leaves {int((ring > 0).sum())} px around it in the frame, expected half "
            f"its own {w * h} px: draw it around the patch alone"
        )

    def share(mask: Image) -> NDArray[np.float32]:
        counts = cv2.calcHist(
            [hsv], [0, 1], cv2.bitwise_and(mask, coloured), [p.hue_bins, p.saturation_bins], [0, 180, 0, 256]
        )
        # A patch seen later is lit a little differently: let each cell speak for its neighbours. Hue wraps.
        padded = np.concatenate([counts[-2:], counts, counts[:2]])
        smooth = cv2.GaussianBlur(padded, (3, 3), 0.8)[2:-2]
        return np.asarray(smooth / max(1, int((mask > 0).sum())), dtype=np.float32)

    patch, around = share(inside), share(ring)
    # Cells that hold next to nothing of the box are not its colour, whatever the ring holds.
    enough = patch > 0.004
    chance = np.where(enough, patch / (patch + around + 1e-9), 0.0)
    # A patch has one hue: cells far from it are edges, where patch and skin mix.
    hue = (np.arange(p.hue_bins) + 0.5) * 180 / p.hue_bins
    main = hue[np.argmax((patch * chance).sum(axis=1))]
    chance[np.abs((hue - main + 90) % 180 - 90) > p.hue_width] = 0.0
    # Twice as common inside as around is where belief begins.
    return np.asarray(255 * np.clip((chance - 0.5) / 0.4, 0.0, 1.0), dtype=np.float32)


def _aspect(m: dict[str, float]) -> float:
    """Ratio of the long to the short axis of the pixels with moments `m`."""
    xx, yy, xy = m["mu20"] / m["m00"], m["mu02"] / m["m00"], m["mu11"] / m["m00"]
    mean, spread = 0.5 * (xx + yy), float(np.hypot(0.5 * (xx - yy), xy))
    # A twelfth is the variance of one pixel: keeps lines of one pixel finite.
    return float(np.sqrt((mean + spread + 1 / 12) / (max(mean - spread, 0.0) + 1 / 12)))
