"""How a forearm's IMU is worn and set up: clock, heading and the axis along the forearm, found from a whole recording.

Coarse first: lags from `pytracker.evidence.patch.lag`, headings by what the camera should then have seen, each of six
axes of the sensor along the forearm. Then each is weighed by how well a filter that is held by the arm's length
explains the patch, and the best are moved in small steps to where they explain it best.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pytracker._core import InputError, TrackingError
from pytracker.doubting.swivel import HANGS, HANGS_SD, hangs
from pytracker.evidence.patch.lag import GRID_S, Lag, banded, find_lags, was_seen
from pytracker.evidence.sightings import Sightings
from pytracker.inertial.gravity import GRAVITY
from pytracker.methods.arm import Ekf
from pytracker.recording.recording import Arm, ArmRecording, Imu
from pytracker.rotation import (
    Array,
    conjugate,
    multiply,
    rotate,
    rotation_vector_to_quaternion,
    triple,
)
from pytracker.tracking.arm import ArmTrack, filter_arm

__all__ = [
    "CLEAR",
    "GIVEN_STAYS",
    "KIND",
    "MOST_FRAMES",
    "Worn",
    "find_worn",
    "is_same",
    "lags_of",
    "mount_of",
    "put_on",
    "weighed",
]

HELD = Ekf(
    corrections=("colour", "arm_length"), bias=True, accel_density=0.2, arm_length_sd_m=0.03, position_start_sd_m=0.05
)
"""Fast, and its log evidence is that of the arm's length too, which tells headings and axes apart."""
HEADINGS = np.radians(np.arange(0.0, 360.0, 5.0))
AXES = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
LEAST_EVIDENCE = -30.0
"""A frame counts no worse."""
BESIDE_S = 1.0
"""No sample that is earlier or later than all frames by more tells anything of them."""
COASTS_S = 0.25
"""So long after the last sample the filter coasts: such frames count as those that have samples."""
HEADINGS_A_LAG = 2
FINALISTS_AN_AXIS = 2
FINALISTS = 6
STEPS = (0.06, np.radians(8.0), np.radians(10.0), np.radians(10.0))
"""First steps of clock, heading, and the axis about two others;"""
LEVELS = ((0,), (1,), (2, 3))
"""they are halved so often, and between these rounds what is hopeless is left out."""
HOPELESS = 60.0
"""What explains by so much log evidence less than the best is not made up for by smaller steps."""
ALONG_DEG = 6.0
"""An IMU is strapped on with one of its axes along the forearm, give or take so much."""
MOST_FRAMES = 750
"""More frames say no more than these, and take longer."""
CLEAR = 25.0
"""Log evidence by which the best must be better than any of another kind: lengths that are 8 % off and a shoulder that
moves make a hand behind the back explain a reaching one better than the truth, by up to 20."""
GIVEN_STAYS = 15.0
"""Log evidence by which it must be better than what is given."""
SAME = (0.08, np.radians(12.0), np.radians(20.0))
"""Clocks, headings and axes that are nearer are the same;"""
KIND = (0.2, np.radians(30.0), np.radians(45.0))
"""those that are nearer than this are of one kind: clock and heading lean on each other, and one of them is written."""
ALIKE = 4.0
"""What a strap and skin do to so many frames is alike: the evidence counts it so many times, and so does the elbow."""


@dataclass(frozen=True)
class Worn:
    """A way to wear the IMU.

    Attributes:
        offset_s: recording time = IMU time + offset.
        heading_rad: turn about the vertical from the sensor's earth frame to the world.
        axis: of the sensor, unit length `(3,)`: from wrist to elbow.
        log_evidence: of the patch, with it.
        depth: at which of the places where the ray meets the elbow's sphere the wrist then starts, 0 or 1; None: at
            either.
    """

    offset_s: float
    heading_rad: float
    axis: Array
    log_evidence: float = -np.inf
    depth: int | None = None


