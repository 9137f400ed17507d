"""An arm's folder to an `ArmRecording`: read, converted to world and recording time, and checked."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from pytracker._core import InputError, check_camera
from pytracker.formats import video
from pytracker.recording.camera import Camera
from pytracker.recording.imu import load_imu
from pytracker.recording.keypoints import files_of, load_keypoints
from pytracker.recording.recording import UPPER_ARM_SD_RAD, Arm, ArmRecording, Imu, Truth, View
from pytracker.recording.schema import ArmEntry, ArmFile, CameraEntry, ImuEntry, TruthEntry
from pytracker.recording.truth import load_points
from pytracker.recording.upper_arm import upper_arm_imu
from pytracker.rotation import Array, Triple, rotate, triple

__all__ = ["load_arm"]

JOINTS = ("shoulder", "elbow", "wrist")
LANDMARKS = ("shoulder", "elbow")
"""What may be seen besides the patch on the wrist."""

SLACK_S = 0.1
"""IMU and video may start and end this far apart without a word."""

START_M = 0.10
START_PX = 40.0
"""How far arm length and patch may be off at the first frame before something must be wrong."""

STRAY = 4.0
"""Times the arm's reach: no marker of it goes so far from where it usually is."""
MOST_STRAYS = 0.05
"""More such rows are no strays: the lengths then tell what is wrong."""
SHOULDER_M = 0.07
ELBOW_SWINGS_M = 0.06
"""A shoulder that is taken to be still moves by a few centimetres."""

START_FROM_RAY = {"position_start_sd_m": 0.15, "velocity_start_sd": 0.3}
"""How well the first wrist is known where only the patch's ray and the arm's reach tell it, m and m/s."""
MISS_M = 0.10
"""How far the patch's ray may pass from the arm sphere when the start is found from it."""


def load_arm(folder: Path, path: Path, entry: ArmFile) -> ArmRecording:
    """What `path`, read as `entry`, says. Raises `InputError`."""
    worn_by = (f"{entry.arm.side}_forearm",)
    if (entry.imu[0].segment or "").endswith("upper_arm") and len(entry.imu) > 1:
        raise InputError(f"{path}: imu[0] is worn by the upper arm, expected the forearm's first")
    imu, warnings = load_imu(folder, f"{path}: imu[0]", entry.imu[0], worn_by)
    mount = np.array(entry.imu[0].mount)
    mount /= np.linalg.norm(mount)
    views = tuple(_view(folder, f"{path}: camera[{k}]", c, mount) for k, c in enumerate(entry.camera))
    overlap_warnings = _check_overlap(views, imu)
    truth, truth_warnings = (None, []) if entry.truth is None else _truth(folder, path, entry.truth, entry.arm)
    start, start_warnings = _wrist_start(path, entry.arm, views[0], imu, truth)
    for number, view in enumerate(views):
        _check_start(f"{path}: camera[{number}]", entry.arm, start, view, imu)
    arm = Arm(
        shoulder_m=entry.arm.shoulder_m,
        upper_arm_m=entry.arm.upper_arm_m,
        forearm_m=entry.arm.forearm_m,
        wrist_start_m=start,
        side=entry.arm.side,
    )
    upper = [upper_arm_imu(folder, f"{path}: imu[1]", worn, arm, imu, views[0].start_s) for worn in entry.imu[1:]]
    names = [name for worn in entry.imu for name in (worn.file, worn.orientation_file)]
    names += [camera.video for camera in entry.camera] + [entry.truth.file if entry.truth else None]
    detected = [file for c in entry.camera if c.keypoints is not None for file in files_of(folder / c.keypoints)]
    return ArmRecording(
        views=views,
        imus=(imu, *(found for found, _ in upper)),
        arm=arm,
        landmarks=tuple(joint for joint in LANDMARKS if any(_sees(view, joint) for view in views)),
        upper_arm_sd_rad=_upper_arm_sd_rad(entry.imu),
        truth=truth,
        spreads=_spreads(entry) | (START_FROM_RAY if start_warnings else {}),
        folder=folder,
        files=(path, *(folder / name for name in names if name is not None), *detected),
        warnings=(
            *warnings,
            *(words for _, said in upper for words in said),
            *overlap_warnings,
            *truth_warnings,
            *start_warnings,
        ),
    )


