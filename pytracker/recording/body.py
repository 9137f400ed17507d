"""A body's folder to a `BodyRecording`: skeleton, camera, initial pose and truth, checked."""

from __future__ import annotations

import dataclasses
import difflib
import math
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.asf import read_asf
from pytracker.formats.imu.read import files_of_imu
from pytracker.formats.toml_file import parse_toml
from pytracker.formats.video_oddities import compression, video_oddities
from pytracker.formats.video_times import counted
from pytracker.recording.body_view import end_of, rate_of, view_of
from pytracker.recording.camera import Camera
from pytracker.recording.found_pose import fingerprint, is_stale
from pytracker.recording.imu import load_imu
from pytracker.recording.keypoints.filled import as_seen
from pytracker.recording.keypoints.load import alone, files_of, of_video, unseen
from pytracker.recording.keypoints.stuck import without_stuck
from pytracker.recording.recording import BodyRecording, BodyView, Imu, Truth
from pytracker.recording.schema import BodyFile, ImuEntry, InitialEntry, SkeletonEntry
from pytracker.recording.truth.body import beside_first_pose, load_truth, uncovered_by_truth
from pytracker.recording.worn import ARM_SEGMENTS, MOST_LATE_S, aligned, to_y_up
from pytracker.rotation import Array
from pytracker.skeleton.average import average_skeleton
from pytracker.skeleton.skeleton import UPPER_BODY, Skeleton

__all__ = ["load_body", "skeleton_of"]

MOST = 1000.0
"""No angle in degrees and no place in metres is larger."""
LATE_S, ENDS_S = 0.1, 0.5
"""A sensor that begins so much after the first frame, or ends so much before the last, is told of."""

MOUNT_SD_DEG = 3.0
"""How well a sensor's mount is known where the recording does not say."""

GUESSED = 0.05
"""A focal length that is known to a larger share only was not measured."""
SQUARE = 1.2
"""Longer side over shorter: pictures of cameras are 4:3 at least."""
LEAST_PX = 8.0
"""Root to head must span as much in the first frame; less is a camera in other units."""


def load_body(folder: Path, path: Path, entry: BodyFile) -> BodyRecording:
    """What `path`, read as `entry`, says. Raises `InputError`."""
    camera_entry = entry.camera[0]
    skeleton, skeleton_file = skeleton_of(folder, path, entry.skeleton)
    view = view_of(folder, path, camera_entry)
    inputs = fingerprint(skeleton, view, camera_entry.focal_sd or 0.0)
    truth, poses, warnings = load_truth(folder, path, entry.truth, skeleton) if entry.truth else (None, None, ())
    initial = _initial(folder, path, entry.initial, skeleton, view, truth, poses)
    _check_in_view(path, skeleton, initial, view)
    view, said = _detected(folder, camera_entry.keypoints, view)
    warnings += said
    imus, said = _imus(folder, path, entry.imu, skeleton, initial, view)
    warnings += said
    if truth is not None and entry.truth is not None:
        warnings += uncovered_by_truth(folder / entry.truth.file, truth, view)
        warnings += beside_first_pose(
            folder / entry.truth.file,
            truth,
            skeleton.joints(initial[None]),
            view,
            distance_sd_m=(entry.initial and entry.initial.distance_sd_m) or 0.0,
            up=entry.truth.up or "y",
        )
    if entry.initial is not None and entry.initial.angles is not None:
        warnings += _changed(folder / entry.initial.angles, inputs)
    warnings += _of_camera(path, view, camera_entry.focal_sd or 0.0)
    names = [camera_entry.video, camera_entry.background, camera_entry.points]
    names += [worn.orientation_file for worn in entry.imu]
    names += [entry.truth.file if entry.truth else None, entry.initial.angles if entry.initial else None]
    files = [folder / name for name in names if name is not None]
    files += [file for worn in entry.imu for file in files_of_imu(folder / worn.file)]
    files += files_of(folder / camera_entry.keypoints) if camera_entry.keypoints else []
    return BodyRecording(
        view=view,
        skeleton=skeleton,
        initial=initial,
        truth=truth,
        poses=poses,
        imus=imus,
        imu_sds_rad=tuple(
            math.radians(MOUNT_SD_DEG if worn.mount_sd_deg is None else worn.mount_sd_deg) for worn in entry.imu
        ),
        folder=folder,
        spreads=_spreads(entry.initial),
        files=(path, *files, *skeleton_file),
        warnings=warnings,
    )


