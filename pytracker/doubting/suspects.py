"""What may be wrong with the description of an arm's recording: each suspect as a change that would put it right.

A heading, a clock, a camera or a length that is off gives a track that is off, as sure of itself as any other. But
the data fit worse: a recording that is described rightly is explained better. Each suspect is tried in a few
strengths.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from pytracker.evidence.sightings import Sightings
from pytracker.recording.camera import Camera
from pytracker.recording.recording import Arm, ArmRecording, Imu
from pytracker.rotation import Array, multiply, rotate, rotation_vector_to_quaternion, triple

__all__ = ["AFTER_PAUSE", "HEADING", "MIRRORED", "MOUNT", "Suspect", "suspects"]

HEADINGS_DEG = (-170.0, -90.0, -40.0, -20.0, -10.0, 10.0, 20.0, 40.0, 90.0)
OFFSETS_S = (-0.8, -0.4, -0.2, -0.1, 0.1, 0.2, 0.4, 0.8)
MOUNTS_DEG = (-90.0, -30.0, -12.0, 12.0, 30.0, 90.0)
TILTS_DEG = (-12.0, -5.0, 5.0, 12.0)
LENGTHS = (0.8, 0.9, 1.1, 1.2)
SHOULDER_M = (-0.2, -0.1, 0.1, 0.2)
FOCALS = (0.7, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.3)
TURNS_DEG = (-10.0, -4.0, -1.5, 1.5, 4.0, 10.0)
HEADING = "heading_deg"
MOUNT = "mount"
MIRRORED = "the video's left and right"
AFTER_PAUSE = "the heading from its sensor's pause on"
PAUSE_S, MOST_PAUSES = 1.0, 2
"""Who says nothing for so long may have been started anew; of many pauses the longest are asked."""
DISTANCES_M = (-0.4, -0.2, 0.2, 0.4)
ALONG_M = (-0.12, -0.06, 0.06, 0.12)


@dataclass(frozen=True)
class Suspect:
    """A change of the description.

    Attributes:
        kind: what is suspected, in words.
        words: what would put it right.
        change: the recording as it would then be.
        see: what is seen as it would then be.
    """

    kind: str
    words: str
    change: Callable[[ArmRecording], ArmRecording] = lambda recording: recording
    see: Callable[[ArmRecording, Sightings], Sightings] = lambda _, sightings: sightings


def suspects(recording: ArmRecording) -> Iterator[Suspect]:
    """All of them, in all strengths, that there are of such a recording."""
    yield from _of_imu()
    yield from _of_pauses(recording.imus[0].time_s)
    yield from _of_arm()
    yield from _of_camera()
    for camera, seconds in itertools.product(range(1, len(recording.views)), OFFSETS_S):
        words = f"start_s of camera {camera} changed by {seconds:+g} s"
        yield Suspect(f"camera {camera}'s start_s", words, see=_seen_later(camera, seconds))


def _of_imu() -> Iterator[Suspect]:
    for degrees in HEADINGS_DEG:
        yield Suspect(HEADING, f"heading_deg turned by {degrees:+g}°", _turned_world([0.0, 0.0, degrees]))
    for seconds in OFFSETS_S:
        yield Suspect("offset_s", f"offset_s changed by {seconds:+g} s", _imu(_later(seconds)))
    for (axis, name), degrees in itertools.product(enumerate("xyz"), MOUNTS_DEG):
        words = f"mount turned by {degrees:+g}° about the sensor's {name}"
        yield Suspect(MOUNT, words, _imu(_mounted(degrees * np.eye(3)[axis])))
    for (axis, name), degrees in itertools.product(enumerate("xy"), TILTS_DEG):
        words = f"the orientation tilted by {degrees:+g}° about {name}"
        yield Suspect("orientation", words, _turned_world(degrees * np.eye(3)[axis]))


def _of_pauses(imu_s: Array) -> Iterator[Suspect]:
    lasted = np.diff(imu_s)
    longest = np.argsort(-lasted, kind="stable")[:MOST_PAUSES]
    for at, degrees in itertools.product(longest[lasted[longest] > PAUSE_S], HEADINGS_DEG):
        words = f"heading_deg turned by {degrees:+g}° from {imu_s[at + 1]:.1f} s on, where its sensor had paused"
        yield Suspect(AFTER_PAUSE, words, _turned_world([0.0, 0.0, degrees], from_s=float(imu_s[at + 1])))


def _of_arm() -> Iterator[Suspect]:
    for name, factor in itertools.product(("upper_arm_m", "forearm_m"), LENGTHS):
        yield Suspect(name, f"{name} times {factor:g}", _arm(_longer(name, factor)))
    for (axis, name), metres in itertools.product(enumerate("xyz"), SHOULDER_M):
        words = f"shoulder_m moved by {100 * metres:+g} cm along {name}"
        yield Suspect("shoulder_m", words, _arm(_moved_shoulder(metres * np.eye(3)[axis])))


def _of_camera() -> Iterator[Suspect]:
    for factor in FOCALS:
        yield Suspect("focal length", f"the focal length times {factor:g}", _cameras(_focal(factor)))
    for (axis, name), degrees in itertools.product(enumerate(("pitch", "pan", "roll")), TURNS_DEG):
        words = f"the camera turned by {degrees:+g}° ({name})"
        yield Suspect(f"camera's {name}", words, _cameras(_turned(degrees * np.eye(3)[axis])))
    for metres in DISTANCES_M:
        words = f"the camera {abs(100 * metres):g} cm {'farther' if metres > 0 else 'nearer'}"
        yield Suspect("camera's distance", words, _cameras(_farther(metres)))
    for metres in ALONG_M:
        words = f"the patch {abs(100 * metres):g} cm nearer the {'elbow' if metres > 0 else 'hand'}"
        yield Suspect("patch_offset_m", words, _cameras(_along(metres)))
    yield Suspect(MIRRORED, "the picture mirrored, as phones film who films themselves", see=_mirrored)


def _imu(change: Callable[[Imu], Imu]) -> Callable[[ArmRecording], ArmRecording]:
    return lambda recording: dataclasses.replace(recording, imus=(change(recording.imus[0]),))


def _arm(change: Callable[[Arm], Arm]) -> Callable[[ArmRecording], ArmRecording]:
    return lambda recording: dataclasses.replace(recording, arm=change(recording.arm))


def _cameras(change: Callable[[Camera], Camera]) -> Callable[[ArmRecording], ArmRecording]:
    def apply(recording: ArmRecording) -> ArmRecording:
        views = tuple(dataclasses.replace(view, camera=change(view.camera)) for view in recording.views)
        return dataclasses.replace(recording, views=views)

    return apply


def _quaternion(degrees: Array | list[float]) -> Array:
    return rotation_vector_to_quaternion(np.radians(np.asarray(degrees, dtype=float)))


def _seen_later(camera: int, seconds: float) -> Callable[[ArmRecording, Sightings], Sightings]:
    """What one of several cameras saw, at its frames, so much later."""

    def see(_: ArmRecording, sightings: Sightings) -> Sightings:
        pixels = sightings.pixels.copy()
        seen = np.flatnonzero(np.isfinite(pixels[:, camera]).all(axis=1))
        time_s = sightings.time_s[seen]
        for axis in range(2 if len(seen) else 0):
            way = pixels[seen, camera, axis]
            pixels[seen, camera, axis] = np.interp(time_s - seconds, time_s, way, left=np.nan, right=np.nan)
        return dataclasses.replace(sightings, pixels=pixels)

    return see


def _turned_world(degrees: Array | list[float], from_s: float = -np.inf) -> Callable[[ArmRecording], ArmRecording]:
    """The sensor's idea of the world, from a time on."""
    turn = _quaternion(degrees)

    def apply(imu: Imu) -> Imu:
        q = imu.q_world_segment.copy()
        turned = imu.time_s >= from_s
        q[turned] = multiply(np.broadcast_to(turn, (int(turned.sum()), 4)), q[turned])
        return dataclasses.replace(imu, q_world_segment=q)

    return _imu(apply)


