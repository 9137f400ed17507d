"""Frames of a camera that is there now: each with the time at which it arrived, or a file's as if it were one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

from pytracker._core import InputError
from pytracker.formats.video import Frame, frames
from pytracker.formats.video_live import camera

__all__ = ["camera_frames"]

Clock = Callable[[], float]
"""Seconds since the beginning."""


def camera_frames(source: str, clock: Clock, late_s: float = 0.0) -> Iterator[Frame]:
    """Frames of `source`: a camera's number (`0`), an address (`rtsp://...`), or a file that is played at its own pace.

    Times are seconds by `clock`, `late_s` before a frame arrived. Raises `InputError` where it cannot be opened.
    """
    if source.isdigit() or "://" in source:
        for index, image in enumerate(camera(int(source) if source.isdigit() else source)):
            yield Frame(index, clock() - late_s, image)
        return
    began_s = clock()
    if not Path(source).is_file():
        raise InputError(f"{source}: no such file, expected a camera's number, such as 0, an address or a video")
    for frame in frames(source):
        time.sleep(max(0.0, began_s + frame.time_s - clock()))
        yield Frame(frame.index, began_s + frame.time_s - late_s, frame.image)