def mount_of(axis: Array) -> Array:
    """`q_segment_sensor` `(4,)` that takes `axis` to the forearm's +y, turning no more than it must."""
    y = np.array([0.0, 1.0, 0.0])
    across = np.cross(axis, y)
    sine, cosine = float(np.linalg.norm(across)), float(axis @ y)
    if sine < 1e-9:
        return np.array([1.0, 0.0, 0.0, 0.0]) if cosine > 0 else np.array([0.0, 1.0, 0.0, 0.0])
    return rotation_vector_to_quaternion(across / sine * np.arctan2(sine, cosine))


def put_on(recording: ArmRecording, worn: Worn, sightings: Sightings) -> Iterator[ArmRecording]:
    """`recording`, its IMU as the file has it, with the IMU worn so; once for every place the wrist may start at."""
    raw, mount = _within(recording.imus[0], sightings.time_s - worn.offset_s), mount_of(worn.axis)
    heading = rotation_vector_to_quaternion(np.array([0.0, 0.0, worn.heading_rad]))
    imu = Imu(
        time_s=raw.time_s + worn.offset_s,
        acc=rotate(mount, raw.acc),
        q_world_segment=np.ascontiguousarray(multiply(multiply(heading, raw.q_world_segment), conjugate(mount))),
        gyr=None if raw.gyr is None else rotate(mount, raw.gyr),
        segment=raw.segment,
    )
    for start in _starts(recording, imu, sightings):
        arm: Arm = replace(recording.arm, wrist_start_m=triple(start))
        yield replace(recording, imus=(imu,), arm=arm)


def _within(imu: Imu, frame_s: Array) -> Imu:
    """The samples that frames at IMU times `(T,)`, s, are tracked by: of an hour's recording few."""
    first, last = np.searchsorted(imu.time_s, [frame_s[0] - BESIDE_S, frame_s[-1] + BESIDE_S])
    if last - first < 2:
        return imu  # the filter says what is wrong
    some = slice(first, last)
    gyr = None if imu.gyr is None else imu.gyr[some]
    return replace(imu, time_s=imu.time_s[some], acc=imu.acc[some], q_world_segment=imu.q_world_segment[some], gyr=gyr)


def lags_of(recording: ArmRecording, sightings: Sightings) -> tuple[Lag, ...]:
    """The ways to lay patch and IMU over each other, best first."""
    raw = recording.imus[0]
    return find_lags(sightings.time_s, sightings.pixels[:, 0], raw.time_s, _acceleration(raw))


def find_worn(
    recording: ArmRecording,
    sightings: Sightings,
    lags: Iterable[Lag],
    axes: Sequence[Array] = AXES,
    *,
    least: float = -np.inf,
) -> tuple[Worn, ...]:
    """The ways, with one of `axes` along the forearm, that explain the recording best, each different from the others.

    Best first; empty where none does. Ways of less than `least` log evidence are not followed to their end.
    """
    sightings = sightings.first(MOST_FRAMES)
    hypotheses = [(lag.offset_s, heading) for lag in lags for heading in _headings(recording, sightings, lag)]
    best: list[Worn] = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:  # the filter lets the interpreter go
        for axis in axes:
            # The best of each axis: which of them it is shows only when they have been moved to where they fit.
            ways = [Worn(offset_s, heading, axis) for offset_s, heading in hypotheses]
            best += _best(pool.map(partial(weighed, recording, sightings), ways), FINALISTS_AN_AXIS)
        # An axis that is given is not moved.
        fixed = (2, 3) if len(axes) == 1 else ()
        for levels in LEVELS:
            best = list(pool.map(partial(_refined, recording, sightings, fixed=fixed, levels=levels), best))
            most = max((least, *(one.log_evidence for one in best)))
            best = [one for one in best if one.log_evidence > most - HOPELESS]
        # Steps were taken from the depth at which each began.
        best = list(pool.map(partial(weighed, recording, sightings), [replace(one, depth=None) for one in best]))
        return tuple(_best(best, FINALISTS))


def _acceleration(imu: Imu) -> Array:
    """In the sensor's earth frame, m/s², without gravity `(M, 3)`."""
    return np.asarray(rotate(imu.q_world_segment, imu.acc) - np.array([0.0, 0.0, GRAVITY]))


