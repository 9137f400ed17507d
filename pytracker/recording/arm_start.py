"""Where the wrist is at the first frame; and whether camera, patch, IMU and arm agree about it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.recording.keypoints.load import first_seen
from pytracker.recording.recording import Imu, Truth, View
from pytracker.recording.schema import ArmEntry
from pytracker.rotation import Array, Triple, rotate, triple

__all__ = ["FIRST_FRAMES", "check_start", "wrist_start"]

START_M = 0.10
START_PX = 40.0
"""How far arm length and patch may be off at the first frame before something must be wrong."""
FIRST_FRAMES = 5
"""A wrist that a detector missed in the first frame is where it is seen in the next ones."""
MISS_M = 0.10
"""How far the patch's ray may pass from the arm sphere when the start is found from it."""
TOUCHES_M = 0.01
"""That of an arm held straight touches it, and nothing is odd."""


def check_start(place: str, arm: ArmEntry, start: Triple, view: View, imu: Imu) -> None:
    """Camera, patch, IMU and arm must agree about the first frame."""
    first, size = _first_pixel(view, arm.side)
    at = int(np.clip(np.searchsorted(imu.time_s, view.start_s), 0, len(imu.time_s) - 1))
    q, wrist = imu.q_world_segment[at], np.array(start)
    length = float(np.linalg.norm(wrist + rotate(q, np.array([0.0, arm.forearm_m, 0.0])) - np.array(arm.shoulder_m)))
    if abs(length - arm.upper_arm_m) > START_M:
        raise InputError(
            f"{place}: at the first frame the elbow is {length:.2f} m from the shoulder, expected "
            f"{arm.upper_arm_m:.2f} ± {START_M} m: check wrist_start_m, shoulder_m, the arm's lengths, and "
            "heading_deg and mount of the IMU"
        )
    pixel = view.camera.project((wrist + rotate(q, np.array(view.camera.patch_offset_m)))[None])[0]
    off, most = float(np.linalg.norm(pixel - first)), max(START_PX, 2.0 * size)
    if not off <= most:
        seen = f"patch_box {list(view.patch_box)}" if view.patch_box else f"its keypoint {np.round(first).tolist()}"
        raise InputError(
            f"{place}: the wrist's start is at pixel ({pixel[0]:.0f}, {pixel[1]:.0f}), but {seen} is {off:.0f} px "
            f"away, expected at most {most:.0f}: check wrist_start_m, patch_box and the camera's matrix, rotation and "
            "translation_m"
        )


def _first_pixel(view: View, side: str) -> tuple[Array, float]:
    """Where the patch is in the first frame, px, and how large; or the wrist, where there is none."""
    if view.patch_box is not None:
        x, y, w, h = view.patch_box
        return np.array([x + (w - 1) / 2, y + (h - 1) / 2]), float(max(w, h))
    assert view.keypoints is not None
    pixel = first_seen(view.keypoints, f"{side}_wrist", FIRST_FRAMES)
    assert pixel is not None
    return pixel, 0.0


def wrist_start(
    path: Path, arm: ArmEntry, view: View, imu: Imu, truth: Truth | None, *, is_late: bool
) -> tuple[Triple, list[str]]:
    """As given, else from truth at the first frame, else where the patch's ray meets the arm sphere.

    Of an IMU that starts late nothing of the first frame holds: the upper arm hangs, where no start is given.
    """
    if arm.wrist_start_m is not None:
        return arm.wrist_start_m, []
    if truth is not None:
        start = truth.at("wrist", np.array([max(view.start_s, imu.time_s[0])]))[0]
        if np.isfinite(start).all():
            return triple(start), []
    if is_late:
        elbow = np.array(arm.shoulder_m) - np.array([0.0, 0.0, arm.upper_arm_m])
        return triple(elbow - rotate(imu.q_world_segment[0], np.array([0.0, arm.forearm_m, 0.0]))), []
    return _start_from_ray(path, arm, view, imu)


def _start_from_ray(path: Path, arm: ArmEntry, view: View, imu: Imu) -> tuple[Triple, list[str]]:
    at = int(np.clip(np.searchsorted(imu.time_s, view.start_s), 0, len(imu.time_s) - 1))
    q = imu.q_world_segment[at]
    patch_to_wrist = -rotate(q, np.array(view.camera.patch_offset_m))
    wrist_to_elbow = rotate(q, np.array([0.0, arm.forearm_m, 0.0]))
    origin = view.camera.position_m + patch_to_wrist
    ray = view.camera.ray(_first_pixel(view, arm.side)[0])
    centre = np.array(arm.shoulder_m) - wrist_to_elbow
    nearest = float(ray @ (centre - origin))
    miss = float(np.linalg.norm(origin + nearest * ray - centre))
    if miss > arm.upper_arm_m + MISS_M:
        raise InputError(
            f"{path}: the patch's ray passes {miss - arm.upper_arm_m:.2f} m from where the arm can reach, expected at "
            f"most {MISS_M} m: check camera, shoulder_m, arm lengths and the IMU's heading_deg and mount, or give "
            "arm.wrist_start_m"
        )
    half = float(np.sqrt(max(arm.upper_arm_m**2 - miss**2, 0.0)))
    near, far = origin + (nearest - half) * ray, origin + (nearest + half) * ray
    if half == 0.0 and miss < arm.upper_arm_m + TOUCHES_M:
        return triple(near), []
    if half == 0.0:
        return triple(near), [
            f"{path}: arm.wrist_start_m is not given, and the patch's ray passes {miss - arm.upper_arm_m:.3f} m from "
            f"where the arm can reach; its nearest point, {np.round(near, 3).tolist()} m, is taken: check camera, "
            "shoulder_m, arm lengths and the IMU's heading_deg and mount"
        ]
    warning = (
        f"{path}: arm.wrist_start_m is not given; the patch's ray meets the arm sphere at "
        f"{np.round(near, 3).tolist()} and {np.round(far, 3).tolist()} m; the nearer to "
        "the camera is taken: give wrist_start_m if it is the other"
    )
    return triple(near), [warning]
