"""Arrays of quaternions, scalar first: what files and the simulator need. The filter's are in Rust."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triple = tuple[float, float, float]
Matrix = tuple[Triple, Triple, Triple]

__all__ = [
    "Array",
    "Matrix",
    "Triple",
    "axes_to_quaternion",
    "conjugate",
    "euler_to_quaternion",
    "matrix_to_quaternion",
    "multiply",
    "quaternion_to_rotation_vector",
    "rotate",
    "rotation_vector_to_quaternion",
    "triple",
    "without_leaps",
]


def triple(v: Array) -> Triple:
    """`(3,)` as plain numbers."""
    return float(v[0]), float(v[1]), float(v[2])


def multiply(a: Array, b: Array) -> Array:
    """Hamilton product of `(..., 4)` and `(..., 4)`: `q_a_b * q_b_c` is `q_a_c`."""
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    w = aw * bw - np.sum(av * bv, axis=-1, keepdims=True)
    return np.asarray(np.concatenate([w, aw * bv + bw * av + np.cross(av, bv)], axis=-1))


def conjugate(q: Array) -> Array:
    """The inverse rotation of unit quaternions `(..., 4)`."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def rotate(q: Array, v: Array) -> Array:
    """Vectors `(..., 3)` turned by unit quaternions `(..., 4)`."""
    twice_cross = 2 * np.cross(q[..., 1:], v)
    return np.asarray(v + q[..., :1] * twice_cross + np.cross(q[..., 1:], twice_cross))


def rotation_vector_to_quaternion(v: Array) -> Array:
    """The turn about `v` by its length in radians, `(..., 3)` to `(..., 4)`."""
    half = 0.5 * np.linalg.norm(v, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * v * np.sinc(half / np.pi)], axis=-1)


def quaternion_to_rotation_vector(q: Array) -> Array:
    """The shorter turn of unit quaternions, its length in radians, `(..., 4)` to `(..., 3)`."""
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, np.abs(q[..., :1]))
    towards = np.where(q[..., :1] < 0, -1.0, 1.0) * q[..., 1:]
    return np.asarray(towards * angle / np.maximum(sine, np.finfo(float).tiny))


def euler_to_quaternion(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Rz(yaw) Ry(pitch) Rx(roll), radians, as Xsens writes it: `(T,)` each to `(T, 4)`."""
    zero = np.zeros_like(roll)
    turn = rotation_vector_to_quaternion
    about_x = turn(np.stack([roll, zero, zero], axis=-1))
    about_y = turn(np.stack([zero, pitch, zero], axis=-1))
    about_z = turn(np.stack([zero, zero, yaw], axis=-1))
    return multiply(about_z, multiply(about_y, about_x))


def axes_to_quaternion(x: Array, y: Array, z: Array) -> Array:
    """From the three axes in the outer frame, `(T, 3)` each."""
    return matrix_to_quaternion(np.stack([x, y, z], axis=-1))


def matrix_to_quaternion(m: Array) -> Array:
    """From rotation matrices `(T, 3, 3)`, by the largest of the four components (Shepperd 1978)."""
    d = np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]], axis=1)
    trace = d.sum(axis=1, keepdims=True)
    # Row k: the quaternion times 4 q_k, for k = w, x, y, z.
    squares = np.concatenate([1 + trace, 1 + 2 * d - trace], axis=1)
    wx, wy, wz = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    xy, xz, yz = m[:, 0, 1] + m[:, 1, 0], m[:, 0, 2] + m[:, 2, 0], m[:, 1, 2] + m[:, 2, 1]
    s = squares
    rows = np.stack(
        [
            np.stack([s[:, 0], wx, wy, wz], axis=1),
            np.stack([wx, s[:, 1], xy, xz], axis=1),
            np.stack([wy, xy, s[:, 2], yz], axis=1),
            np.stack([wz, xz, yz, s[:, 3]], axis=1),
        ],
        axis=1,
    )
    q = rows[np.arange(len(m)), np.argmax(squares, axis=1)]
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    return np.asarray(np.where(q[:, :1] < 0, -q, q))


def without_leaps(q: Array) -> Array:
    """Quaternions `(M, 4)` with the sign of the one before: q and -q are the same turn."""
    signs = np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    return np.asarray(q * np.concatenate([[1.0], np.cumprod(signs)])[:, None])
