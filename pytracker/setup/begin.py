"""`init(folder, video=...)`: a first recording.toml from the files that there are, which says what is missing still."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import tomlkit

from pytracker._core import InputError, check_camera
from pytracker.formats.imu.read import read_imu
from pytracker.formats.trc import read_trc
from pytracker.formats.video import frames, probe
from pytracker.output import write_whole
from pytracker.recording.camera import Camera
from pytracker.recording.truth.points import UP
from pytracker.recording.upright import to_up
from pytracker.rotation import Array
from pytracker.setup.entries.known import known_of
from pytracker.setup.entries.subject import SUBJECTS, SubjectEntry, check_command, value
from pytracker.setup.entries.truth import truth_lines
from pytracker.setup.upright import AS_TRC, axis_up, words_of

__all__ = ["init"]

PHONE_FOCAL = 0.8
"""Focal length of a phone's main camera while it films, as a share of the picture's longer side: 0.65 to 0.95."""
PHONE_FOCAL_SD = 0.1
ASKED = ("rate_hz in [[imu]]", "columns = {")
"""What a sensor's file that does not say all of itself is read by, once recording.toml says it."""


def init(
    folder: Path | str,
    *,
    video: Path | str,
    imu: Path | str | None = None,
    keypoints: Path | str | None = None,
    truth: Path | str | None = None,
    camera: Path | str | None = None,
    camera_name: str | None = None,
    force: bool = False,
) -> Path:
    """Write `folder`/recording.toml; the files stay where they are and are named from there.

    An arm where there is an IMU, else a body. `camera` is what is known already: a TOML file whose keys are those of
    `[[camera]]` and `[arm]`, a former recording.toml, or a calibration by others; `camera_name` names one of several.
    Returns the file's path. Raises `InputError` for a file that cannot be read, or a recording.toml that is there
    already, unless `force`.
    """
    folder = Path(folder)
    path = folder / "recording.toml"
    if path.exists() and not force:
        raise InputError(f"{path}: already exists, expected none (or --force to replace it)")
    known, scaled = ({}, "") if camera is None else known_of(camera, camera_name, Path(video))
    folder.mkdir(parents=True, exist_ok=True)
    kind = "arm" if imu is not None else "body"
    subject = SUBJECTS[kind]
    turned, up = _turn(known, None if truth is None else Path(truth), kind)
    lines = [
        "# Made by pytracker init. What is missing is said where it belongs; `pytracker check` looks at all of it.",
        "schema = 1",
        f'kind = "{kind}"',
        "",
        *_camera(folder, Path(video), known, subject, None if keypoints is None else Path(keypoints), turned, scaled),
        *([] if imu is None else _imu(folder, Path(imu), f"{known.get('side', 'right')}_forearm")),
        *subject.tables(known, folder, has_keypoints=keypoints is not None),
        *([] if truth is None else _truth(folder, Path(truth), kind, known, up)),
    ]
    write_whole(path, "\n".join(lines) + "\n")
    return path


def _named(folder: Path, file: Path) -> str:
    """A file as the folder names it. Raises `InputError` where it is not there."""
    if not file.exists():
        raise InputError(f"{file}: there is no such file")
    name = os.path.relpath(file.resolve(), folder.resolve()).replace(os.sep, "/")
    return tomlkit.item(name).as_string()


def _turn(known: dict[str, object], truth: Path | None, kind: str) -> tuple[str, str]:
    """Turn what is known of the camera to the world of a `kind` of recording: y is up for a body, z for an arm.

    How, in words, and which axis is up in the truth; both empty where it was so. Who gives an arm's shoulder too gives
    both in one world.
    """
    wanted = UP[kind]
    if "rotation" not in known or "shoulder_m" in known:
        return "", ""
    try:
        rotation = np.array(known["rotation"], dtype=float).reshape(3, 3)
    except (TypeError, ValueError):
        return "", ""  # said where it is loaded
    up = axis_up(rotation)
    if not up:
        return f"not turned, the camera looks up, down or askew: {wanted} is to be up here", ""
    if up == wanted:
        return "", ""
    is_theirs = truth is not None and truth.suffix.lower() == ".trc" and _is_turned(known, truth)
    first = AS_TRC if is_theirs else np.eye(3)
    of_truth = axis_up(rotation @ first.T)
    turn = to_up(of_truth, wanted) @ first
    known["rotation"] = (rotation @ turn.T).tolist()
    words = f"turned, the calibration has its {up} axis up: x, y, z here are its {words_of(turn)}"
    return words, "" if of_truth == wanted else of_truth


