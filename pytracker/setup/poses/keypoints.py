"""A body's first pose from the 2-D keypoints of its first frame.

Where the joints of a pose are seen against where a detector has them, and a prior of how people stand: facing the
camera or turned from it, upright, arms anywhere. Depth is what the keypoints hardly tell: of the poses that fit as
well the one nearest the prior is taken, from several starts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pytracker._core import KEYPOINTS, InputError
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array
from pytracker.setup.poses.fit import (
    CHANNELS,
    HIPS_M,
    SDS,
    FoundPose,
    along,
    distance_sd,
    faced,
    fitted_from,
    named,
    starts,
    turn_to,
)
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["LEAST_SEEN", "FirstPose", "first_pose"]

TRUNK_M = 0.5
"""From hips to shoulders."""
SHOULDERS_M = 0.33
"""From one to the other."""
PIXEL_SD = 0.01
"""Of a keypoint, as a share of the person's height in the picture."""
LEAST_SEEN = 6
FITS = 4.0
"""The worst keypoint of a pose that fits lies beside it by no more standard deviations."""


@dataclass(frozen=True, eq=False)
class FirstPose(FoundPose):
    """A pose that fits keypoints.

    Attributes:
        rms_px: how far its joints lie from the keypoints.
        worst: the keypoint that lies farthest, and by how many standard deviations.
        is_from_behind: whether the camera sees the person's back; or the picture is mirrored.
    """

    rms_px: float
    worst: tuple[str, float]
    is_from_behind: bool

    @property
    def fits(self) -> bool:
        """Whether every keypoint is explained."""
        return self.worst[1] <= FITS


def first_pose(skeleton: Skeleton, camera: WeakPerspective | Camera, points: Array, focal_sd: float = 0.0) -> FirstPose:
    """From keypoints of one person `(9, 3)`: u, v, confidence; `focal_sd` of the camera is a share.

    Raises `InputError` where too few are seen, or nothing of how large the trunk is.
    """
    return faced(skeleton, camera, lambda seen_by: _found(skeleton, seen_by, points, focal_sd))


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
        near, ends, _ = skeleton.core.pose(poses)
        of = {"shoulder": (near, "humerus"), "elbow": (ends, "humerus"), "wrist": (ends, "wrist")}
        places = []
        for k in seen:
            side, joint = names[k].split("_")
            if joint == "hip":
                places.append(near[:, skeleton.bone(f"{side[0]}femur")])
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
    best, _ = min(fitted_from(residuals, starts(_stands(camera, at))), key=lambda fit: fit[1])
    beside = np.linalg.norm(camera.project(joints(best[None])[0]) - pixels, axis=1)
    worst = int(np.argmax(beside))
    angles = named(zip(CHANNELS, best.tolist(), strict=True))
    rms = float(np.sqrt(np.mean(beside**2)))
    distance_sd_m = distance_sd(camera, joints(best[None])[0], focal_sd)
    worst_off = names[seen[worst]], float(beside[worst] / sd)
    return FirstPose(angles, distance_sd_m, rms, worst_off, _is_from_behind(camera, at))


def _stands(camera: WeakPerspective | Camera, seen: dict[str, Array]) -> Array:
    """Where a person stands and where they look, by joints that are seen, px: root_tx .. root_rz, m and rad.

    They look at the camera, or away from it where they are seen from behind.
    """
    place = _place(camera, seen)
    turn = turn_to(camera, place)
    if _is_from_behind(camera, seen):
        turn += np.pi
    return np.array([*place, 0.0, turn, 0.0])


def _is_from_behind(camera: WeakPerspective | Camera, seen: dict[str, Array]) -> bool:
    """Whether the left shoulder is seen left of the right one, whichever way the camera is up."""
    left, right = (seen.get(f"{side}_shoulder") for side in ("left", "right"))
    if left is None or right is None:
        return False
    place = _place(camera, seen)
    hips, above = camera.project(np.stack([place, place + np.array([0.0, TRUNK_M, 0.0])]))
    up = above - hips
    return bool(np.dot(left - right, [-up[1], up[0]]) < 0)


def _place(camera: WeakPerspective | Camera, seen: dict[str, Array]) -> Array:
    """Where the hips are, by how long the trunk is in the picture, m `(3,)`, or by how wide the shoulders are.

    A camera without perspective sees nothing of it. Raises `InputError` where neither is seen.
    """
    if not isinstance(camera, Camera):
        return np.array([0.0, HIPS_M, 0.0])
    shoulders, hips = ([at for name, at in seen.items() if name.endswith(joint)] for joint in ("shoulder", "hip"))
    if shoulders and hips:
        top, bottom = np.mean(shoulders, axis=0), np.mean(hips, axis=0)
        return along(camera, bottom, TRUNK_M / max(float(np.linalg.norm(top - bottom)), 1.0))
    if len(shoulders) < len(("left", "right")):
        raise InputError(
            f"{len(shoulders)} shoulders and {len(hips)} hips are among the keypoints of the first frame, expected "
            "both shoulders, or one and a hip: they tell how far off the person is"
        )
    width = max(float(np.linalg.norm(shoulders[0] - shoulders[1])), 1.0)
    return along(camera, np.mean(shoulders, axis=0), SHOULDERS_M / width) - [0.0, TRUNK_M, 0.0]
