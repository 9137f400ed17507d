"""Rows of a truth in which a joint is where no arm reaches, or where another is: markers leap, and are exchanged.

Bones keep their lengths. Where all that hang on a joint are far longer or shorter than usual, it was not measured. And
two joints that from one row to the next stand in each other's place have exchanged their names.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker.rotation import Array
from pytracker.series import runs

__all__ = ["without_strays"]

BONES = (
    *((f"{side}shoulder", f"{side}elbow") for side in ("", "left_", "right_")),
    *((f"{side}elbow", f"{side}wrist") for side in ("", "left_", "right_")),
    ("left_shoulder", "right_shoulder"),
    *((end, f"{side}_shoulder") for end in ("root", "head") for side in ("left", "right")),
    ("root", "head"),
)
"""Pairs of joints, of an arm and of a body, whose distance changes little."""
LENGTHS = (0.5, 1.5)
"""Times the usual: without markers of their own people's have 0.66 to 1.3, with them, and simulated, 0.93 to 1.05."""
PAIRS = (
    *((f"{side}elbow", f"{side}wrist") for side in ("", "left_", "right_")),
    *((f"left_{joint}", f"right_{joint}") for joint in ("shoulder", "elbow", "wrist")),
)
"""Joints that are taken for each other."""
LEAP_M, BACK = 0.1, 0.25
"""Both together go so far from a row to the next, and with their names exchanged by no more than this share of it."""
ENOUGH = 10
"""Of fewer rows nothing is usual."""


def without_strays(file: Path, time_s: Array, joints: Mapping[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """Joints, world, m `(T, 3)` each, NaN in rows where they stray or are exchanged; and a word on each such."""
    kept, said = _without_exchanged(file, time_s, joints)
    strayed, words = _without_leaps(file, kept)
    return strayed, [*said, *words]


def _without_exchanged(file: Path, time_s: Array, joints: Mapping[str, Array]) -> tuple[dict[str, Array], list[str]]:
    kept, said = dict(joints), []
    for a, b in PAIRS:
        if a not in joints or b not in joints:
            continue
        odd = _exchanged(joints[a], joints[b])
        if not odd.any():
            continue
        for joint in (a, b):
            kept[joint] = np.where(odd[:, None], np.nan, kept[joint])
        first, end = max(runs(odd), key=lambda run: run[1] - run[0])
        said.append(
            f"{file}: {a} and {b} stand in each other's place in {int(odd.sum())} of {len(odd)} rows, longest from "
            f"{time_s[first]:.3f} to {time_s[end - 1]:.3f} s, as if exchanged: left out"
        )
    return kept, said


def _exchanged(a: Array, b: Array) -> NDArray[np.bool_]:
    """In which rows `(T,)` two joints are exchanged: in the fewer of those between which they change places."""
    known = np.flatnonzero(np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1))
    odd = np.zeros(len(a), dtype=bool)
    if len(known) < ENOUGH:
        return odd
    a, b = a[known], b[known]
    stay, exchange = (
        np.linalg.norm(to_a[1:] - a[:-1], axis=1) + np.linalg.norm(to_b[1:] - b[:-1], axis=1)
        for to_a, to_b in ((a, b), (b, a))
    )
    changes = (stay > LEAP_M) & (exchange < BACK * stay)
    side = np.concatenate([[0], np.cumsum(changes)]) % 2
    odd[known] = side == (1 if side.mean() <= 0.5 else 0)
    return odd if changes.any() else np.zeros_like(odd)


def _without_leaps(file: Path, joints: Mapping[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """Without rows in which all bones of a joint are of odd lengths."""
    odd = {joint: np.full(len(points), True) for joint, points in joints.items()}
    has_bones: set[str] = set()
    for a, b in BONES:
        if a not in joints or b not in joints:
            continue
        apart = np.linalg.norm(joints[a] - joints[b], axis=1)
        if np.isfinite(apart).sum() < ENOUGH:
            continue
        share = apart / max(float(np.nanmedian(apart)), 1e-9)
        for joint in (a, b):
            # A length that is not known says nothing against a joint.
            odd[joint] &= (share < LENGTHS[0]) | (share > LENGTHS[1])
            has_bones.add(joint)
    kept, said = dict(joints), []
    for joint in sorted(has_bones):
        if not odd[joint].any():
            continue
        kept[joint] = np.where(odd[joint][:, None], np.nan, joints[joint])
        first = int(np.argmax(odd[joint]))
        at = np.round(joints[joint][first], 3).tolist()
        said.append(
            f"{file}: {joint} is at {at} m in row {first + 1} of its data, where its distance to its neighbours is "
            f"less than {LENGTHS[0]:g} or more than {LENGTHS[1]:g} times the usual; "
            f"{int(odd[joint].sum())} of {len(odd[joint])} rows are such and are left out"
        )
    return kept, said
