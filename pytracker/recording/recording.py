"""A recording: cameras, IMUs, arm and truth, in SI units, world coordinates and recording time.

`pytracker.load` makes one from a folder, `pytracker.simulate` one from nothing.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from pytracker._core import InputError, Observation
from pytracker.formats.keypoints.read import Keypoints
from pytracker.formats.video_steady import CameraMoves
from pytracker.recording.camera import Camera, ProjectionFit, WeakPerspective
from pytracker.rotation import Array, Triple, conjugate, multiply, rotate
from pytracker.skeleton.skeleton import Skeleton

__all__ = [
    "PAUSES",
    "UPPER_ARM_SD_RAD",
    "Arm",
    "ArmRecording",
    "BodyRecording",
    "BodyView",
    "Imu",
    "Recording",
    "Truth",
    "View",
    "Worn",
]


PAUSES = 2.5
"""Rows of a truth that are so many usual steps apart have others missing between them."""
UPPER_ARM_SD_RAD = 0.05
"""How well a sensor tells where an upper arm points, where the recording does not say."""


@dataclass(frozen=True, kw_only=True)
class Arm:
    """The subject's arm.

    Attributes:
        shoulder_m: shoulder joint, world, m.
        upper_arm_m: shoulder to elbow, m.
        forearm_m: elbow to wrist, m.
        wrist_start_m: wrist joint at the first frame, world, m.
        side: `right` or `left`.
    """

    shoulder_m: Triple
    upper_arm_m: float
    forearm_m: float
    wrist_start_m: Triple
    side: str = "right"


@dataclass(frozen=True, kw_only=True)
class View:
    """A camera and its video.

    Attributes:
        camera: the calibrated camera.
        video: the file; None where sightings come from elsewhere.
        start_s: recording time of the first frame, s.
        patch_box: x, y, width, height of the patch in the first frame, px.
        patches: the same of further patches, by the joint that they sit on: `shoulder`, `elbow`.
        keypoints: what a detector found in the video, px, where there is such a file.
        moves: by how much its camera moves, where that was looked at.
    """

    camera: Camera
    video: Path | None = None
    start_s: float = 0.0
    patch_box: tuple[int, int, int, int] | None = None
    patches: Mapping[str, tuple[int, int, int, int]] = field(default_factory=dict)
    keypoints: Keypoints | None = None
    moves: CameraMoves | None = None


@dataclass(frozen=True, eq=False)
class Worn:
    """How a sensor is worn.

    Attributes:
        mount: sensor to segment `(4,)`.
        heading: the turn from its earth frame to the world `(4,)`.
    """

    mount: Array
    heading: Array

    def of_segment(self, vectors: Array) -> Array:
        """What was measured in the sensor's axes `(..., 3)`, in its segment's."""
        return rotate(self.mount, vectors)

    def q_world_segment(self, q_earth_sensor: Array) -> Array:
        """How the segment is turned, of the sensor's own orientation; both `(M, 4)`."""
        q = multiply(multiply(self.heading, q_earth_sensor), conjugate(self.mount))
        return np.ascontiguousarray(q)


