"""Where each camera saw the patch, on one time axis: the evidence that a tracker of the arm takes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import ARM_NEWS_S, InputError
from pytracker.evidence.ahead import ahead
from pytracker.evidence.patch.camshift import PatchTrack, track_patch
from pytracker.evidence.patch.colour import CamshiftParameters
from pytracker.evidence.patch.hanging import without_hanging, without_standing
from pytracker.evidence.patch.landmarks import JointPixels, joints_seen, wrist_seen
from pytracker.formats.video import Frame, frames
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array

__all__ = ["SAME_FRAME_S", "Landmarks", "Progress", "Sightings", "sightings_of"]

Progress = Callable[[str, int], None]
"""Called with (stage, frames done)."""

SAME_FRAME_S = 1e-3
"""Frames of several cameras nearer than this, and than frames of one camera are, are one observation."""
SKIPPED = 1.5
"""Frames farther apart than so many usual intervals do not follow one another."""
QUARTER = 0.3186
"""A quarter of what is normally distributed is nearer to its mean, in standard deviations."""
ENOUGH = 200
"""Fewer differences do not tell a spread."""


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Where a camera saw a joint of the arm besides the patch on the wrist.

    Attributes:
        joint: `shoulder` or `elbow`.
        camera: which camera.
        pixels: `(T, 2)`, px, a row for every frame of the sightings; NaN where it was not seen.
        sd_px: standard deviation per axis `(T,)`, px.
    """

    joint: str
    camera: int
    pixels: Array
    sd_px: Array


