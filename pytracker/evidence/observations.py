"""`recording.observations()`: all that was observed, in order of time, as a tracker takes it."""

from __future__ import annotations

import heapq
import itertools
import time
from bisect import bisect_left
from collections.abc import Iterable, Iterator
from functools import singledispatch
from operator import attrgetter
from typing import TypeVar

import numpy as np

from pytracker._core import InputError, Observation
from pytracker.evidence.ahead import ahead
from pytracker.evidence.senses import Senses, senses_of
from pytracker.evidence.sightings import Landmarks, Progress, Sightings, sightings_of
from pytracker.formats.video import frames
from pytracker.recording.recording import ArmRecording, BodyRecording, Imu, Recording
from pytracker.rotation import Array

__all__ = ["observations", "read_evidence", "shared_sightings"]

ROLL_SD = 0.35
"""Of an upper arm: its muscles turn about the bone, rad.

A forearm turns within itself, which the state does not hold.
"""


Evidence = TypeVar("Evidence", Sightings, Senses)

AT_ONCE = 1000
"""Samples of an arm's sensor that are made together."""

TIME = attrgetter("time_s")


@singledispatch
def read_evidence(recording: Recording, progress: Progress | None = None) -> Sightings | Senses:
    """What has to be known before the first observation: an arm's patch in the videos, a body's background."""
    raise InputError(f"{type(recording).__name__} is no recording of an arm or a body, expected one")


@read_evidence.register
def _(recording: ArmRecording, progress: Progress | None = None) -> Sightings:
    return sightings_of(recording, progress=progress)


@read_evidence.register
def _(recording: BodyRecording, progress: Progress | None = None) -> Senses:
    return senses_of(recording)


@singledispatch
def shared_sightings(recording: Recording, progress: Progress | None = None) -> Sightings | None:
    """What several methods on one recording share: an arm's patch; of a body, whose video streams, nothing."""
    return None


@shared_sightings.register
def _(recording: ArmRecording, progress: Progress | None = None) -> Sightings | None:
    return sightings_of(recording, progress=progress)


@singledispatch
def observations(recording: Recording, evidence: Sightings | Senses | None = None) -> Iterator[Observation]:
    """What was observed, in order of time; of the same time a sensor's sample before a frame.

    `evidence` is what was found before or elsewhere: patch centres of an arm, what a body's pictures show; without it
    the videos are searched. An arm's frames begin with the first IMU sample. A body's video is streamed: memory does
    not grow with its length. Raises `InputError` for evidence of another kind, for sensor times that do not increase,
    and where no frame comes after the first sample.
    """
    raise InputError(f"{type(recording).__name__} is no recording of an arm or a body, expected one")


Recording.observer = staticmethod(observations)


def _given(evidence: Sightings | Senses | None, recording: Recording, expected: type[Evidence]) -> Evidence:
    """What is given, or what the recording has. Raises `InputError` for another kind's."""
    evidence = read_evidence(recording) if evidence is None else evidence
    if isinstance(evidence, expected):
        return evidence
    found, wanted = (cls.__name__.lower() for cls in (type(evidence), expected))
    raise InputError(f"{found} are given for a recording of kind {recording.kind!r}, expected {wanted}")


@observations.register
def _(recording: ArmRecording, evidence: Sightings | Senses | None = None) -> Iterator[Observation]:
    sightings = _given(evidence, recording, Sightings)
    imu = recording.imus[0]
    _check_times("IMU sample", imu.time_s)
    _check_times("frame", sightings.time_s)
    _check_landmarks(recording, sightings)
    if not len(sightings.time_s):
        raise InputError("the sightings hold no frame, expected one at least")
    covered = sightings.time_s >= imu.time_s[0]
    if not covered.any():
        raise InputError(
            f"all {len(covered)} frames ({sightings.time_s[0]:.3f} to {sightings.time_s[-1]:.3f} s) come before the "
            f"first IMU sample at {imu.time_s[0]:.3f} s, expected an overlap: check start_s and offset_s"
        )
    first = int(np.argmax(covered))
    others = itertools.chain(
        *(_worn(worn, recording.upper_arm_sd_rad) for worn in recording.imus[1:]),
        *(_of_landmarks(landmarks, sightings.time_s, first) for landmarks in sightings.landmarks),
        Observation.patches(sightings.time_s[first:], sightings.pixels[first:], first),
    )
    return _among(_inertials(imu), others)


