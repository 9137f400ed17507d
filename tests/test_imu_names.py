"""IMU files of other loggers: their names, their units, their commas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu import read_imu
from pytracker.formats.imu_gravity import GRAVITY
from pytracker.formats.imu_names import Column, known_as

PHYPHOX = '"Time (s)";"Acceleration x (m/s^2)";"Acceleration y (m/s^2)";"Acceleration z (m/s^2)"'
X_IO = ",".join([
    "Time (s)", *(f"Gyroscope {axis} (deg/s)" for axis in "XYZ"), *(f"Accelerometer {axis} (g)" for axis in "XYZ"),
])  # fmt: skip


@pytest.mark.parametrize(
    ("header", "column"),
    [
        ("Time (s)", Column("time_s", 1.0)),
        ("timestamp [ms]", Column("time_s", 1e-3)),
        ("seconds_elapsed", Column("time_s", 1.0)),
        ("Accelerometer X (g)", Column("acc_x", GRAVITY)),
        ("ACC-Y[mg]", Column("acc_y", 1e-3 * GRAVITY)),
        ("Acceleration z (m/s^2)", Column("acc_z", 1.0)),
        ("Gyroscope y (°/s)", Column("gyr_y", 0.017453292519943295)),
        ("gyro.z", Column("gyr_z", 1.0)),
        ("Magnetic field x (µT)", Column("mag_x", 1.0)),
        ("Accelerometer X (counts)", None),
        ("Linear Acceleration x (m/s^2)", None),
        ("FreeAcc_X", None),
        ("quat_w", None),
        ("temperature (°C)", None),
    ],
)
def test_names_and_units_are_known(header: str, column: Column | None) -> None:
    assert known_as(header) == column


def test_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    path = tmp_path / "phyphox.csv"
    path.write_text(f"sep=;\n{PHYPHOX}\n0,00;0,1;-0,2;9,81\n0,01;0,1;-0,25;9,80\n")
    log = read_imu(path)
    assert log.acc is not None
    assert log.time_s.tolist() == [0.0, 0.01]
    assert log.acc[1].tolist() == [0.1, -0.25, 9.8]


def test_units_in_the_header_are_turned_into_ours(tmp_path: Path) -> None:
    path = tmp_path / "x-io.csv"
    path.write_text(f"{X_IO}\n0.0,180,0,-90,0,0,1\n0.01,180,0,-90,0,0,1\n")
    log = read_imu(path)
    assert log.acc is not None
    assert log.gyr is not None
    assert log.acc[0] == pytest.approx([0, 0, GRAVITY])
    assert log.gyr[0] == pytest.approx([np.pi, 0, -np.pi / 2])


def test_a_clock_that_counts_from_the_start_is_preferred(tmp_path: Path) -> None:
    path = tmp_path / "logger.csv"
    path.write_text(
        "time,seconds_elapsed,acc_x,acc_y,acc_z\n1700000000000000000,0.5,0,0,9.8\n1700000000010000000,0.51,0,0,9.8\n"
    )
    assert read_imu(path).time_s.tolist() == [0.5, 0.51]


def test_a_map_names_what_is_not_known(tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    path.write_text("clock,fx,fy,fz,e0,e1,e2,e3\n0,0,0,9.8,1,0,0,0\n0.01,0,0,9.8,1,0,0,0\n")
    with pytest.raises(pt.InputError, match=r'or columns = \{ time_s = "..."'):
        read_imu(path)
    ours = {"time_s": "clock", "acc_x": "fx", "acc_y": "fy", "acc_z": "fz"}
    turn = {"q_w": "e0", "q_x": "e1", "q_y": "e2", "q_z": "e3"}
    log = read_imu(path, columns={**ours, **turn})
    assert log.q_world_sensor is not None
    assert log.q_world_sensor[1].tolist() == [1, 0, 0, 0]
    with pytest.raises(pt.InputError, match=r"columns.acc_x is 'ax', but the header has no such column: clock"):
        read_imu(path, columns={**ours, "acc_x": "ax"})
