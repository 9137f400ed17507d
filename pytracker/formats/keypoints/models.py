"""Orders in which pose estimators list their joints, by name; from the estimators' own documentation."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.rotation import Array

__all__ = ["COCO", "MODELS", "model_of", "name_of"]

FACE = ("nose", "left_eye", "right_eye", "left_ear", "right_ear")


def _pairs(*joints: str) -> tuple[str, ...]:
    """Left and right of each."""
    return tuple(f"{side}_{joint}" for joint in joints for side in ("left", "right"))


COCO = (*FACE, *_pairs("shoulder", "elbow", "wrist", "hip", "knee", "ankle"))
RIGHT_ARM, LEFT_ARM = (tuple(f"{side}_{j}" for j in ("shoulder", "elbow", "wrist")) for side in ("right", "left"))
RIGHT_LEG, LEFT_LEG = (tuple(f"{side}_{j}" for j in ("hip", "knee", "ankle")) for side in ("right", "left"))
FEET = tuple(f"{side}_{toe}" for side in ("left", "right") for toe in ("big_toe", "small_toe", "heel"))
OPENPOSE_FACE = ("right_eye", "left_eye", "right_ear", "left_ear")

OTHERS = tuple(f"other_{k}" for k in range(110))
"""Of faces and hands."""
HALPE = (*COCO, "head_top", "neck", "hip", *_pairs("big_toe", "small_toe", "heel"))
BODY_25B = (*COCO, "neck", "head_top", *FEET)

MODELS: dict[str, tuple[str, ...]] = {
    "coco_17": COCO,
    "halpe_26": HALPE,
    "halpe_136": (*HALPE, *OTHERS),
    "body_25": ("nose", "neck", *RIGHT_ARM, *LEFT_ARM, "hip", *RIGHT_LEG, *LEFT_LEG, *OPENPOSE_FACE, *FEET),
    "body_25b": BODY_25B,
    "body_135": (*BODY_25B, *OTHERS),
    "coco_18": ("nose", "neck", *RIGHT_ARM, *LEFT_ARM, *RIGHT_LEG, *LEFT_LEG, *OPENPOSE_FACE),
    "coco_133": (*COCO, *FEET, *OTHERS),
    "blazepose_33": (
        "nose", *(f"{side}_eye{part}" for side in ("left", "right") for part in ("_inner", "", "_outer")),
        *_pairs("ear", "mouth", "shoulder", "elbow", "wrist", "pinky", "index", "thumb", "hip", "knee", "ankle", "heel",
                "foot_index"),
    ),
    "ours": ("head", *_pairs("shoulder", "elbow", "wrist", "hip")),
}  # fmt: skip
"""By the name that `keypoint_model` knows them by."""

SIDES = {"l": "left", "r": "right", "left": "left", "right": "right"}
JOINTS = ("shoulder", "elbow", "wrist", "hip", "ear", "eye", "knee", "ankle")


def name_of(words: str) -> str:
    """`LShoulder`, `shoulder_left`, `R.Wrist`, `LEFT_EAR`: our name of it; what is none of ours with `other_`."""
    plain = re.sub(r"[^a-z]", "", words.lower())
    for joint in JOINTS:
        if joint in plain:
            side = SIDES.get(plain.replace(joint, "", 1))
            return f"{side}_{joint}" if side else plain
    return plain if plain in ("nose", "head", "neck") else f"other_{plain}"


def model_of(path: Path, model: str, count: int, people: Sequence[Array]) -> tuple[str, ...]:
    """The order of `count` joints; two of 25 are told apart by where the neck is. Raises `InputError`."""
    if model != "auto":
        if model not in MODELS:
            raise InputError(f"keypoint_model {model!r} is not known, expected auto or one of: {', '.join(MODELS)}")
        if len(MODELS[model]) != count:
            raise InputError(f"{path}: people have {count} keypoints, expected {len(MODELS[model])} as {model} has")
        return MODELS[model]
    fitting = [name for name, order in MODELS.items() if len(order) == count]
    if not fitting:
        known = ", ".join(str(k) for k in sorted({len(order) for order in MODELS.values()}))
        raise InputError(
            f"{path}: people have {count} keypoints, expected {known} (keypoint_model: {', '.join(MODELS)})"
        )
    if len(fitting) == 1:
        return MODELS[fitting[0]]
    return MODELS[min(fitting, key=lambda name: _neck_off(MODELS[name], people))]


def _neck_off(order: Sequence[str], people: Sequence[Array]) -> float:
    """How far the neck is from the middle of the shoulders, in their widths: little where the order is right."""
    neck, left, right = (order.index(name) for name in ("neck", "left_shoulder", "right_shoulder"))
    known = [p[:, :2] for p in people if (p[[neck, left, right], 2] > 0).all()]
    if not known:
        return np.inf
    p = np.stack(known)
    width = np.linalg.norm(p[:, left] - p[:, right], axis=1)
    off = np.linalg.norm(p[:, neck] - 0.5 * (p[:, left] + p[:, right]), axis=1)
    return float(np.median(off / np.maximum(width, 1e-9)))
