"""Cameras that others have calibrated, in our terms.

| file | whose |
|---|---|
| TOML, a table a camera with `matrix`, `distortions`, `rotation`, `translation` | Pose2Sim, AniPose, Caliscope |
| XML, `<camera>` with `<transform>` and `<intrinsic>` | Qualisys Track Manager |
| YAML, XML of matrices called `camera_matrix`, `distortion_coefficients`, ... | OpenCV's FileStorage, ROS |
| TOML with `matrix` at its top, or `[[camera]]` and `[arm]` of a recording.toml | ours |
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from pytracker._core import InputError
from pytracker.formats.opencv_storage import matrices_of, picture_size
from pytracker.formats.text import read_lines
from pytracker.formats.toml_file import parse_toml
from pytracker.rotation import Array, rotate, rotation_vector_to_quaternion

__all__ = ["read_calibration", "size_of"]

QUALISYS_PX = 64.0
"""Qualisys counts in so many parts of a pixel, and in millimetres; its camera looks along -z, with y up."""
OVER = np.diag([1.0, -1.0, -1.0])

OPENCV_SECOND = ("m2", "d2", "k2", "camera_matrix_2", "cameramatrix2")
DISTORTIONS = ("distortions", "distortion", "dist_coeffs", "distortion_coefficients")
OF_VIDEO = ("patch_box", "patches", "start_s", "keypoints", "keypoint_model", "background")
"""What a recording.toml says of a camera's video; another begins otherwise."""
FARTHEST_M = 50.0
"""No camera of a room is farther from its world; one that was calibrated in millimetres is."""
TURN_RAD = 2 * np.pi
"""No rotation vector turns farther."""
OPENCV_MATRIX = ("cameramatrix", "k", "mtx", "m1", "intrinsic", "intrinsicmatrix")
OPENCV_OTHERS = (
    ("distortioncoefficients", "distortioncoeffs", "distortion", "distcoeffs", "dist", "d", "d1"),
    ("r", "rvec", "rotation", "rotationmatrix"),
    ("t", "tvec", "translation", "translationvector"),
)
"""What matrices of OpenCV are called, without underscores: intrinsics; distortion, rotation, translation."""


def read_calibration(path: Path | str, camera: str | None = None) -> dict[str, Any]:
    """The keys of `[[camera]]` that it has, and whatever else stands in a file of ours; `size_px` where it says which.

    `camera` names one of several, of a recording.toml its number. Raises `InputError` for a file that is none of these,
    a camera that is not there, or values that are no numbers, or no metres.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: there is no such file")
    if path.suffix.lower() in (".toml", ".tml"):
        data = parse_toml(path)
        if (former := _recorded(data)) is not None:
            return {**_chosen(path, former, camera), **(data["arm"] if isinstance(data.get("arm"), dict) else {})}
        tables = [(str(name), table) for name, table in _tables(data) if "matrix" in table]
        if tables:
            return _of_toml(path, _chosen(path, tables, camera))
        if camera is not None:
            raise InputError(f"{path}: holds one camera without a name, and {camera!r} is named, expected none")
        return data
    text = "\n".join(read_lines(path))
    matrices = matrices_of(path, text)
    return _of_opencv(path, matrices, picture_size(text, matrices)) if matrices else _of_qualisys(path, text, camera)


def size_of(path: Path | str, known: Mapping[str, Any]) -> tuple[int, int] | None:
    """Width and height of the pictures that a calibration is of, px; None where it does not say.

    Raises `InputError` where it says something else there.
    """
    match known.get("size_px"):
        case None:
            return None
        case [int() | float() as width, int() | float() as height] if 1 <= width < 1e5 and 1 <= height < 1e5:
            return round(width), round(height)
    raise InputError(f"{path}: size_px is {str(known['size_px'])[:80]}, expected width and height, px")


def _tables(data: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Cameras stand at the top, or in a table of their own."""
    inner = data.get("cameras") if isinstance(data.get("cameras"), dict) else data
    assert isinstance(inner, dict)
    return [(str(table.get("name", name)), table) for name, table in inner.items() if isinstance(table, dict)]


def _chosen(path: Path, cameras: list[tuple[str, Any]], camera: str | None) -> Any:
    names = [name for name, _ in cameras]
    if camera is None and len(cameras) == 1:
        return cameras[0][1]
    if camera is None or names.count(camera) != 1:
        said = "none is named" if camera is None else f"{camera!r} is named"
        raise InputError(
            f"{path}: holds the cameras {', '.join(names)[:300]}, and {said}, expected one of them (--camera NAME)"
        )
    return dict(cameras)[camera]


def _recorded(data: dict[str, Any]) -> list[tuple[str, Any]] | None:
    """The cameras of a recording.toml by number, without what is of their video alone; None where it is none."""
    tables = data.get("camera")
    tables = [tables] if isinstance(tables, dict) and "matrix" in tables else tables
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        return None
    return [(str(k), {key: of for key, of in table.items() if key not in OF_VIDEO}) for k, table in enumerate(tables)]


def _numbers(path: Path, what: str, value: object, *shapes: tuple[int, ...]) -> Array:
    try:
        found = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape not in shapes or not np.isfinite(found).all():
        expected = " or ".join(" x ".join(map(str, shape)) for shape in shapes)
        raise InputError(f"{path}: {what} is {str(value)[:80]}, expected {expected} numbers")
    return found


