"""Where each camera saw the patch, on one time axis: the evidence that a tracker of the arm takes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.evidence.camshift import CamshiftParameters, PatchTrack, track_patch
from pytracker.formats.video import Frame, frames
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array

__all__ = ["SAME_FRAME_S", "Progress", "Sightings", "sight"]

Progress = Callable[[str, int], None]
"""Called with (stage, frames done)."""

SAME_FRAME_S = 1e-3
"""Frames of several cameras nearer than this, and than frames of one camera are, are one observation."""


@dataclass(frozen=True, eq=False)
class Sightings:
    """Patch centres of one recording.

    Attributes:
        time_s: recording time of every frame, increasing `(T,)`.
        pixels: centres `(T, C, 2)`, px; NaN where a camera did not see the patch.
        reasons: why not, in words `(T,)`; empty where at least one camera saw it.
        tracks: what the patch tracker found, camera by camera; empty where the centres came from elsewhere.
    """

    time_s: Array
    pixels: Array
    reasons: tuple[str, ...]
    tracks: tuple[PatchTrack, ...] = ()

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Whether any camera saw the patch, `(T,)`."""
        return _seen(self.pixels)

    @staticmethod
    def of(time_s: Array, pixels: Array) -> Sightings:
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
        return Sightings(time_s, pixels, tuple("" if s else "not seen" for s in seen))


def _seen(pixels: Array) -> NDArray[np.bool_]:
    """Whether any camera saw it, `(T,)`."""
    return np.asarray(np.isfinite(pixels).all(axis=2).max(axis=1, initial=False), dtype=np.bool_)


def sight(
    recording: ArmRecording, parameters: CamshiftParameters | None = None, progress: Progress | None = None
) -> Sightings:
    """Follow the patch through every video of `recording`. Raises `InputError`."""
    tracks, times = [], []
    for number, view in enumerate(recording.views):
        if view.video is None or view.patch_box is None:
            raise InputError(f"camera {number} has no video or patch_box, expected both, or sightings from elsewhere")
        stage = "patch" if len(recording.views) == 1 else f"patch, camera {number}"
        track = track_patch(_counted(frames(view.video), stage, progress), view.patch_box, parameters)
        tracks.append(track)
        times.append(track.time_s + view.start_s)
    return _merge(times, tracks)


def _counted(source: Iterator[Frame], stage: str, progress: Progress | None) -> Iterator[Frame]:
    for frame in source:
        yield frame
        if progress is not None:
            progress(stage, frame.index + 1)


def _merge(times: list[Array], tracks: list[PatchTrack]) -> Sightings:
    """One row a distinct time, one column a camera; frames of one camera are never one."""
    every = np.sort(np.concatenate(times))
    shortest = min((float(np.diff(time_s).min()) for time_s in times if len(time_s) > 1), default=np.inf)
    same_s = min(SAME_FRAME_S, 0.4 * shortest)
    start_of_row = np.concatenate([[True], np.diff(every) > same_s])
    rows = every[start_of_row]
    pixels = np.full((len(rows), len(tracks), 2), np.nan)
    said: list[list[str]] = [[] for _ in rows]
    for camera, (time_s, track) in enumerate(zip(times, tracks, strict=True)):
        at = np.searchsorted(rows, time_s + same_s, side="right") - 1
        pixels[at, camera] = track.pixel
        for row, reason in zip(at, track.reason, strict=True):
            if reason:
                said[row].append(reason if len(tracks) == 1 else f"camera {camera}: {reason}")
    seen = _seen(pixels)
    reasons = tuple("" if s else "; ".join(words) or "no camera" for s, words in zip(seen, said, strict=True))
    return Sightings(rows, pixels, reasons, tuple(tracks))