def _headings(recording: ArmRecording, sightings: Sightings, lag: Lag) -> list[float]:
    """Headings with which the IMU's movement is best what the camera saw, at that lag."""
    raw = recording.imus[0]
    camera_start, seen = banded(sightings.time_s, sightings.pixels[:, 0])
    imu_start, moved = banded(raw.time_s + lag.offset_s, _acceleration(raw), integrations=2)
    skip = round((camera_start - imu_start) / GRID_S)
    a, b = max(0, -skip), max(0, skip)
    count = min(len(seen) - a, len(moved) - b)
    is_seen = was_seen(sightings.time_s, sightings.pixels[:, 0])[a : a + count] > 0
    seen, moved = seen[a : a + count][is_seen], moved[b : b + count][is_seen]
    slope = _slope(recording, np.nanmean(sightings.pixels[:, 0], axis=0))
    left = np.array([float(((seen - moved @ (slope @ _about_z(h)).T) ** 2).sum()) for h in HEADINGS])
    lowest = (left <= np.roll(left, 1)) & (left <= np.roll(left, -1))
    return [float(HEADINGS[k]) for k in np.argsort(np.where(lowest, left, np.inf))[:HEADINGS_A_LAG] if lowest[k]]


def _about_z(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _slope(recording: ArmRecording, pixel: Array) -> Array:
    """How a pixel moves with the patch, `(2, 3)` px/m, where its ray is nearest to the shoulder."""
    camera = recording.views[0].camera
    ray, origin = camera.ray(pixel), np.asarray(camera.position_m)
    at = origin + ray * float(ray @ (np.array(recording.arm.shoulder_m) - origin))
    step = 1e-3
    moved = camera.project(np.concatenate([at + step * np.eye(3), at - step * np.eye(3)]))
    return np.asarray((moved[:3] - moved[3:]).T / (2 * step))


def _starts(recording: ArmRecording, imu: Imu, sightings: Sightings) -> list[Array]:
    """Where the first patch that the IMU was there for may be: its ray meets the elbow's sphere at two depths."""
    seen = np.isfinite(sightings.pixels[:, 0]).all(axis=1)
    frame = int(np.argmax(seen & (sightings.time_s >= imu.time_s[0])))
    at = int(np.clip(np.searchsorted(imu.time_s, sightings.time_s[frame]), 0, len(imu.time_s) - 1))
    arm, camera = recording.arm, recording.views[0].camera
    centre = np.array(arm.shoulder_m) - rotate(imu.q_world_segment[at], np.array([0.0, arm.forearm_m, 0.0]))
    ray, origin = camera.ray(sightings.pixels[frame, 0]), np.asarray(camera.position_m)
    nearest = float(ray @ (centre - origin))
    miss = float(np.linalg.norm(origin + nearest * ray - centre))
    half = np.sqrt(max(0.0, arm.upper_arm_m**2 - miss**2))
    return [origin + (nearest + by) * ray for by in ((half, -half) if half > 0.05 else (0.0,))]


def weighed(recording: ArmRecording, sightings: Sightings, worn: Worn) -> Worn:
    """With its log evidence, of the better of its starts, and of how likely an arm is held, and one wears it, so."""
    sightings = sightings.first(MOST_FRAMES)
    seen = np.isfinite(sightings.pixels[:, 0]).all(axis=1)
    first_s, last_s = recording.imus[0].time_s[[0, -1]] + worn.offset_s + np.array([0.0, COASTS_S])
    is_there = seen & (sightings.time_s >= first_s) & (sightings.time_s <= last_s)
    # So many frames have no samples by any clock: they tell no way from another. Others are held against this one.
    beyond = int(seen.sum()) - _most_within(sightings.time_s[seen], last_s - first_s)
    found: dict[int, float] = {}
    ways = list(put_on(recording, worn, sightings))
    for depth in range(len(ways)) if worn.depth is None else (min(worn.depth, len(ways) - 1),):
        track = _held(ways[depth], sightings)
        if track is None:
            continue
        evidence = np.maximum(np.nan_to_num(track.log_evidence, nan=LEAST_EVIDENCE), LEAST_EVIDENCE)
        usual = float(np.median(evidence[is_there])) if is_there.any() else LEAST_EVIDENCE
        outside = np.sort(evidence[seen & ~is_there])
        outside[:beyond] = usual
        whole = float(evidence[is_there].sum() + outside.sum())
        found[depth] = whole - 0.5 * ALIKE * (min(0.0, hangs(track) - HANGS) / HANGS_SD) ** 2
    aslant = np.degrees(np.arccos(min(1.0, float(np.abs(worn.axis).max()))))
    best = max(found, key=found.__getitem__, default=None)
    most = -np.inf if best is None else found[best] - 0.5 * (aslant / ALONG_DEG) ** 2
    return replace(worn, log_evidence=most, depth=best)


def _most_within(time_s: Array, span_s: float) -> int:
    """How many of times `(T,)`, increasing, some stretch so long has at the most."""
    return int((np.searchsorted(time_s, time_s + span_s, side="right") - np.arange(len(time_s))).max(initial=0))


def _held(recording: ArmRecording, sightings: Sightings) -> ArmTrack | None:
    """The track, or what there is of it where the filter was lost."""
    try:
        return filter_arm(recording, HELD, sightings=sightings)
    except (InputError, TrackingError):
        return None


def _best(worn: Iterable[Worn], most: int) -> list[Worn]:
    """The best, none like a better one."""
    kept: list[Worn] = []
    for one in sorted(worn, key=lambda one: -one.log_evidence):
        if len(kept) < most and np.isfinite(one.log_evidence) and not any(is_same(one, other) for other in kept):
            kept.append(one)
    return kept


def is_same(one: Worn, other: Worn, within: tuple[float, float, float] = SAME) -> bool:
    """Whether clock, heading and axis of two ways are nearer than `within`, s and rad."""
    turn = np.abs((one.heading_rad - other.heading_rad + np.pi) % (2 * np.pi) - np.pi)
    apart = (abs(one.offset_s - other.offset_s), turn, float(np.arccos(np.clip(one.axis @ other.axis, -1.0, 1.0))))
    return all(distance < limit for distance, limit in zip(apart, within, strict=True))


def _refined(
    recording: ArmRecording, sightings: Sightings, worn: Worn, *, fixed: Collection[int], levels: Collection[int]
) -> Worn:
    """Moved to where it explains most: by steps of clock, heading and axis, but `fixed` ones, halved so often."""
    best = worn
    known = {_place(best): best}
    for level in levels:
        steps = np.array(STEPS) / 2**level
        gains = True
        while gains:
            gains = False
            for which in sorted({*range(len(steps))} - {*fixed}):
                for sign in (1.0, -1.0):
                    step = _stepped(best, which, sign * steps[which])
                    # Back to where it came from, and whatever was tried since the last gain, is known.
                    tried = known.get(_place(step)) or weighed(recording, sightings, step)
                    known[_place(step)] = tried
                    if tried.log_evidence > best.log_evidence + 0.5:
                        best, gains = tried, True
                        break
    return best


def _place(worn: Worn) -> tuple[float, ...]:
    """The same for ways that are the same but for rounding."""
    return tuple(round(float(x), 7) for x in (worn.offset_s, worn.heading_rad, *worn.axis))


def _stepped(worn: Worn, which: int, by: float) -> Worn:
    if which == 0:
        return replace(worn, offset_s=worn.offset_s + by)
    if which == 1:
        return replace(worn, heading_rad=(worn.heading_rad + by) % (2 * np.pi))
    back = conjugate(mount_of(worn.axis))
    about = np.array([1.0, 0.0, 0.0]) if which == 2 else np.array([0.0, 0.0, 1.0])
    turned = rotate(rotation_vector_to_quaternion(by * about), np.array([0.0, 1.0, 0.0]))
    return replace(worn, axis=rotate(back, turned))
