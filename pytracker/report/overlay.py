"""`overlay.webm`: a recording's video with something drawn over every frame, in a form that browsers play."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from threading import Event

import cv2
import numpy as np

from pytracker.evidence.sightings import SAME_FRAME_S
from pytracker.formats.video import Image, frames
from pytracker.formats.video_write import VideoWriter
from pytracker.rotation import Array

__all__ = ["caption", "enlarged", "write_overlay"]

WIDTH = 480
MOST_FRAMES_PER_S = 15.0
"""Enough to judge by. The OpenCV wheel can write VP8 and VP9 for browsers; VP9 takes five times as long."""


def write_overlay(
    path: Path,
    video: Path,
    start_s: float,
    frame_time_s: Array,
    track_time_s: Array,
    draw: Callable[[Image, int], Image],
    stop: Event,
) -> bool:
    """Write `draw(frame, row of the track)` of as many frames as are worth it, until `stop` is set.

    Raises `InputError` where OpenCV cannot write it, `OSError` where the disk does not take it.
    """
    interval = float(np.median(np.diff(frame_time_s))) if len(frame_time_s) > 1 else 0.04
    step = max(1, int(np.ceil(1.0 / (interval * MOST_FRAMES_PER_S))))
    with ExitStack() as stack:
        writer: VideoWriter | None = None
        for frame in frames(video):
            if stop.is_set():
                return False
            row = int(np.searchsorted(track_time_s, frame.time_s + start_s + SAME_FRAME_S, side="right")) - 1
            if frame.index % step or row < 0:
                continue
            image = draw(frame.image, row)
            if writer is None:
                size = (image.shape[1], image.shape[0])
                writer = stack.enter_context(VideoWriter(path, "VP80", 1.0 / (interval * step), size))
            writer.write(image)
    return writer is not None


def enlarged(frame: Image) -> tuple[Image, float]:
    """A frame at the overlay's width, and how many of its pixels one of the frame's is."""
    scale = WIDTH / frame.shape[1]
    # Even sides: VP8 stores colour at half resolution.
    size = (WIDTH, 2 * round(frame.shape[0] * scale / 2))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(frame, size, interpolation=how), dtype=np.uint8), scale


def caption(image: Image, words: str) -> None:
    """Words at the lower edge, readable on anything."""
    place = (8, image.shape[0] - 10)
    for colour, width in (((0, 0, 0), 3), ((255, 255, 255), 1)):
        cv2.putText(image, words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, colour, width, cv2.LINE_AA)
