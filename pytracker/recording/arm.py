"""An arm's folder to an `ArmRecording`: read, converted to world and recording time, and checked."""

from __future__ import annotations

import dataclasses
import filecmp
import itertools
from pathlib import Path

import numpy as np

from pytracker._core import InputError, check_camera
from pytracker.formats import video
from pytracker.formats.imu.read import files_of_imu, holds_several
from pytracker.formats.video_oddities import video_oddities
from pytracker.formats.video_steady import camera_moves
from pytracker.formats.video_times import counted
from pytracker.recording.arm_start import FIRST_FRAMES, check_start, wrist_start
from pytracker.recording.camera import Camera
from pytracker.recording.imu import load_imu
from pytracker.recording.keypoints.load import files_of, first_seen, load_keypoints, of_video
from pytracker.recording.recording import UPPER_ARM_SD_RAD, Arm, ArmRecording, Imu, View
from pytracker.recording.schema import ArmFile, CameraEntry, ImuEntry
from pytracker.recording.truth.arm import load_truth
from pytracker.recording.truth.points import uncovered
from pytracker.recording.upper_arm import upper_arm_imu
from pytracker.rotation import Array, rotate, triple

__all__ = ["load_arm"]

LANDMARKS = ("shoulder", "elbow")
"""What may be seen besides the patch on the wrist."""

SLACK_S = 0.1
"""IMU and video may start and end this far apart without a word."""


UNKNOWN_START = {"position_start_sd_m": 0.3, "velocity_start_sd": 0.8}
"""How well the first wrist is known where only the patch's ray and the arm's reach tell it, or, where the IMU starts
after the first frame, nothing; m and m/s."""
LEAST_PX = 0.5
"""No detector is better."""
WRIST_KEYPOINT_M = 0.012
"""From frame to frame a detector's wrist is off by as much across the picture."""
WRIST_KEYPOINT = {"patch_offset_start_sd_m": 0.02}
"""Its constant error, m."""
PART_S = 0.5
"""Cameras may begin and end so far apart without a word."""


def load_arm(folder: Path, path: Path, entry: ArmFile) -> ArmRecording:
    """What `path`, read as `entry`, says. Raises `InputError`."""
    worn_by = (f"{entry.arm.side}_forearm",)
    if (entry.imu[0].segment or "").endswith("upper_arm") and len(entry.imu) > 1:
        raise InputError(f"{path}: imu[0] is worn by the upper arm, expected the forearm's first")
    imu, warnings = load_imu(folder, f"{path}: imu[0]", entry.imu[0], worn_by)
    mount = np.array(entry.imu[0].mount)
    mount /= np.linalg.norm(mount)
    _require_own_files(folder, path, entry)
    views = tuple(_view(folder, f"{path}: camera[{k}]", c, mount, entry.arm.side) for k, c in enumerate(entry.camera))
    views, of_keypoints = _detected(folder, entry, views)
    odd_cameras = _odd_cameras(path, views)
    overlap_warnings = _check_overlap(views, imu) + of_keypoints + odd_cameras
    truth, truth_warnings = (None, []) if entry.truth is None else load_truth(folder, path, entry.truth, entry.arm)
    if truth is not None and entry.truth is not None and (video := views[0].video) is not None:
        truth_warnings += uncovered(folder / entry.truth.file, truth, video, views[0].start_s)
    is_late = imu.time_s[0] > views[0].start_s + SLACK_S
    try:
        start, start_warnings = wrist_start(path, entry.arm, views[0], imu, truth, is_late=is_late)
        for number, view in enumerate(views):
            if imu.time_s[0] <= view.start_s + SLACK_S:
                check_start(f"{path}: camera[{number}]", entry.arm, start, view, imu)
    except InputError as error:
        # What was odd of sensor or camera may be why.
        raise InputError("; ".join([str(error), *(f"and {words}" for words in (*warnings, *odd_cameras))])) from None
    start_sds = UNKNOWN_START if is_late or start_warnings else {}
    arm = Arm(
        shoulder_m=entry.arm.shoulder_m,
        upper_arm_m=entry.arm.upper_arm_m,
        forearm_m=entry.arm.forearm_m,
        wrist_start_m=start,
        side=entry.arm.side,
    )
    upper = [upper_arm_imu(folder, f"{path}: imu[1]", worn, arm, imu, views[0].start_s) for worn in entry.imu[1:]]
    sensors = [file for worn in entry.imu for file in files_of_imu(folder / worn.file)]
    names = [worn.orientation_file for worn in entry.imu]
    names += [camera.video for camera in entry.camera] + [entry.truth.file if entry.truth else None]
    detected = [file for c in entry.camera if c.keypoints is not None for file in files_of(folder / c.keypoints)]
    return ArmRecording(
        views=views,
        imus=(imu, *(found for found, _ in upper)),
        arm=arm,
        landmarks=tuple(joint for joint in LANDMARKS if any(_sees(view, joint) for view in views)),
        upper_arm_sd_rad=_upper_arm_sd_rad(entry.imu),
        truth=truth,
        spreads=_by_keypoints(views, arm) | _spreads(entry) | start_sds,
        folder=folder,
        files=(path, *sensors, *(folder / name for name in names if name is not None), *detected),
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
        "patch_offset_start_sd_m": [camera.patch_offset_sd_m for camera in cameras],
        "camera_turn_sd_rad": [np.radians(c.rotation_sd_deg) for c in cameras if c.rotation_sd_deg is not None],
        "camera_distance_sd_m": [camera.distance_sd_m for camera in cameras],
        "focal_sd": [camera.focal_sd for camera in cameras],
    }
    known = {name: [float(value) for value in values if value is not None] for name, values in said.items()}
    return {name: max(values) for name, values in known.items() if values}


