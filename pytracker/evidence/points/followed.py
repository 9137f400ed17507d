"""Whose keypoints are whose: of several people the one who is tracked, left and right as that person has them.

Detectors take the left arm for the right from one frame to the next, and files of mirrored videos do so throughout. The
core decides the same for its particles (`rust/body/cues/keypoints.rs`); here it is asked of what came out.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker._core import KEYPOINTS
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["ARMS", "EXCHANGED", "LIMBS", "followed", "limbs_off_m"]

ARMS = ("left_elbow", "left_wrist", "right_elbow", "right_wrist")
LIMBS = (*ARMS, "left_shoulder", "right_shoulder")
"""Joints that every detector means alike; heads and hips it does not."""
_AT = [KEYPOINTS.index(name) for name in LIMBS]
_OTHER = {"left": "right", "right": "left"}
EXCHANGED = [KEYPOINTS.index("_".join(_OTHER.get(word, word) for word in name.split("_"))) for name in KEYPOINTS]
"""Of every keypoint the one that it is where left and right are exchanged."""
THERE_M = 0.15
"""Exchanged points that are taken for a person's lie so near, most of them, and nearer by `NEARER_M` than they came."""
NEARER_M = 0.10


def limbs_off_m(camera: Camera | WeakPerspective, joints: Mapping[str, Array], people: Array) -> Array:
    """How far the points of everyone `(P, 9, 3)`, px, lie from `LIMBS` across the picture `(P, 6)`, m; NaN if not seen.

    `joints` are `(3,)` each, world, m.
    """
    places = np.stack([joints[name] for name in LIMBS])
    apart = np.linalg.norm(people[:, _AT, :2] - camera.project(places), axis=2)
    return np.asarray(apart / camera.px_per_m(places))


def followed(
    camera: Camera | WeakPerspective, joints: Mapping[str, Array], people: Array | None
) -> tuple[Array | None, bool]:
    """Points `(9, 3)` of who is tracked, and whether their left and right had to be exchanged; None where nobody is.

    Args:
        camera: what sees them.
        joints: what was tracked, `(3,)` each, world, m.
        people: u, v and standard deviation, px, of everyone `(P, 9, 3)`.
    """
    if people is None or not len(people):
        return None, False
    as_came, other = (_medians(limbs_off_m(camera, joints, way)) for way in (people, people[:, EXCHANGED]))
    nearest, exchanged = int(np.argmin(as_came)), int(np.argmin(other))
    if other[exchanged] < min(THERE_M, as_came[nearest] - NEARER_M):
        return people[exchanged][EXCHANGED], True
    return people[nearest], False


def _medians(rows: Array) -> Array:
    """Row by row, of what is known, as one point may be wild; infinite where nothing is."""
    return np.array([float(np.nanmedian(row)) if np.isfinite(row).any() else np.inf for row in rows])
