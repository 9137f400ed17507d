"""Simulated arm recordings: what a subject at a table does, and what IMU and cameras say of it.

The wrist follows a pattern on the table; the elbow swings towards a fixed direction; the sensor sits on the
forearm with +y from wrist to elbow. The world is x right, y away from the subject, z up, table at z = 0.
"""

from __future__ import annotations

import dataclasses
from functools import cached_property

import numpy as np

from pytracker._core import InputError
from pytracker.evidence.sightings import Landmarks
from pytracker.inertial.gravity import GRAVITY
from pytracker.recording.camera import Camera
from pytracker.recording.recording import Arm, ArmRecording, Imu, Truth, View
from pytracker.rotation import (
    Array,
    Triple,
    axes_to_quaternion,
    conjugate,
    multiply,
    rotate,
    rotation_vector_to_quaternion,
    triple,
)
from pytracker.simulate.arm_scene import ArmScene
from pytracker.simulate.arm_senses import beside, upper_arm_imu
from pytracker.simulate.patterns import PATTERNS
from pytracker.simulate.worn import RATE_HZ, Worn

__all__ = ["IMAGE_SIZE", "TRUTH_RATE_HZ", "ArmSimulation"]

REST = np.array([0.0, 0.0, GRAVITY])
"""What a sensor at rest feels, m/s²."""
IMAGE_SIZE = (640, 480)
FOCAL_PX = 700.0
CAMERA_DISTANCE_M = 2.0
CAMERA_ELEVATION_DEG = 30.0
TRUTH_RATE_HZ = 100.0
DIFFERENCE_S = 2e-3
STRETCHED = 0.97
"""An arm is never quite straight."""


