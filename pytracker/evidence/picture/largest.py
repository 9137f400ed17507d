"""Who is largest in a frame, before anything is known of where they are: evidence, and a box about them."""

from __future__ import annotations

import cv2
import numpy as np

from pytracker._core import InputError
from pytracker.evidence.picture.complexion import gains_of_face
from pytracker.evidence.picture.silhouette import BodyEvidence, Silhouette
from pytracker.evidence.picture.thresholds import SilhouetteParameters
from pytracker.formats.video import Image

__all__ = ["Box", "largest_person"]

Box = tuple[int, int, int, int]
"""Left, top, right and bottom, px."""

FACE_M = 0.12
"""The middle of a face below its crown."""
GAP_M = 0.03
"""Pieces of one person lie no farther apart."""
FILLS = 1.5
"""A picture is so many times as high as who is filmed, as a first guess."""
LEAST_M2 = 0.15
"""Less foreground is nobody whole."""
MOST_SHARE = 0.8
"""Nobody fills so much of the picture."""


def largest_person(image: Image, background: Image, height_m: float) -> tuple[BodyEvidence, Box]:
    """What a frame shows, BGR `(H, W, 3)`, in white light, and where its largest person is, who is so tall.

    Their box is left, top, right and bottom, px. Raises `InputError` where nobody is seen.
    """
    gains = (1.0, 1.0, 1.0)
    px_per_m = image.shape[0] / (FILLS * height_m)
    for _ in range(2):
        evidence = Silhouette(background, px_per_m, SilhouetteParameters(gains=gains))(image)
        gap = 2 * round(GAP_M * px_per_m) + 1
        closed = cv2.morphologyEx(evidence.foreground, cv2.MORPH_CLOSE, np.ones((gap, gap), np.uint8))
        _, _, stats, _ = cv2.connectedComponentsWithStats(closed)
        sizes = np.asarray(stats)[1:]
        if not len(sizes) or sizes[:, cv2.CC_STAT_AREA].max() < LEAST_M2 * px_per_m**2:
            raise InputError(
                "the first frame differs from the background by no person, expected somebody: do they come later (cut "
                "what is before off the video), or does the background hold them (camera.background)?"
            )
        if np.count_nonzero(evidence.foreground) > MOST_SHARE * evidence.foreground.size:
            raise InputError(
                f"{np.count_nonzero(evidence.foreground) / evidence.foreground.size:.0%} of the first frame differs "
                "from the background, expected a person: is that frame dark, or the background of another light or "
                "place of the camera?"
            )
        left, top, width, height, _ = (int(x) for x in sizes[int(np.argmax(sizes[:, cv2.CC_STAT_AREA]))])
        px_per_m = height / height_m
        crown = np.flatnonzero(evidence.foreground[top, left : left + width])
        u = left + (float(crown.mean()) if len(crown) else 0.5 * width)
        gains = gains_of_face(image, background, np.array([u, top + FACE_M * px_per_m]), px_per_m)
    return evidence, (left, top, left + width, top + height)
