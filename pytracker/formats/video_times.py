"""When the frames of a video are, one by one, where the container's count and rate do not tell."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import cv2
import numpy as np

from pytracker.formats.container import frames_of_avi, is_fragmented
from pytracker.formats.edit_list import shown_s
from pytracker.formats.matroska import is_matroska
from pytracker.formats.video import VideoInfo, probe, time_of
from pytracker.rotation import Array

__all__ = ["counted", "frame_times"]


def counted(path: Path) -> VideoInfo:
    """As `probe`, and its count is that of the frames which can be decoded. Raises `InputError`.

    Matroska and WebM only estimate it, of an AVI some may be empty, of a trimmed MP4 some are not shown, one in
    fragments may count those of the first: these are decoded once.
    """
    info, avi = probe(path), frames_of_avi(path)
    if is_matroska(path) or (avi is not None and avi.empty) or shown_s(path) is not None or is_fragmented(path):
        return dataclasses.replace(info, frame_count=len(frame_times(path)))
    return info


def frame_times(path: Path) -> Array:
    """Of every frame that can be decoded `(T,)`, s since the first."""
    stat = path.stat()
    return _frame_times(path, stat.st_size, stat.st_mtime_ns)


@functools.lru_cache(maxsize=4)  # all that is asked of one recording's video
def _frame_times(path: Path, _size: int, _changed: int) -> Array:
    capture = cv2.VideoCapture(str(path))
    try:
        times: list[float] = []
        while capture.grab():
            times.append(time_of(path, capture, len(times), times[-1] if times else 0.0))
    finally:
        capture.release()
    found = np.array(times)
    return found - found[0] if len(found) else found
