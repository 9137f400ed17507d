"""What an IMU file tells of itself: units, orders and frames, its lag against a patch, the axis it is worn along."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hidden_imu import ACC, COLUMNS, EVERY, GYR, QUATERNION, otherwise, rows_of, written

import pytracker as pt
from pytracker.evidence import sightings_of
from pytracker.evidence.patch.lag import find_lags
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.conventions import AccUnit, Conventions, GyrUnit, in_our_terms
from pytracker.inertial.gravity import GRAVITY
from pytracker.rotation import rotate
from pytracker.setup.checks.worn import given_axis
from pytracker.setup.conventions import find_conventions
from pytracker.setup.worn import mount_of
from pytracker.simulate import ArmSimulation


@pytest.fixture(scope="module")
def sightings(gesturing: Path) -> pt.Sightings:
    recording = pt.load(gesturing)
    assert isinstance(recording, pt.ArmRecording)
    return sightings_of(recording)


@pytest.mark.parametrize("conventions", EVERY, ids=lambda c: "-".join(c.__dict__.values()).replace(" ", "_"))
def test_conventions_are_found_and_read(conventions: Conventions, gesturing: Path, tmp_path: Path) -> None:
    rows = rows_of(gesturing)
    log = read_imu(written(otherwise(rows, conventions), tmp_path / "imu.csv"))
    found = find_conventions(log)
    assert found.conventions == conventions
    assert found.unknown == ()
    ours = in_our_terms(log, found.conventions)
    assert ours.acc is not None
    assert ours.q_world_sensor is not None
    assert np.abs(ours.acc - rows[:, ACC]).max() < 1e-5
    same = np.abs((ours.q_world_sensor * rows[:, QUATERNION]).sum(axis=1))
    assert same == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("unit", get_args(GyrUnit))
@pytest.mark.parametrize("acc_unit", get_args(AccUnit))
def test_without_a_quaternion_gravity_tells_the_units(
    acc_unit: AccUnit, unit: GyrUnit, gesturing: Path, tmp_path: Path
) -> None:
    """Only the acceleration's was written, and the file refused for its turn rate (ActiGraph: g and deg/s)."""
    rows = otherwise(rows_of(gesturing), Conventions(acc_unit=acc_unit, gyr_unit=unit))
    path = tmp_path / "imu.csv"
    header = COLUMNS.split(",q_w", maxsplit=1)[0]
    np.savetxt(path, rows[:, : QUATERNION.start], "%.7f", ",", header=header, comments="")
    found = find_conventions(read_imu(path))
    assert (found.conventions.acc_unit, found.conventions.gyr_unit) == (acc_unit, unit)
    # What is as usual may be told or not: it is taken as it is.
    assert found.unknown == () or unit == "rad/s"
    rows[:, ACC], rows[:, GYR] = [0.0, 0.0, 9.8], 0.001
    np.savetxt(path, rows[:, : QUATERNION.start], "%.7f", ",", header=header, comments="")
    assert "gyr_unit" in find_conventions(read_imu(path)).unknown


@pytest.mark.parametrize("axis", range(3))
def test_an_accelerometer_with_a_mirrored_axis_is_no_gyroscope_in_degrees(axis: int, tmp_path: Path) -> None:
    """Which hardly turned, and so left gravity steadier: a unit, a clock, a heading and a mount were written."""
    imu = ArmSimulation(pt.ArmScene(worn=True, pattern="reach", duration_s=12.0), 5).imu
    assert imu.gyr is not None
    mount = np.array([0.5, -0.3, 0.6, 0.5]) / np.sqrt(0.95)
    rows = np.column_stack([imu.time_s, rotate(mount, imu.acc), rotate(mount, imu.gyr)])
    rows[:, ACC.start + axis] *= -1.0
    path = tmp_path / "imu.csv"
    header = COLUMNS.split(",q_w", maxsplit=1)[0]
    np.savetxt(path, rows[:, : QUATERNION.start], "%.7f", ",", header=header, comments="")
    found = find_conventions(read_imu(path))
    assert found.unknown == ("gyr_unit",)
    assert found.conventions == Conventions()
    assert f"if the accelerometer's {'xyz'[axis]} has the other sign" in found.evidence["gyr_unit"]


def test_a_gyroscope_in_other_axes_is_none_in_degrees(tmp_path: Path) -> None:
    """It hardly turned in degrees, and gravity was the steadier: written in four of five."""
    for seed, pattern in ((101, "gesture"), (102, "reach")):
        imu = ArmSimulation(pt.ArmScene(worn=True, pattern=pattern, duration_s=20.0), seed).imu
        assert imu.gyr is not None
        rows = np.column_stack([imu.time_s, imu.acc, imu.gyr[:, [1, 0, 2]]])
        path = tmp_path / "imu.csv"
        np.savetxt(path, rows, "%.7f", ",", header=COLUMNS.split(",q_w", maxsplit=1)[0], comments="")
        found = find_conventions(read_imu(path))
        assert found.unknown == ("gyr_unit",)
        assert found.conventions == Conventions()


def test_a_sensor_that_does_not_turn_tells_no_quaternion(tmp_path: Path) -> None:
    rows = np.zeros((500, 11))
    rows[:, 0] = np.arange(500) / 50
    rows[:, ACC] = [0.0, 0.0, 4.0]
    rows[:, 7] = 1.0
    found = find_conventions(read_imu(written(rows, tmp_path / "imu.csv")))
    assert {"acc_unit", "quaternion", "quaternion_takes"} <= set(found.unknown)
    assert found.conventions == Conventions()
    # Found by fuzzing: what was read is not checked yet.
    for time_s in (1e15, -5.0, np.nan):
        rows[-1, 0] = time_s
        with_odd_time = find_conventions(read_imu(written(rows, tmp_path / "imu.csv")))
        assert "quaternion" in with_odd_time.unknown


@pytest.mark.parametrize("offset_s", [-29.3, 0.0, 11.77])
def test_any_lag_is_found_from_the_movement_alone(offset_s: float, gesturing: Path, sightings: pt.Sightings) -> None:
    recording = pt.load(gesturing)
    assert isinstance(recording, pt.ArmRecording)
    imu = recording.imus[0]
    world = rotate(imu.q_world_segment, imu.acc) - np.array([0.0, 0.0, GRAVITY])
    best = find_lags(sightings.time_s, sightings.pixels[:, 0], imu.time_s - offset_s, world)[0]
    # The simulator's own clock is 20 ms off.
    assert best.offset_s == pytest.approx(offset_s, abs=0.045)
    assert best.explained > 0.7
    never = find_lags(sightings.time_s[:50], sightings.pixels[:50, 0], imu.time_s, world)
    assert never == ()
    unseen = np.full((500, 2), np.nan)
    assert find_lags(np.arange(500) / 25, unseen, imu.time_s, world) == ()


@pytest.mark.parametrize("axis", [[0, 1, 0], [0, -1, 0], [1, 0, 0], [0.6, 0, -0.8]])
def test_a_mount_takes_the_axis_to_the_forearm(axis: list[float]) -> None:
    mount = mount_of(np.array(axis, dtype=float))
    assert rotate(mount, np.array(axis, dtype=float)) == pytest.approx([0, 1, 0], abs=1e-12)
    assert given_axis(list(mount)) == pytest.approx(axis, abs=1e-12)