def _later(seconds: float) -> Callable[[Imu], Imu]:
    return lambda imu: dataclasses.replace(imu, time_s=imu.time_s + seconds)


def _mounted(degrees: Array) -> Callable[[Imu], Imu]:
    """The segment's frame turned in the sensor: readings turn with it, what they say of the world stays."""
    turn = _quaternion(degrees)
    back = turn * np.array([1.0, -1.0, -1.0, -1.0])

    def apply(imu: Imu) -> Imu:
        q = multiply(imu.q_world_segment, np.broadcast_to(turn, (len(imu.acc), 4)))
        gyr = None if imu.gyr is None else rotate(back, imu.gyr)
        return dataclasses.replace(imu, acc=rotate(back, imu.acc), gyr=gyr, q_world_segment=np.ascontiguousarray(q))

    return apply


def _longer(name: str, factor: float) -> Callable[[Arm], Arm]:
    return lambda arm: dataclasses.replace(arm, **{name: min(1.0, factor * getattr(arm, name))})


def _moved_shoulder(by: Array) -> Callable[[Arm], Arm]:
    return lambda arm: dataclasses.replace(arm, shoulder_m=triple(np.asarray(arm.shoulder_m) + by))


def _focal(factor: float) -> Callable[[Camera], Camera]:
    def apply(camera: Camera) -> Camera:
        (fx, skew, cx), (_, fy, cy), last = camera.matrix
        return dataclasses.replace(camera, matrix=((factor * fx, factor * skew, cx), (0.0, factor * fy, cy), last))

    return apply


def _turned(degrees: Array) -> Callable[[Camera], Camera]:
    """About the camera's own axes, where it stands."""

    def apply(camera: Camera) -> Camera:
        turn = np.stack([rotate(_quaternion(degrees), axis) for axis in np.eye(3)], axis=1)
        rotation = turn @ np.array(camera.rotation)
        translation = turn @ np.array(camera.translation_m)
        rows = (triple(rotation[0]), triple(rotation[1]), triple(rotation[2]))
        return dataclasses.replace(camera, rotation=rows, translation_m=triple(translation))

    return apply


def _farther(metres: float) -> Callable[[Camera], Camera]:
    def apply(camera: Camera) -> Camera:
        x, y, z = camera.translation_m
        return dataclasses.replace(camera, translation_m=(x, y, z + metres))

    return apply


def _along(metres: float) -> Callable[[Camera], Camera]:
    """The patch so much nearer the elbow."""

    def apply(camera: Camera) -> Camera:
        x, y, z = camera.patch_offset_m
        return dataclasses.replace(camera, patch_offset_m=(x, y + metres, z))

    return apply


def _mirrored(recording: ArmRecording, sightings: Sightings) -> Sightings:
    """Left for right, about the principal point, which is about the middle."""
    pixels = sightings.pixels * [-1.0, 1.0] + [2.0 * recording.views[0].camera.matrix[0][2], 0.0]
    return dataclasses.replace(sightings, pixels=np.ascontiguousarray(pixels))
