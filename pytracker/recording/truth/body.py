"""Measured joints of a body: read, checked against the skeleton's lengths and the first pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from pytracker._core import KEY_JOINTS, InputError
from pytracker.formats.amc import read_amc
from pytracker.recording.body_view import end_of
from pytracker.recording.recording import BodyView, Truth
from pytracker.recording.schema import TruthEntry
from pytracker.recording.truth.points import POINT_FORMATS, load_points, uncovered, uncovered_between
from pytracker.recording.truth.strays import without_strays
from pytracker.recording.upright import TO_Y, to_up
from pytracker.rotation import Array
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["beside_first_pose", "load_truth", "uncovered_by_truth"]

SHOULDERS = ("left_shoulder", "right_shoulder")
BONES = (
    *((f"{side}_shoulder", f"{side}_elbow") for side in ("left", "right")),
    *((f"{side}_elbow", f"{side}_wrist") for side in ("left", "right")),
    SHOULDERS,
    ("root", "head"),
)
"""Pairs of joints whose distance the skeleton says."""
LENGTHS = (0.6, 1.5)
"""Times the skeleton's, where joints are joints and metres are metres."""
ALIKE = (0.88, 1.14)
"""The median of all, of people whose height is known: 0.95 to 1.02 on clips of two."""
NEAR_S = 0.25
"""The truth's first frame with joints is the video's first, where it lies so near."""
PLACE_M = 0.3
SHAPE_M = 0.2
"""How far the first pose's joints may lie from the truth's, and how far once its middle is put on theirs (medians)."""
ENOUGH = 3
"""Joints that have a shape; bones that have a scale."""


def load_truth(
    folder: Path, path: Path, entry: TruthEntry, skeleton: Skeleton
) -> tuple[Truth, Array | None, tuple[str, ...]]:
    """Joints, and poses where the file has them; and what is odd about it. Raises `InputError`."""
    file = folder / entry.file
    suffix = file.suffix.lower()
    if suffix not in (".amc", *POINT_FORMATS):
        expected = f"an .amc motion, or points: {', '.join(POINT_FORMATS)}"
        raise InputError(f"{path}: truth.file is {entry.file!r}, expected {expected}")
    if suffix != ".amc":
        truth, unseen = load_points(path, file, entry, KEY_JOINTS, kind="body")
        joints, strayed = without_strays(file, truth.time_s, truth.joints_m)
        truth = replace(truth, joints_m=joints)
        return truth, None, (*unseen, *strayed, *_check_lengths(file, truth, skeleton))
    idle = sorted({"markers", "up"} & entry.model_fields_set)
    if idle:
        raise InputError(f"{path}: truth.{idle[0]} goes with a file of markers, not with an .amc motion")
    if entry.rate_hz is None:
        raise InputError(
            f"{path}: truth.rate_hz is missing, expected the rate of {entry.file}, which has none (CMU: 120)"
        )
    motion = read_amc(file, skeleton)
    # By the frames' own numbers: where some are missing the others stay at their times.
    time_s = (motion.numbers - motion.numbers[0]) / entry.rate_hz + entry.offset_s
    steps = np.diff(motion.numbers)
    gaps = [int(k) for k in np.flatnonzero(steps > np.median(steps))] if len(steps) > 1 else []
    warnings = [
        f"{file}: frame {motion.numbers[k + 1]} follows frame {motion.numbers[k]}; what lies between is not scored"
        for k in gaps
    ]
    truth = Truth(time_s=time_s, joints_m=skeleton.joints(motion.poses))
    return truth, motion.poses, (*motion.warnings, *warnings)


def uncovered_by_truth(file: Path, truth: Truth, view: BodyView) -> tuple[str, ...]:
    """A word where the truth of `file` covers only a part of the frames. Raises `InputError` where it covers none."""
    if view.video is not None:
        return uncovered(file, truth, view.video, view.start_s)
    return uncovered_between(file, truth, "the keypoints", view.start_s, end_of(view))


def _check_lengths(file: Path, truth: Truth, skeleton: Skeleton) -> tuple[str, ...]:
    """Points that were mixed up, or are in other units, do not have its lengths; a word where all are off alike."""
    longer = []
    still = skeleton.joints(np.zeros((1, len(skeleton.channels))))
    for a, b in BONES:
        if a not in truth.joints_m or b not in truth.joints_m:
            continue
        apart = np.linalg.norm(truth.joints_m[a] - truth.joints_m[b], axis=1)
        if not np.isfinite(apart).any():
            continue
        length = float(np.linalg.norm(still[a] - still[b]))
        low, high = (share * length for share in LENGTHS)
        middle = float(np.nanmedian(apart))
        if not low <= middle <= high:
            collar = " (collar bones begin at the neck)" if (a, b) == SHOULDERS else ""
            raise InputError(
                f"{file}: {a} and {b} are {middle:.3g} m apart (median), expected {low:.2f} to {high:.2f} m by the "
                f"skeleton: check the markers' names{collar}, the file's units, and the skeleton"
            )
        longer.append(middle / length)
    scale = float(np.median(longer)) if len(longer) >= ENOUGH else 1.0
    if ALIKE[0] <= scale <= ALIKE[1]:
        return ()
    words = (
        f"{file}: its bones are {scale:.2f} times as long as the skeleton's (median of {len(longer)}), expected "
        f"{ALIKE[0]:g} to {ALIKE[1]:g}: check how it was calibrated, and height_m"
    )
    return (words,)


def beside_first_pose(
    file: Path, truth: Truth, first: Mapping[str, Array], view: BodyView, *, distance_sd_m: float, up: str
) -> tuple[str, ...]:
    """A word where the truth's joints are elsewhere than those of the first pose, `(1, 3)` each, in the first frame.

    `distance_sd_m` is how well that one's distance from the camera is known, `up` the axis that is up in the file.
    """
    names = [name for name in first if name in truth.joints_m]
    rows = np.stack([truth.joints_m[name] for name in names], axis=1)
    near = (np.abs(truth.time_s - view.start_s) <= NEAR_S) & np.isfinite(rows).all(axis=(1, 2))
    if not near.any():
        return ()
    theirs = rows[int(np.argmax(near))]
    ours = np.stack([first[name][0] for name in names])
    off, askew = _medians(ours, theirs)
    if off <= PLACE_M + 2 * distance_sd_m and (askew <= SHAPE_M or len(names) < ENOUGH):
        return ()
    words = (
        f"{file}: in the first frame its joints are {off:.2f} m from those of the first pose (median), {askew:.2f} m "
        f"once both are put on each other, expected at most {PLACE_M + 2 * distance_sd_m:.2f} and {SHAPE_M:.2f} m: "
        "check truth.up, truth.offset_s, the camera's world and the first pose"
    )
    as_read = theirs @ to_up(up, "y")
    others = [other for other in TO_Y if _medians(ours, as_read @ to_up(other, "y").T)[1] <= SHAPE_M / 2]
    if others and askew > SHAPE_M and len(names) >= ENOUGH:
        words += f'; with truth.up = "{others[0]}" they would fit'
    return (words,)


def _medians(ours: Array, theirs: Array) -> tuple[float, float]:
    """Between joints `(J, 3)`, m: as they are, and with their middles put on each other."""
    apart = ours - theirs
    return (
        float(np.median(np.linalg.norm(apart, axis=1))),
        float(np.median(np.linalg.norm(apart - apart.mean(axis=0), axis=1))),
    )
