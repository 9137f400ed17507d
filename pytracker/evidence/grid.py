"""A pixel grid over a picture."""

from __future__ import annotations

import cv2
import numpy as np

from pytracker.formats.video import Image

__all__ = ["draw_grid", "png_of"]

EVERY_PX = 50
LINE = (255, 255, 255)
BOX = (60, 60, 230)


def png_of(image: Image) -> bytes:
    """A picture as PNG."""
    ok, png = cv2.imencode(".png", image)
    assert ok
    return png.tobytes()


def draw_grid(image: Image, box: tuple[int, int, int, int] | None) -> Image:
    """Lines every 50 px with their coordinates, and the box, where there is one."""
    out = image.copy()
    height, width = out.shape[:2]
    for x in range(0, width, EVERY_PX):
        cv2.line(out, (x, 0), (x, height), LINE, 1)
    for y in range(0, height, EVERY_PX):
        cv2.line(out, (0, y), (width, y), LINE, 1)
    out = np.asarray(cv2.addWeighted(out, 0.45, image, 0.55, 0), dtype=np.uint8)
    for x in range(0, width, EVERY_PX):
        _number(out, x, (x + 2, 11))
    for y in range(EVERY_PX, height, EVERY_PX):
        _number(out, y, (2, y - 3))
    if box is not None:
        x, y, w, h = box
        cv2.rectangle(out, (x, y), (x + w - 1, y + h - 1), BOX, 1)
    return out


def _number(image: Image, value: int, at: tuple[int, int]) -> None:
    for colour, thickness in (((0, 0, 0), 3), (LINE, 1)):
        cv2.putText(image, str(value), at, cv2.FONT_HERSHEY_SIMPLEX, 0.38, colour, thickness, cv2.LINE_AA)
