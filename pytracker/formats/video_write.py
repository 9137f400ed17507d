"""Videos written frame by frame."""

from __future__ import annotations

import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2

from pytracker._core import InputError
from pytracker.formats.video import Image

__all__ = ["VideoWriter"]

_REDIRECTED = threading.Lock()


class VideoWriter:
    """Writes a video and looks at what was written: OpenCV says nothing of a disk that is full.

    A context: on a good end the file is opened and its frames are counted. Raises `OSError` where some are missing, and
    `InputError` where this OpenCV has no encoder for `fourcc`.
    """

    def __init__(self, path: Path, fourcc: str, rate_hz: float, size: tuple[int, int]) -> None:
        self.path, self.count = path, 0
        with _without("OpenCV: FFMPEG: tag"):
            self._writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*fourcc), rate_hz, size)
        if not self._writer.isOpened():
            raise InputError(f"{path}: OpenCV cannot write {fourcc} video here")

    def __enter__(self) -> VideoWriter:
        return self

    def write(self, image: Image) -> None:
        """Append a frame, BGR `(H, W, 3)`."""
        self._writer.write(image)
        self.count += 1

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: object) -> None:
        self._writer.release()
        if kind is None and (found := _count(self.path)) != self.count:
            raise OSError(f"{self.path}: {found} of {self.count} frames could be written: is the disk full?")


@contextmanager
def _without(words: str) -> Iterator[None]:
    """Standard error but for lines with these words: OpenCV warns there of a tag that a WebM does without."""
    if sys.stderr is None:
        yield
        return
    with _REDIRECTED, tempfile.TemporaryFile("w+", errors="replace") as kept:
        sys.stderr.flush()
        stderr = os.dup(2)
        try:
            os.dup2(kept.fileno(), 2)
            yield
        finally:
            os.dup2(stderr, 2)
            os.close(stderr)
            kept.seek(0)
            sys.stderr.writelines(line for line in kept if words not in line)


def _count(path: Path) -> int:
    """How many frames can be decoded."""
    capture = cv2.VideoCapture(str(path))
    try:
        found = 0
        while capture.grab():
            found += 1
        return found
    finally:
        capture.release()