def _inertials(imu: Imu) -> Iterator[list[Observation]]:
    """Every sample, in stretches that are made as they are needed."""
    for first in range(0, len(imu.time_s), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        gyr = None if imu.gyr is None else imu.gyr[some]
        yield Observation.inertials(imu.time_s[some], imu.acc[some], imu.q_world_segment[some], gyr, first)


def _among(stretches: Iterable[list[Observation]], others: Iterable[Observation]) -> Iterator[Observation]:
    """All in order of time. Sorting a stretch is many times faster than merging one by one."""
    rest, taken = sorted(others, key=TIME), 0
    for stretch in stretches:
        # What is as late as the last sample comes after it: with the next.
        until = bisect_left(rest, TIME(stretch[-1]), taken, key=TIME)
        yield from sorted(stretch + rest[taken:until], key=TIME)
        taken = until
    yield from rest[taken:]


def _check_landmarks(recording: ArmRecording, sightings: Sightings) -> None:
    for of in sightings.landmarks:
        if of.joint not in recording.landmarks or not 0 <= of.camera < len(recording.views):
            there = ", ".join(recording.landmarks) or "none"
            raise InputError(
                f"sightings hold the {of.joint} of camera {of.camera}, expected of the recording's landmarks ({there}) "
                f"and its {len(recording.views)} cameras"
            )


def _of_landmarks(landmarks: Landmarks, time_s: Array, first: int) -> Iterator[Observation]:
    """Where it was seen, frame by frame."""
    seen = np.flatnonzero(np.isfinite(landmarks.pixels).all(axis=1))
    for k in seen[seen >= first].tolist():
        pixel, sd_px = landmarks.pixels[k].tolist(), float(landmarks.sd_px[k])
        yield Observation.landmark(float(time_s[k]), landmarks.joint, pixel, sd_px, landmarks.camera, k)


def _check_times(what: str, time_s: Array) -> None:
    back = np.flatnonzero(~(np.diff(time_s) > 0))
    if back.size:
        k = int(back[0]) + 1
        raise InputError(f"{what} {k} has time {time_s[k]} s after {time_s[k - 1]} s, expected increasing times")


@observations.register
def _(recording: BodyRecording, evidence: Sightings | Senses | None = None) -> Iterator[Observation]:
    senses = _given(evidence, recording, Senses)
    worn = [_worn(imu, sd_rad) for imu, sd_rad in zip(recording.imus, recording.imu_sds_rad, strict=True)]
    return heapq.merge(*worn, ahead(_timed(_pictures(recording, senses), senses)), key=TIME)


def _worn(imu: Imu, sd_rad: float) -> Iterator[Observation]:
    """How the segment is turned that wears it."""
    _check_times("IMU sample", imu.time_s)
    roll_sd = ROLL_SD if "upper" in imu.segment else float("inf")
    for k, (time_s, q) in enumerate(zip(imu.time_s.tolist(), imu.q_world_segment.tolist(), strict=True)):
        yield Observation.orientation(time_s, imu.segment, q, sd_rad, roll_sd, k)


def _pictures(recording: BodyRecording, senses: Senses) -> Iterator[Observation]:
    """Frame by frame what the video shows, or what a detector found in one that is not there."""
    view = recording.view
    if view.video is not None:
        for frame in frames(view.video):
            yield Observation.picture(frame.time_s + view.start_s, senses(frame), frame.index)
        return
    assert view.keypoints is not None
    for k in range(int(view.keypoints.frames[-1]) + 1):
        yield Observation.picture(view.start_s + k / view.rate_hz, senses.without_picture(k), k)


def _timed(source: Iterator[Observation], senses: Senses) -> Iterator[Observation]:
    """The same; how long it took is added up."""
    while True:
        began = time.perf_counter()
        found = next(source, None)
        senses.run_s += time.perf_counter() - began
        if found is None:
            return
        yield found
