"""Of which frames of a video keypoints are: by their numbers, by their times, else one by one."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker.formats.container import AviFrames, frames_of_avi
from pytracker.formats.keypoints.read import Keypoints
from pytracker.formats.matroska import is_matroska
from pytracker.formats.video import VideoInfo
from pytracker.formats.video_times import frame_times
from pytracker.rotation import Array

__all__ = ["frames_in"]

Numbers = NDArray[np.int64]

IRREGULAR = 0.3
"""Times that lie farther beside whole frames, as a share of one, are of no steady rate."""
TYPED = 0.05
"""A row every so many frames is every whole number of them, to this share: its rate was typed, or the video's was."""
MOSTLY, BESIDE = 0.75, 0.6
"""So many rows must be of a frame each, beside it by no more than so much of the usual distance of frames."""
ENDS = 3.0
"""Rows that are denser than frames end with the video, to so many frames: else another rate was typed."""
NOWHERE = -1
"""Instead of the number of a frame that holds no picture."""


def frames_in(path: Path, keypoints: Keypoints, video: Path, info: VideoInfo) -> tuple[Numbers, tuple[str, ...]]:
    """Numbers of the frames of `video` as they are decoded, -1 of those that are not in it; and what is odd about them.

    `info` is of `counted`; it counts no frames where keypoints stand for the video.
    """
    avi = frames_of_avi(video) if info.frame_count and video.is_file() else None
    if avi is not None and avi.empty:
        return _in_avi(keypoints, video, info, avi)
    if keypoints.time_s is None or not info.rate_hz:
        return keypoints.frames, () if len(keypoints.frames) == info.frame_count else keypoints.warnings
    return _by_times(path, keypoints, keypoints.time_s, video, info)


def _by_times(
    path: Path, keypoints: Keypoints, time_s: Array, video: Path, info: VideoInfo
) -> tuple[Numbers, tuple[str, ...]]:
    there, by_rate = bool(info.frame_count) and video.is_file(), _of_rate(time_s, info)
    # Matroska's rate is a word, its frames' times are their own.
    if by_rate is not None and not (there and is_matroska(video)):
        return by_rate, keypoints.warnings
    if len(keypoints.frames) == info.frame_count:
        return keypoints.frames, ()
    times = frame_times(video) if there else _ideal(time_s, info)
    nearest = _nearest(time_s, times)
    if nearest is not None:
        return nearest, keypoints.warnings
    nearest = _nearest_but_few(time_s, times)
    if nearest is not None:
        without = int((nearest == NOWHERE).sum())
        words = f"{path}: {without} of its {len(nearest)} rows are of no frame of {video.name} by their times: left out"
        return nearest, (*keypoints.warnings, words)
    nearest = _nearest_of_dense(time_s, times)
    if nearest is not None:
        kept = int((nearest != NOWHERE).sum())
        words = f"{path}: has {len(nearest)} rows for {len(times)} frames of {video.name}: the {kept} nearest are taken"
        return nearest, (*keypoints.warnings, words)
    if by_rate is not None:
        return by_rate, keypoints.warnings
    words = (
        f"{path}: its times, from {time_s[0]:.3f} to {time_s[-1]:.3f} s, are not those of frames of a video of "
        f"{info.rate_hz:g} Hz: its rows are counted as frames instead"
    )
    return keypoints.frames, (*keypoints.warnings, words)


def _ideal(time_s: Array, info: VideoInfo) -> Array:
    """Times of the frames where there is no video, or none to look at."""
    count = info.frame_count or int(np.ceil(time_s[-1] * info.rate_hz)) + 1
    return np.arange(count) / info.rate_hz


