"""A recording: cameras, IMUs, arm and truth, in SI units, world coordinates and recording time.

`pytracker.load` makes one from a folder, `pytracker.simulate` one from nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from pytracker._core import Observation
from pytracker.formats.keypoints import Keypoints
from pytracker.rotation import Array, Matrix, Triple
from pytracker.skeleton.skeleton import Skeleton

__all__ = [
    "Arm",
    "ArmRecording",
    "BodyRecording",
    "BodyView",
    "Camera",
    "Imu",
    "ProjectionFit",
    "Recording",
    "Truth",
    "View",
    "WeakPerspective",
]

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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
class Camera:
    """A calibrated pinhole camera (OpenCV: x right, y down, z forward).

    Attributes:
        matrix: intrinsics, px.
        rotation: world to camera.
        translation_m: world to camera, m.
        distortion: k1 k2 p1 p2 k3.
        patch_offset_m: centre of the patch that it follows, in the segment's frame, m from the wrist.
    """

    matrix: Matrix
    rotation: Matrix = IDENTITY
    translation_m: Triple = (0.0, 0.0, 0.0)
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    patch_offset_m: Triple = (0.0, 0.0, 0.0)

    def project(self, points: Array) -> Array:
        """Pixels `(T, 2)` of world points `(T, 3)`; NaN behind the camera."""
        p = points @ np.array(self.rotation).T + np.array(self.translation_m)
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
        k1, k2, p1, p2, k3 = self.distortion
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        homogeneous = np.stack([xd, yd, np.ones_like(xd)], axis=1) @ np.array(self.matrix).T
        homogeneous[p[:, 2] <= 0] = np.nan
        return np.ascontiguousarray(homogeneous[:, :2])

    def px_per_m(self, points: Array) -> Array:
        """Pixels per metre across the viewing direction at world points `(T, 3)`, `(T,)`."""
        depth = points @ np.array(self.rotation)[2] + self.translation_m[2]
        return np.asarray(0.5 * (self.matrix[0][0] + self.matrix[1][1]) / depth)

    def ray(self, pixel: Array) -> Array:
        """Unit vector in the world, `(3,)`, from the camera through a pixel `(2,)`."""
        normal = np.linalg.solve(np.array(self.matrix), np.array([pixel[0], pixel[1], 1.0]))[:2]
        undistorted = normal.copy()
        # The inverse of the distortion has no closed form; this fixed point is OpenCV's own.
        k1, k2, p1, p2, k3 = self.distortion
        for _ in range(20):
            x, y = undistorted
            r2 = x * x + y * y
            radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
            shift = np.array([2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y])
            undistorted = (normal - shift) / radial
        ray = np.array(self.rotation).T @ np.array([*undistorted, 1.0])
        return np.asarray(ray / np.linalg.norm(ray))

    @property
    def position_m(self) -> Array:
        """Where the camera stands, world, m `(3,)`."""
        return np.asarray(-np.array(self.rotation).T @ np.array(self.translation_m))


@dataclass(frozen=True, kw_only=True)
class View:
    """A camera and its video.

    Attributes:
        camera: the calibrated camera.
        video: the file; None where sightings come from elsewhere.
        start_s: recording time of the first frame, s.
        patch_box: x, y, width, height of the patch in the first frame, px.
    """

    camera: Camera
    video: Path | None = None
    start_s: float = 0.0
    patch_box: tuple[int, int, int, int] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Imu:
    """A worn IMU, in recording time and in the frame of its segment (+y from its far joint to its near one).

    Attributes:
        time_s: `(M,)`, increasing.
        acc: specific force, m/s² `(M, 3)`.
        q_world_segment: orientation of the segment, to the world, w first `(M, 4)`.
        gyr: turn rate, rad/s `(M, 3)`, where there is a gyroscope.
        segment: which segment wears it.
    """

    time_s: Array
    acc: Array
    q_world_segment: Array
    gyr: Array | None = None
    segment: str = "right_forearm"


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """Measured joints.

    Attributes:
        time_s: recording time, `(T,)`.
        joints_m: by joint, world, m `(T, 3)`; NaN where it was not seen.
        gaps: how many rows of each joint were not seen.
    """

    time_s: Array
    joints_m: dict[str, Array]
    gaps: dict[str, int] = field(default_factory=dict)

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
            at[(interval[before] > 2.5 * np.median(interval)) & (time_s != self.time_s[before])] = np.nan
        return at


@dataclass(frozen=True, kw_only=True, eq=False)
class ProjectionFit:
    """How well a weak-perspective matrix fits point pairs; Li & Kulić Table II. One row for u, one for v.

    Attributes:
        matrix: px per metre along x, y, z, and px `(2, 4)`; columns that were not fitted are zero.
        low: lower 95 % bound of every coefficient `(2, 4)`.
        high: upper bound.
        sse: sum of squared residuals, px² `(2,)`.
        r2: coefficient of determination `(2,)`.
        adjusted_r2: the same for the number of coefficients `(2,)`.
        rmse: sqrt(sse / (n - coefficients)), px `(2,)`.
        points_m: the world points `(n, 3)`.
        pixels: the image points `(n, 2)`.
    """

    matrix: Array
    low: Array
    high: Array
    sse: Array
    r2: Array
    adjusted_r2: Array
    rmse: Array
    points_m: Array
    pixels: Array


@dataclass(frozen=True, kw_only=True)
class WeakPerspective:
    """A camera far away: Li & Kulić eq. (3).

    Attributes:
        affine: rows u and v: px per metre along x, y, z, and px.
    """

    affine: tuple[tuple[float, float, float, float], tuple[float, float, float, float]]

    def project(self, points: Array) -> Array:
        """Pixels `(T, 2)` of world points `(T, 3)`."""
        rows = np.array(self.affine)
        return np.asarray(points @ rows[:, :3].T + rows[:, 3])

    def px_per_m(self, points: Array) -> Array:
        """Pixels per metre at world points `(T, 3)`: the same everywhere, `(T,)`."""
        return np.full(len(points), float(np.linalg.norm(np.array(self.affine)[:, :3], axis=1).mean()))


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
    """

    camera: WeakPerspective | Camera
    video: Path | None = None
    size_px: tuple[int, int] = (0, 0)
    rate_hz: float = 0.0
    start_s: float = 0.0
    background: Path | None = None
    fit: ProjectionFit | None = None
    keypoints: Keypoints | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
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

    def observations(self, evidence: Any = None) -> Iterator[Observation]:
        """All that was observed, in order of time: see `pytracker.evidence.observations`."""
        return type(self).observer(self, evidence)


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmRecording(Recording):
    """An arm: cameras that follow a patch, an IMU on the wrist.

    Attributes:
        views: cameras with their videos.
        imus: inertial sensors.
        arm: the subject's arm.
    """

    views: tuple[View, ...]
    imus: tuple[Imu, ...]
    arm: Arm

    kind: ClassVar[str] = "arm"


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
    """

    view: BodyView
    skeleton: Skeleton
    initial: Array
    poses: Array | None = None
    imus: tuple[Imu, ...] = ()
    imu_sds_rad: tuple[float, ...] = ()

    kind: ClassVar[str] = "body"