class ArmSimulation:
    """A scene played once, with the noise of one seed; every property is drawn from a stream of its own."""

    def __init__(self, scene: ArmScene | None = None, seed: int = 0) -> None:
        self.scene = scene or ArmScene()
        self.seed = seed
        reach = np.linalg.norm(self.wrist(self.frame_time_s) - self.shoulder(self.frame_time_s), axis=1)
        longest = self.scene.upper_arm_m + self.scene.forearm_m
        if reach.max() >= longest:
            raise InputError(
                f"the pattern is {reach.max():.3f} m from the shoulder, expected less than {longest:.3f} m"
            )

    def _rng(self, what: str) -> np.random.Generator:
        return np.random.default_rng([self.seed, *what.encode()])

    @cached_property
    def _worn(self) -> Worn | None:
        return Worn(self.scene.duration_s, self._rng("worn")) if self.scene.worn else None

    def wrist(self, time_s: Array) -> Array:
        """Wrist joint at `time_s`, world, m `(T, 3)`."""
        s = self.scene
        return np.asarray(s.centre_m) + s.radius_m * PATTERNS[s.pattern](time_s, s.period_s)

    def shoulder(self, time_s: Array) -> Array:
        """Shoulder joint at `time_s`, world, m `(T, 3)`."""
        shoulder = np.asarray(self.scene.shoulder_m) + self.scene.shoulder_motion_m * _slow(
            time_s, self._rng("shoulder")
        )
        if self._worn is None:
            return shoulder
        wrist = self.wrist(time_s)
        shoulder = shoulder + self._worn.shoulder(time_s, wrist - np.asarray(self.scene.centre_m))
        # Who does not reach that far leans forward.
        between = wrist - shoulder
        distance = np.linalg.norm(between, axis=1, keepdims=True)
        reach = STRETCHED * (self.scene.upper_arm_m + self.scene.forearm_m)
        return np.asarray(shoulder + between * np.maximum(0.0, 1.0 - reach / distance))

    def elbow(self, time_s: Array) -> Array:
        """Elbow joint: where the two arm spheres meet, swung towards `elbow_swing`, world, m `(T, 3)`."""
        s = self.scene
        shoulder, wrist = self.shoulder(time_s), self.wrist(time_s)
        between = wrist - shoulder
        distance = np.linalg.norm(between, axis=1, keepdims=True)
        along = between / distance
        to_centre = (s.upper_arm_m**2 - s.forearm_m**2 + distance**2) / (2 * distance)
        radius = np.sqrt(np.maximum(s.upper_arm_m**2 - to_centre**2, 0.0))
        swing = np.asarray(s.elbow_swing) - along * (along @ np.asarray(s.elbow_swing))[:, None]
        swing /= np.linalg.norm(swing, axis=1, keepdims=True)
        return np.asarray(shoulder + along * to_centre + swing * radius)

    def q_world_sensor(self, time_s: Array) -> Array:
        """True orientation of the sensor, `(T, 4)`: the forearm's, unless it is worn."""
        q = self.q_world_forearm(time_s)
        return q if self._worn is None else multiply(q, self._worn.mount(time_s, self._turn_rate(time_s)))

    def _turn_rate(self, time_s: Array) -> Array:
        """How fast the forearm turns `(T,)`, rad/s."""
        h = DIFFERENCE_S
        turned = multiply(conjugate(self.q_world_forearm(time_s - h)), self.q_world_forearm(time_s + h))
        return np.asarray(np.linalg.norm(turned[:, 1:], axis=1) / h)

    def q_world_forearm(self, time_s: Array) -> Array:
        """True orientation of the forearm: +y from wrist to elbow, +z as far up as that allows, `(T, 4)`."""
        y = (self.elbow(time_s) - self.wrist(time_s)) / self.scene.forearm_m
        z = np.array([0.0, 0.0, 1.0]) - y * y[:, 2:]
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        return axes_to_quaternion(np.cross(y, z), y, z)

    @cached_property
    def frame_time_s(self) -> Array:
        """Times of the frames that were not dropped, `(T,)`."""
        s = self.scene
        time_s = np.arange(round(s.duration_s * s.frame_rate_hz)) / s.frame_rate_hz
        return _keep(time_s, s.dropped_frames, self._rng("dropped frames"))

    @cached_property
    def arm(self) -> Arm:
        """The arm as it was measured, starting where the pattern starts."""
        s = self.scene
        upper_arm, forearm = (1.0, 1.0) if self._worn is None else self._worn.lengths
        start = self.wrist(np.zeros(1))[0]
        return Arm(
            shoulder_m=s.shoulder_m,
            upper_arm_m=s.upper_arm_m * float(upper_arm),
            forearm_m=s.forearm_m * float(forearm),
            wrist_start_m=triple(start),
        )

    @cached_property
    def cameras(self) -> tuple[Camera, ...]:
        """As they were calibrated. The first faces the subject; each further one stands a quarter turn on."""
        return tuple(
            look_at(self.scene.centre_m, 90.0 * k, CAMERA_ELEVATION_DEG, CAMERA_DISTANCE_M, self.scene.patch_offset_m)
            for k in range(self.scene.cameras)
        )

    @cached_property
    def true_cameras(self) -> tuple[Camera, ...]:
        """As they were: turned about what was filmed, of another focal length, where it is worn."""
        return self.cameras if self._worn is None else tuple(self._uncalibrated(camera) for camera in self.cameras)

    def _uncalibrated(self, camera: Camera) -> Camera:
        assert self._worn is not None
        centre = np.asarray(self.scene.centre_m)
        q = rotation_vector_to_quaternion(self._worn.camera_turn)
        rotation = np.array(camera.rotation) @ np.stack([rotate(q, axis) for axis in np.eye(3)], axis=1)
        translation = np.array(camera.rotation) @ centre + np.array(camera.translation_m) - rotation @ centre
        (fx, skew, cx), (_, fy, cy), last = camera.matrix
        return dataclasses.replace(
            camera,
            matrix=((fx * self._worn.focal, skew, cx), (0.0, fy * self._worn.focal, cy), last),
            rotation=(triple(rotation[0]), triple(rotation[1]), triple(rotation[2])),
            translation_m=triple(translation),
        )

    @cached_property
    def imu(self) -> Imu:
        """What the IMU says, with its noise, bias and orientation error."""
        s = self.scene
        rate_hz = s.imu_rate_hz if self._worn is None else RATE_HZ
        time_s = np.arange(round(s.duration_s * rate_hz) + 1) / rate_hz
        time_s = _keep(time_s, s.dropped_imu, self._rng("dropped imu"))
        q = self.q_world_sensor(time_s)
        h = DIFFERENCE_S
        acceleration = (self.wrist(time_s + h) - 2 * self.wrist(time_s) + self.wrist(time_s - h)) / h**2
        turned = multiply(conjugate(self.q_world_sensor(time_s - h)), self.q_world_sensor(time_s + h))
        rate = turned[:, 1:] * np.sign(turned[:, :1]) / h
        rng = self._rng("imu")
        size = (len(time_s), 3)
        acc = rotate(conjugate(q), acceleration + REST)
        acc += s.acc_bias * _direction(rng) + s.acc_noise * rng.standard_normal(size)
        gyr = rate + s.gyr_bias * _direction(rng) + s.gyr_noise * rng.standard_normal(size)
        half = np.deg2rad(s.orientation_error_deg) / np.sqrt(2)
        error = half * (_direction(rng) + _slow(time_s, rng))
        if self._worn is None:
            return Imu(
                time_s=time_s, acc=acc, q_world_segment=multiply(rotation_vector_to_quaternion(error), q), gyr=gyr
            )
        acc += self._worn.acceleration(time_s, acceleration)
        measured = multiply(self._worn.tilt(time_s, self._turn_rate(time_s)), q)
        return Imu(time_s=self._worn.clock(time_s), acc=acc, q_world_segment=measured, gyr=gyr)

    def patch(self, time_s: Array) -> Array:
        """Centre of the patch, world, m `(T, 3)`."""
        offset = np.broadcast_to(np.asarray(self.scene.patch_offset_m, dtype=float), (len(time_s), 3))
        return self.wrist(time_s) + rotate(self.q_world_sensor(time_s), offset)

    def sightings(self, pixel_sd: float = 4.0) -> Array:
        """Patch centres with Gaussian noise, no video between: `(T, C, 2)` px, NaN where occluded."""
        patch = self.patch(self.frame_time_s)
        pixels = np.stack([camera.project(patch) for camera in self.true_cameras], axis=1)
        pixels += pixel_sd * self._rng("pixels").standard_normal(pixels.shape)
        pixels[self.is_occluded(self.frame_time_s)] = np.nan
        return pixels

    def landmark(self, joint: str, time_s: Array) -> Array:
        """Centre of the patch on `shoulder` or `elbow`, world, m `(T, 3)`."""
        at = self.shoulder(time_s) if joint == "shoulder" else self.elbow(time_s)
        off = beside(self._rng(f"patch on {joint}"))
        return at + rotate(self.q_of_landmark(joint, time_s), np.broadcast_to(off, (len(time_s), 3)))

    def q_of_landmark(self, joint: str, time_s: Array) -> Array:
        """How that patch is turned, to the world `(T, 4)`: with the trunk, which is still, or with the forearm."""
        still = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), (len(time_s), 4))
        return still if joint == "shoulder" else self.q_world_forearm(time_s)

    def landmarks(self, pixel_sd: float = 4.0) -> tuple[Landmarks, ...]:
        """Where the cameras see the patches besides the wrist's, with Gaussian noise, no video between."""
        time_s, found = self.frame_time_s, []
        for joint in self.joints_seen:
            for number, camera in enumerate(self.true_cameras):
                noise = self._rng(f"pixels of {joint} {number}").standard_normal((len(time_s), 2))
                pixels = camera.project(self.landmark(joint, time_s)) + pixel_sd * noise
                found.append(Landmarks(joint, number, pixels, np.full(len(time_s), pixel_sd)))
        return tuple(found)

    @property
    def joints_seen(self) -> tuple[str, ...]:
        """Joints with a patch."""
        return tuple(sense for sense in self.scene.senses if sense != "upper_arm")

    @cached_property
    def imus(self) -> tuple[Imu, ...]:
        """The forearm's, and the upper arm's where there is one."""
        if "upper_arm" not in self.scene.senses:
            return (self.imu,)
        rng = self._rng("upper arm")
        worn = Worn(self.scene.duration_s, rng)
        upper = upper_arm_imu(self.shoulder, self.elbow, worn, REST, rng)
        # One clock for both.
        time_s = upper.time_s if self._worn is None else self._worn.clock(upper.time_s)
        return self.imu, dataclasses.replace(upper, time_s=time_s)

    def is_occluded(self, time_s: Array) -> np.ndarray:
        """Whether something hides the patch, `(T,)`."""
        hidden = np.zeros(len(time_s), dtype=bool)
        for start, end in self.scene.occlusions:
            hidden |= (time_s >= start) & (time_s < end)
        return hidden

    @cached_property
    def truth(self) -> Truth:
        """Where shoulder, elbow and wrist really were, at 100 Hz."""
        time_s = np.arange(round(self.scene.duration_s * TRUTH_RATE_HZ) + 1) / TRUTH_RATE_HZ
        joints = {"shoulder": self.shoulder(time_s), "elbow": self.elbow(time_s), "wrist": self.wrist(time_s)}
        return Truth(time_s=time_s, joints_m=joints)

    def recording(self) -> ArmRecording:
        """As a recording in memory, without video: to be tracked from `sightings`."""
        views = tuple(View(camera=camera) for camera in self.cameras)
        return ArmRecording(views=views, imus=self.imus, arm=self.arm, truth=self.truth, landmarks=self.joints_seen)


