"""What the light of a recording does to skin, by the face of its first frame: gains that take it to white light.

Thresholds on colour hold for a camera that knows what is white, and for light enough. The first pose shows where a face
is. Where that is as faces usually are nothing is done, to the bit; else every picture is multiplied, channel by channel
(von Kries' rule), so that it is, if that makes the scene behind greyer too (Buchsbaum's grey world); or by one number,
where that is enough.
"""

from __future__ import annotations

import cv2
import numpy as np

from pytracker.formats.video import Image
from pytracker.rotation import Array

__all__ = ["gains_of_face", "is_grey", "red_is_blue"]

FACE_M = 0.08
"""Radius about the end of a skeleton's head, the middle of the face, within which nothing but a face is seen."""
PART_M, PARTS_M = 0.045, (-0.07, 0.0, 0.07)
"""Radius of a part of it, and how far beside its middle parts are looked at: a first pose is off by some cm."""
DIFFERS, DIFFERS_SHARE = 4.0, 0.08
"""What differs from the background by less, of 255 and of its brightness, is none of the person."""
LEAST_PX = 12
"""A face of fewer pixels tells nothing."""
TYPICAL_YCC = np.array([115.0, 153.0, 112.0])
"""Y, Cr and Cb of faces: 94 to 125, 147 to 155 and 108 to 113 of nine people and renderings."""
TYPICAL_BGR = np.array([87.0, 103.0, 150.0])
"""The same."""
LEAST_SHIFT = 8.0
"""A face is as usual whose Cr and Cb are no farther off."""
DIM = 85.0
"""And whose Y is not below this; what is too bright has lost what would mend it."""
MOST_SHIFT = 30.0
"""What is farther off is no face, in any light that a camera may have taken for white."""
EVEN = 26.0
"""Cr and Cb of the middle half of a face differ by no more; those of a head beside the wall do."""
AS_RED = 2.0
"""Parts of a face differ in Cr by no more; of these the one that is neither in shadow nor shines is looked at."""
REDDER = 1.05
"""Times as red as blue: no part of a face whose red is blue is, nor its hair."""
DARKEST = 12.0
"""Nothing is told by what is darker."""
DIM_PICTURE = 150.0
"""A head is dim in a picture whose brightest twentieth is not: it is seen from behind, or against the light."""


GREY = 8
"""Blue, green and red of a picture without colour differ by no more; of people before white walls by 50 somewhere."""
MOSTLY = 0.99
"""In so much of it."""
NONE = (1.0, 1.0, 1.0)


def is_grey(image: Image) -> bool:
    """Whether a picture, BGR `(H, W, 3)`, has no colour, as of an infra-red camera: no skin is seen in it."""
    return bool((image.max(axis=2) - image.min(axis=2) <= GREY).mean() >= MOSTLY)


def gains_of_face(image: Image, background: Image, head: Array, px_per_m: float) -> tuple[float, float, float]:
    """Gains of blue, green and red, by the face at `head` `(2,)`, px, of a frame and its background, BGR `(H, W, 3)`.

    All one where it is as faces usually are, and where what is there cannot be one.
    """
    middle, *parts = _looked(image, background, head, px_per_m)
    if not parts:
        return NONE
    face = _face(parts)
    if _is_usual(middle) or _is_usual(face) or not _may_be_one(face, image):
        return NONE
    seen = np.maximum(np.median(face, axis=0), 1.0)
    white = TYPICAL_BGR / seen
    lighter = np.full(3, float(np.exp(np.log(white).mean())))
    # Skin that is pale or tanned before a wall that is grey is not the light's doing.
    if _colourfulness(background, white) < _colourfulness(background, lighter):
        return _three(white)
    is_dim = lighter[0] > 1.0 and _is_usual(_gained(np.rint(seen)[None], lighter))
    return _three(lighter) if is_dim else NONE