def _is_turned(known: dict[str, object], truth: Path) -> bool:
    """Whether the points of a TRC stand more upright in the picture when they are taken as Pose2Sim turns them."""
    try:
        camera = Camera(
            matrix=known["matrix"],  # type: ignore[arg-type]  # validated
            rotation=known["rotation"],  # type: ignore[arg-type]  # likewise
            translation_m=known["translation_m"],  # type: ignore[arg-type]  # likewise
        )
        check_camera(camera)
        rows = np.stack(list(read_trc(truth).positions_m.values()), axis=1)
    except (InputError, KeyError, TypeError, ValueError):
        return True  # said where they are loaded
    seen = np.isfinite(rows).all(axis=2)
    points = rows[int(np.argmax(seen.sum(axis=1)))]
    points = points[np.isfinite(points).all(axis=1)]

    def tallness(at: Array) -> float:
        pixels = camera.project(at)
        pixels = pixels[np.isfinite(pixels).all(axis=1)]
        return float(np.ptp(pixels[:, 1]) - np.ptp(pixels[:, 0])) if len(pixels) > 1 else -np.inf

    return tallness(points @ AS_TRC) >= tallness(points)


def _camera(
    folder: Path,
    video: Path,
    known: dict[str, object],
    subject: SubjectEntry,
    keypoints: Path | None,
    turned: str,
    scaled: str,
) -> list[str]:
    name, info = _named(folder, video), probe(video)
    next(frames(video), None)
    lines = [
        "[[camera]]",
        f"video = {name}  # {info.width} x {info.height} px, about {info.frame_count} frames at "
        f"{info.rate_hz:.4g} a second",
    ]
    if keypoints is not None:
        lines.append(f"keypoints = {_named(folder, keypoints)}")
    if "matrix" in known:
        lines.append(f"matrix = {value(known['matrix'])}" + (f"  # {scaled}" if scaled else ""))
    else:
        focal = PHONE_FOCAL * max(info.width, info.height)
        matrix = [[focal, 0.0, (info.width - 1) / 2], [0.0, focal, (info.height - 1) / 2], [0.0, 0.0, 1.0]]
        lines.append(f"matrix = {value(matrix)}  # guessed, as of a phone: pytracker calibrate camera finds it")
        lines.append(f"focal_sd = {PHONE_FOCAL_SD}")
    lines += [f"{key} = {value(known[key])}" for key in subject.camera_keys if key in known]
    return [*lines, *subject.pose(known, turned), *subject.patch(known, folder), ""]


def _imu(folder: Path, file: Path, segment: str) -> list[str]:
    name = _named(folder, file)
    try:
        log = read_imu(file, segment=segment)
    except InputError as error:
        if not any(key in str(error) for key in ASKED):
            raise
        words = " ".join(str(error).split())
        return ["[[imu]]", f"file = {name}", f"# missing here: {words}", f"# then {check_command(folder)}", ""]
    holds = {"acc": log.acc, "gyr": log.gyr, "mag": log.mag, "orientation": log.q_world_sensor}
    has = ", ".join(words for words, values in holds.items() if values is not None)
    span = log.time_s[-1] - log.time_s[0]
    return [
        "[[imu]]",
        f"file = {name}  # {len(log.time_s)} samples over {span:.1f} s: {has}",
        f"# offset_s, heading_deg, mount, units and directions: {check_command(folder)} finds them",
        "",
    ]


def _truth(folder: Path, file: Path, kind: str, known: dict[str, object], up: str) -> list[str]:
    return truth_lines(_named(folder, file), file, kind, str(known.get("side", "right")), up)
