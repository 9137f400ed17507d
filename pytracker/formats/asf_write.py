"""Skeletons as Acclaim files (ASF), beside the motion (AMC) that is of them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from pytracker.formats.asf import INCH_M
from pytracker.rotation import Matrix
from pytracker.skeleton.skeleton import Bone, Skeleton

__all__ = ["write_asf"]


def write_asf(path: Path | str, skeleton: Skeleton) -> None:
    """Write a skeleton, in its own units, as `read_asf` and any Acclaim reader read it."""
    turn = math.pi / 180 if skeleton.in_degrees else 1.0
    lines = [
        "# written by pytracker", ":version 1.10", ":name pytracker", ":units", "  mass 1.0",
        f"  length {INCH_M / skeleton.unit_m:.9g}", f"  angle {'deg' if skeleton.in_degrees else 'rad'}",
        ":documentation", "  the skeleton that was tracked",
        *_root(skeleton.bones[0], turn), ":bonedata",
    ]  # fmt: skip
    for number, bone in enumerate(skeleton.bones[1:], 1):
        lines += _bone(number, bone, skeleton.unit_m, turn)
    lines += [":hierarchy", "  begin"]
    for parent, bone in enumerate(skeleton.bones):
        children = [child.name for child in skeleton.bones if child.parent == parent]
        if children:
            lines.append(f"    {bone.name} {' '.join(children)}")
    Path(path).write_text("\n".join([*lines, "  end", ""]), "latin-1", newline="\n")


def _root(root: Bone, turn: float) -> list[str]:
    return [
        ":root", f"  order {' '.join(root.channels).upper()}", f"  axis {_letters(root)}", "  position 0 0 0",
        f"  orientation {_numbers(np.array(_angles(root.frame, root.order)) / turn)}",
    ]  # fmt: skip


def _bone(number: int, bone: Bone, unit_m: float, turn: float) -> list[str]:
    length_m = float(np.linalg.norm(bone.reach_m))
    along = np.array(bone.reach_m) / length_m if length_m > 0 else np.array([0.0, 1.0, 0.0])
    lines = [
        "  begin", f"    id {number}", f"    name {bone.name}", f"    direction {_numbers(along)}",
        f"    length {_numbers([length_m / unit_m])}",
        f"    axis {_numbers(np.array(_angles(bone.frame, bone.order)) / turn)} {_letters(bone)}",
    ]  # fmt: skip
    if bone.channels:
        lines.append(f"    dof {' '.join(bone.channels)}")
        pairs = [f"({_numbers([low / turn, high / turn])})" for low, high in bone.limits_rad]
        lines += [f"    limits {pairs[0]}", *(f"           {pair}" for pair in pairs[1:])]
    return [*lines, "  end"]


def _angles(frame: Matrix, order: tuple[int, int, int]) -> tuple[float, float, float]:
    """About x, y and z, rad, which turn into `frame` one after the other in that order."""
    m, (i, j, k) = np.array(frame), order
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    middle = math.asin(float(np.clip(-sign * m[k, i], -1.0, 1.0)))
    if abs(math.cos(middle)) > 1e-9:
        first, last = math.atan2(sign * m[k, j], m[k, k]), math.atan2(sign * m[j, i], m[i, i])
    else:  # first and last turn about the same axis: one of them is enough
        first, last = 0.0, math.atan2(-sign * m[i, j], m[j, j])
    angles = {i: first, j: middle, k: last}
    return angles[0], angles[1], angles[2]


def _letters(bone: Bone) -> str:
    return "".join("XYZ"[axis] for axis in bone.order)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value + 0.0:.12g}" for value in values)