def red_is_blue(image: Image, background: Image, head: Array, px_per_m: float) -> bool:
    """Whether the face is one with red and blue exchanged alone: a picture that was written from RGB. As above."""
    parts = [part for part in _looked(image, background, head, px_per_m) if len(part)]
    # A face that is dark, or dim, is redder than blue all the same.
    if any(_is_usual(part) or np.median(part[:, 2]) > REDDER * np.median(part[:, 0]) for part in parts):
        return False
    bluest = max(parts, key=lambda part: float(np.median(_ycc(part)[:, 2])), default=None)
    return bluest is not None and _is_usual(bluest[:, ::-1])


def _looked(image: Image, background: Image, head: Array, px_per_m: float) -> list[Image]:
    """The person's pixels about the middle of the head, and of parts beside it; one of none where there are too few."""
    none = [np.zeros((0, 3), np.uint8)]
    if not (np.isfinite(head).all() and (np.abs(head) < 1e6).all()):
        return none
    looked = [(0.0, 0.0, FACE_M), *((right, down, PART_M) for down in PARTS_M for right in PARTS_M)]
    found = [_person(image, background, head + px_per_m * np.array(at), px_per_m * m) for *at, m in looked]
    return [part for part in found if len(part) >= LEAST_PX] or none


def _face(parts: list[Image]) -> Image:
    """The part that is one: hair, walls and most collars are less red in the same light, and a forehead may shine."""
    seen = [np.median(_ycc(part), axis=0) for part in parts]
    reddest = max(cr for _, cr, _ in seen)
    red = [k for k, (_, cr, _) in enumerate(seen) if cr >= reddest - AS_RED]
    return parts[sorted(red, key=lambda k: float(seen[k][0]))[(len(red) - 1) // 2]]


def _three(gains: Array) -> tuple[float, float, float]:
    blue, green, red = gains.tolist()
    return blue, green, red


def _gained(bgr: Array, gains: Array) -> Image:
    return np.asarray(np.clip(np.rint(bgr * gains), 0, 255), dtype=np.uint8)


def _colourfulness(background: Image, gains: Array) -> float:
    """How far a scene is from grey on the whole, once it is multiplied."""
    _, cr, cb = _ycc(_gained(background.reshape(-1, 3).mean(axis=0)[None] / gains.max(), gains))[0]
    return float(np.hypot(cr - 128.0, cb - 128.0))


def _person(image: Image, background: Image, middle: Array, radius_px: float) -> Image:
    """Pixels of the person within a circle, BGR `(N, 3)`."""
    mask = np.zeros(image.shape[:2], np.uint8)
    cv2.circle(mask, (round(float(middle[0])), round(float(middle[1]))), max(1, round(radius_px)), 255, -1)
    inside = mask > 0
    seen, behind = (cv2.blur(of, (3, 3))[inside].astype(float) for of in (image, background))
    differs = np.abs(seen - behind).max(axis=1) > DIFFERS + DIFFERS_SHARE * behind.mean(axis=1)
    return np.asarray(seen[differs], dtype=np.uint8)


def _ycc(bgr: Image) -> Array:
    return np.asarray(cv2.cvtColor(bgr[None], cv2.COLOR_BGR2YCrCb)[0], dtype=float)


def _is_usual(bgr: Image) -> bool:
    bright, *colour = np.median(_ycc(bgr), axis=0)
    return bool((np.abs(np.array(colour) - TYPICAL_YCC[1:]) <= LEAST_SHIFT).all() and bright >= DIM)


def _may_be_one(bgr: Image, image: Image) -> bool:
    """Whether it is a face in some light that a camera may have taken for white, or a dim one."""
    ycc = _ycc(bgr)
    bright, *colour = np.median(ycc, axis=0)
    spread = np.ptp(np.percentile(ycc[:, 1:], (25, 75), axis=0), axis=0)
    if (np.abs(np.array(colour) - TYPICAL_YCC[1:]) > MOST_SHIFT).any() or (spread > EVEN).any() or bright < DARKEST:
        return False
    is_dim_picture = float(np.percentile(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), 95)) < DIM_PICTURE
    return bool(bright >= DIM or is_dim_picture)
