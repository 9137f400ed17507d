"""`track(recording, method, seed)`: a recording to a track, by the tracker that it needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import singledispatch
from typing import overload

from pytracker._core import InputError
from pytracker.evidence.pose.trunk import distance_changes
from pytracker.evidence.sightings import Progress, Sightings
from pytracker.methods.arm import ArmMethod, Smooth
from pytracker.methods.body import BodyMethod, BodySmooth, Partitioned
from pytracker.methods.method import Method
from pytracker.recording.keypoints.load import arms_are_seen
from pytracker.recording.recording import ArmRecording, BodyRecording, Recording
from pytracker.skeleton.skeleton import UPPER_BODY
from pytracker.tracking.arm import ArmTrack, track_arm
from pytracker.tracking.body import BodyTrack, track_body
from pytracker.tracking.fits import check_fits

__all__ = ["default_method", "track"]

TRACKERS: Mapping[str, Callable[..., ArmTrack | BodyTrack]] = {"arm": track_arm, "body": track_body}
"""By kind of recording."""


@singledispatch
def default_method(recording: Recording) -> Method:
    """The best for a recording that is there as a whole.

    All are smoothed, but for a body whose picture shows arms that its keypoints leave out: smoothing needs the joints
    that a detector saw. Where keypoints show that the person comes nearer or goes farther off, the distance is tracked
    too.
    """
    raise NotImplementedError(f"a method for a {type(recording).__name__}")


@default_method.register
def _(recording: ArmRecording) -> Method:
    return Smooth()


@default_method.register
def _(recording: BodyRecording) -> Method:
    keypoints = recording.view.keypoints
    leaves_arms_out = keypoints is not None and not recording.imus and not arms_are_seen(keypoints)
    method = Partitioned if leaves_arms_out and recording.has_picture else BodySmooth
    return method(free=(*UPPER_BODY, "root_tz")) if distance_changes(recording) else method()


@overload
def track(
    recording: ArmRecording,
    method: ArmMethod | None = None,
    seed: int = 0,
    *,
    sightings: Sightings | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> ArmTrack: ...


@overload
def track(
    recording: BodyRecording,
    method: BodyMethod | None = None,
    seed: int = 0,
    *,
    progress: Progress | None = None,
    threads: int | None = None,
) -> BodyTrack: ...


@overload
def track(
    recording: Recording,
    method: Method | None = None,
    seed: int = 0,
    *,
    sightings: Sightings | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> ArmTrack | BodyTrack: ...


def track(
    recording: Recording,
    method: Method | None = None,
    seed: int = 0,
    *,
    sightings: Sightings | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> ArmTrack | BodyTrack:
    """Track `recording` by `method`; without one by the best (`default_method`).

    `sightings` (arm) are patch centres found before or elsewhere; without them the videos are searched. `threads`
    limits how many work on the particles and does not change the result.

    Raises `InputError` for what cannot be used, such as an arm's method for a body, and `TrackingError`, naming the
    frame, when the track is lost beyond recovery; its `track` attribute then holds the frames before, where there are
    any.
    """
    method = default_method(recording) if method is None else method
    check_fits(recording, method)
    if not isinstance(seed, int) or not 0 <= seed < 2**64:
        raise InputError(f"seed is {seed!r}, expected a whole number, 0 or larger and below 2^64")
    return TRACKERS[recording.kind](recording, method, seed, sightings=sightings, progress=progress, threads=threads)
