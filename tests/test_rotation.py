"""Arrays of quaternions against SciPy."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from pytracker import rotation as r

vectors = arrays(np.float64, (4, 3), elements=st.floats(-4, 4, allow_subnormal=False))


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(q, scalar_first=True)


@given(vectors, vectors, vectors)
def test_rotation_vector_product_and_turning(a: np.ndarray, b: np.ndarray, v: np.ndarray) -> None:
    qa, qb = r.rotation_vector_to_quaternion(a), r.rotation_vector_to_quaternion(b)
    expected = Rotation.from_rotvec(a) * Rotation.from_rotvec(b)
    assert np.allclose(r.rotate(r.multiply(qa, qb), v), expected.apply(v), atol=1e-11)
    assert np.allclose(r.rotate(r.conjugate(qa), r.rotate(qa, v)), v, atol=1e-11)


@given(vectors)
def test_rotation_vector_round_trip(a: np.ndarray) -> None:
    found = r.quaternion_to_rotation_vector(r.rotation_vector_to_quaternion(a))
    assert np.allclose(Rotation.from_rotvec(found).as_matrix(), Rotation.from_rotvec(a).as_matrix(), atol=1e-10)
    assert np.all(np.linalg.norm(found, axis=1) <= np.pi + 1e-9)
    assert np.array_equal(
        r.quaternion_to_rotation_vector(np.array([[1.0, 0, 0, 0], [-1.0, 0, 0, 0]])), np.zeros((2, 3))
    )


@given(vectors)
def test_matrix_round_trip(a: np.ndarray) -> None:
    m = Rotation.from_rotvec(a).as_matrix()
    assert np.allclose(scipy_of(r.matrix_to_quaternion(m)).as_matrix(), m, atol=1e-10)
    assert np.allclose(r.axes_to_quaternion(m[:, :, 0], m[:, :, 1], m[:, :, 2]), r.matrix_to_quaternion(m), atol=1e-12)


@given(vectors)
def test_euler_is_z_y_x(angles: np.ndarray) -> None:
    roll, pitch, yaw = angles.T
    expected = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=1)).as_matrix()
    assert np.allclose(scipy_of(r.euler_to_quaternion(roll, pitch, yaw)).as_matrix(), expected, atol=1e-11)


def test_half_turns() -> None:
    for axis in np.eye(3):
        m = Rotation.from_rotvec(np.pi * axis).as_matrix()[None]
        assert np.allclose(np.abs(r.matrix_to_quaternion(m)), [[0, *axis]], atol=1e-12)
