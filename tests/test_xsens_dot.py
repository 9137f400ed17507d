"""Xsens DOT's CSV: what stands above its header, degrees per second, acceleration without gravity."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.check import check
from pytracker.rotation import Array, multiply, rotate, rotation_vector_to_quaternion
from pytracker.simulate.arm import ArmSimulation

ABOVE = """sep=,
DeviceTag:,Xsens DOT 1
FirmwareVersion:,1.6.0
AppVersion:,v2020.2.0
SyncStatus:,Unsynced
OutputRate:,60Hz
FilterProfile:,General
MeasurementMode:,Sensor fusion Mode - Extended (Quaternion)
StartTime:,2020-10-10_21-51-46_512_GMT+2

"""
QUATERNION = ["Quat_W", "Quat_X", "Quat_Y", "Quat_Z"]


@pytest.fixture(scope="module")
def worn() -> tuple[Array, Array, Array, Array]:
    """Time, specific force, turn rate and orientation of a sensor at 60 Hz."""
    imu = ArmSimulation(pt.ArmScene(pattern="gesture", period_s=2.0, imu_rate_hz=60.0), 3).imu
    assert imu.gyr is not None
    return imu.time_s, imu.acc, imu.gyr, imu.q_world_segment


@pytest.fixture
def export(worn: tuple[Array, Array, Array, Array], tmp_path: Path) -> Callable[..., Path]:
    def write(names: list[str], *columns: Array, above: str = ABOVE) -> Path:
        time_s = worn[0]
        table = np.column_stack([np.arange(len(time_s)), np.rint(1e6 * time_s), *columns, np.zeros(len(time_s))])
        lines = [",".join(f"{cell:.12g}" for cell in row) for row in table]
        path = tmp_path / "Xsens DOT_1_D422CD006321.csv"
        header = ",".join(["PacketCounter", "SampleTimeFine", *names, "Status"])
        path.write_text(above + "\n".join([header, *lines]) + "\n")
        return path

    return write


def test_acceleration_and_degrees_per_second(
    worn: tuple[Array, Array, Array, Array], export: Callable[..., Path]
) -> None:
    time_s, acc, gyr, q = worn
    names = [*QUATERNION, "Acc_X", "Acc_Y", "Acc_Z", "Gyr_X", "Gyr_Y", "Gyr_Z"]
    log = read_imu(export(names, q, acc, np.degrees(gyr)))
    assert log.rate_hz == 60.0
    assert log.lines[0] == 12
    path = export(names, q, acc, np.degrees(gyr))  # as a spreadsheet saves it in half of Europe
    path.write_text(path.read_text().replace(",", ";"))
    assert read_imu(path).rate_hz == 60.0
    assert log.time_s - log.time_s[0] == pytest.approx(time_s - time_s[0], abs=2e-6)
    assert log.acc == pytest.approx(acc)
    assert log.gyr == pytest.approx(gyr)
    assert check(log).warnings == ()
    # What says that it is in degrees and is not, is told.
    with pytest.raises(pt.InputError, match="is it in other units than rad/s"):
        check(read_imu(export(names, q, acc, gyr)))


def test_gravity_is_put_back(worn: tuple[Array, Array, Array, Array], export: Callable[..., Path]) -> None:
    """What a DOT records by default: orientation, and acceleration in the earth frame without gravity."""
    _, acc, _, q = worn
    free = rotate(q, acc) - [0.0, 0.0, 9.80665]
    log = read_imu(export([*QUATERNION, "FreeAcc_X", "FreeAcc_Y", "FreeAcc_Z"], q, free))
    assert log.acc == pytest.approx(acc, abs=1e-6)
    (words,) = check(log).warnings
    assert "its acceleration is free of gravity, which is put back by its orientation" in words


def test_gravity_is_put_back_downwards_too(
    worn: tuple[Array, Array, Array, Array], export: Callable[..., Path]
) -> None:
    """Of an earth frame that is north, east, down, as MT Manager says of it; there was no way to load it."""
    _, acc, _, q = worn
    down = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])
    q_ned = multiply(np.broadcast_to(down, q.shape), q)
    free = rotate(q_ned, acc) + np.array([0.0, 0.0, 9.80665])
    names = [*QUATERNION, "FreeAcc_X", "FreeAcc_Y", "FreeAcc_Z"]
    log = read_imu(export(names, q_ned, free, above="// General information:\n// Coordinate system: NED\n"))
    assert log.acc == pytest.approx(acc, abs=1e-6)


def test_columns_that_stand_twice_are_refused(
    worn: tuple[Array, Array, Array, Array], export: Callable[..., Path]
) -> None:
    _, acc, _, _ = worn
    with pytest.raises(pt.InputError, match="column 'Acc_X' stands more than once, expected one sensor a file"):
        read_imu(export(["Acc_X", "Acc_Y", "Acc_Z"] * 2, acc, acc))


def test_without_a_word_above_its_header(worn: tuple[Array, Array, Array, Array], export: Callable[..., Path]) -> None:
    _, acc, _, q = worn
    names = [*QUATERNION, "Acc_X", "Acc_Y", "Acc_Z"]
    for above in ("", "sep=,\n"):
        assert read_imu(export(names, q, acc, above=above)).acc == pytest.approx(acc)


def test_increments_are_turned_into_rates(worn: tuple[Array, Array, Array, Array], export: Callable[..., Path]) -> None:
    """High fidelity, of which a DOT writes no acceleration: it was refused for having none."""
    time_s, acc, gyr, q = worn
    step_s = float(np.median(np.diff(time_s)))
    names = ["dq_W", "dq_X", "dq_Y", "dq_Z", "dv[1]", "dv[2]", "dv[3]"]
    log = read_imu(export([*QUATERNION, *names], q, rotation_vector_to_quaternion(gyr * step_s), acc * step_s))
    assert log.acc is not None
    assert log.gyr is not None
    assert np.allclose(log.acc, acc, atol=1e-4)
    assert np.allclose(log.gyr, gyr, atol=1e-4)
    assert check(log).warnings == ()
    # Where there is an acceleration it stands.
    other = read_imu(export(["Acc_X", "Acc_Y", "Acc_Z", *names[4:]], acc, 2.0 * acc * step_s))
    assert other.acc is not None
    assert np.allclose(other.acc, acc, atol=1e-5)