def _by_keypoints(views: tuple[View, ...], arm: Arm) -> dict[str, float]:
    """A detector's wrist, in place of a patch, is as well known as its error is usual on people."""
    if any(view.patch_box is not None for view in views):
        return {}
    px_per_m = float(views[0].camera.px_per_m(np.array([arm.shoulder_m]))[0])
    return WRIST_KEYPOINT | {"pixel_sd": max(LEAST_PX, WRIST_KEYPOINT_M * px_per_m)}


def _view(folder: Path, place: str, entry: CameraEntry, mount: Array, side: str) -> View:
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
    if entry.patch_box is None and entry.keypoints is None:
        raise InputError(f"{place}.patch_box is missing, expected where the patch is in the first frame, or keypoints")
    boxes = {"patch_box": entry.patch_box, **{f"patches.{joint}": box for joint, box in entry.patches.items()}}
    for key, box in boxes.items():
        x, y, w, h = box or (0, 0, 2, 2)
        if w < 2 or h < 2 or x < 0 or y < 0 or x + w > info.width or y + h > info.height:
            raise InputError(
                f"{place}: {key} is {list(box or ())} (x, y, width, height), expected at least 2 px wide and high and "
                f"inside the {info.width} x {info.height} px of {file}"
            )
    keypoints = None
    if entry.keypoints is not None:
        keypoints = load_keypoints(folder / entry.keypoints, entry.keypoint_model, file, counted(file))
        if entry.patch_box is None and first_seen(keypoints, f"{side}_wrist", FIRST_FRAMES) is None:
            raise InputError(
                f"{folder / entry.keypoints}: has no {side} wrist in the first {FIRST_FRAMES} frames, expected it, "
                f"or {place}.patch_box"
            )
    return View(
        camera=camera, video=file, start_s=entry.start_s, patch_box=entry.patch_box,
        patches={str(joint): box for joint, box in entry.patches.items()}, keypoints=keypoints,
        moves=camera_moves(file),
    )  # fmt: skip


