"""What stands still where a hand was: no part of the person, though it has the colour of one.

A hand that hung beside a box of wood, or of skin's colour, and was raised then, is gone from its place, and the box is
there as before. Of a hand that never moves nothing tells it.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.picture.skin import RIM_PX, Skin
from pytracker.evidence.picture.thresholds import SilhouetteParameters
from pytracker.formats.video import Image, as_image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["draw", "left_behind"]

Mask = NDArray[np.bool_]

ABOUT_M = 0.30
"""So wide about a forearm and hand of the first pose their pixels are looked for: the pose is not exact."""
HAND_M2 = 0.008
"""A hand and wrist are larger from the front, and what the rim of one changes that sways by 3 cm is less."""
AWAY, THERE = 0.25, 0.9
"""In so many of the samples the hand is away; in so many a thing is there, which the person covers now and then."""
LEAST_M2 = 0.01
"""What is smaller is no more than a rim, or draws no hand."""
SAME_SHARE = 0.5
"""What differs by less than this share of what foreground does is the same: skin and a wall may be much alike."""
PERSON_M = 0.2
"""So wide about all other bones it may be the person."""


def draw(mask: Image, camera: Camera | WeakPerspective, bones: Array, width_m: float, label: int) -> None:
    """Draw bones `(B, 2, 3)`, world, m, so wide into `(H, W)`; those that are far out of the picture are left out."""
    width_px = width_m * float(camera.px_per_m(bones[:1, 0])[0])
    for ends in bones:
        pixels = camera.project(ends)
        if np.isfinite(pixels).all() and np.abs(pixels).max() < 10 * max(mask.shape):
            a, b = np.rint(pixels).astype(int).tolist()
            cv2.line(mask, a, b, label, max(1, round(width_px)))


def left_behind(
    samples: Sequence[Image], first: Image, person: Mask, camera: Camera | WeakPerspective, bones: Array, hands: Mask
) -> Mask:
    """Where skin's colour `(H, W)` stays as in the `first` frame, in nearly all `samples`, beside hands that left.

    `person` is what was taken for the person in the first frame; `bones` `(B, 2, 3)` are those of the first pose,
    world, m, and `hands` `(2, B)` says which of them are either forearm with its hand.
    """
    level = SilhouetteParameters().foreground_level
    smooth = as_image(cv2.blur(first, (3, 3)))
    off = [cv2.absdiff(cv2.blur(image, (3, 3)), smooth).max(axis=2) for image in samples]
    px2_per_m2 = float(camera.px_per_m(bones[:1, 0])[0]) ** 2
    theirs = np.zeros(first.shape[:2], np.uint8)
    draw(theirs, camera, bones[~hands.any(axis=0)], PERSON_M, 1)
    for hand in hands:
        about = np.zeros(first.shape[:2], np.uint8)
        draw(about, camera, bones[hand], ABOUT_M, 1)
        its = person & (about > 0)
        changed = [np.count_nonzero(its & (there >= level)) for there in off]
        if np.quantile(changed, 1.0 - AWAY) < HAND_M2 * px2_per_m2:
            theirs |= about
    same = np.mean([there < SAME_SHARE * level for there in off], axis=0) >= THERE
    stays = same & (theirs == 0) & _is_skins(smooth, np.sqrt(px2_per_m2))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(stays.astype(np.uint8))
    is_small = np.asarray(stats)[:, cv2.CC_STAT_AREA] < LEAST_M2 * px2_per_m2
    return np.asarray(stays & ~is_small[labels])


def _is_skins(image: Image, px_per_m: float) -> Mask:
    """What has skin's colour, and its rim."""
    y, cr, cb = (as_image(plane) for plane in cv2.split(cv2.cvtColor(image, cv2.COLOR_BGR2YCrCb)))
    coloured = Skin(SilhouetteParameters(), px_per_m).coloured(y, cr, cb)
    return np.asarray(cv2.dilate(coloured, np.ones((RIM_PX, RIM_PX), np.uint8)) > 0)
