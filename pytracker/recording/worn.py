"""Sensors on a body's arms, turned to the body's world and to its first pose.

The heading of a sensor that has no true north, and what "no roll" is for it, are taken from the first pose.
"""

from __future__ import annotations

import numpy as np

from pytracker._core import InputError
from pytracker.recording.recording import Imu
from pytracker.rotation import Array, matrix_to_quaternion, multiply, rotate, rotation_vector_to_quaternion
from pytracker.skeleton.skeleton import Skeleton

__all__ = [
    "ARM_SEGMENTS",
    "MOST_LATE_S",
    "MOST_OFF_DEG",
    "UP",
    "aligned",
    "heading_between",
    "segment_frame",
    "to_y_up",
]

ARM_SEGMENTS = ("left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm")
UP = np.array([0.0, 1.0, 0.0])
"""The body's world."""
LEAST_LEVEL = 0.35
"""A segment that is steeper than this (sine of its angle to the vertical) shows no heading."""
MOST_LATE_S = 0.5
"""Until its first sample an arm is taken to be as at the first frame, where that is to tell its heading or roll."""
MOST_OFF_DEG = 45.0
"""A first pose and a sensor that differ by more are not of the same arm."""


def segment_frame(skeleton: Skeleton, pose: Array, segment: str) -> Array:
    """`q_world_segment` `(4,)` of a posed arm: +y to the near joint, +x along the elbow's axis."""
    side, part = segment.split("_", 1)
    letter = side[0]
    near, far = (f"{letter}humerus",) * 2 if part == "upper_arm" else (f"{letter}radius", f"{letter}wrist")
    starts, ends, rotations = skeleton.core.pose(pose[None])
    along = starts[0, skeleton.bone(near)] - ends[0, skeleton.bone(far)]
    y = along / np.linalg.norm(along)
    elbow = np.array(skeleton.bones[skeleton.bone(f"{letter}radius")].frame)[:, 0]
    axis = rotations[0, skeleton.bone(f"{letter}humerus")] @ elbow
    x = axis - (axis @ y) * y
    x /= np.linalg.norm(x)
    return np.asarray(matrix_to_quaternion(np.stack([x, y, np.cross(x, y)], axis=1)[None])[0])


def aligned(place: str, imu: Imu, heading_is_known: bool, skeleton: Skeleton, pose: Array, first_s: float) -> Array:
    """`q_world_segment` `(M, 4)` of a sensor, turned about the vertical and its long axis to fit the first pose.

    Raises `InputError` where that pose shows no heading, or contradicts the sensor.
    """
    expected = segment_frame(skeleton, pose, imu.segment)
    at = int(np.clip(np.searchsorted(imu.time_s, first_s, side="right") - 1, 0, len(imu.time_s) - 1))
    q = imu.q_world_segment
    if not heading_is_known:
        # About y, from z to x.
        wanted, found = (rotate(quaternion, UP)[[2, 0]] for quaternion in (expected, q[at]))
        turn = heading_between(f"{place}.heading_deg", imu.segment, wanted, found)
        q = multiply(rotation_vector_to_quaternion(turn * UP)[None], q)
    off = np.degrees(np.arccos(np.clip(rotate(expected, UP) @ rotate(q[at], UP), -1.0, 1.0)))
    if off > MOST_OFF_DEG:
        raise InputError(
            f"{place}: at the first frame the {imu.segment} points {off:.0f}° away from where the first pose has it, "
            f"expected at most {MOST_OFF_DEG:.0f}°: check mount, heading_deg, offset_s, segment and the first pose"
        )
    # About the segment's own axis: what is left of the elbow's axis after the one is swung onto the other.
    y = rotate(q[at], UP)
    axis, wanted = rotate(q[at], np.array([1.0, 0.0, 0.0])), rotate(expected, np.array([1.0, 0.0, 0.0]))
    wanted = wanted - (wanted @ y) * y
    roll = np.arctan2(np.cross(axis, wanted) @ y, axis @ wanted)
    return np.ascontiguousarray(multiply(q, rotation_vector_to_quaternion(roll * UP)[None]))


def heading_between(key: str, segment: str, wanted: Array, found: Array) -> float:
    """The turn about the vertical, rad, that takes the level part `found` `(2,)` of where a segment points to `wanted`.

    Raises `InputError`, naming the key that is missing, where the segment is too steep to tell.
    """
    level = min(float(np.hypot(*wanted)), float(np.hypot(*found)))
    if level < LEAST_LEVEL:
        steep, least = np.degrees(np.arcsin([level, LEAST_LEVEL]))
        raise InputError(
            f"{key} is missing, and at the first frame the {segment} hangs too steeply to show it ({steep:.0f}° from "
            f"the vertical, expected {least:.0f}° at least): give it, or start with the arm away from the body"
        )
    return float(np.arctan2(wanted[1], wanted[0]) - np.arctan2(found[1], found[0]))


def to_y_up(q_earth_segment: Array) -> Array:
    """From an earth frame whose z is up to the body's world, whose y is: x stays."""
    q = rotation_vector_to_quaternion(np.array([-0.5 * np.pi, 0.0, 0.0]))
    return np.ascontiguousarray(multiply(q[None], q_earth_segment))
