"""A body's first pose from the 2-D keypoints of its first frame.

Where the joints of a pose are seen against where a detector has them, and a prior of how people stand: facing the
camera or turned from it, upright, arms anywhere. Depth is what the keypoints hardly tell: of the poses that fit as
well the one nearest the prior is taken, from several starts.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from pytracker._core import KEYPOINTS, InputError
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array, triple
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["FirstPose", "first_pose"]

ARM = ("humerus_rx", "humerus_ry", "humerus_rz", "radius_rx")
CHANNELS = (
    "root_tx", "root_ty", "root_tz", "root_rx", "root_ry", "root_rz", *(f"{side}{dof}" for side in "lr" for dof in ARM),
)  # fmt: skip
SDS = np.array([1.0, 1.0, 0.5, *np.radians([8.0, 30.0, 8.0]), *np.tile(np.radians([50.0, 50.0, 40.0, 45.0]), 2)])
"""How far from the prior people are, m and rad."""
STARTS_DEG = {
    "hanging": (0.0, -70.0, 0.0, 15.0),
    "bent": (20.0, -65.0, 0.0, 80.0),
    "forward": (60.0, -45.0, -60.0, 60.0),
    "raised": (0.0, 40.0, 0.0, 60.0),
    "sideways": (0.0, -10.0, 0.0, 10.0),
}
"""The left arm's humerus and radius; the right one's is its mirror."""
HIPS_M = 0.93
"""Where the root is looked for first, above the floor."""
TRUNK_M = 0.5
"""From hips to shoulders."""
SHOULDERS_M = 0.33
"""From one to the other."""
PIXEL_SD = 0.01
"""Of a keypoint, as a share of the person's height in the picture."""
DISTANCE_SHARE = 0.06
"""Of two people of a height one has a trunk so much longer, and a detector's hips and shoulders are no skeleton's."""
TURNS = 25
STEP = 1e-5
LEAST_SEEN = 6
BESIDE = 0.5
"""A camera that looks farther beside the world's z axis looks across it, rad."""
FITS = 4.0
"""The worst keypoint of a pose that fits lies beside it by no more standard deviations."""


@dataclass(frozen=True, eq=False)
class FirstPose:
    """A pose that fits.

    Attributes:
        angles: channels that are not zero, by name: degrees, `root_t*` in metres.
        rms_px: how far its joints lie from the keypoints.
        worst: the keypoint that lies farthest, and by how many standard deviations.
        distance_sd_m: how well it tells how far off the person is, m; None for weak perspective, which knows none.
        is_from_behind: whether the camera sees the person's back; or the picture is mirrored.
    """

    angles: dict[str, float]
    rms_px: float
    worst: tuple[str, float]
    distance_sd_m: float | None
    is_from_behind: bool

    @property
    def fits(self) -> bool:
        """Whether every keypoint is explained."""
        return self.worst[1] <= FITS

    def channels(self, skeleton: Skeleton) -> Array:
        """The pose as the skeleton has it `(D,)`, m and rad."""
        pose = np.zeros(len(skeleton.channels))
        for name, value in self.angles.items():
            pose[skeleton.channels.index(name)] = value if name.startswith("root_t") else np.radians(value)
        return pose


def first_pose(skeleton: Skeleton, camera: WeakPerspective | Camera, points: Array, focal_sd: float = 0.0) -> FirstPose:
    """From keypoints of one person `(9, 3)`: u, v, confidence; `focal_sd` of the camera is a share.

    Where the camera looks across the world's z axis it is found in a world that is turned: a person who faces such a
    camera has a right angle about y, where turns about x and z are one. Raises `InputError` where too few are seen.
    """
    beside = _beside(camera)
    if abs(beside) < BESIDE or not isinstance(camera, Camera):
        return _found(skeleton, camera, points, focal_sd)
    turn = np.array([[np.cos(beside), 0.0, np.sin(beside)], [0.0, 1.0, 0.0], [-np.sin(beside), 0.0, np.cos(beside)]])
    rows = [triple(row) for row in np.array(camera.rotation) @ turn]
    found = _found(skeleton, dataclasses.replace(camera, rotation=(rows[0], rows[1], rows[2])), points, focal_sd)
    pose = skeleton.core.turned(found.channels(skeleton).tolist(), turn.tolist())
    values = zip(CHANNELS, (pose[column] for column in skeleton.columns(CHANNELS)), strict=True)
    return dataclasses.replace(found, angles=_named(values))


def _beside(camera: WeakPerspective | Camera) -> float:
    """How far beside the world's z axis a camera looks, seen from above, rad: 0 along it, either way."""
    if not isinstance(camera, Camera):
        return 0.0
    x, _, z = camera.rotation[2]
    return float(np.arctan(x / z)) if z else float(np.pi / 2)