def _of_toml(path: Path, table: dict[str, Any]) -> dict[str, Any]:
    if table.get("fisheye"):
        raise InputError(f"{path}: the camera is a fisheye, expected one with OpenCV's five distortions")
    found: dict[str, Any] = {"matrix": _numbers(path, "matrix", table["matrix"], (3, 3)).tolist()}
    distortion = next((table[name] for name in DISTORTIONS if name in table), None)
    if distortion is not None:
        given = _numbers(path, "distortions", distortion, (4,), (5,))
        found["distortion"] = [*given.tolist(), *[0.0] * (5 - len(given))]
    translation = table.get("translation", table.get("translation_m"))
    if "rotation" in table and translation is not None:
        rotation = _numbers(path, "rotation", table["rotation"], (3,), (3, 3))
        if rotation.ndim == 1:
            turn = float(np.linalg.norm(rotation))
            if turn > TURN_RAD:
                raise InputError(
                    f"{path}: the camera's rotation vector is {turn:.4g} long, expected radians, {TURN_RAD:.4g} at "
                    "most: are they degrees?"
                )
            rotation = np.stack([rotate(rotation_vector_to_quaternion(rotation), axis) for axis in np.eye(3)], axis=1)
        found["rotation"] = rotation.tolist()
        found["translation_m"] = _numbers(path, "translation", translation, (3,)).tolist()
        far = float(np.linalg.norm(found["translation_m"]))
        if far > FARTHEST_M:
            raise InputError(
                f"{path}: the camera's translation is {far:.4g} long, expected metres, {FARTHEST_M:g} at most"
            )
    if "size" in table:
        found["size_px"] = [round(side) for side in _numbers(path, "size", table["size"], (2,)).tolist()]
    return found


def _of_opencv(path: Path, matrices: dict[str, Array], size_px: tuple[int, int] | None) -> dict[str, Any]:
    def named(names: tuple[str, ...]) -> Array | None:
        found = [name for name in matrices if name.lower().replace("_", "") in names]
        if len(found) > 1:
            raise InputError(f"{path}: has {' and '.join(found)}, expected one of them: a file of one camera")
        return matrices[found[0]] if found else None

    second = [name for name in matrices if name.lower() in OPENCV_SECOND]
    if second:
        raise InputError(f"{path}: has {second[0]}, of a second camera, expected a file of one")

    matrix = named(OPENCV_MATRIX)
    if matrix is None:
        raise InputError(f"{path}: holds {', '.join(matrices)[:200]}, expected camera_matrix")
    table: dict[str, Any] = {"matrix": matrix.tolist()}
    distortion, rotation, translation = (named(names) for names in OPENCV_OTHERS)
    if distortion is not None:
        more = distortion.ravel()[5:]
        if more.any():
            raise InputError(
                f"{path}: has {distortion.size} distortions, {more.tolist()} beyond the fifth, expected k1 k2 p1 p2 k3 "
                "alone: calibrate without the rational model"
            )
        table["distortions"] = distortion.ravel()[:5].tolist()
    if rotation is not None and translation is not None:
        table["rotation"] = (rotation if rotation.shape == (3, 3) else rotation.ravel()).tolist()
        table["translation"] = translation.ravel().tolist()
    if size_px is not None:
        table["size"] = list(size_px)
    return _of_toml(path, table)


def _of_qualisys(path: Path, text: str, camera: str | None) -> dict[str, Any]:
    try:
        root = ElementTree.fromstring(text.encode())  # noqa: S314 - a file of the user's own
    except (ElementTree.ParseError, ValueError, LookupError):
        raise InputError(
            f"{path}: is no calibration that is known, expected TOML (Pose2Sim, AniPose, Caliscope), YAML or XML of "
            "OpenCV or ROS (each matrix with rows, cols and data), or XML of Qualisys"
        ) from None
    cameras = [(str(of.get("serial", k)), of) for k, of in enumerate(root.iter("camera"))]
    if not cameras:
        raise InputError(f"{path}: has no <camera>, expected a calibration of Qualisys")
    chosen = _chosen(path, cameras, camera)
    transform, intrinsic = chosen.find("transform"), chosen.find("intrinsic")
    if transform is None or intrinsic is None:
        raise InputError(f"{path}: the camera has no <transform> or no <intrinsic>, expected both")

    def of(element: ElementTree.Element, *names: str) -> Array:
        return _numbers(path, ", ".join(names), [element.get(name) for name in names], (len(names),))

    fx, fy, cx, cy = of(intrinsic, "focalLengthU", "focalLengthV", "centerPointU", "centerPointV") / QUALISYS_PX
    rows = [of(transform, *(f"r{r}{c}" for c in (1, 2, 3))) for r in (1, 2, 3)]
    rotation = OVER @ np.array(rows)
    centre = of(transform, "x", "y", "z") / 1000.0
    k1, k2, p1, p2 = of(
        intrinsic, "radialDistortion1", "radialDistortion2", "tangentalDistortion1", "tangentalDistortion2"
    )
    found: dict[str, Any] = {
        "matrix": [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]],
        "distortion": [float(k1), float(k2), float(p1), float(p2), float(intrinsic.get("radialDistortion3", 0.0))],
        "rotation": rotation.tolist(),
        "translation_m": (-rotation @ centre).tolist(),
    }
    if intrinsic.get("sensorMaxU") is not None:
        ends = of(intrinsic, "sensorMaxU", "sensorMaxV")
        found["size_px"] = [round(end / QUALISYS_PX) + 1 for end in ends]
    return found