def _require_own_files(folder: Path, path: Path, entry: ArmFile) -> None:
    """Raises `InputError` where two cameras, or two sensors, have one file, or copies of one."""
    videos = [(f"camera[{k}].video", camera.video) for k, camera in enumerate(entry.camera)]
    worn = [(f"imu[{k}].file", imu.file) for k, imu in enumerate(entry.imu)]
    several = holds_several(folder / entry.imu[0].file)
    for (first, one), (second, other) in (
        *itertools.combinations(videos, 2),
        *([] if several else itertools.combinations(worn, 2)),
    ):
        files = folder / one, folder / other
        if files[0].resolve() == files[1].resolve():
            raise InputError(f"{path}: {second} is that of {first.partition('.')[0]}, {other}, expected another one's")
        if all(file.is_file() for file in files) and filecmp.cmp(*files, shallow=False):
            raise InputError(f"{path}: {second}, {other}, is a copy of {one}, expected what another one recorded")


def _sees(view: View, joint: str) -> bool:
    return joint in view.patches or view.keypoints is not None


def _upper_arm_sd_rad(entries: tuple[ImuEntry, ...]) -> float:
    said = [worn.mount_sd_deg for worn in entries[1:] if worn.mount_sd_deg is not None]
    return float(np.radians(said[0])) if said else UPPER_ARM_SD_RAD


def _odd_cameras(path: Path, views: tuple[View, ...]) -> list[str]:
    found: list[str] = []
    for number, view in enumerate(views):
        assert view.video is not None
        info = video.probe(view.video)
        found += [f"{path}: camera[{number}].{words}" for words in view.camera.oddities((info.width, info.height))]
    return found


def _detected(folder: Path, entry: ArmFile, views: tuple[View, ...]) -> tuple[tuple[View, ...], list[str]]:
    """The views without keypoints that were held; a word on those, and on keypoints of a part of their video."""
    found: list[View] = []
    words: list[str] = []
    for camera, view in zip(entry.camera, views, strict=True):
        if camera.keypoints is None or view.keypoints is None or view.video is None:
            found.append(view)
            continue
        kept, said = of_video(folder / camera.keypoints, view.keypoints, counted(view.video))
        found.append(dataclasses.replace(view, keypoints=kept))
        words += said
    return tuple(found), words


def _check_overlap(views: tuple[View, ...], imu: Imu) -> list[str]:
    warnings = []
    spans: list[tuple[float, float]] = []
    for view in views:
        assert view.video is not None
        warnings += video_oddities(view.video, view.start_s, view.moves)
        info = video.probe(view.video)
        start = view.start_s
        # The promised length is only an estimate: it is used to tell recordings apart, not to trim them.
        end = start + (info.frame_count / info.rate_hz if info.rate_hz else 0.0)
        spans.append((start, end))
        if imu.time_s[-1] < start or imu.time_s[0] > max(end, start):
            raise InputError(
                f"{view.video} covers {start:.3f} to {end:.3f} s and the IMU {imu.time_s[0]:.3f} to "
                f"{imu.time_s[-1]:.3f} s of recording time, expected them to overlap: check start_s and offset_s"
            )
        if imu.time_s[0] > start + SLACK_S:
            warnings.append(
                f"{view.video}: the IMU starts {imu.time_s[0] - start:.3f} s after the first frame; the frames before "
                "are not tracked, and where the wrist is when tracking starts is not known"
            )
        if imu.time_s[-1] < end - SLACK_S:
            warnings.append(
                f"{view.video}: the IMU ends {end - imu.time_s[-1]:.3f} s before the video; the frames after are "
                "tracked without it and say so"
            )
    return [*warnings, *_of_part(views, spans)]


def _of_part(views: tuple[View, ...], spans: list[tuple[float, float]]) -> list[str]:
    """A word on further cameras that see a part of what the first sees."""
    first, last = spans[0]
    return [
        f"{view.video} covers {start:.3f} to {end:.3f} s and {views[0].video} {first:.3f} to {last:.3f} s of recording "
        "time: where it has no frames the others are followed alone: was it cut short, or is start_s another?"
        for view, (start, end) in zip(views[1:], spans[1:], strict=True)
        if end > start and last > first and (start > first + PART_S or end < last - PART_S)
    ]
