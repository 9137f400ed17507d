"""A second sensor, on the upper arm: read, and turned to the world."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.recording.imu import load_imu
from pytracker.recording.recording import Arm, Imu
from pytracker.recording.schema import ImuEntry
from pytracker.recording.worn import MOST_LATE_S, MOST_OFF_DEG, heading_between
from pytracker.rotation import multiply, rotate, rotation_vector_to_quaternion

__all__ = ["upper_arm_imu"]

UP, ALONG = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
SLACK_S = 0.1
"""Two sensors may begin and end so far apart without a word."""


def upper_arm_imu(
    folder: Path, place: str, entry: ImuEntry, arm: Arm, forearm: Imu, first_s: float
) -> tuple[Imu, tuple[str, ...]]:
    """What `entry`, at `place` of the file, says, and what is odd about it.

    Where its heading is not given it is taken from the arm at the first frame. Raises `InputError` where that shows no
    heading, or contradicts the sensor. What begins later is used from then on.
    """
    segment = f"{arm.side}_upper_arm"
    if entry.segment != segment:
        raise InputError(f"{place}.segment is {entry.segment!r}, expected {segment!r}: the forearm has a sensor")
    imu, warnings = load_imu(folder, place, entry, (segment,), needs_heading=False)
    begin_s = max(first_s, forearm.time_s[0])
    late_s = imu.time_s[0] - begin_s
    if imu.time_s[-1] < begin_s or (entry.heading_deg is None and late_s > MOST_LATE_S):
        how = "" if imu.time_s[-1] < begin_s else f" to {MOST_LATE_S:g} s later, to tell its heading, or heading_deg"
        raise InputError(
            f"{place} covers {imu.time_s[0]:.3f} to {imu.time_s[-1]:.3f} s of recording time, expected it to cover the "
            f"first frame at {begin_s:.3f} s{how}: check offset_s"
        )
    fore, at = (max(int(np.searchsorted(of.time_s, begin_s, "right")) - 1, 0) for of in (forearm, imu))
    elbow = np.array(arm.wrist_start_m) + rotate(forearm.q_world_segment[fore], ALONG) * arm.forearm_m
    wanted = (np.array(arm.shoulder_m) - elbow) / np.linalg.norm(np.array(arm.shoulder_m) - elbow)
    q = imu.q_world_segment
    if entry.heading_deg is None:
        found = rotate(q[at], ALONG)
        turn = heading_between(f"{place}.heading_deg", segment, wanted[:2], found[:2])
        q = np.ascontiguousarray(multiply(rotation_vector_to_quaternion(turn * UP)[None], q))
    off = np.degrees(np.arccos(np.clip(wanted @ rotate(q[at], ALONG), -1.0, 1.0)))
    if off > MOST_OFF_DEG and late_s <= MOST_LATE_S:
        raise InputError(
            f"{place}: at the first frame the upper arm points {off:.0f}° away from where wrist and shoulder have it, "
            f"expected at most {MOST_OFF_DEG:.0f}°: check mount, heading_deg, offset_s and wrist_start_m"
        )
    if late_s > SLACK_S:
        words = f"{folder / entry.file}: begins {late_s:.3f} s after the forearm's and the first frame; the frames"
        warnings = (*warnings, f"{words} before are tracked without it")
    if imu.time_s[-1] < forearm.time_s[-1] - SLACK_S:
        words = (
            f"{folder / entry.file}: ends {forearm.time_s[-1] - imu.time_s[-1]:.3f} s before the forearm's; the frames "
            "after are tracked without it"
        )
        warnings = (*warnings, words)
    return dataclasses.replace(imu, q_world_segment=q), warnings
