"""An arm's recording to an `ArmTrack`: the patch found in the videos, tracked with the IMU, smoothed where asked."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pytracker._core import ARM_NOTHING_CAME, Tracker, TrackingError
from pytracker.evidence.sightings import Progress, Sightings, sightings_of
from pytracker.methods.arm import ArmMethod, Mixture
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array
from pytracker.tracking.alike import UNLIKE, moves_otherwise
from pytracker.tracking.camera_moved import MOVED, camera_moved
from pytracker.tracking.follow import Followed, follow, smoothed
from pytracker.tracking.tracks import Track

__all__ = ["JITTERY", "ArmTrack", "filter_arm", "track_arm"]

STRETCH = 200
"""Frames tracked between two calls of the progress function, at the most."""
PARTICLE_FRAMES = 4_000_000
"""So many particles times frames are a second's work: whoever stops a run does not wait for longer."""
TURN = slice(9, 12)
"""Columns of the orientation's error in the state of a worn arm: after position, velocity and bias."""
JITTERY = 1.5
"""Centres that jump by so many times `pixel_sd` are more uncertain than that."""

REST_SD, MOVING_SDS = 0.02, (0.3, 0.8)
"""How fast the wrist may go at the first frame, m/s per axis: not at all, or as people move; clips are cut anywhere."""
PROBE = Mixture(components=1)
"""Its log evidence tells which."""
PROBE_S = 1.0
"""Of so much; half of it, or twice, tells them apart as well."""
RESTS = 2.5
"""Log evidence by which rest must be better: a wrist that goes along the viewing ray looks nearly like one that rests
(0.8 to 3.7 less of 0.3 m/s than of rest; 0.4 to 5.5 where it rests)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmTrack(Track):
    """What a method made of an arm's recording; joints `wrist` and `elbow`.

    Attributes:
        method: the method with its parameters.
        recording: what was tracked.
        state_mean: whole state `(T, D)`: position, velocity, then bias and patch offset where estimated.
        state_sd: its standard deviations `(T, D)`.
        wrist_covariance: covariance of the position `(T, 3, 3)`, m².
        sightings: the evidence used.
    """

    method: ArmMethod
    recording: ArmRecording
    state_mean: Array
    state_sd: Array
    wrist_covariance: Array
    sightings: Sightings

    judged_by: ClassVar[str] = "wrist"


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
    something is known, that stands for the method's own parameter; so does what the centres show, where they jump from
    frame to frame by more than 1.5 times `pixel_sd` (`Sightings.jitter_px`) and this is left at its default. Where
    `velocity_start_sd` is, it is whichever of 0.02, 0.3 and 0.8 m/s explains the first second best: recordings start
    amid a movement.

    Raises `InputError` for what cannot be used, and `TrackingError`, naming the frame, when the track is lost
    beyond recovery; its `track` attribute then holds the frames before, where there are any.
    """
    began = time.perf_counter()
    if sightings is None:
        sightings = sightings_of(recording, progress=progress)
    evidence_s = time.perf_counter() - began
    method = replace(method, velocity_start_sd=_speed_sd(recording, sightings, method))
    track = _judged(filter_arm(recording, method, seed, sightings=sightings, progress=progress, threads=threads))
    track = replace(track, stage_s={"evidence": evidence_s} | dict(track.stage_s))
    if track.lost:
        loss = TrackingError(track.lost)
        loss.track = track
        raise loss
    return track


