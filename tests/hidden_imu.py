"""A recording whose clock, heading, mount and conventions are hidden, as files come from people."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import get_args

import numpy as np

from pytracker.inertial.conventions import AccUnit, Conventions, Direction, Earth, GyrUnit, Order
from pytracker.inertial.gravity import GRAVITY
from pytracker.rotation import Array, conjugate, multiply, rotate, rotation_vector_to_quaternion
from pytracker.setup.draft import Draft

KNOWN = ("matrix", "rotation", "translation_m")
ACC, GYR, QUATERNION = slice(1, 4), slice(4, 7), slice(7, 11)
COLUMNS = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q_w,q_x,q_y,q_z"
EVERY = [
    Conventions(acc_unit=a, gyr_unit=g, quaternion=o, quaternion_takes=d, earth=e)
    for a, g, o, d, e in itertools.product(*(get_args(of) for of in (AccUnit, GyrUnit, Order, Direction, Earth)))
]


def rows_of(folder: Path) -> Array:
    header, *lines = (folder / "imu.csv").read_text().splitlines()
    at = [header.split(",").index(name) for name in COLUMNS.split(",")]
    return np.array([[float(cell) for cell in line.split(",")] for line in lines])[:, at]


def otherwise(rows: Array, of: Conventions) -> Array:
    """The same samples, as a file of these conventions has them."""
    rows = rows.copy()
    q = rows[:, QUATERNION]
    if of.earth == "z down":
        q = multiply(np.broadcast_to([0.0, -1.0, 0.0, 0.0], q.shape), q)
    q = conjugate(q) if of.quaternion_takes == "world to sensor" else q
    rows[:, QUATERNION] = np.roll(q, -1, axis=1) if of.quaternion == "xyzw" else q
    rows[:, ACC] /= GRAVITY if of.acc_unit == "g" else 1.0
    rows[:, GYR] = np.degrees(rows[:, GYR]) if of.gyr_unit == "deg/s" else rows[:, GYR]
    return rows


def written(rows: Array, path: Path) -> Path:
    np.savetxt(path, rows, "%.7f", ",", header=COLUMNS, comments="")
    return path


def known_file(folder: Path, path: Path) -> Path:
    """What a person has measured: camera and arm."""
    draft = Draft(folder)
    lines = [f"{key} = {draft.get(f'camera.{key}')}" for key in KNOWN]
    lines += [f"{key} = {draft.get(f'arm.{key}')}" for key in ("shoulder_m", "upper_arm_m", "forearm_m")]
    path.write_text("\n".join(lines) + "\n")
    return path


def hidden(rows: Array, offset_s: float, heading_deg: float, mount: Array) -> Array:
    """The samples by another clock, in another earth frame, of a sensor that is worn otherwise."""
    rows, back = rows.copy(), conjugate(mount)
    rows[:, 0] -= offset_s
    rows[:, ACC], rows[:, GYR] = rotate(back, rows[:, ACC]), rotate(back, rows[:, GYR])
    turn = rotation_vector_to_quaternion(np.array([0.0, 0.0, -np.radians(heading_deg)]))
    q = rows[:, QUATERNION]
    rows[:, QUATERNION] = multiply(multiply(np.broadcast_to(turn, q.shape), q), np.broadcast_to(mount, q.shape))
    return rows