def _of_rate(time_s: Array, info: VideoInfo) -> Numbers | None:
    """Numbers at regular times, whose clock need not be the video's: a detector's rate is one that somebody typed.

    None where the times are of no steady rate, or reach beyond the video.
    """
    steps = np.diff(time_s)
    interval_s = float(np.mean(steps[steps < 1.5 * np.median(steps)]))  # times are often rounded
    counts = np.rint(time_s / interval_s)
    if np.abs(time_s / interval_s - counts).max() > IRREGULAR:
        return None
    ratio, last = interval_s * info.rate_hz, float(counts[-1])
    every = max(1, round(ratio))
    if not info.frame_count:
        return np.asarray(every * counts, dtype=np.int64) if abs(ratio - every) <= TYPED * every else None
    fitting = [step for step in dict.fromkeys((every, 1)) if step * last <= info.frame_count]
    if every in fitting and abs(ratio - every) <= TYPED * every:
        return np.asarray(every * counts, dtype=np.int64)
    # Another rate that is true, or one that somebody typed: whichever ends with the video.
    step = min(fitting, key=lambda step: abs(step * last + 1 - info.frame_count), default=ratio)
    if abs(ratio * last + 1 - info.frame_count) < abs(step * last + 1 - info.frame_count):
        return None
    return np.asarray(step * counts, dtype=np.int64) if fitting else None


def _nearest(time_s: Array, times: Array) -> Numbers | None:
    """Which of a video's frames are the nearest in time, each once; None where some are nowhere near."""
    if len(times) < 2:
        return None
    nearest = _closest(time_s, times)
    # Of two that are nearest to one frame the later is of the next.
    rows = np.arange(len(nearest))
    frames = np.maximum.accumulate(nearest - rows) + rows
    if frames[-1] >= len(times) or np.abs(times[frames] - time_s).max() > float(np.median(np.diff(times))):
        return None
    return np.asarray(frames, dtype=np.int64)


def _nearest_but_few(time_s: Array, times: Array) -> Numbers | None:
    """The same, -1 of rows that are of no frame, or of one that another row is nearer to; None where they are many."""
    if len(times) < 2:
        return None
    frames = _nearest_to_each(time_s, times)
    return frames if np.count_nonzero(frames != NOWHERE) > MOSTLY * len(time_s) else None


def _nearest_of_dense(time_s: Array, times: Array) -> Numbers | None:
    """The same of rows that are denser than frames and end with them: a detector's own rate; else None."""
    if len(times) < 2 or len(time_s) <= len(times):
        return None
    usual_s = float(np.median(np.diff(times)))
    frames = _nearest_to_each(time_s, times)
    is_whole = np.count_nonzero(frames != NOWHERE) >= MOSTLY * len(times)
    return frames if is_whole and abs(time_s[-1] - times[-1]) <= ENDS * usual_s else None


def _nearest_to_each(time_s: Array, times: Array) -> Numbers:
    """Of which frame each row is: of that to which none is nearer, nor too far away; else -1."""
    nearest = _closest(time_s, times)
    off = np.abs(times[nearest] - time_s)
    order = np.argsort(off, kind="stable")
    kept = order[np.unique(nearest[order], return_index=True)[1]]
    kept = kept[off[kept] <= BESIDE * float(np.median(np.diff(times)))]
    frames = np.full(len(time_s), NOWHERE, dtype=np.int64)
    frames[kept] = nearest[kept]
    return frames


def _closest(time_s: Array, times: Array) -> NDArray[np.intp]:
    """The frame that is the nearest to each time."""
    after = np.clip(np.searchsorted(times, time_s), 1, len(times) - 1)
    return np.asarray(after - (time_s - times[after - 1] < times[after] - time_s))


def _in_avi(keypoints: Keypoints, video: Path, info: VideoInfo, avi: AviFrames) -> tuple[Numbers, tuple[str, ...]]:
    """Where some frames of an AVI are empty: who counts them too has numbers that are not those of decoded ones."""
    numbers = keypoints.frames
    if keypoints.time_s is not None:
        whole = _of_rate(keypoints.time_s, dataclasses.replace(info, frame_count=avi.count))
        numbers = numbers if whole is None else whole
    elif numbers[-1] < info.frame_count:
        return numbers, keypoints.warnings
    places = np.rint(frame_times(video) * info.rate_hz).astype(np.int64)
    at = np.clip(np.searchsorted(places, numbers), 0, len(places) - 1)
    return np.where(places[at] == numbers, at, NOWHERE), keypoints.warnings
