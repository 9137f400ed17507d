"""A first pose that `check` found: its file says from what, so that it is told where that has changed since."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path

import numpy as np

from pytracker.recording.recording import BodyView
from pytracker.rotation import Array
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["fingerprint", "is_as_found", "is_stale", "lines_of"]

HEAD = "# Found from the first frame: bone_dof = degrees, root_t* in metres.\n"
PLACES = ("# From ", ", as ")
STAMP = "# From {inputs}, as {content}: check --write finds it again where camera, height or keypoints change.\n"
"""Fingerprints of what it was found from and of the lines that follow."""
BESIDE = "/"
FRAMES = 5
"""From so many of the keypoints' first frames it is found."""


def fingerprint(skeleton: Skeleton, view: BodyView, focal_sd: float) -> str:
    """Of what a first pose is found from: skeleton and camera, and the first keypoints where there are any."""
    camera = [np.ravel(value).tolist() for value in dataclasses.asdict(view.camera).values()]
    bones = [bone.reach_m for bone in skeleton.bones]
    seen_by = _short(json.dumps([[_rounded(np.array(row, dtype=float)) for row in (*camera, *bones)], focal_sd]))
    points = "" if view.keypoints is None else _short(json.dumps(_rounded(view.keypoints.points[:FRAMES])))
    return f"{seen_by}{BESIDE}{points}"


def lines_of(values: dict[str, float], inputs: str) -> str:
    """A file of channels, degrees and metres, and what it was found from."""
    content = "".join(f"{name} = {value}\n" for name, value in values.items())
    return HEAD + STAMP.format(inputs=inputs, content=_short(content)) + content


def is_as_found(file: Path) -> bool:
    """Whether `check` wrote the file and nobody changed it since."""
    found = _stamp(file)
    return found is not None and found[1] == found[2]


def is_stale(file: Path, inputs: str) -> bool:
    """Whether it is as it was found, from something else than `inputs`; without keypoints it is of the same ones."""
    found = _stamp(file)
    if found is None or found[1] != found[2]:
        return False
    (camera, points), (camera_now, points_now) = found[0].split(BESIDE)[:2], inputs.split(BESIDE)
    return camera != camera_now or (bool(points_now) and points != points_now)


def _stamp(file: Path) -> tuple[str, str, str] | None:
    """Of a file's inputs, of its content when it was found, and of its content now; None where it has none."""
    if not file.is_file():
        return None
    lines = file.read_text("utf-8", errors="replace").splitlines(keepends=True)
    if len(lines) < 2 or not lines[1].startswith(PLACES[0]) or PLACES[1] not in lines[1]:
        return None
    inputs, _, content = lines[1].removeprefix(PLACES[0]).partition(PLACES[1])
    if BESIDE not in inputs:
        return None
    return inputs, content.partition(":")[0], _short("".join(lines[2:]))


def _rounded(values: Array) -> list[str]:
    """As the same numbers are on every machine."""
    return [f"{value:.5g}" for value in np.ravel(values)]


def _short(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]