@dataclass(frozen=True, kw_only=True, eq=False)
class Imu:
    """A worn IMU, in recording time and in the frame of its segment (+y from its far joint to its near one).

    Attributes:
        time_s: `(M,)`, increasing.
        acc: specific force, m/s² `(M, 3)`.
        q_world_segment: orientation of the segment, to the world, w first `(M, 4)`.
        gyr: turn rate, rad/s `(M, 3)`, where there is a gyroscope.
        segment: which segment wears it.
        worn: how, by the recording's description; None where there is none.
    """

    time_s: Array
    acc: Array
    q_world_segment: Array
    gyr: Array | None = None
    segment: str = "right_forearm"
    worn: Worn | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """Measured joints.

    Attributes:
        time_s: recording time, `(T,)`.
        joints_m: by joint, world, m `(T, 3)`; NaN where it was not seen.
    """

    time_s: Array
    joints_m: dict[str, Array]

    def at(self, joint: str, time_s: Array) -> Array:
        """Position of `joint` at `time_s` by linear interpolation `(T, 3)`; NaN in a gap, beside one, or outside.

        Rows that are missing altogether are a gap like rows that are empty.
        """
        points = self.joints_m[joint]
        at = np.stack(
            [np.interp(time_s, self.time_s, points[:, d], left=np.nan, right=np.nan) for d in range(3)], axis=1
        )
        if len(self.time_s) > 2:
            interval = np.diff(self.time_s)
            before = np.clip(np.searchsorted(self.time_s, time_s, side="right") - 1, 0, len(interval) - 1)
            at[(interval[before] > PAUSES * np.median(interval)) & (time_s != self.time_s[before])] = np.nan
        return at


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyView:
    """A camera that sees a body, and its video.

    Attributes:
        camera: weak perspective or a calibrated pinhole.
        video: the file; None where there are keypoints alone.
        size_px: width and height of its picture.
        rate_hz: frames a second, where there are keypoints alone; a video has its frames' own times.
        start_s: recording time of the first frame, s.
        background: an image without the person; None: the median over the video.
        fit: where the camera was fitted to point pairs.
        keypoints: what a detector found in the video, px, where there is such a file.
        moves: by how much its camera moves, where that was looked at.
    """

    camera: WeakPerspective | Camera
    video: Path | None = None
    size_px: tuple[int, int] = (0, 0)
    rate_hz: float = 0.0
    start_s: float = 0.0
    background: Path | None = None
    fit: ProjectionFit | None = None
    keypoints: Keypoints | None = None
    moves: CameraMoves | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording(ABC):
    """What every folder holds.

    Attributes:
        truth: measured joints, where there are any.
        folder: where it was read from.
        files: every file that was read.
        warnings: what is odd but usable, in words.
        spreads: how well things are known where the recording says so, by the parameter of a method.
    """

    truth: Truth | None = None
    folder: Path | None = None
    files: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()
    spreads: Mapping[str, float] = field(default_factory=dict)

    kind: ClassVar[str]
    observer: ClassVar[Callable[[Recording, Any], Iterator[Observation]]]
    """What makes its observations: set by the stage that can, which comes after this one."""

    @property
    @abstractmethod
    def camera(self) -> WeakPerspective | Camera:
        """In whose picture and depth errors are taken apart."""

    @property
    @abstractmethod
    def video(self) -> Path | None:
        """The first camera's, where there is one."""

    @property
    def has_picture(self) -> bool:
        """Whether there is a video, or what was found in one by colour."""
        return True

    @property
    def points(self) -> tuple[str, ...]:
        """Cues that say where a body's joints are, or how its limbs lie, without a picture."""
        return ()

    def observations(self, evidence: Any = None) -> Iterator[Observation]:
        """All that was observed, in order of time: see `pytracker.evidence.observations`."""
        return type(self).observer(self, evidence)


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmRecording(Recording):
    """An arm: cameras that follow a patch, an IMU on the wrist.

    Attributes:
        views: cameras with their videos.
        imus: inertial sensors: of the forearm, and of the upper arm where there is one.
        arm: the subject's arm.
        landmarks: which joints are seen besides the patch: `shoulder`, `elbow`.
        upper_arm_sd_rad: how well the upper arm's sensor tells where it points, from sample to sample.
    """

    views: tuple[View, ...]
    imus: tuple[Imu, ...]
    arm: Arm
    landmarks: tuple[str, ...] = ()
    upper_arm_sd_rad: float = UPPER_ARM_SD_RAD

    kind: ClassVar[str] = "arm"

    @property
    def camera(self) -> Camera:
        """The first of the cameras."""
        return self.views[0].camera

    @property
    def video(self) -> Path | None:
        """Of the first camera."""
        return self.views[0].video

    @property
    def has_upper_arm(self) -> bool:
        """Whether the upper arm wears a sensor."""
        return len(self.imus) > 1


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyRecording(Recording):
    """A body: a camera and a skeleton.

    Attributes:
        view: the camera with its video.
        skeleton: the subject's skeleton.
        initial: the pose at the first frame `(C,)`, m and rad.
        poses: the true poses, where there are any `(T, C)`, at the truth's times.
        imus: inertial sensors on the arms, in the body's world.
        imu_sds_rad: how well each tells where its segment points.

    Raises `InputError` where these are not as many as the sensors.
    """

    view: BodyView
    skeleton: Skeleton
    initial: Array
    poses: Array | None = None
    imus: tuple[Imu, ...] = ()
    imu_sds_rad: tuple[float, ...] = ()

    kind: ClassVar[str] = "body"

    def __post_init__(self) -> None:
        if len(self.imu_sds_rad) != len(self.imus):
            raise InputError(f"imu_sds_rad are {len(self.imu_sds_rad)} for {len(self.imus)} imus, expected one of each")

    @property
    def camera(self) -> WeakPerspective | Camera:
        """Its camera."""
        return self.view.camera

    @property
    def video(self) -> Path | None:
        """Its camera's."""
        return self.view.video

    @property
    def has_picture(self) -> bool:
        """Whether there is more than keypoints."""
        return self.video is not None

    @property
    def points(self) -> tuple[str, ...]:
        """Keypoints and sensors, of those that there are."""
        there = {"keypoints": self.view.keypoints is not None, "orientation": bool(self.imus)}
        return tuple(cue for cue, is_there in there.items() if is_there)