def _named(values: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Degrees, and metres, of channels."""
    return {name: round(float(value if name.startswith("root_t") else np.degrees(value)), 4) for name, value in values}


def _found(skeleton: Skeleton, camera: WeakPerspective | Camera, points: Array, focal_sd: float) -> FirstPose:
    """In the world as it is."""
    names = list(KEYPOINTS)
    wanted = [k for k, name in enumerate(names) if name.endswith(("shoulder", "elbow", "wrist", "hip"))]
    seen = [k for k in wanted if np.isfinite(points[k, :2]).all()]
    if len(seen) < LEAST_SEEN:
        raise InputError(
            f"{len(seen)} of shoulders, elbows, wrists and hips are among the keypoints of the first frame, expected "
            f"{LEAST_SEEN} at least"
        )
    columns = skeleton.columns(CHANNELS)
    pixels = points[seen, :2]
    sd = PIXEL_SD * max(40.0, 2.5 * float(np.ptp(pixels[:, 1])))

    def joints(values: Array) -> Array:
        poses = np.zeros((len(values), len(skeleton.channels)))
        poses[:, columns] = values
        starts, ends, _ = skeleton.core.pose(poses)
        of = {"shoulder": (starts, "humerus"), "elbow": (ends, "humerus"), "wrist": (ends, "wrist")}
        places = []
        for k in seen:
            side, joint = names[k].split("_")
            if joint == "hip":
                places.append(starts[:, skeleton.bone(f"{side[0]}femur")])
            else:
                which, bone = of[joint]
                places.append(which[:, skeleton.bone(f"{side[0]}{bone}")])
        return np.stack(places, axis=1)

    def residuals(values: Array, prior: Array) -> Array:
        """`(K, R)` of `(K, D)`: keypoints, then the prior, in standard deviations."""
        places = joints(values)
        found = camera.project(places.reshape(-1, 3)).reshape(len(values), -1, 2)
        beside = ((found - pixels) / sd).reshape(len(values), -1)
        return np.concatenate([np.nan_to_num(beside, nan=1e3), (values - prior) / SDS], axis=1)

    at = {names[k]: points[k, :2] for k in seen}
    fits = [_fitted(residuals, start) for start in _starts(_stands(camera, at))]
    best, _ = min(fits, key=lambda fit: fit[1])
    beside = np.linalg.norm(camera.project(joints(best[None])[0]) - pixels, axis=1)
    worst = int(np.argmax(beside))
    angles = _named(zip(CHANNELS, best.tolist(), strict=True))
    rms = float(np.sqrt(np.mean(beside**2)))
    distance_sd_m = _distance_sd(camera, joints(best[None])[0], focal_sd)
    return FirstPose(angles, rms, (names[seen[worst]], float(beside[worst] / sd)), distance_sd_m, _is_from_behind(at))


def _distance_sd(camera: WeakPerspective | Camera, places: Array, focal_sd: float) -> float | None:
    """How well the size of a person tells how far off they are, m."""
    if not isinstance(camera, Camera):
        return None
    return round(
        float(np.hypot(DISTANCE_SHARE, focal_sd)) * float(np.linalg.norm(places.mean(axis=0) - camera.position_m)), 3
    )


def _stands(camera: WeakPerspective | Camera, seen: dict[str, Array]) -> Array:
    """Where a person stands and where they look, by joints that are seen, px: root_tx .. root_rz, m and rad.

    They look at the camera, or away from it where they are seen from behind.
    """
    place = np.array([0.0, HIPS_M, 0.0])
    if isinstance(camera, Camera):
        place = _place(camera, seen)
        to_camera = camera.position_m - place
    else:
        u, v = (row[:3] for row in np.array(camera.affine))
        to_camera = -np.cross(u, v)
    turn = float(np.arctan2(to_camera[0], to_camera[2]))
    if _is_from_behind(seen):
        turn += np.pi
    return np.array([*place, 0.0, turn, 0.0])


def _is_from_behind(seen: dict[str, Array]) -> bool:
    """Whether the left shoulder is seen left of the right one."""
    left, right = (seen.get(f"{side}_shoulder") for side in ("left", "right"))
    return left is not None and right is not None and bool(left[0] < right[0])


def _place(camera: Camera, seen: dict[str, Array]) -> Array:
    """Where the hips are, by how long the trunk is in the picture, m `(3,)`, or by how wide the shoulders are.

    Above the origin where neither is seen.
    """
    shoulders, hips = ([at for name, at in seen.items() if name.endswith(joint)] for joint in ("shoulder", "hip"))
    if shoulders and hips:
        top, bottom = np.mean(shoulders, axis=0), np.mean(hips, axis=0)
        return _along(camera, bottom, TRUNK_M / max(float(np.linalg.norm(top - bottom)), 1.0))
    if len(shoulders) == len(("left", "right")):
        width = max(float(np.linalg.norm(shoulders[0] - shoulders[1])), 1.0)
        return _along(camera, np.mean(shoulders, axis=0), SHOULDERS_M / width) - [0.0, TRUNK_M, 0.0]
    return np.array([0.0, HIPS_M, 0.0])


def _along(camera: Camera, pixel: Array, m_per_px: float) -> Array:
    """The place that is seen there, so far off that a pixel is so much."""
    ray = camera.ray(pixel)
    depth_m = camera.matrix[1][1] * m_per_px
    return np.asarray(camera.position_m + ray * depth_m / float(ray @ np.array(camera.rotation)[2]))


def _starts(stands: Array) -> list[Array]:
    """The prior's middle with arms in several ways, on either side."""
    starts = []
    for left in STARTS_DEG.values():
        for right in STARTS_DEG.values():
            mirrored = (right[0], -right[1], -right[2], right[3])
            starts.append(np.array([*stands, *np.radians([*left, *mirrored])]))
    return starts


def _fitted(residuals: Callable[[Array, Array], Array], prior: Array) -> tuple[Array, float]:
    """Levenberg-Marquardt from the prior's middle; the pose and half its squared residuals."""
    at, damping = prior.copy(), 1e-2
    now = residuals(at[None], prior)[0]
    for _ in range(TURNS):
        moved = residuals(at + STEP * np.eye(len(at)), prior)
        slope = (moved - now).T / STEP
        square, down = slope.T @ slope, slope.T @ now
        step = np.linalg.solve(square + damping * np.diag(np.diag(square)), -down)
        tried = residuals((at + step)[None], prior)[0]
        if tried @ tried < now @ now:
            is_done = now @ now - tried @ tried < 1e-6 * (now @ now)
            at, now, damping = at + step, tried, damping / 5
            if is_done:
                break
        else:
            damping *= 5
            if damping > 1e6:
                break
    return at, float(now @ now)
