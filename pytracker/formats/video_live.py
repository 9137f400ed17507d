"""Pictures of a camera that is there now, one by one."""

from __future__ import annotations

from collections.abc import Iterator

import cv2

from pytracker._core import InputError
from pytracker.formats.video import Image, as_image

__all__ = ["camera"]


def camera(source: int | str) -> Iterator[Image]:
    """Pictures `(H, W, 3)`, blue, green and red, of a camera by its number or address, until it ends.

    The driver keeps none back where it can be told so: an old picture would come with the time of a new one. Raises
    `InputError` where it cannot be opened or gives none.
    """
    capture = cv2.VideoCapture(source)
    try:
        if not capture.isOpened():
            raise InputError(
                f"camera {source}: cannot be opened, expected one that is there and that no other program uses"
            )
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        has_given = False
        while True:
            ok, image = capture.read()
            if not ok:
                break
            has_given = True
            yield as_image(image)
    finally:
        capture.release()
    if not has_given:
        raise InputError(f"camera {source}: gives no picture, expected one at least")
