"""IMU files of other loggers: their names, their units, their commas."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu.names import Column, known_as
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.check import check
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.inertial.orientation import orient
from pytracker.rotation import Array

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
        ("Acc_X (m/s/s)", Column("acc_x", 1.0)),
        ("Acc_Y [milli-g]", Column("acc_y", 1e-3 * GRAVITY)),
        ("acc_z (m/sec^2)", Column("acc_z", 1.0)),
        ("gyr_x (deg/sec)", Column("gyr_x", 0.017453292519943295)),
        ("time (msec)", Column("time_s", 1e-3)),
        ("Time (seconds)", Column("time_s", 1.0)),
        ("Time since start in ms ", Column("time_s", 1e-3)),
        ("Gyro-X (d/s)", Column("gyr_x", 0.017453292519943295)),
        ("AsX(°/s)", Column("gyr_x", 0.017453292519943295)),
        ("HX(uT)", Column("mag_x", 1.0)),
        ("Hz", None),
        ("Accelerometer X (counts)", None),
        ("Linear Acceleration x (m/s^2)", None),
        ("FreeAcc_X", None),
        ("time_ms", Column("time_s", 1e-3)),
        ("millis", Column("time_s", 1e-3)),
        ("#timestamp [ns]", Column("time_s", 1e-9)),
        ("%time", Column("time_s", 1.0)),
        ("gFx", Column("acc_x", GRAVITY)),
        ("a_RS_S_x [m s^-2]", Column("acc_x", 1.0)),
        ("field.linear_acceleration.x", Column("acc_x", 1.0)),
        ("linear_acceleration_x", None),
        ("field.angular_velocity.y", Column("gyr_y", 1.0)),
        ("Gyroscope/Z (rad/s)", Column("gyr_z", 1.0)),
        ("Quat_W", Column("q_w", 1.0)),
        ("field.orientation.x", Column("q_x", 1.0)),
        ("quat_1", None),
        ("temperature (°C)", None),
    ],
)
def test_names_and_units_are_known(header: str, column: Column | None) -> None:
    assert known_as(header) == column


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_semicolons_or_tabs_and_decimal_commas(delimiter: str, tmp_path: Path) -> None:
    path = tmp_path / "phyphox.csv"
    text = f"{PHYPHOX}\n0,00;0,1;-0,2;9,81\n1,0E-02;0,1;-0,25;9,80\n".replace(";", delimiter)
    path.write_text(f"sep={delimiter}\n{text}")
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


Row = Callable[[float, Array, Array, Array], list[object]]
"""Cells of a row: time, s; specific force; turn rate; orientation."""
LOGGERS: dict[str, tuple[list[str], Row]] = {
    # ROS' bag as a table: nanoseconds since 1970, w last.
    "ros": (
        ["%time", *(f"field.orientation.{a}" for a in "xyzw"), *(f"field.angular_velocity.{a}" for a in "xyz"),
         *(f"field.linear_acceleration.{a}" for a in "xyz")],
        lambda t, a, g, q: [int(1.7e18) + int(t * 1e9), *q[[1, 2, 3, 0]], *g, *a],
    ),
    "euroc": (
        ["#timestamp [ns]", *(f"w_RS_S_{a} [rad s^-1]" for a in "xyz"), *(f"a_RS_S_{a} [m s^-2]" for a in "xyz")],
        lambda t, a, g, q: [int(1.7e18) + int(t * 1e9), *g, *a],
    ),
    "arduino": (
        ["millis", "ax", "ay", "az", "gx", "gy", "gz", "qw", "qx", "qy", "qz"],
        lambda t, a, g, q: [round(t * 1e3), *a, *g, *q],
    ),
    "unit not said": (
        ["Timestamp", "AccX[mg]", "AccY[mg]", "AccZ[mg]", "GyroX[mdps]", "GyroY[mdps]", "GyroZ[mdps]"],
        lambda t, a, g, q: [round(t * 1e3), *(a / GRAVITY * 1e3), *(np.degrees(g) * 1e3)],
    ),
    "physics toolbox": (
        ["time", "gFx", "gFy", "gFz", "ax", "ay", "az", "wx", "wy", "wz"],
        lambda t, a, g, q: [t, *(a / GRAVITY), 0.0, 0.0, 0.0, *g],
    ),
    "dates": (
        ["time", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"],
        lambda t, a, g, q: [f"2024-02-28T23:59:{50 + t:09.6f}+01:00", *a, *g],
    ),
    "times of day": (
        ["time", "acc_x", "acc_y", "acc_z"],
        lambda t, a, g, q: [("23:59:" if t < 0.25 else "00:00:") + f"{(59.75 + t) % 60:09.6f}", *a],
    ),
    "quoted": (
        ['"time_s"', '"acc_x"', '"acc_y"', '"acc_z"', '"note"'],
        lambda t, a, g, q: [f'"{t}"', *a, '"up, then down"'],
    ),
    "apdm": (
        ["Time (s)", *(f"Accelerometer/{a} (m/s^2)" for a in "XYZ"), *(f"Gyroscope/{a} (rad/s)" for a in "XYZ")],
        lambda t, a, g, q: [t, *a, *g],
    ),
}  # fmt: skip


@pytest.mark.parametrize("logger", LOGGERS)
def test_other_loggers_are_read(logger: str, tmp_path: Path) -> None:
    names, row = LOGGERS[logger]
    rng = np.random.default_rng(0)
    time_s = np.arange(50) / 100
    acc, gyr, q = (
        rng.normal(0, 1, (50, 3)) + np.array([0, 0, 9.8]),
        rng.normal(0, 1, (50, 3)),
        rng.normal(0, 1, (50, 4)),
    )
    rows = [row(*each) for each in zip(time_s, acc, gyr, q, strict=True)]
    # What the logger says of itself stands above.
    lines = ["Recorded by:,A. Logger", "", ",".join(names), *(",".join(map(str, each)) for each in rows)]
    path = tmp_path / "imu.csv"
    path.write_text("\n".join(lines) + "\n")
    log = read_imu(path)
    assert log.acc is not None
    assert log.lines[0] == 4
    assert log.time_s - log.time_s[0] == pytest.approx(time_s, abs=1e-6)
    assert log.acc == pytest.approx(acc)
    assert (log.gyr is None) == (logger in ("quoted", "times of day"))
    if log.gyr is not None:
        assert log.gyr == pytest.approx(gyr)
    if logger in ("ros", "arduino"):
        assert log.q_world_sensor == pytest.approx(q)
    assert ("taken as milliseconds, of 100 Hz" in " ".join(log.warnings)) == (logger == "unit not said")


def test_a_quoted_cell_without_end_is_no_other_error(tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text('time_s,acc_x,acc_y,acc_z\n0,0,0,"' + "9" * 200_000 + "\n")
    with pytest.raises(pt.InputError, match=r"imu\.csv:2: acc_z is"):
        read_imu(path)


def test_rows_of_empty_cells_are_none(tmp_path: Path) -> None:
    """As spreadsheets leave them below the last."""
    path = tmp_path / "imu.csv"
    path.write_text("time_s,acc_x,acc_y,acc_z\n0.0,0,0,9.8\n0.01,0,0,9.8\n,,,\n,,,\n")
    assert len(read_imu(path).time_s) == 2


def test_an_empty_row_among_others_keeps_its_place(tmp_path: Path) -> None:
    """Of rows that follow each other at a rate, those after it would be early."""
    path = tmp_path / "imu.csv"
    path.write_text("acc_x,acc_y,acc_z\n0,0,9.8\n,,\n,,\n0,0,9.8\n")
    log = read_imu(path, rate_hz=100.0)
    assert log.time_s == pytest.approx([0.0, 0.01, 0.02, 0.03])
    assert log.acc is not None
    assert np.isnan(log.acc[1:3]).all()


def test_a_gyroscope_that_is_not_known_is_shown(tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text("time_s,acc_x,acc_y,acc_z,omega_1,omega_2,omega_3\n" + "0,0,0,9.8,1,2,3\n0.01,0,0,9.8,1,2,3\n")
    with pytest.raises(
        pt.InputError, match=r"nor a gyroscope \(it has omega_1, omega_2, omega_3 beside, which are not"
    ):
        orient(read_imu(path))


def test_a_turn_rate_that_is_not_known_is_told(tmp_path: Path) -> None:
    """An orientation beside it hid that it was not read."""
    path = tmp_path / "imu.csv"
    path.write_text(
        "time_s,acc_x,acc_y,acc_z,q_w,q_x,q_y,q_z,gyro_dps_x\n" + "0,0,0,9.8,1,0,0,0,1\n0.01,0,0,9.8,1,0,0,0,1\n"
    )
    assert "columns gyro_dps_x look like a turn rate and are not read" in read_imu(path).warnings[0]
    assert known_as("gyr_x_deg_s") == known_as("gyr_x (deg/s)")
    assert known_as("acc_x_m_s2") == known_as("acc_x (m/s2)")


def samples(count: int = 200) -> Array:
    """Of a sensor that turns to and fro: acceleration, m/s², and turn rate, rad/s."""
    time_s = np.arange(count) / 60.0
    rate = np.stack([np.sin(2.0 * time_s), np.cos(3.0 * time_s), np.sin(1.3 * time_s)], axis=1)
    return np.concatenate([np.tile([0.3, -1.0, 9.8], (count, 1)), rate], axis=1)


@pytest.mark.parametrize("lost_share", [0.0, 0.05])
@pytest.mark.parametrize("decimals", [2, 3, 6])
def test_a_counter_shows_what_was_lost(lost_share: float, decimals: int, tmp_path: Path) -> None:
    """Times went on row by row: 21 cm off, valid in 96 % of the frames, and another rate was asked for."""
    kept = np.flatnonzero(np.random.default_rng(4).random(600) >= lost_share)
    path = tmp_path / "imu.csv"
    values = [",".join(map(str, row)) for row in samples(600)]
    lines = [f"{(250 + k) % 256},{row / 60:.{decimals}f},{values[k]}" for row, k in enumerate(kept)]
    path.write_text("\n".join(["packet_counter,time_s,ax,ay,az,gx,gy,gz", *lines]) + "\n")
    log = read_imu(path)
    assert log.time_s - log.time_s[0] == pytest.approx((kept - kept[0]) / 60, abs=0.02)
    said = [words for words in log.warnings if "its counter skips" in words]
    assert len(said) == (lost_share > 0)
    # Whoever has true times beside it is believed.
    true = [f"{k},{k / 60:.6f},{values[k]}" for k in kept]
    path.write_text("\n".join(["counter,time_s,ax,ay,az,gx,gy,gz", *true]) + "\n")
    assert read_imu(path).warnings == ()
    assert read_imu(path).time_s == pytest.approx(kept / 60, abs=1e-6)


@pytest.mark.parametrize("counts", ["another's", "each second anew"])
def test_a_counter_of_something_else_moves_no_time(counts: str, tmp_path: Path) -> None:
    """True times were drawn out by 2 to 5 s in 20."""
    time_s = np.arange(600) / 60
    counter = np.floor(1.2 * np.arange(600)) if counts == "another's" else np.arange(600) % 60
    path = tmp_path / "imu.csv"
    lines = [
        f"{c:.0f},{t:.6f},{','.join(map(str, row))}" for c, t, row in zip(counter, time_s, samples(600), strict=True)
    ]
    path.write_text("\n".join(["counter,time_s,ax,ay,az,gx,gy,gz", *lines]) + "\n")
    assert read_imu(path).time_s == pytest.approx(time_s, abs=1e-6)
    assert read_imu(path).warnings == ()


def test_a_mapped_column_keeps_its_unit(tmp_path: Path) -> None:
    """A clock in milliseconds was asked for in seconds, and nothing could say so."""
    path = tmp_path / "imu.csv"
    axes = [f'"IMU {sensor} {axis}, {unit}"' for sensor, unit in (("A", "mG"), ("T", "mdps")) for axis in "XYZ"]
    rows = [",".join(f"{x:.6f}" for x in [16 * k, *(row[:3] / GRAVITY * 1e3), *1e3 * np.degrees(row[3:])])
            for k, row in enumerate(samples())]  # fmt: skip
    path.write_text("\n".join([",".join(["Clock [ms]", *axes]), *rows]) + "\n")
    ours = {f"{sensor}_{axis}": f"IMU {name} {axis.upper()}, {unit}" for sensor, name, unit in
            (("acc", "A", "mG"), ("gyr", "T", "mdps")) for axis in "xyz"}  # fmt: skip
    log = read_imu(path, columns={"time_s": "Clock [ms]", **ours})
    assert log.acc is not None
    assert log.gyr is not None
    assert log.time_s == pytest.approx(0.016 * np.arange(200))
    assert np.column_stack([log.acc, log.gyr]) == pytest.approx(samples(), abs=1e-6)


def test_two_shimmers_in_a_file_are_not_mixed(tmp_path: Path) -> None:
    """Acceleration was the wrist's and turn rate the trunk's, without a word."""
    path, names = tmp_path / "imu.csv", ["Timestamp_Unix_CAL"]
    for device, acc in (("Trunk", "Accel_LN"), ("Wrist", "Accel_WR")):
        names += [f"{device}_{sensor}_{axis}_CAL" for sensor in (acc, "Gyro") for axis in "XYZ"]
    units = ["ms", *(["m/(s^2)"] * 3 + ["deg/s"] * 3) * 2]
    rows = [[1.7e12 + 16 * k, *row, *(2 * row)] for k, row in enumerate(samples())]
    path.write_text("\n".join("\t".join(map(str, row)) for row in [names, units, *rows]) + "\n")
    with pytest.raises(pt.InputError, match="holds the sensors trunk, wrist, expected one a file, or columns"):
        read_imu(path)
    wrist = {f"{ours}_{axis}": f"Wrist_{theirs}_{axis.upper()}_CAL" for ours, theirs in
             (("acc", "Accel_WR"), ("gyr", "Gyro")) for axis in "xyz"}  # fmt: skip
    log = read_imu(path, columns={"time_s": "Timestamp_Unix_CAL", **wrist})
    assert np.diff(log.time_s) == pytest.approx(0.016, abs=1e-6)
    assert log.acc is not None
    assert log.acc == pytest.approx(2 * samples()[:, :3])


def test_a_magnetometer_that_pauses_is_one(tmp_path: Path) -> None:
    """One empty cell, and there was no magnetometer; one that reads zero told north."""

    def read(field: Callable[[int], str]) -> ImuLog:
        path = tmp_path / "imu.csv"
        slow = samples() * [1.0, 1.0, 1.0, 0.01, 0.01, 0.01]
        rows = [f"{k / 60:.6f},{','.join(map(str, row))},{field(k)}" for k, row in enumerate(slow)]
        path.write_text("\n".join(["time_s,ax,ay,az,gx,gy,gz,mx,my,mz", *rows]) + "\n")
        return orient(check(read_imu(path)))

    whole = read(lambda k: f"{20 + 0.01 * k:.3f},{-5 + 0.02 * k:.3f},-40")
    found = read(lambda k: ",," if k % 10 else f"{20 + 0.01 * k:.3f},{-5 + 0.02 * k:.3f},-40")
    assert "magnetic north" in found.warnings[-1]
    assert whole.q_world_sensor is not None
    assert found.q_world_sensor is not None
    assert np.abs((found.q_world_sensor * whole.q_world_sensor).sum(axis=1)) == pytest.approx(1.0, abs=1e-4)
    found = read(lambda k: ",," if k % 199 else "20,-5,-40" if k else "20,-4,-40")
    assert "the magnetometer says nothing for 3.32 s, so the heading is arbitrary" in found.warnings[-1]
    assert "the magnetometer says nothing, or always the same" in read(lambda _: "0,0,0").warnings[-1]


@pytest.mark.parametrize(
    ("names", "units"),
    [
        ("time,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", "ms,g,g,g,deg/s,deg/s,deg/s"),
        ("timestamp;ax;ay;az;gx;gy;gz", "[ms];[g];[g];[g];[dps];[dps];[dps]"),
    ],
)
def test_units_in_a_row_of_their_own(tmp_path: Path, names: str, units: str) -> None:
    """Of spreadsheets: the row was refused as no number."""
    delimiter = ";" if ";" in names else ","
    rows = [delimiter.join(map(str, (10 * k, 0.1, 0, 1, 90, 0, k))) for k in range(20)]
    (tmp_path / "imu.csv").write_text("\n".join([names, units, *rows]), "utf-8")
    log = read_imu(tmp_path / "imu.csv")
    assert log.acc is not None
    assert log.gyr is not None
    assert log.time_s[:2] == pytest.approx([0.0, 0.01])
    assert log.acc[0] == pytest.approx([0.980665, 0.0, 9.80665])
    assert log.gyr[0, 0] == pytest.approx(np.pi / 2)
    assert log.lines[0] == 3
    (tmp_path / "imu.csv").write_text("\n".join([names, units.replace("g", "?"), *rows]), "utf-8")
    with pytest.raises(pt.InputError, match="expected a number"):
        read_imu(tmp_path / "imu.csv")