def _spreads(entry: ArmFile) -> dict[str, float]:
    """How well things are known, where the file says so, by a method's parameter; the widest of several cameras."""
    cameras = entry.camera
    said = {
        "upper_arm_sd_m": [entry.arm.upper_arm_sd_m],
        "forearm_sd_m": [entry.arm.forearm_sd_m],
        "shoulder_place_sd_m": [entry.arm.shoulder_sd_m],
        "mount_sd_rad": [np.radians(sd) for sd in [entry.imu[0].mount_sd_deg] if sd is not None],
        "clock_sd_s": [entry.imu[0].offset_sd_s],
        "offset_start_sd_m": [camera.patch_offset_sd_m for camera in cameras],
        "camera_turn_sd_rad": [np.radians(c.rotation_sd_deg) for c in cameras if c.rotation_sd_deg is not None],
        "camera_distance_sd_m": [camera.distance_sd_m for camera in cameras],
        "focal_sd": [camera.focal_sd for camera in cameras],
    }
    known = {name: [float(value) for value in values if value is not None] for name, values in said.items()}
    return {name: max(values) for name, values in known.items() if values}


def _view(folder: Path, place: str, entry: CameraEntry, mount: Array) -> View:
    offset = rotate(mount, np.array(entry.patch_offset_m))
    camera = Camera(
        matrix=entry.matrix,
        rotation=entry.rotation,
        translation_m=entry.translation_m,
        distortion=entry.distortion,
        patch_offset_m=triple(offset),
    )
    try:
        check_camera(camera)
    except InputError as error:
        raise InputError(f"{place}: {error}") from None
    file = folder / entry.video
    info = video.probe(file)
    for key, box in {"patch_box": entry.patch_box, **{f"patches.{k}": b for k, b in entry.patches.items()}}.items():
        x, y, w, h = box
        if w < 2 or h < 2 or x < 0 or y < 0 or x + w > info.width or y + h > info.height:
            raise InputError(
                f"{place}: {key} is {list(box)} (x, y, width, height), expected at least 2 px wide and high and inside "
                f"the {info.width} x {info.height} px of {file}"
            )
    keypoints = None
    if entry.keypoints is not None:
        keypoints = load_keypoints(folder / entry.keypoints, entry.keypoint_model, file, info)
    return View(
        camera=camera, video=file, start_s=entry.start_s, patch_box=entry.patch_box,
        patches={str(joint): box for joint, box in entry.patches.items()}, keypoints=keypoints,
    )  # fmt: skip


def _sees(view: View, joint: str) -> bool:
    return joint in view.patches or view.keypoints is not None


def _upper_arm_sd_rad(entries: tuple[ImuEntry, ...]) -> float:
    said = [worn.mount_sd_deg for worn in entries[1:] if worn.mount_sd_deg is not None]
    return float(np.radians(said[0])) if said else UPPER_ARM_SD_RAD


def _check_overlap(views: tuple[View, ...], imu: Imu) -> list[str]:
    warnings = []
    for view in views:
        assert view.video is not None
        info = video.probe(view.video)
        start = view.start_s
        # The promised length is only an estimate: it is used to tell recordings apart, not to trim them.
        end = start + (info.frame_count / info.rate_hz if info.rate_hz else 0.0)
        if imu.time_s[-1] < start or imu.time_s[0] > max(end, start):
            raise InputError(
                f"{view.video} covers {start:.3f} to {end:.3f} s and the IMU {imu.time_s[0]:.3f} to "
                f"{imu.time_s[-1]:.3f} s of recording time, expected them to overlap: check start_s and offset_s"
            )
        if imu.time_s[0] > start + SLACK_S:
            warnings.append(
                f"{view.video}: the IMU starts {imu.time_s[0] - start:.3f} s after the first frame; the frames before "
                "are not tracked, and the wrist's start is taken to hold where tracking starts"
            )
        if imu.time_s[-1] < end - SLACK_S:
            warnings.append(
                f"{view.video}: the IMU ends {end - imu.time_s[-1]:.3f} s before the video; the frames after are "
                "tracked without it and say so"
            )
    return warnings


def _truth(folder: Path, path: Path, entry: TruthEntry, arm: ArmEntry) -> tuple[Truth, list[str]]:
    file = folder / entry.file
    truth, gaps = load_points(path, file, entry, JOINTS, kind="arm")
    if "wrist" not in truth.joints_m:
        raise InputError(
            f"{path}: truth.markers names {', '.join(truth.joints_m) or 'nothing'}, expected at least wrist"
        )
    joints = dict(truth.joints_m)
    strayed = _without_strays(file, joints, arm)
    truth = dataclasses.replace(truth, joints_m=joints)
    return truth, [*strayed, *_check_truth(file, truth, arm), *gaps]


def _without_strays(file: Path, joints: dict[str, Array], arm: ArmEntry) -> list[str]:
    """Rows where a marker is far from where it usually is are gaps, not truth.

    Returns a word on each joint that has some.
    """
    warnings = []
    reach = arm.upper_arm_m + arm.forearm_m
    for joint, points in joints.items():
        usual = np.nanmedian(points, axis=0) if np.isfinite(points).any() else np.zeros(3)
        with np.errstate(invalid="ignore"):
            stray = np.linalg.norm(points - usual, axis=1) > STRAY * reach
        if not stray.any() or stray.mean() > MOST_STRAYS:
            continue
        first = int(np.argmax(stray))
        warnings.append(
            f"{file}: {joint} is at {np.round(points[first], 3).tolist()} m in row {first + 1} of its data, "
            "expected within "
            f"{STRAY * reach:.1f} m of its usual place; {int(stray.sum())} of {len(points)} rows are such and "
            "are left out"
        )
        joints[joint] = np.where(stray[:, None], np.nan, points)
    return warnings


