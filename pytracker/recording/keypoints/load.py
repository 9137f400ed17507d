"""`[[camera]] keypoints` to keypoints in the pixels and frames of that camera's video."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoints.read import Keypoints, read_keypoints
from pytracker.formats.video import VideoInfo
from pytracker.recording.keypoints.filled import as_seen
from pytracker.recording.keypoints.frames import frames_in
from pytracker.rotation import Array

__all__ = [
    "alone",
    "arms_are_seen",
    "files_of",
    "first_seen",
    "in_pixels",
    "load_keypoints",
    "of_video",
    "tallest",
    "uncovered",
    "unseen",
]

OUTSIDE = 0.25
"""More points outside the picture, and they are of another."""
SPARSE = 0.2
"""Of keypoints alone so many of the frames must be there: a stray file is not a day of frames."""
OFTEN_SEEN = 0.5
"""An arm whose elbow and wrist are in so many of the frames is followed by them."""
_ARMS = [KEYPOINTS.index(f"{side}_{joint}") for side in ("left", "right") for joint in ("elbow", "wrist")]
LACKS, MOST_LACKS = 0.1, 300
"""Where more frames than this share of the video's, or than so many, are before the first or after the last, something
is missing."""
LEAST_MISSING, MISSING = 15, 0.1
"""So many frames on end may be without any and no word is said; of longer gaps such a share of the video."""


def load_keypoints(path: Path, model: str, video: Path, info: VideoInfo) -> Keypoints:
    """Read them, of `video`. Raises `InputError`."""
    return in_pixels(path, read_keypoints(path, model), video, info)


def alone(path: Path, keypoints: Keypoints) -> tuple[Keypoints, tuple[str, ...]]:
    """The same, counted from 0, where there is no video; a word where they begin late. Raises `InputError`."""
    first, last = int(keypoints.frames[0]), int(keypoints.frames[-1])
    if len(keypoints.frames) < SPARSE * (last - first + 1):
        raise InputError(
            f"{path}: has {len(keypoints.frames)} of the frames {first} to {last}, expected most of them: a stray file?"
        )
    if first == 1:
        return dataclasses.replace(keypoints, frames=keypoints.frames - 1), keypoints.warnings  # counted from one
    if first == 0:
        return keypoints, keypoints.warnings
    words = f"{path}: the keypoints begin at frame {first}: frame 0 is taken to be at start_s, and the first pose there"
    return keypoints, (*keypoints.warnings, words)


def uncovered(path: Path, keypoints: Keypoints, info: VideoInfo) -> tuple[str, ...]:
    """A word where keypoints end long before their video, or begin long after it, or are missing for long within.

    A row in which nobody was found is none.
    """
    there = keypoints.frames[np.isfinite(keypoints.points[..., 0]).any(axis=(1, 2))]
    if not info.frame_count or not len(there):
        return ()
    first, last, rows = int(there[0]), int(there[-1]), len(there)
    if info.frame_count - (last - first + 1) <= min(LACKS * info.frame_count, MOST_LACKS):
        return _missing_within(path, there, info)
    every = round(info.frame_count / rows)
    skips = every > 1 and last - first + 1 == rows and abs(info.frame_count - every * rows) <= every
    why = (
        f"of one frame in {every} (a column frame says which)"
        if skips
        else "another clip's, cut short, or without rows where nobody was found"
    )
    return (
        f"{path}: the keypoints are of frames {first} to {last}, and the video has {info.frame_count}; the others are "
        f"tracked without: {why}?",
    )


def _missing_within(path: Path, there: NDArray[np.int64], info: VideoInfo) -> tuple[str, ...]:
    steps = np.diff(there)
    gaps = np.flatnonzero(steps > LEAST_MISSING)
    missing = int((steps[gaps] - 1).sum())
    if missing <= MISSING * info.frame_count:
        return ()
    k = int(steps.argmax())
    longest = f"{there[k] + 1} to {there[k + 1] - 1}"
    where = f"frames {longest}" if len(gaps) == 1 else f"{missing} frames, {longest} among them"
    return (f"{path}: has no keypoints in {where}: these are tracked without",)


def arms_are_seen(keypoints: Keypoints) -> bool:
    """Whether elbows and wrists are among them most of the time."""
    seen = np.isfinite(keypoints.points[:, :, _ARMS, 0]).any(axis=1)
    return bool((seen.mean(axis=0) >= OFTEN_SEEN).all())


def unseen(path: Path, keypoints: Keypoints) -> tuple[str, ...]:
    """A word where joints of the arms are in no frame at all."""
    there = np.isfinite(keypoints.points[..., 0])
    missing = [KEYPOINTS[k] for k in _ARMS if not there[..., k].any()]
    if not missing:
        return ()
    return (f"{path}: keypoints have no {', '.join(missing)} in any frame: only pictures and sensors tell of these",)


def tallest(people: Array) -> int | None:
    """Which of some people `(P, 9, 3)` is the tallest in the picture; None where nobody is there."""
    v = people[..., 1]
    there = np.isfinite(v).sum(axis=1) > 1
    if not there.any():
        return None
    spans = [float(np.nanmax(row) - np.nanmin(row)) if seen else -1.0 for row, seen in zip(v, there, strict=True)]
    return int(np.argmax(spans))


def first_seen(keypoints: Keypoints, joint: str, frames: int) -> Array | None:
    """Where a joint of the tallest person is first seen `(2,)`, px, in so many frames; None where it is not."""
    for people in keypoints.points[keypoints.frames < frames]:
        who = tallest(people)
        if who is not None and np.isfinite(pixel := people[who, KEYPOINTS.index(joint), :2]).all():
            return np.asarray(pixel)
    return None


def files_of(path: Path) -> list[Path]:
    """One file, or those of a folder."""
    return sorted(path.glob("[!.]*.json")) if path.is_dir() else [path]


def in_pixels(path: Path, keypoints: Keypoints, video: Path, info: VideoInfo) -> Keypoints:
    """The same in px of `video`, frames counted from 0. Raises `InputError` where they cannot be of this video."""
    frames, odd = frames_in(path, keypoints, video, info)
    # Of some frames the video has no picture.
    points, frames = keypoints.points[frames >= 0], frames[frames >= 0]
    if not len(frames):
        raise InputError(f"{path}: none of its {len(keypoints.frames)} rows is of a frame that {video} has")
    if keypoints.is_share:
        points[..., :2] = points[..., :2] * [info.width, info.height] - 0.5
    seen = points[np.isfinite(points[..., 0])]
    u, v = seen[:, 0], seen[:, 1]
    outside = (u < -1) | (v < -1) | (u > info.width) | (v > info.height)
    if outside.mean() > OUTSIDE:
        raise InputError(
            f"{path}: {outside.mean():.0%} of the keypoints lie outside the {info.width} x {info.height} px of {video} "
            f"(they reach to {u.max():.0f}, {v.max():.0f}), expected pixels of that video: of another size or clip?"
        )
    # A file is written of frames in which nobody is seen too; rows of a table, and entries of a list, are not.
    begins_at_one = path.is_dir() and frames[0] == 1 and frames[-1] < info.frame_count - 1
    if info.frame_count and (begins_at_one or (frames[0] > 0 and frames[-1] == info.frame_count)):
        if frames[-1] < info.frame_count:
            words = f"{path}: its frames are numbered from 1 to {frames[-1]}: taken to be counted from one"
            odd = (*odd, f"{words}; if frame 0 is not seen, write it with nothing in it")
        frames = frames - 1
    if info.frame_count and frames[-1] >= info.frame_count:
        raise InputError(
            f"{path}: has frame {frames[-1]}, expected below the {info.frame_count} frames of {video}: another clip?"
        )
    return Keypoints(frames, points, warnings=odd)


def of_video(path: Path, keypoints: Keypoints, info: VideoInfo) -> tuple[Keypoints, tuple[str, ...]]:
    """Those of a video that were seen; a word on those that were not, and where they are of a part of it."""
    kept, said = as_seen(path, keypoints)
    return kept, (*keypoints.warnings, *uncovered(path, kept, info), *said)
