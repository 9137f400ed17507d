"""What besides the video is known of a simulated body: a detector's keypoints, and inertial sensors on the arms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker._core import KEY_JOINTS, KEYPOINTS
from pytracker.inertial.gravity import GRAVITY
from pytracker.recording.camera import Camera
from pytracker.recording.worn import UP, segment_frame, to_y_up
from pytracker.rotation import (
    Array,
    conjugate,
    multiply,
    quaternion_to_rotation_vector,
    rotate,
    rotation_vector_to_quaternion,
)
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["write_imu", "write_keypoints"]

DROPPED, WILD = 0.05, 0.02
"""Shares of points that a detector does not find, and that it finds somewhere else."""
SURE, UNSURE = 0.95, 0.4
"""The confidences that it states: of a third of the wild ones it is as sure as of others."""
IMU_SD = (0.05, 0.01)
"""Noise of acceleration, m/s², and turn rate, rad/s."""
HEIGHT_ALONG_ARM = {"forearm": ("wrist", "elbow"), "upper_arm": ("elbow", "shoulder")}


def write_keypoints(
    path: Path, skeleton: Skeleton, poses: Array, camera: Camera, sd_px: float, size: tuple[int, int], seed: int
) -> None:
    """A table of the joints that the skeleton has, one row a frame, as a detector with noise of `sd_px` finds them."""
    rng = np.random.default_rng([seed, *b"keypoints"])
    joints, names, columns = skeleton.joints(poses), [], []
    for name in (name for name in KEYPOINTS if name in KEY_JOINTS):
        uv = camera.project(joints[name]) + sd_px * rng.standard_normal((len(poses), 2))
        wild, dropped = rng.random(len(poses)) < WILD, rng.random(len(poses)) < DROPPED
        uv[wild] = rng.uniform((0, 0), size, (int(wild.sum()), 2))
        uv[dropped] = np.nan
        unsure = wild & (rng.random(len(poses)) < 2 / 3)
        names += [f"{name}_x", f"{name}_y", f"{name}_confidence"]
        columns += [uv[:, 0], uv[:, 1], np.where(dropped, 0.0, np.where(unsure, UNSURE, SURE))]
    rows = [",".join("" if np.isnan(x) else f"{x:.3f}" for x in row) for row in np.column_stack(columns)]
    path.write_text("\n".join([",".join(names), *rows]) + "\n", "utf-8")


def write_imu(path: Path, skeleton: Skeleton, poses: Array, rate_hz: float, segment: str, sd: float, seed: int) -> None:
    """A sensor on `segment`, its frame the segment's, off by `sd` rad: two thirds of it constant, the rest slow."""
    rng = np.random.default_rng([seed, *segment.encode()])
    side, part = segment.split("_", 1)
    far, near = (skeleton.joints(poses)[f"{side}_{joint}"] for joint in HEIGHT_ALONG_ARM[part])
    time_s = np.arange(len(poses)) / rate_hz
    q_world = np.stack([segment_frame(skeleton, pose, segment) for pose in poses])
    constant, slow = (share * sd / np.sqrt(3) * rng.standard_normal(3) for share in (0.8, 0.6 * np.sqrt(2)))
    phase = rng.uniform(0, 2 * np.pi, 3)
    error = constant + slow * np.sin(2 * np.pi * time_s[:, None] / 7.0 + phase)
    q_world = multiply(rotation_vector_to_quaternion(error), q_world)
    # Neighbouring quaternions on the same side, so that differences are turns.
    turns = quaternion_to_rotation_vector(multiply(conjugate(q_world[:-1]), q_world[1:])) * rate_hz
    gyr = np.vstack([turns, turns[-1:]]) + IMU_SD[1] * rng.standard_normal((len(poses), 3))
    place = far + 0.2 * (near - far)
    force = np.gradient(np.gradient(place, time_s, axis=0), time_s, axis=0) + GRAVITY * UP
    acc = rotate(conjugate(q_world), force) + IMU_SD[0] * rng.standard_normal((len(poses), 3))
    to_earth = conjugate(to_y_up(np.array([[1.0, 0.0, 0.0, 0.0]])))
    rows = np.column_stack([time_s, acc, gyr, multiply(to_earth, q_world)])
    header = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q_w,q_x,q_y,q_z"
    np.savetxt(path, rows, fmt="%.6f", delimiter=",", header=header, comments="")
