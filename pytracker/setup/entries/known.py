"""`init --known`: what is known beforehand of a camera and an arm, in the pixels of the video that it is taken for."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any

from pytracker._core import InputError
from pytracker.formats.calibration import read_calibration, size_of
from pytracker.formats.video import probe
from pytracker.recording.schema import ArmEntry, BodyCameraEntry, CameraEntry

__all__ = ["known_of"]

KEYS = {*CameraEntry.model_fields, *BodyCameraEntry.model_fields, *ArmEntry.model_fields, "schema", "kind"}
WEAK = ("affine", "points")
OFF_MIDDLE = 0.25
"""A principal point farther off the middle, as a share of width or height, is of pictures of another size."""
PADDED_PX = 16
"""Encoders fill pictures up to whole blocks of so many pixels, or cut what is beyond: nothing is scaled then."""
ASPECT = 0.01
"""Width and height of a picture that was scaled are scaled alike, but for this."""


def known_of(path: Path | str, camera: str | None, video: Path) -> tuple[dict[str, Any], str]:
    """Keys of `[[camera]]` and `[arm]`, and in words how the camera was made one of `video`, empty where it was.

    Raises `InputError` for a file that is no calibration, a key that is none, or pictures of another shape.
    """
    known = read_calibration(path, camera)
    for key in known:
        if key not in KEYS:
            near = difflib.get_close_matches(key, KEYS, n=1, cutoff=0.5)
            hint = f", did you mean {near[0]!r}?" if near else ""
            raise InputError(f"{path}: {key} is no key of [[camera]] or [arm]{hint}")
        if key in WEAK:
            raise InputError(f"{path}: {key} is of a weak perspective, expected matrix, rotation and translation_m")
    size = size_of(path, known) or _size_of_its_video(Path(path), known)
    known.pop("size_px", None)
    if size is None or "matrix" not in known:
        _check_middle(path, known, video)
        return known, ""
    return _scaled(path, known, size, video)


def _size_of_its_video(path: Path, known: dict[str, Any]) -> tuple[int, int] | None:
    """Of a former recording's camera, where its video is still there."""
    video = known.get("video")
    if not isinstance(video, str) or not (path.parent / video).is_file():
        return None
    info = probe(path.parent / video)
    return info.width, info.height


def _check_middle(path: Path | str, known: dict[str, Any], video: Path) -> None:
    """Of a calibration that says no size. Raises `InputError` where its pictures' middle is none of the video's."""
    try:
        (_, _, cx), (_, _, cy), _ = ([float(x) for x in row] for row in known["matrix"])
    except (KeyError, TypeError, ValueError):
        return  # said where it is loaded
    info = probe(video)
    if max(abs((cx + 0.5) / info.width - 0.5), abs((cy + 0.5) / info.height - 0.5)) > OFF_MIDDLE:
        raise InputError(
            f"{path}: matrix has its principal point at ({cx:g}, {cy:g}), far from the middle of pictures of "
            f"{info.width} x {info.height} px as {video} has, expected size_px = [width, height] of the pictures it is "
            f"of (about [{2 * cx + 1:.0f}, {2 * cy + 1:.0f}], if they are whole), or one of this size"
        )


def _scaled(path: Path | str, known: dict[str, Any], size: tuple[int, int], video: Path) -> tuple[dict[str, Any], str]:
    info = probe(video)
    here = (info.width, info.height)
    if all(abs(ours - theirs) <= PADDED_PX for ours, theirs in zip(here, size, strict=True)):
        return known, ""
    across, down = here[0] / size[0], here[1] / size[1]
    if abs(across / down - 1.0) > ASPECT:
        raise InputError(
            f"{path}: is of pictures of {size[0]} x {size[1]} px, and {video} has {here[0]} x {here[1]}, expected the "
            "same, or scaled alike: was one cut or turned?"
        )
    try:
        (fx, skew, cx), (_, fy, cy), last = known["matrix"]
        matrix = [
            [across * fx, across * skew, across * (cx + 0.5) - 0.5],
            [0.0, down * fy, down * (cy + 0.5) - 0.5],
            list(last),
        ]
    except (TypeError, ValueError):
        return known, ""  # said where it is loaded
    words = f"scaled from {size[0]} x {size[1]} px, as if the whole picture was: where it was cut, calibrate anew"
    known.pop("patch_box", None)  # in the other pixels: check finds it
    return known | {"matrix": matrix}, words