@dataclass(frozen=True, eq=False)
class Sightings:
    """Patch centres of one recording.

    Attributes:
        time_s: recording time of every frame, increasing `(T,)`.
        pixels: centres `(T, C, 2)`, px; NaN where a camera did not see the patch.
        reasons: why not, in words `(T,)`; empty where at least one camera saw it, or a detector did just before and
            after.
        tracks: what the patch tracker found, camera by camera; empty where the centres came from elsewhere.
        landmarks: other joints that were seen.
    """

    time_s: Array
    pixels: Array
    reasons: tuple[str, ...]
    tracks: tuple[PatchTrack, ...] = ()
    landmarks: tuple[Landmarks, ...] = ()

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Whether any camera saw the patch, `(T,)`."""
        return _seen(self.pixels)

    @property
    def jitter_px(self) -> float:
        """How uncertain a single centre is along an axis, px, as it jumps from frame to frame; NaN of too few frames.

        By the third difference over frames, of the camera that is worst: noise is in every frame, and movement that
        three frames do not foretell in some; so it is a quarter of them, the steadiest, that tells.
        """
        pixels, steps_s = self.pixels.copy(), np.diff(self.time_s)
        if len(steps_s):
            pixels[1:][steps_s > SKIPPED * np.median(steps_s)] = np.nan
        jumps = np.abs(np.diff(pixels, n=3, axis=0))
        spreads = [
            np.quantile(known, 0.25) / (QUARTER * np.sqrt(20.0))
            for camera in range(pixels.shape[1])
            if len(known := (of := jumps[:, camera])[np.isfinite(of)]) >= ENOUGH
        ]
        return float(max(spreads, default=np.nan))

    def first(self, count: int) -> Sightings:
        """The first `count` frames that say something new; without what they were seen by.

        Of a fast camera's, which says the same again, as many a second as of a usual one. Cameras may take turns.
        """
        some = slice(0, count)
        if (np.diff(self.time_s[some]) >= ARM_NEWS_S).all():
            return Sightings(self.time_s[some], self.pixels[some], self.reasons[some])
        kept: list[int] = []
        # The last column is for frames that no camera saw it in.
        seen = np.column_stack([np.isfinite(self.pixels).all(axis=2), ~self.valid])
        last_s = np.full(seen.shape[1], -np.inf)
        for frame, (time_s, by) in enumerate(zip(self.time_s.tolist(), seen, strict=True)):
            if np.any(time_s - last_s[by] >= ARM_NEWS_S):
                kept.append(frame)
                last_s[by] = last_s[-1] = time_s
            if len(kept) == count:
                break
        return Sightings(self.time_s[kept], self.pixels[kept], tuple(self.reasons[frame] for frame in kept))

    def last(self, count: int) -> Sightings:
        """The last of them, likewise."""
        new = self.first(len(self.time_s))
        some = slice(max(0, len(new.time_s) - count), None)
        return Sightings(new.time_s[some], new.pixels[some], new.reasons[some])

    @staticmethod
    def of(time_s: Array, pixels: Array, landmarks: tuple[Landmarks, ...] = ()) -> Sightings:
        """From centres `(T, 2)` or `(T, C, 2)` that came from elsewhere: another tracker, keypoints, a simulation."""
        try:
            time_s = np.ascontiguousarray(time_s, dtype=np.float64)
            pixels = np.ascontiguousarray(pixels, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"times or pixels are no arrays of numbers: {error}") from None
        if time_s.ndim != 1 or not len(time_s) or not (np.diff(time_s) > 0).all() or not np.isfinite(time_s).all():
            raise InputError(f"frame times have shape {time_s.shape}, expected (T,), finite and increasing")
        pixels = pixels[:, None, :] if pixels.ndim == 2 else pixels
        if pixels.ndim != 3 or pixels.shape[2] != 2 or len(pixels) != len(time_s):
            raise InputError(f"pixels have shape {pixels.shape} for {len(time_s)} times, expected (T, 2) or (T, C, 2)")
        seen = _seen(pixels)
        for of in landmarks:
            if of.pixels.shape != (len(time_s), 2) or of.sd_px.shape != (len(time_s),):
                raise InputError(
                    f"pixels of the {of.joint} have shape {of.pixels.shape} and sd_px {of.sd_px.shape}, expected "
                    f"{(len(time_s), 2)} and {(len(time_s),)}"
                )
        reasons = tuple("" if s else "not seen" for s in seen)
        return Sightings(time_s, pixels, reasons, landmarks=landmarks)


def _seen(pixels: Array) -> NDArray[np.bool_]:
    """Whether any camera saw it, `(T,)`."""
    return np.asarray(np.isfinite(pixels).all(axis=2).max(axis=1, initial=False), dtype=np.bool_)


def sightings_of(
    recording: ArmRecording, parameters: CamshiftParameters | None = None, progress: Progress | None = None
) -> Sightings:
    """Follow the patch through every video of `recording`. Raises `InputError`."""
    tracks, times, joints = [], [], []
    for number, view in enumerate(recording.views):
        if view.video is None:
            raise InputError(f"camera {number} has no video, expected one, or sightings from elsewhere")
        where = "" if len(recording.views) == 1 else f", camera {number}"
        film = partial(_film, view.video, where, progress)
        if view.patch_box is not None:
            found = track_patch(film("patch"), view.patch_box, parameters)
            hung = without_hanging(found, recording.imus[0], view.start_s)
            track = without_standing(hung, recording.imus[0], view.start_s)
        elif view.keypoints is not None:
            track = wrist_seen(view.keypoints, recording.arm.side, film("wrist"))
        else:
            raise InputError(f"camera {number} has neither patch_box nor keypoints, expected one, or sightings")
        tracks.append(track)
        times.append(track.time_s + view.start_s)
        joints.append(joints_seen(recording, number, track, parameters, film))
    return _merge(times, tracks, joints)


def _film(video: Path, where: str, progress: Progress | None, stage: str) -> Iterator[Frame]:
    return _counted(ahead(frames(video)), stage + where, progress)


def _counted(source: Iterator[Frame], stage: str, progress: Progress | None) -> Iterator[Frame]:
    for frame in source:
        yield frame
        if progress is not None:
            progress(stage, frame.index + 1)


def _merge(times: list[Array], tracks: list[PatchTrack], joints: list[dict[str, JointPixels]]) -> Sightings:
    """One row a distinct time, one column a camera; frames of one camera are never one."""
    every = np.sort(np.concatenate(times))
    shortest = min((float(np.diff(time_s).min()) for time_s in times if len(time_s) > 1), default=np.inf)
    same_s = min(SAME_FRAME_S, 0.4 * shortest)
    start_of_row = np.concatenate([[True], np.diff(every) > same_s])
    rows = every[start_of_row]
    pixels = np.full((len(rows), len(tracks), 2), np.nan)
    said: list[list[str]] = [[] for _ in rows]
    landmarks = []
    for camera, (time_s, track) in enumerate(zip(times, tracks, strict=True)):
        at = np.searchsorted(rows, time_s + same_s, side="right") - 1
        pixels[at, camera] = track.pixel
        for joint, (where, sd_px) in joints[camera].items():
            landmarks.append(Landmarks(joint, camera, _in_rows(len(rows), at, where), _in_rows(len(rows), at, sd_px)))
        for row, reason in zip(at, track.reason, strict=True):
            if reason:
                said[row].append(reason if len(tracks) == 1 else f"camera {camera}: {reason}")
    seen = _seen(pixels)
    reasons = tuple("" if s else "; ".join(words) for s, words in zip(seen, said, strict=True))
    return Sightings(rows, pixels, reasons, tuple(tracks), tuple(landmarks))


def _in_rows(count: int, at: NDArray[np.intp], values: Array) -> Array:
    """Values of some rows, as rows for every one; NaN for the others."""
    out = np.full((count, *values.shape[1:]), np.nan)
    out[at] = values
    return out
