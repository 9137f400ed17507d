"""A camera of ours for others: Pose2Sim's and AniPose's TOML, OpenCV's FileStorage as YAML.

World to camera as in ours; rotations as Rodrigues' vectors in TOML, as matrices in YAML. The inverse of `calibration`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from pytracker._core import InputError
from pytracker.rotation import Array, matrix_to_quaternion, quaternion_to_rotation_vector

__all__ = ["calibration_text", "with_pose"]

YAML = (".yml", ".yaml")


def calibration_text(path: Path, camera: Mapping[str, Any], size_px: tuple[int, int], name: str) -> str:
    """What to write to `path`, whose suffix tells the format: `.toml`, or `.yml` and `.yaml`.

    `camera` has the keys of `[[camera]]`: matrix, and where they are known distortion, rotation and translation_m.
    Raises `InputError` for another suffix, values of another shape, half a pose, or none, which TOML must have.
    """
    suffix = path.suffix.lower()
    if suffix != ".toml" and suffix not in YAML:
        raise InputError(
            f"{path}: expected a name that ends in .toml (Pose2Sim, AniPose) or {', '.join(YAML)} (OpenCV)"
        )
    matrix = _numbers(camera, "matrix", (3, 3))
    distortion = _numbers(camera, "distortion", (5,)) if "distortion" in camera else np.zeros(5)
    pose = [key for key in ("rotation", "translation_m") if key in camera]
    if len(pose) == 1 or (not pose and suffix == ".toml"):
        raise InputError(
            f"the camera has {pose[0] if pose else 'neither rotation nor translation_m'}, expected both: "
            "pytracker calibrate pose"
        )
    rotation = _numbers(camera, "rotation", (3, 3)) if pose else None
    translation = _numbers(camera, "translation_m", (3,)) if pose else None
    if suffix in YAML:
        return _yaml(matrix, distortion, rotation, translation, size_px)
    table: dict[str, Any] = {"name": name, "size": [float(side) for side in size_px], "matrix": matrix.tolist()}
    # They know four distortions; the fifth is read by whoever hands them to OpenCV.
    table["distortions"] = (distortion if distortion[4] else distortion[:4]).tolist()
    if rotation is not None and translation is not None:
        q = matrix_to_quaternion(rotation[None])
        table |= {"rotation": quaternion_to_rotation_vector(q)[0].tolist(), "translation": translation.tolist()}
    return tomlkit.dumps({name: table | {"fisheye": False}})


def with_pose(path: Path, rotation: Array, translation_m: Array, **besides: object) -> str:
    """The TOML file of one of our cameras, with where it stands, and `besides`; all else in it stays as it is."""
    document = tomlkit.parse(path.read_text("utf-8-sig"))
    found = {"rotation": np.round(rotation, 9).tolist(), "translation_m": np.round(translation_m, 6).tolist()}
    for key, value in {**found, **besides}.items():
        document[key] = value
    return tomlkit.dumps(document)


def _numbers(camera: Mapping[str, Any], key: str, shape: tuple[int, ...]) -> Array:
    try:
        found = np.array(camera[key], dtype=np.float64)
    except (KeyError, TypeError, ValueError):
        found = np.empty(0)
    if found.shape != shape or not np.isfinite(found).all():
        expected = " x ".join(map(str, shape))
        raise InputError(f"{key} of the camera is {str(camera.get(key))[:80]}, expected {expected} numbers")
    return found


def _yaml(
    matrix: Array, distortion: Array, rotation: Array | None, translation: Array | None, size_px: tuple[int, int]
) -> str:
    lines = ["%YAML:1.0", "---", f"image_width: {size_px[0]}", f"image_height: {size_px[1]}"]
    named = {"camera_matrix": matrix, "distortion_coefficients": distortion[None]}
    if rotation is not None and translation is not None:
        named |= {"rotation_matrix": rotation, "translation_vector": translation[:, None]}
    for key, values in named.items():
        cells = ", ".join(repr(float(value)) for value in values.ravel())
        lines += [f"{key}: !!opencv-matrix", f"   rows: {values.shape[0]}", f"   cols: {values.shape[1]}", "   dt: d"]
        lines += [f"   data: [ {cells} ]"]
    return "\n".join(lines) + "\n"