def filter_arm(
    recording: ArmRecording,
    method: ArmMethod,
    seed: int = 0,
    *,
    sightings: Sightings,
    progress: Progress | None = None,
    threads: int | None = None,
) -> ArmTrack:
    """The same, of which the core alone has judged what frames are worth: for who tries many descriptions of one.

    Where it is lost beyond recovery, the track is what there was before, and says why (`lost`); `TrackingError` is
    raised where that is nothing.
    """
    began = time.perf_counter()
    method = method.known_by(recording.spreads)
    if sightings.jitter_px > JITTERY * method.pixel_sd and method.pixel_sd == ArmMethod.pixel_sd:
        method = replace(method, pixel_sd=sightings.jitter_px)
    tracker = Tracker(recording, method, seed)
    at_once = max(1, min(STRETCH, PARTICLE_FRAMES // max(1, method.sample_size or 1)))
    source = recording.observations(sightings)
    found = follow(tracker, source, at_once=at_once, progress=progress, threads=threads)
    found.table |= smoothed(tracker, found.tracked, progress, threads)
    stage_s = {"filter": time.perf_counter() - began}
    return _assemble(recording, method, seed, sightings, found, stage_s)


def _speed_sd(recording: ArmRecording, sightings: Sightings, method: ArmMethod) -> float:
    """How fast the wrist may go at the first frame, m/s per axis: found, where the method has it at its default."""
    own = method.velocity_start_sd
    if own != type(method).velocity_start_sd or "velocity_start_sd" in recording.spreads or not len(sightings.time_s):
        return own
    seen = np.asarray(np.isfinite(sightings.pixels[..., 0])).any(axis=1)
    began_s, seen_s = sightings.time_s[0], sightings.time_s[int(np.argmax(seen))]
    if not seen.any() or max(seen_s, recording.imus[0].time_s[0]) > began_s + PROBE_S:
        return max(MOVING_SDS)  # by then it may go as it likes
    first = sightings.first(int(np.searchsorted(sightings.time_s, seen_s + PROBE_S)))
    evidence = {}
    for sd in (REST_SD, *MOVING_SDS):
        probe = replace(PROBE, pixel_sd=method.pixel_sd, velocity_start_sd=sd)
        try:
            track = filter_arm(recording, probe, sightings=first)
        except TrackingError:
            return own
        evidence[sd] = float(np.nansum(track.log_evidence)) - (RESTS if sd == REST_SD else 0.0)
    return max(evidence, key=lambda sd: evidence[sd])


def _assemble(
    recording: ArmRecording,
    method: ArmMethod,
    seed: int,
    sightings: Sightings,
    found: Followed,
    stage_s: dict[str, float],
) -> ArmTrack:
    """Rows for every frame: those that were not tracked hold NaN and a reason."""
    first, end = found.first, found.first + found.tracked
    reason = list(sightings.reasons)
    reason[:first] = ["before the first IMU sample"] * first
    reason[end:] = ["the track was lost before"] * (found.count - end)
    for row, doubt in enumerate(found.table["doubt"], start=first):
        # What says why nothing came, or for how long, stands in its place; `_judged` sees what comes later too.
        if doubt and doubt not in (*ARM_NOTHING_CAME, UNLIKE):
            reason[row] = f"{doubt}; {reason[row]}" if reason[row] else str(doubt)
    joints = {joint: found.joint(joint) for joint in ("wrist", "elbow")}
    imu_time_s = recording.imus[0].time_s
    since = sightings.time_s - imu_time_s[np.clip(np.searchsorted(imu_time_s, sightings.time_s, "right") - 1, 0, None)]
    for frame in np.flatnonzero(since > max(method.hold_s, 1.5 * float(np.median(np.diff(imu_time_s))))):
        reason[frame] = reason[frame] or f"no IMU sample for {since[frame]:.2f} s"
    return ArmTrack(
        method=method,
        seed=seed,
        time_s=sightings.time_s,
        joints=joints,
        ess=found.rows(found.table["ess"]),
        log_evidence=found.rows(found.table["log_evidence"]),
        valid=np.array([not words for words in reason]),
        reason=tuple(reason),
        state_mean=found.rows(found.table["mean"]),
        state_sd=found.rows(found.table["sd"]),
        wrist_covariance=found.rows(found.table["place_covariance"]),
        sightings=sightings,
        recording=recording,
        stage_s=stage_s,
        lost=found.lost,
    )


def _judged(track: ArmTrack) -> ArmTrack:
    """The same, by what the whole alone shows: a camera that moved, a patch that moves otherwise than the sensor."""
    if not track.method.follows_patch:
        return track
    wrist_m = track.joints["wrist"].mean
    is_worn = isinstance(track.method, Mixture)
    turn_rad = np.nanmean(track.state_mean[:, TURN], axis=0) if is_worn else np.zeros(3)
    has_moved = [camera_moved(view, track.time_s, wrist_m) for view in track.recording.views]
    otherwise = moves_otherwise(track.recording, track.sightings, wrist_m, turn_rad)
    reason = list(track.reason)
    for why, is_so in ((MOVED, np.any(has_moved, axis=0)), (UNLIKE, otherwise)):
        for frame in np.flatnonzero(is_so):
            reason[frame] = f"{reason[frame]}; {why}" if reason[frame] else why
    return replace(track, reason=tuple(reason), valid=np.array([not words for words in reason]))