def _changed(file: Path, inputs: str) -> tuple[str, ...]:
    """A word where the first pose was found from something else than there is now."""
    if not is_stale(file, inputs):
        return ()
    return (
        f"{file}: was found with another camera, height or keypoints than there are now: pytracker check --write finds "
        "the first pose again",
    )


def _detected(folder: Path, named: str | None, view: BodyView) -> tuple[BodyView, tuple[str, ...]]:
    """The view without keypoints that nobody saw, counted from 0 where they stand alone; and what is odd about them."""
    if named is None or view.keypoints is None:
        return view, ()
    file = folder / named
    if view.video is not None:
        kept, said = of_video(file, view.keypoints, counted(view.video))
        said = (*unseen(file, kept), *said)
    else:
        begun, late = alone(file, view.keypoints)
        kept, said = as_seen(file, begun)
        said = (*late, *said)
    kept, stuck = without_stuck(file, kept, rate_of(view))
    return dataclasses.replace(view, keypoints=kept), (*said, *stuck)


def _of_camera(path: Path, view: BodyView, focal_sd: float) -> tuple[str, ...]:
    """Words on an odd video, a focal length that is guessed of a cut picture, and a camera of another size."""
    words = []
    if view.video is not None:
        words += video_oddities(view.video, view.start_s, view.moves)
        words += compression(view.video) if view.keypoints is None else []
    width, height = view.size_px
    if focal_sd >= GUESSED and max(width, height) <= SQUARE * min(width, height):
        words.append(
            f"{path}: the picture is {width} x {height} px, which is a part of what a camera took, and the focal "
            "length is guessed from it as of a whole one: distances and what lies towards the camera may be wrong by "
            "half; take the uncut video, or calibrate the camera"
        )
    if isinstance(view.camera, Camera):
        words += [f"{path}: camera[0].{odd}" for odd in view.camera.oddities(view.size_px)]
    return tuple(words)


def _spreads(entry: InitialEntry | None) -> dict[str, float]:
    """How well the first pose is known, by the parameter of a method."""
    if entry is None or entry.distance_sd_m is None:
        return {}
    return {"first_distance_sd_m": entry.distance_sd_m}


def skeleton_of(folder: Path, path: Path, entry: SkeletonEntry) -> tuple[Skeleton, tuple[Path, ...]]:
    """The skeleton that `entry` says, and the files it is in. Raises `InputError`."""
    if (entry.file is None) == (entry.height_m is None):
        raise InputError(f"{path}: [skeleton] has {'both' if entry.file else 'neither'}, expected file or height_m")
    if entry.height_m is not None:
        return average_skeleton(entry.height_m), ()
    assert entry.file is not None
    return read_asf(folder / entry.file), (folder / entry.file,)


def _imus(
    folder: Path, path: Path, entries: tuple[ImuEntry, ...], skeleton: Skeleton, initial: Array, view: BodyView
) -> tuple[tuple[Imu, ...], tuple[str, ...]]:
    """Sensors on the arms, turned to the body's world and to its first pose; and what is odd about them."""
    imus: list[Imu] = []
    warnings: list[str] = []
    for k, entry in enumerate(entries):
        place = f"{path}: imu[{k}]"
        imu, said = load_imu(folder, place, entry, ARM_SEGMENTS, needs_heading=False)
        if any(other.segment == imu.segment for other in imus):
            raise InputError(f"{place}.segment is {imu.segment!r}, worn by another sensor too, expected one each")
        first_s, end_s = view.start_s, end_of(view)
        if not imu.time_s[0] - MOST_LATE_S <= first_s <= imu.time_s[-1]:
            raise InputError(
                f"{place} covers {imu.time_s[0]:.3f} to {imu.time_s[-1]:.3f} s of recording time, expected it to cover "
                f"the first frame at {first_s:.3f} s, or to begin {MOST_LATE_S:g} s later at the most: check offset_s"
            )
        imu = dataclasses.replace(imu, q_world_segment=to_y_up(imu.q_world_segment))
        q = aligned(place, imu, entry.heading_deg is not None, skeleton, initial, first_s)
        imus.append(dataclasses.replace(imu, q_world_segment=q))
        warnings += said
        if imu.time_s[0] > first_s + LATE_S:
            warnings.append(
                f"{place} begins {imu.time_s[0] - first_s:.3f} s after the first frame: its arm is taken to be then as "
                "in the first pose, and the frames before are tracked without it"
            )
        if imu.time_s[-1] < end_s - ENDS_S:
            warnings.append(
                f"{place} ends at {imu.time_s[-1]:.3f} s of recording time and the frames at {end_s:.3f} s: from there "
                "on its segment is tracked without it"
            )
    return tuple(imus), tuple(warnings)


