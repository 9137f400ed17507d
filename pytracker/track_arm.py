"""An arm's recording to an `ArmTrack`: evidence to the tracker, the same bits as the online tracker gives."""

from __future__ import annotations

import time
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from pytracker._core import ArmTracker, InputError, TrackingError
from pytracker.evidence.sightings import Progress, Sightings, sight
from pytracker.joint_track import JointTrack, Track
from pytracker.methods import ArmMethod
from pytracker.recording import ArmRecording
from pytracker.rotation import Array

__all__ = ["ArmTrack", "track_arm"]

STRETCH = 200
"""Frames tracked between two calls of the progress function, at the most."""
PARTICLE_FRAMES = 4_000_000
"""So many particles times frames are a second's work: whoever stops a run does not wait for longer."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmTrack(Track):
    """What a method made of an arm's recording; joints `wrist` and `elbow`.

    Attributes:
        method: the method with its parameters.
        recording: what was tracked.
        state_mean: whole state `(T, D)`: position, velocity, then bias and patch offset where estimated.
        state_covariance: its covariance `(T, D, D)`.
        sightings: the evidence used.
    """

    method: ArmMethod
    recording: ArmRecording
    state_mean: Array
    state_covariance: Array
    sightings: Sightings


def track_arm(
    recording: ArmRecording,
    method: ArmMethod,
    seed: int = 0,
    *,
    sightings: Sightings | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> ArmTrack:
    """Track an arm: see `pytracker.track`.

    `sightings` are patch centres found before or elsewhere; without them the videos are searched. `threads`
    limits how many work on a large particle set and does not change the result. Where the recording says how well
    something is known, that stands for the method's own parameter.

    Raises `InputError` for what cannot be used, and `TrackingError`, naming the frame, when the track is lost
    beyond recovery; its `track` attribute then holds the frames before, where there are any.
    """
    began = time.perf_counter()
    parameters = {field.name for field in fields(method)}
    said: dict[str, Any] = {name: sd for name, sd in recording.spreads.items() if name in parameters}
    method = replace(method, **said)
    if sightings is None:
        sightings = sight(recording, progress=progress)
    seen = time.perf_counter()
    imu = recording.imus[0]
    back = np.flatnonzero(~(np.diff(imu.time_s) > 0))
    if back.size:
        k = int(back[0]) + 1
        raise InputError(
            f"IMU sample {k} has time {imu.time_s[k]} s after {imu.time_s[k - 1]} s, expected increasing times"
        )
    covered = sightings.time_s >= imu.time_s[0]
    if not covered.any():
        raise InputError(
            f"all {len(covered)} frames ({sightings.time_s[0]:.3f} to {sightings.time_s[-1]:.3f} s) come before the "
            f"first IMU sample at {imu.time_s[0]:.3f} s, expected an overlap: check start_s and offset_s"
        )
    tracker = ArmTracker(recording.arm, [view.camera for view in recording.views], method, seed)
    tables: list[dict[str, Any]] = []
    first, used, lost = int(np.argmax(covered)), 0, None
    step = max(1, min(STRETCH, PARTICLE_FRAMES // max(1, getattr(method, "particles", 1))))
    for start in range(first, len(covered), step):
        stretch = slice(start, start + step)
        table, taken, lost = tracker.run(
            imu.time_s[used:],
            imu.acc[used:],
            imu.q_world_sensor[used:],
            None if imu.gyr is None else imu.gyr[used:],
            sightings.time_s[stretch],
            sightings.pixels[stretch],
            first_frame=start,
            threads=threads,
        )
        tables.append(table)
        used += taken
        if progress is not None:
            progress("track", min(stretch.stop, len(covered)))
        if lost:
            break
    tables = [table for table in tables if len(table["ess"])]
    if not tables:
        raise TrackingError(lost)
    whole = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    whole |= _smoothed(tracker, len(whole["ess"]), progress, threads)
    stage_s = {"evidence": seen - began, "filter": time.perf_counter() - seen}
    result = _assemble(recording, method, seed, sightings, first, whole, stage_s, lost or "")
    if lost:
        error = TrackingError(lost)
        error.track = result
        raise error
    return result


def _smoothed(tracker: ArmTracker, frames: int, progress: Progress | None, threads: int | None) -> dict[str, Any]:
    """The columns that smoothing changes; none for a method that does not smooth."""
    tables: list[dict[str, Any]] = []
    done = 0
    try:
        # Window by window: whoever stops a run does not wait for the whole of it.
        while len((table := tracker.smoothed(done, threads=threads))["ess"]):
            tables.append(table)
            done += len(table["ess"])
            if progress is not None:
                progress("smooth", done)
    except TrackingError:
        return {"doubt": ["the recording could not be smoothed: this is the filter's estimate"] * frames}
    return {name: np.concatenate([table[name] for table in tables]) for name in (tables[0] if tables else ())}


def _assemble(
    recording: ArmRecording,
    method: ArmMethod,
    seed: int,
    sightings: Sightings,
    first: int,
    table: dict[str, Any],
    stage_s: dict[str, float],
    lost: str,
) -> ArmTrack:
    """Rows for every frame: those that were not tracked hold NaN and a reason."""
    frames, end = len(sightings.time_s), first + len(table["ess"])

    def rows(values: Array) -> Array:
        out = np.full((frames, *values.shape[1:]), np.nan)
        out[first:end] = values
        return out

    reason = list(sightings.reasons)
    reason[:first] = ["before the first IMU sample"] * first
    reason[end:] = ["the track was lost before"] * (frames - end)
    for row, doubt in enumerate(table["doubt"], start=first):
        reason[row] = "; ".join(words for words in (doubt, reason[row]) if words)
    imu_time_s = recording.imus[0].time_s
    since = sightings.time_s - imu_time_s[np.clip(np.searchsorted(imu_time_s, sightings.time_s, "right") - 1, 0, None)]
    for frame in np.flatnonzero(since > max(method.hold_s, 1.5 * float(np.median(np.diff(imu_time_s))))):
        reason[frame] = reason[frame] or f"no IMU sample for {since[frame]:.2f} s"
    return ArmTrack(
        method=method,
        seed=seed,
        time_s=sightings.time_s,
        joints={
            joint: JointTrack(
                rows(table[joint]),
                *(rows(table[f"{joint}_{quantity}"]) for quantity in ("mode", "sd", "lo", "hi")),
            )
            for joint in ("wrist", "elbow")
        },
        ess=rows(table["ess"]),
        log_evidence=rows(table["log_evidence"]),
        valid=np.array([not words for words in reason]),
        reason=tuple(reason),
        state_mean=rows(table["mean"]),
        state_covariance=rows(table["covariance"]),
        sightings=sightings,
        recording=recording,
        stage_s=stage_s,
        lost=lost,
    )
