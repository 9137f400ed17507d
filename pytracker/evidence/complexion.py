"""What the light of a recording does to skin, by the face of its first frame: gains that take it to white light.

Thresholds on colour hold for a camera that knows what is white, and for light enough. The first pose shows where a face
is. Where that is as faces usually are nothing is done, to the bit; else every picture is multiplied, channel by channel
(von Kries' rule), so that it is.
"""

from __future__ import annotations

import cv2
import numpy as np

from pytracker.formats.video import Image
from pytracker.rotation import Array

__all__ = ["gains_of_face"]

FACE_M = 0.08
"""Radius about the end of a skeleton's head, the middle of the face, within which nothing but a face is seen."""
LEAST_PX = 12
"""A face of fewer pixels tells nothing."""
TYPICAL_YCC = np.array([115.0, 153.0, 112.0])
"""Y, Cr and Cb of faces: 94 to 125, 147 to 155 and 108 to 113 of nine people and renderings."""
TYPICAL_BGR = np.array([87.0, 103.0, 150.0])
"""The same."""
LEAST_SHIFT = 8.0
"""A face is as usual whose Cr and Cb are no farther off."""
DIM, GLARING = 85.0, 145.0
"""And whose Y is between these."""
MOST_SHIFT = 30.0
"""What is farther off is no face, in any light that a camera may have taken for white."""
EVEN = 26.0
"""Cr and Cb of the middle half of a face differ by no more; those of a head beside the wall do."""
DARKEST = 12.0
"""Nothing is told by what is darker."""
DIM_PICTURE = 130.0
"""A head is dim in a picture whose brightest twentieth is not: it is seen from behind, or against the light."""


def gains_of_face(image: Image, head: Array, px_per_m: float) -> tuple[float, float, float]:
    """Gains of blue, green and red, by the face at `head` `(2,)`, px, of a frame, BGR `(H, W, 3)`.

    All one where it is as faces usually are, and where what is there cannot be one.
    """
    bgr = _face(image, head, px_per_m)
    if len(bgr) < LEAST_PX:
        return 1.0, 1.0, 1.0
    ycc = cv2.cvtColor(bgr[None], cv2.COLOR_BGR2YCrCb)[0].astype(float)
    bright, *colour = np.median(ycc, axis=0).tolist()
    shift = np.abs(np.array(colour) - TYPICAL_YCC[1:])
    spread = np.ptp(np.percentile(ycc[:, 1:], (25, 75), axis=0), axis=0)
    is_usual = (shift <= LEAST_SHIFT).all() and DIM <= bright <= GLARING
    is_face = (shift <= MOST_SHIFT).all() and (spread <= EVEN).all() and bright >= DARKEST
    if bright < DIM:
        is_face &= float(np.percentile(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), 95)) < DIM_PICTURE
    if is_usual or not is_face:
        return 1.0, 1.0, 1.0
    blue, green, red = (TYPICAL_BGR / np.maximum(np.median(bgr, axis=0), 1.0)).tolist()
    return blue, green, red


def _face(image: Image, head: Array, px_per_m: float) -> Image:
    """Its pixels, BGR `(N, 3)`; none where it is not in the picture."""
    mask = np.zeros(image.shape[:2], np.uint8)
    if np.isfinite(head).all() and (np.abs(head) < 1e6).all():
        cv2.circle(mask, (round(float(head[0])), round(float(head[1]))), round(FACE_M * px_per_m), 255, -1)
    return np.asarray(cv2.blur(image, (3, 3))[mask > 0], dtype=np.uint8)