def _initial(
    folder: Path,
    path: Path,
    entry: InitialEntry | None,
    skeleton: Skeleton,
    view: BodyView,
    truth: Truth | None,
    poses: Array | None,
) -> Array:
    """The pose at the first frame: as said, else the truth's at that time."""
    if entry is not None and entry.angles is not None:
        if entry.frame is not None:
            raise InputError(f"{path}: [initial] has angles and frame, expected one of them")
        return _angles(folder / entry.angles, skeleton)
    if truth is None or poses is None:
        raise InputError(
            f"{path}: has no [initial] angles and no [truth] with angles (.amc), expected one to know the first pose: "
            "pytracker check --write finds it from the first frame"
        )
    if entry is not None and entry.frame is not None:
        if entry.frame >= len(poses):
            raise InputError(f"{path}: initial.frame is {entry.frame}, expected below {len(poses)}, the truth's frames")
        return np.asarray(poses[entry.frame])
    if not truth.time_s[0] - 1e-9 <= view.start_s <= truth.time_s[-1]:
        raise InputError(
            f"{path}: the video starts at {view.start_s:.3f} s and the truth covers {truth.time_s[0]:.3f} to "
            f"{truth.time_s[-1]:.3f} s, expected it to cover the first frame, or [initial]"
        )
    return np.asarray(poses[int(np.argmin(np.abs(truth.time_s - view.start_s)))])


def _angles(file: Path, skeleton: Skeleton) -> Array:
    """`bone_dof = degrees` (root_tx, root_ty, root_tz: metres); what is not named is 0."""
    if not file.is_file():
        raise InputError(f"{file}: no such file, expected the first pose: lines of bone_dof = degrees")
    values = parse_toml(file)
    pose = np.zeros(len(skeleton.channels))
    for name, value in values.items():
        if name not in skeleton.channels:
            near = difflib.get_close_matches(name, skeleton.channels, n=1)
            raise InputError(
                f"{file}: {name} is no channel of the skeleton, expected such as {(near or UPPER_BODY)[0]}"
            )
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= MOST:
            raise InputError(
                f"{file}: {name} is {str(value)[:40]}, expected a number within ±{MOST:g} (degrees; root_tx, root_ty, "
                "root_tz: metres)"
            )
        is_length = name.split("_")[-1].startswith("t")
        pose[skeleton.channels.index(name)] = value if is_length else math.radians(value)
    return pose


def _check_in_view(path: Path, skeleton: Skeleton, initial: Array, view: BodyView) -> None:
    """The first pose must be in the picture."""
    width, height = view.size_px
    joints = skeleton.joints(initial[None])
    pixels = view.camera.project(np.concatenate([joints["root"], joints["head"]]))
    apart = float(np.linalg.norm(pixels[1] - pixels[0]))
    if not apart >= LEAST_PX:
        raise InputError(
            f"{path}: at the first frame root and head are {apart:.3g} px apart, expected at least {LEAST_PX:.0f} px: "
            "check the units of the camera and of its points (metres, pixels)"
        )
    for name, (u, v) in zip(("root", "head"), pixels, strict=True):
        if not (-0.5 * width <= u <= 1.5 * width and -0.5 * height <= v <= 1.5 * height):
            raise InputError(
                f"{path}: at the first frame the {name} is seen at ({u:.4g}, {v:.4g}) px, expected in or near the "
                f"{width} x {height} px of {view.video or 'the keypoints'}: check camera, skeleton and first pose"
            )
