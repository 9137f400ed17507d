"""IMU files without orientation, of which one is computed: the gyroscope's unit, its signs and its bias."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE
from test_formats_imu import write
from test_imu_agreement import waving
from test_imu_faults import ACC, GYR, NO_QUATERNION, arm, told

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.bias import bias_at_rest, bias_by_gravity
from pytracker.inertial.check import check
from pytracker.inertial.gravity import at_rest
from pytracker.rotation import Array, conjugate, multiply, rotate, rotation_vector_to_quaternion
from pytracker.simulate import ArmSimulation

__all__ = ["arm"]


@pytest.mark.parametrize(
    "factor", [180 / np.pi, np.pi / 180, np.array([1.0, -1.0, 1.0]), np.array([1.0, 1.0, -1.0])], ids=str
)
def test_without_orientation_a_gyroscope_in_other_units_is_told(tmp_path: Path, factor: Array | float) -> None:
    table = waving(20.0)[:, :7]
    table[:, GYR] *= 0.2  # slow: a fifth of the turns, in as much time
    q = np.zeros((len(table), 4))
    q[0] = [1.0, 0.0, 0.0, 0.0]
    for k in range(1, len(q)):
        q[k] = multiply(q[k - 1], rotation_vector_to_quaternion(0.005 * (table[k, GYR] + table[k - 1, GYR])))
    table[:, ACC] = rotate(conjugate(q), np.array([0.0, 0.0, 9.81]))
    table[:, ACC] += np.random.default_rng(0).normal(0, 0.05, (len(q), 3))
    assert "refused" not in told(tmp_path, table, NO_QUATERNION)
    table[:, GYR] *= factor
    assert "computed from the gyroscope: is gyr in rad/s" in told(tmp_path, table, NO_QUATERNION)


@pytest.mark.parametrize("axis", [None, 0, 1, 2])
def test_without_orientation_a_worn_gyroscope_with_another_sign_is_told(tmp_path: Path, axis: int | None) -> None:
    """What straps shake hides it: 0.48 m/s² from gravity, 0.22 with the right sign; 32 cm off."""
    imu = ArmSimulation(pt.ArmScene(pattern="gesture", worn=True), seed=1).imu
    assert imu.gyr is not None
    signs = np.where(np.arange(3) == axis, -1.0, 1.0)
    said = told(tmp_path, np.column_stack([imu.time_s, imu.acc, imu.gyr * signs]), NO_QUATERNION)
    assert ("refused" not in said) if axis is None else (f"its {'xyz'[axis]} has the other" in said)


@pytest.mark.parametrize("axis", [None, 0, 1, 2])
def test_without_orientation_an_accelerometer_with_another_sign_is_told(tmp_path: Path, axis: int | None) -> None:
    """The gyroscope does not turn it as it is; a sensor that is worn aslant, for one axis may stay level throughout."""
    imu = ArmSimulation(pt.ArmScene(pattern="gesture", worn=True), seed=1).imu
    assert imu.gyr is not None
    mount = np.array([0.5, 0.1, -0.7, 0.5])
    acc = rotate(mount, imu.acc) * np.where(np.arange(3) == axis, -1.0, 1.0)
    said = told(tmp_path, np.column_stack([imu.time_s, acc, rotate(mount, imu.gyr)]), NO_QUATERNION)
    assert ("refused" not in said) if axis is None else (f"the accelerometer's {'xyz'[axis]} has the other" in said)


def test_without_orientation_a_part_in_other_units_is_named(tmp_path: Path, arm: Array) -> None:
    """The last tenth in degrees per second made 11 cm of 2, without a word on it."""
    table = arm[:, :7].copy()
    assert "for 2 s from here on" not in told(tmp_path, table, NO_QUATERNION)
    table[1800:, GYR] *= 180 / np.pi
    assert re.search(r"imu\.csv:1802: for 2 s from here on .* another unit there", told(tmp_path, table, NO_QUATERNION))


def test_real_sensors_that_move_have_no_bias_by_gravity(shared: Callable[[str], Path]) -> None:
    """About an axis that stays upright nothing is told: 0.17 rad/s of none, were it believed."""
    files = sorted(shared("data/imu/broad").glob("*.mat"))
    for path in files if IS_ACCEPTANCE else files[:2]:
        log = check(read_imu(path))
        moving = log.kept((log.time_s > 60.0) & (log.time_s < 100.0))
        assert bias_at_rest(moving) is None
        assert not np.any(bias_by_gravity(moving))


def test_even_turning_is_no_rest(tmp_path: Path) -> None:
    """A wrist that goes in a circle evenly was "at rest" twice a turn, and what it turned by taken off: 22 cm for 2."""
    imu = ArmSimulation(pt.ArmScene(pattern="circle", duration_s=20.0), seed=4).imu
    assert imu.gyr is not None
    table = np.column_stack([imu.time_s, imu.acc, imu.gyr])
    assert at_rest(read_imu(write(tmp_path / "imu.csv", table.tolist(), NO_QUATERNION)))
    assert "At rest the gyroscope reads" not in told(tmp_path, table, NO_QUATERNION)
    still = np.column_stack([imu.time_s, np.tile([0.0, 0.0, 9.81], (len(table), 1)), np.zeros((len(table), 3))])
    still[:, 1:] += np.random.default_rng(0).normal(0.0, 0.01, (len(table), 6))
    still[:, GYR] += [0.0, 0.2, -0.1]
    said = told(tmp_path, still, NO_QUATERNION)
    assert re.search(r"At rest the gyroscope reads \[-?0\.\d*, (0\.19|0\.2).*, -(0\.09|0\.1).*\] rad/s", said)


@pytest.mark.parametrize("share", [1.0, 0.4])
@pytest.mark.parametrize("pattern", ["circle", "reach", "gesture"])
def test_a_bias_of_what_never_lies_still_is_told_by_gravity(tmp_path: Path, pattern: str, share: float) -> None:
    """It was left in: 28 cm, all valid. About the axis that stays upright it is not known well."""
    imu = ArmSimulation(pt.ArmScene(pattern=pattern, duration_s=20.0), seed=2).imu
    assert imu.gyr is not None
    biased = np.array([0.1, -0.2, 0.3]) * share
    table = np.column_stack([imu.time_s, imu.acc, imu.gyr + biased])
    log = check(read_imu(write(tmp_path / "imu.csv", table.tolist(), NO_QUATERNION)))
    found, unsure = bias_by_gravity(log)
    off = found - biased
    axis = unsure / np.linalg.norm(unsure) if unsure.any() else np.zeros(3)
    assert np.linalg.norm(off - axis * (axis @ off)) < 0.03
    assert abs(axis @ off) < 3.0 * np.linalg.norm(unsure) + 0.01
    assert not np.any(bias_by_gravity(dataclasses.replace(log, gyr=imu.gyr)))


@pytest.mark.parametrize("noise", [0.005, 0.05])
@pytest.mark.parametrize("seconds", [4, 30])
def test_a_still_sensor_without_orientation_is_no_fault(tmp_path: Path, noise: float, seconds: int) -> None:
    """Gravity is steady whatever the gyroscope's unit: all such were refused as being in degrees per second."""
    rng, count = np.random.default_rng(0), 100 * seconds
    acc = np.array([0.0, 0.0, 9.81]) + rng.normal(0.0, 0.05, (count, 3))
    table = np.column_stack([np.arange(count) / 100, acc, rng.normal(0.0, noise, (count, 3))])
    assert "refused" not in told(tmp_path, table, NO_QUATERNION)
