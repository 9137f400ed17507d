"""Video files, frame by frame, with the container's own times.

Times are read after each frame, as the container has them, so that a variable frame rate stays what it was;
`index / fps` and the container's frame count are not trusted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.container import frames_of_avi, missing_bytes, span_s
from pytracker.formats.edit_list import shown_s

__all__ = [
    "MOST_FRAMES",
    "OPENCV",
    "Frame",
    "Image",
    "VideoInfo",
    "as_image",
    "frames",
    "glimpses",
    "opened",
    "probe",
    "time_of",
]

OPENCV: str = cv2.__version__
"""Which OpenCV decodes and draws: another one may give other bits."""

Image = NDArray[np.uint8]

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
"""Of which folders of frames are made."""
TRUNCATED_SHARE = 0.9
"""Fewer frames than this share of what the container promises, and the file is taken to be cut short."""
GLANCES = 12
"""So many frames after the first, half of them spread over the whole video: no camera gives the same bytes in all."""
MOST_FRAMES = 100_000_000
"""A header that says more was never finished."""


def as_image(array: Any) -> Image:
    """What OpenCV gives, as the eight-bit image that it is."""
    return np.asarray(array, dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame.

    Attributes:
        index: number, from 0.
        time_s: the container's time, s, the first frame at 0.
        image: BGR `(H, W, 3)`.
    """

    index: int
    time_s: float
    image: Image


@dataclass(frozen=True)
class VideoInfo:
    """What a container says of itself.

    Attributes:
        width: px.
        height: px.
        frame_count: as promised; an estimate in many containers, 0 where unknown.
        rate_hz: as promised; an average where the rate varies, 0 where unknown.
        codec: four small letters, such as `h264`.
    """

    width: int
    height: int
    frame_count: int
    rate_hz: float
    codec: str = ""


def opened(path: Path) -> cv2.VideoCapture:
    """A decoder at its first frame, which whoever opens it releases. Raises `InputError`."""
    if not path.is_file():
        of = path if path.is_dir() else path.parent
        count = sum(one.suffix.lower() in PICTURES for one in of.iterdir()) if of.is_dir() else 0
        if count > 1 and (path.is_dir() or "%" in path.name or path.suffix.lower() in PICTURES):
            raise InputError(
                f"{path}: {of.name} holds {count} pictures, expected a video, such as ffmpeg makes of them: ffmpeg "
                "-framerate RATE -pattern_type glob -i 'FOLDER/*.png' -c:v mjpeg -q:v 2 video.avi"
            )
        raise InputError(f"{path}: no such file, expected a video")
    if path.stat().st_size == 0:
        raise InputError(f"{path}: the file is empty (0 bytes), expected a video")
    capture = cv2.VideoCapture(str(path))
    if not capture.isOpened():
        raise InputError(
            f"{path}: cannot be opened as a video ({path.stat().st_size} bytes): it is cut short, of an unknown "
            "codec or no video; expected a file that FFmpeg reads, such as H.264 in .mp4 or .mkv"
        )
    # A phone held upright writes turned pictures and says so: not every version of OpenCV heeds that by itself.
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)
    return capture


