"""Rows of a truth in which a joint is where no arm or trunk reaches: a marker that leapt, was exchanged, or filled in.

Bones keep their lengths. Where all that hang on a joint are far longer or shorter than usual, it was not measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pytracker.rotation import Array

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
ENOUGH = 10
"""Of fewer rows nothing is usual."""


def without_strays(file: Path, joints: Mapping[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """Joints, world, m `(T, 3)` each, NaN in rows where they stray; and a word on each that has such rows."""
    odd = {joint: np.full(len(points), True) for joint, points in joints.items()}
    has_bones: set[str] = set()
    for a, b in BONES:
        if a not in joints or b not in joints:
            continue
        apart = np.linalg.norm(joints[a] - joints[b], axis=1)
        if np.isfinite(apart).sum() < ENOUGH:
            continue
        share = apart / np.nanmedian(apart)
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