def look_at(
    centre_m: Triple, azimuth_deg: float, elevation_deg: float, distance_m: float, patch_offset_m: Triple
) -> Camera:
    """A camera at `distance_m` from `centre_m`; azimuth 0 faces the subject, looking along -y."""
    azimuth, elevation = np.deg2rad(azimuth_deg), np.deg2rad(elevation_deg)
    away = np.array([-np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)])
    forward = -away
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    translation = -rotation @ (np.asarray(centre_m) + distance_m * away)
    width, height = IMAGE_SIZE
    return Camera(
        matrix=((FOCAL_PX, 0.0, width / 2), (0.0, FOCAL_PX, height / 2), (0.0, 0.0, 1.0)),
        rotation=(triple(rotation[0]), triple(rotation[1]), triple(rotation[2])),
        translation_m=triple(translation),
        patch_offset_m=patch_offset_m,
    )


def _keep(time_s: Array, dropped: float, rng: np.random.Generator) -> Array:
    """`time_s` without a random share, first and last kept."""
    keep = rng.random(len(time_s)) >= dropped
    keep[[0, -1]] = True
    return time_s[keep]


def _direction(rng: np.random.Generator) -> Array:
    """A random unit vector `(3,)`."""
    v = rng.standard_normal(3)
    return np.asarray(v / np.linalg.norm(v))


def _slow(time_s: Array, rng: np.random.Generator) -> Array:
    """A slow random vector of RMS length 1: two sines an axis with periods of 5 to 15 s, `(T, 3)`."""
    period = rng.uniform(5.0, 15.0, (2, 3))
    phase = rng.uniform(0.0, 2 * np.pi, (2, 3))
    waves = np.sin(2 * np.pi * time_s[:, None, None] / period + phase).sum(axis=1)
    return np.asarray(waves / np.sqrt(3.0))
