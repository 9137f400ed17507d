"""Measured joints of an arm: read, without markers that stray, and checked against the arm's lengths."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.recording.recording import Truth
from pytracker.recording.schema import ArmEntry, TruthEntry
from pytracker.recording.truth.points import load_points
from pytracker.recording.truth.strays import without_strays
from pytracker.rotation import Array

__all__ = ["load_truth"]

JOINTS = ("shoulder", "elbow", "wrist")
STRAY = 4.0
"""Times the arm's reach: no marker of it goes so far from where it usually is."""
MOST_STRAYS = 0.05
"""More such rows are no strays."""
ENOUGH_ROWS = 10
SHOULDER_M = 0.07
BENDS_M, KEEPS = 0.02, 0.5
"""An elbow whose distance from the shoulder varies by so much, and the wrist's by half as much at most, is none."""
ELBOW_SWINGS_M = 0.06
"""A shoulder that is taken to be still moves by a few centimetres."""


def load_truth(folder: Path, path: Path, entry: TruthEntry, arm: ArmEntry) -> tuple[Truth, list[str]]:
    """The file of `entry`, with at least the wrist; and what is odd about it. Raises `InputError`."""
    file = folder / entry.file
    truth, gaps = load_points(path, file, entry, JOINTS, kind="arm")
    if "wrist" not in truth.joints_m:
        raise InputError(
            f"{path}: truth.markers names {', '.join(truth.joints_m) or 'nothing'}, expected at least wrist"
        )
    joints = dict(truth.joints_m)
    strayed = _without_far_ones(file, joints, arm)
    joints, leapt = without_strays(file, truth.time_s, joints)
    strayed += leapt
    truth = dataclasses.replace(truth, joints_m=joints)
    return truth, [*strayed, *_held(file, joints["wrist"]), *_check_truth(file, truth, arm), *gaps]


def _held(file: Path, wrist: Array) -> list[str]:
    """A word where the wrist is in one place in all rows, to the last digit: nobody measured that."""
    seen = wrist[np.isfinite(wrist).all(axis=1)]
    if len(seen) < ENOUGH_ROWS or np.ptp(seen, axis=0).any():
        return []
    return [f"{file}: the wrist is at {seen[0].tolist()} m in all of its {len(seen)} rows, expected some movement"]


def _without_far_ones(file: Path, joints: dict[str, Array], arm: ArmEntry) -> list[str]:
    """Rows where a marker is far from where it usually is are gaps, not truth.

    Returns a word on each joint that has some.
    """
    warnings = []
    reach = arm.upper_arm_m + arm.forearm_m
    for joint, points in joints.items():
        usual = np.nanmedian(points, axis=0) if np.isfinite(points).any() else np.zeros(3)
        with np.errstate(invalid="ignore"):
            stray = np.linalg.norm(points - usual, axis=1) > STRAY * reach
        if not stray.any():
            continue
        first = int(np.argmax(stray))
        if stray.mean() > MOST_STRAYS:
            in_mm = float((np.linalg.norm(points - usual, axis=1) / 1000.0 > STRAY * reach).mean()) <= MOST_STRAYS
            raise InputError(
                f"{file}: {joint} is at {np.round(points[first], 3).tolist()} m in row {first + 1} of its data, and in "
                f"{int(stray.sum())} of {len(points)} rows farther than {STRAY * reach:.1f} m from its usual place, "
                f"expected {MOST_STRAYS:.0%} of them at most: "
                + (
                    "are they millimetres that the file calls metres?"
                    if in_mm
                    else "is that how gaps were written? Leave them empty"
                )
            )
        warnings.append(
            f"{file}: {joint} is at {np.round(points[first], 3).tolist()} m in row {first + 1} of its data, "
            "expected within "
            f"{STRAY * reach:.1f} m of its usual place; {int(stray.sum())} of {len(points)} rows are such and "
            "are left out"
        )
        joints[joint] = np.where(stray[:, None], np.nan, points)
    return warnings


def _exchanged(file: Path, joints: Mapping[str, Array]) -> list[str]:
    """A word where the wrist keeps its distance from the shoulder and the elbow does not: they are exchanged."""
    if "elbow" not in joints:
        return []
    elbow, wrist = (np.linalg.norm(joints[joint] - joints["shoulder"], axis=1) for joint in ("elbow", "wrist"))
    bends, keeps = float(np.nanstd(elbow)), float(np.nanstd(wrist))
    if bends < BENDS_M or keeps > KEEPS * bends:
        return []
    return [
        f"{file}: the wrist keeps its distance from the shoulder to {keeps:.3f} m (sd) and the elbow's varies by "
        f"{bends:.3f} m, expected the reverse: are wrist and elbow exchanged?"
    ]


def _check_truth(file: Path, truth: Truth, arm: ArmEntry) -> list[str]:
    """Markers that were mixed up, or are in other units, do not have the arm's lengths.

    Returns a warning where the shoulder is not where it is said to be.
    """
    shoulder = np.broadcast_to(np.array(arm.shoulder_m), (len(truth.time_s), 3))
    joints = {"shoulder": shoulder, **truth.joints_m}
    reach = arm.upper_arm_m + arm.forearm_m
    for a, b, low, high in (
        ("shoulder", "elbow", 0.6 * arm.upper_arm_m, 1.5 * arm.upper_arm_m),
        ("elbow", "wrist", 0.6 * arm.forearm_m, 1.5 * arm.forearm_m),
        ("shoulder", "wrist", 0.1 * reach, 1.2 * reach),
    ):
        if a not in joints or b not in joints:
            continue
        distance = np.linalg.norm(joints[a] - joints[b], axis=1)
        if not np.isfinite(distance).any():
            raise InputError(f"{file}: {a} and {b} are never seen together, expected some frames of truth")
        middle = float(np.nanmedian(distance))
        if not low <= middle <= high:
            raise InputError(
                f"{file}: {a} and {b} are {middle:.3f} m apart, expected {low:.2f} to {high:.2f} m by the arm's "
                "lengths: check the markers' names and units, and the world frame"
            )
    if "shoulder" in truth.joints_m:
        if exchanged := _exchanged(file, joints):
            return exchanged
        middle_m = np.nanmedian(truth.joints_m["shoulder"], axis=0)
        off = float(np.linalg.norm(middle_m - np.array(arm.shoulder_m)))
        if off > SHOULDER_M:
            return [
                f"{file}: the shoulder is at {np.round(middle_m, 3).tolist()} m (median), {off:.2f} m from shoulder_m "
                f"{list(arm.shoulder_m)}, expected at most {SHOULDER_M} m"
            ]
    elif "elbow" in truth.joints_m:
        swings = float(np.nanstd(np.linalg.norm(truth.joints_m["elbow"] - np.array(arm.shoulder_m), axis=1)))
        if swings > ELBOW_SWINGS_M:
            return [
                f"{file}: the elbow's distance from shoulder_m varies by {swings:.2f} m (sd), expected less than "
                f"{ELBOW_SWINGS_M} m: is the shoulder elsewhere?"
            ]
    return []
