"""Pictures of a body made smaller: more pixels a metre tell hardly more of it, and take as much longer.

Wrists of clips of people, filmed at 235 px a metre: 8.1 and 7.7 cm; shrunk to 118 beforehand 8.2 and 7.9.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import cv2
import numpy as np

from pytracker.formats.video import Frame, Image, as_image
from pytracker.rotation import Array

__all__ = ["LEAST_PX", "place_in_frame", "place_in_smaller", "smaller", "smaller_frames", "times_smaller"]

ENOUGH_PX_PER_M = 100.0
"""At least as many are left."""
MOST, LEAST_PX = 16, 32
"""Times, and pixels a side that are left."""


def times_smaller(px_per_m: float, image: Image) -> int:
    """By how many whole times pictures as this one, of so many pixels a metre, may be made smaller.

    Of who is set up to stand before the lens a picture is left all the same, and all of it of who stands behind.
    """
    most = max(1, min(MOST, min(image.shape[:2]) // LEAST_PX))
    return int(np.clip(px_per_m / ENOUGH_PX_PER_M, 1, most)) if np.isfinite(px_per_m) else 1


def smaller(image: Image, times: int) -> Image:
    """Every pixel the mean of `times` by `times`; what is left over at the right and below is cut off."""
    if times == 1:
        return image
    height, width = (side // times for side in image.shape[:2])
    return as_image(cv2.resize(image[: height * times, : width * times], (width, height), interpolation=cv2.INTER_AREA))


def smaller_frames(source: Iterable[Frame], times: int) -> Iterator[Frame]:
    """Frame by frame."""
    return (replace(frame, image=smaller(frame.image, times)) for frame in source)


def place_in_smaller(pixels: Array, times: int) -> Array:
    """Where pixels of the frame `(..., 2)` lie in its smaller picture, px; pixel centres are at integers in both."""
    return (pixels + 0.5) / times - 0.5


def place_in_frame(pixels: Array, times: int) -> Array:
    """Where pixels of a picture that was made smaller `(..., 2)` lie in the frame, px."""
    return (pixels + 0.5) * times - 0.5