def probe(path: Path, *, is_still: bool = False) -> VideoInfo:
    """Open `path` and decode its first frame.

    Raises `InputError`, also for one picture throughout, unless `is_still` says that it may be: a background.
    """
    capture = opened(path)
    try:
        ok, image = capture.read()
        codec = int(capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode("ascii", "replace")
        if not ok:
            raise InputError(
                f"{path}: holds no frame that can be decoded, expected at least one (its codec is {codec!r}: ffmpeg -i "
                f"{path.name} -c:v libx264 -crf 18 other.mp4 writes one that is usual)"
            )
        if missing := missing_bytes(path):
            raise InputError(
                f"{path}: by its own container {missing} bytes are missing at its end ({path.stat().st_size} "
                "are there), "
                "expected a whole file: it is cut short"
            )
        count, avi = _promised(path, capture), frames_of_avi(path)
        if avi is not None and 0 < avi.count < TRUNCATED_SHARE * count:
            raise InputError(
                f"{path}: its header says {count} frames and {avi.count} are there: it is cut short, or frames are "
                "missing within; expected a whole file"
            )
        if not is_still:
            _require_change(path, capture, image, count)
        rate = capture.get(cv2.CAP_PROP_FPS)
        return VideoInfo(image.shape[1], image.shape[0], count, max(0.0, float(rate)), codec.lower())
    finally:
        capture.release()


def _require_change(path: Path, capture: cv2.VideoCapture, first: Any, count: int) -> None:
    """Raises `InputError` for a video that is one picture, byte for byte.

    Of frames that are flagged as interlaced some versions of OpenCV say that they were read, and give what happened to
    lie in memory.
    """
    spread = np.linspace(0, count - 1, GLANCES // 2 + 2).astype(int)[1:-1].tolist()
    looked = 1
    for index in [None] * (GLANCES // 2) + (spread if count > GLANCES else []):
        if index is not None:
            capture.set(cv2.CAP_PROP_POS_FRAMES, float(index))
        ok, image = capture.read()
        if ok and not np.array_equal(first, image):
            return
        looked += ok
    if looked > GLANCES // 2:
        raise InputError(
            f"{path}: {looked} frames from all over it are the same picture, byte for byte, expected a video in which "
            f"something moves: is it interlaced, which OpenCV {OPENCV} may not decode (ffmpeg -i {path.name} -vf yadif "
            "-crf 18 progressive.mp4 makes it progressive), or a still?"
        )


def _promised(path: Path, capture: cv2.VideoCapture) -> int:
    """How many frames the container says that it has; of an AVI how many it has, unless it says more.

    Where a container's length is that of its sound as well, by when its pictures are; where it was trimmed, by how long
    they are shown. Raises `InputError` for one that is damaged inside.
    """
    said, avi, span = max(0, int(capture.get(cv2.CAP_PROP_FRAME_COUNT))), frames_of_avi(path), span_s(path)
    if span is not None and capture.get(cv2.CAP_PROP_FPS) > 0:
        return round((span[1] - span[0]) * capture.get(cv2.CAP_PROP_FPS)) + 1
    if avi is None or not avi.count:
        shown = shown_s(path)
        return said if shown is None else min(said, round(shown * capture.get(cv2.CAP_PROP_FPS)) or said)
    if avi.broken_at is not None and avi.count < said:
        raise InputError(
            f"{path}: is damaged at byte {avi.broken_at} of {path.stat().st_size}: no frame is found there, and those "
            "after would come too early; expected a whole file: copy or export it again"
        )
    return said if avi.count < TRUNCATED_SHARE * said and said < MOST_FRAMES else avi.count - avi.empty


def frames(path: Path | str) -> Iterator[Frame]:
    """Decode `path` frame by frame, in constant memory.

    Raises `InputError` where the file cannot be opened, holds no frame, or has times that do not increase, and
    after the last frame where far fewer could be decoded than the container promises.
    """
    path = Path(path)
    capture = opened(path)
    try:
        promised = _promised(path, capture)
        duration_s = promised / capture.get(cv2.CAP_PROP_FPS) if capture.get(cv2.CAP_PROP_FPS) > 0 else 0.0
        index, first_s, last_s = 0, 0.0, -1.0
        while True:
            ok, image = capture.read()
            if not ok:
                break
            time_s = time_of(path, capture, index, last_s)
            if index == 0:
                first_s = time_s
            elif time_s <= last_s:
                raise InputError(
                    f"{path}: frame {index} has time {time_s:.6f} s after {last_s:.6f} s, expected increasing times"
                )
            yield Frame(index, time_s - first_s, _bgr(image))
            last_s = time_s
            index += 1
    finally:
        capture.release()
    if index == 0:
        raise InputError(f"{path}: holds no frame that can be decoded, expected at least one")
    # A variable rate breaks the promised count, not the promised duration.
    is_short = index < TRUNCATED_SHARE * promised and last_s - first_s < TRUNCATED_SHARE * duration_s
    if is_short or missing_bytes(path):
        raise InputError(
            f"{path}: decoding stopped after frame {index - 1} at {last_s:.3f} s, expected {promised:.0f} frames "
            f"({duration_s:.3f} s): the file is cut short or damaged"
        )


def time_of(path: Path, capture: cv2.VideoCapture, index: int, last_s: float) -> float:
    """Of the frame that was read, s by the container; `last_s` is of the one before.

    An AVI has no times but the order in which frames are decoded: of the last, which B-frames hold back, there is none;
    nor is there in a program stream (.mpg).
    """
    time_s = float(capture.get(cv2.CAP_PROP_POS_MSEC)) / 1000.0
    has_none = index and time_s == 0.0 and (last_s > 0.0 or frames_of_avi(path) is not None)
    if has_none and capture.get(cv2.CAP_PROP_FPS) > 0:
        return last_s + 1.0 / float(capture.get(cv2.CAP_PROP_FPS))
    return time_s


def glimpses(path: Path, count: int) -> Iterator[Frame]:
    """The first frame and `count` others spread over the whole video, each at about its time, without the rest.

    Fewer where it is shorter, or the container cannot find them. Raises `InputError` as `probe`.
    """
    capture = opened(path)
    try:
        promised, rate_hz = _promised(path, capture), capture.get(cv2.CAP_PROP_FPS)
        for index in np.unique(np.linspace(0, max(promised - 1, 0), count + 1).astype(int)).tolist():
            if index:
                capture.set(cv2.CAP_PROP_POS_FRAMES, float(index))
            ok, image = capture.read()
            if ok:
                yield Frame(index, index / rate_hz if rate_hz > 0 else 0.0, _bgr(image))
    finally:
        capture.release()


def _bgr(image: Any) -> Image:
    return as_image(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else image)