def _check_truth(file: Path, truth: Truth, arm: ArmEntry) -> list[str]:
    """Markers that were mixed up, or are in other units, do not have the arm's lengths.

    Returns a warning where the shoulder is not where it is said to be.
    """
    shoulder = np.broadcast_to(np.array(arm.shoulder_m), (len(truth.time_s), 3))
    joints = {"shoulder": shoulder, **truth.joints_m}
    reach = arm.upper_arm_m + arm.forearm_m
    for a, b, low, high in (
        ("shoulder", "elbow", 0.6 * arm.upper_arm_m, 1.5 * arm.upper_arm_m),
        ("elbow", "wrist", 0.6 * arm.forearm_m, 1.5 * arm.forearm_m),
        ("shoulder", "wrist", 0.1 * reach, 1.2 * reach),
    ):
        if a not in joints or b not in joints:
            continue
        distance = np.linalg.norm(joints[a] - joints[b], axis=1)
        if not np.isfinite(distance).any():
            raise InputError(f"{file}: {a} and {b} are never seen together, expected some frames of truth")
        middle = float(np.nanmedian(distance))
        if not low <= middle <= high:
            raise InputError(
                f"{file}: {a} and {b} are {middle:.3f} m apart, expected {low:.2f} to {high:.2f} m by the arm's "
                "lengths: check the markers' names and units, and the world frame"
            )
    if "shoulder" in truth.joints_m:
        middle_m = np.nanmedian(truth.joints_m["shoulder"], axis=0)
        off = float(np.linalg.norm(middle_m - np.array(arm.shoulder_m)))
        if off > SHOULDER_M:
            return [
                f"{file}: the shoulder is at {np.round(middle_m, 3).tolist()} m (median), {off:.2f} m from shoulder_m "
                f"{list(arm.shoulder_m)}, expected at most {SHOULDER_M} m"
            ]
    elif "elbow" in truth.joints_m:
        swings = float(np.nanstd(np.linalg.norm(truth.joints_m["elbow"] - np.array(arm.shoulder_m), axis=1)))
        if swings > ELBOW_SWINGS_M:
            return [
                f"{file}: the elbow's distance from shoulder_m varies by {swings:.2f} m (sd), expected less than "
                f"{ELBOW_SWINGS_M} m: is the shoulder elsewhere?"
            ]
    return []


def _check_start(place: str, arm: ArmEntry, start: Triple, view: View, imu: Imu) -> None:
    """Camera, patch, IMU and arm must agree about the first frame."""
    assert view.patch_box is not None
    x, y, w, h = view.patch_box
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
    off = float(np.linalg.norm(pixel - [x + (w - 1) / 2, y + (h - 1) / 2]))
    if not off <= max(START_PX, 2.0 * max(w, h)):
        raise InputError(
            f"{place}: the wrist's start is at pixel ({pixel[0]:.0f}, {pixel[1]:.0f}), but patch_box "
            f"{list(view.patch_box)} is {off:.0f} px away, expected at most {max(START_PX, 2.0 * max(w, h)):.0f}: "
            "check wrist_start_m, patch_box and the camera's matrix, rotation and translation_m"
        )


def _wrist_start(path: Path, arm: ArmEntry, view: View, imu: Imu, truth: Truth | None) -> tuple[Triple, list[str]]:
    """As given, else from truth at the first frame, else where the patch's ray meets the arm sphere."""
    if arm.wrist_start_m is not None:
        return arm.wrist_start_m, []
    if truth is not None:
        start = truth.at("wrist", np.array([max(view.start_s, imu.time_s[0])]))[0]
        if np.isfinite(start).all():
            return triple(start), []
    return _start_from_ray(path, arm, view, imu)


def _start_from_ray(path: Path, arm: ArmEntry, view: View, imu: Imu) -> tuple[Triple, list[str]]:
    assert view.patch_box is not None
    x, y, w, h = view.patch_box
    at = int(np.clip(np.searchsorted(imu.time_s, view.start_s), 0, len(imu.time_s) - 1))
    q = imu.q_world_segment[at]
    patch_to_wrist = -rotate(q, np.array(view.camera.patch_offset_m))
    wrist_to_elbow = rotate(q, np.array([0.0, arm.forearm_m, 0.0]))
    origin = view.camera.position_m + patch_to_wrist
    ray = view.camera.ray(np.array([x + (w - 1) / 2, y + (h - 1) / 2]))
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
