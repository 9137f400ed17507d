"""What loggers do to a file: clocks that begin again, a last row that is cut short, zeros and words below it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_formats_imu import load, write

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.rotation import Array
from pytracker.simulate import ArmSimulation


@pytest.fixture(scope="module")
def arm() -> Array:
    """20 s of a simulated wrist: time, acceleration, turn rate, orientation."""
    imu = ArmSimulation(pt.ArmScene(duration_s=20.0), seed=4).imu
    assert imu.gyr is not None
    return np.column_stack([imu.time_s, imu.acc, imu.gyr, imu.q_world_segment])


@pytest.mark.parametrize(("unit", "turn"), [("time_ms", 2**32), ("time_us", 2**32), ("time_ms", 86_400_000)])
def test_a_clock_that_begins_again_goes_on(tmp_path: Path, arm: Array, unit: str, turn: int) -> None:
    """micros() does so every 71 minutes: the file was refused."""
    per_s = {"time_ms": 1e3, "time_us": 1e6}[unit]
    rows = [[str(x) for x in row] for row in arm]
    for row, at in zip(rows, arm[:, 0], strict=True):
        row[0] = str(round(at * per_s + turn - 5 * per_s) % turn)
    path = write(tmp_path / "imu.csv", rows)
    path.write_text(path.read_text().replace("time_s", unit, 1))
    log = load(path)
    assert np.allclose(np.diff(log.time_s), 0.01)
    assert "begun again after" in log.warnings[0]


def test_a_date_that_is_cut_short_is_no_sample(tmp_path: Path, arm: Array) -> None:
    rows = [[f"2026-05-01T10:00:{at[0]:09.6f}", *(str(x) for x in at[1:])] for at in arm[:1000]]
    path = write(tmp_path / "imu.csv", rows)
    path.write_text(path.read_text().replace("time_s", "timestamp", 1).rstrip("\n") + "\n2026-05-01T10:0")
    log = load(path)
    assert len(log.time_s) == 1000
    assert "its last row has 1 cells of 11" in " ".join(log.warnings)


@pytest.mark.parametrize("end", ["19.99,0.1,0.2", "# end of log", "\0" * 512, "\n\n"])
def test_what_a_logger_leaves_at_the_end_is_no_sample(tmp_path: Path, arm: Array, end: str) -> None:
    """A row that was being written when its power went, or zeros of its last block: all was refused."""
    path = write(tmp_path / "imu.csv", arm.tolist())
    path.write_text(path.read_text().rstrip("\n") + "\n" + end)
    log = load(path)
    assert len(log.time_s) == len(arm)
    assert [words.split(": ", 1)[1] for words in log.warnings] == (
        ["its last row has 3 cells of 11: the file is cut short there, the row left out"] if "0.2" in end else []
    )


def test_a_clock_that_stands_before_every_channel_is_named_by_its_number(tmp_path: Path) -> None:
    """Delsys: muscles are faster than the accelerometer, whose cells are empty below its last."""
    path = tmp_path / "delsys.csv"
    rows = [
        f"{k / 100},0.1,{k / 50},0,{k / 50},0,{k / 50},{9.8 + k}" if k < 20 else f"{k / 100},0.1,,,,,,"
        for k in range(40)
    ]
    path.write_text("\n".join(["Label: arm", "", "X[s],EMG [V],X[s],ACC a,X[s],ACC b,X[s],ACC c", *rows]) + "\n")
    columns = {"time_s": "X[s].1", "acc_x": "ACC a", "acc_y": "ACC b", "acc_z": "ACC c"}
    log = read_imu(path, columns=columns)
    assert log.time_s == pytest.approx(np.arange(20) / 50)
    assert log.acc is not None
    assert log.acc[:, 2] == pytest.approx(9.8 + np.arange(20))


def test_a_map_of_columns_finds_their_header(tmp_path: Path) -> None:
    """Noraxon: names with commas in quotes, below what it says of the recording; minutes; m/s/s of Blue Trident."""
    path = tmp_path / "noraxon.csv"
    path.write_text(
        '"Type","Trial"\n"Name","a"\n\n"time,min","Arm X,mG","Arm Y,mG","Arm Z,mG"\n0,0,0,1000\n1,0,0,1000\n'
    )
    columns = {"time_s": "time,min", **{f"acc_{axis}": f"Arm {axis.upper()},mG" for axis in "xyz"}}
    log = read_imu(path, columns=columns)
    assert log.time_s.tolist() == [0.0, 60.0]
    assert log.acc is not None
    assert log.acc[0] == pytest.approx([0.0, 0.0, 9.80665])
    path.write_text("time_s,ax_m/s/s,ay_m/s/s,az_m/s/s\n0,0,0,9.8\n0.01,0,0,9.8\n")
    assert read_imu(path).acc is not None


def test_an_export_with_the_time_of_day_alone_has_times(tmp_path: Path) -> None:
    """MT Manager's UTC columns: a rate was asked for, and a wrong one believed."""
    path = tmp_path / "mt.txt"
    clocks = [(23, 59, 59, 980_000_000), (23, 59, 59, 990_000_000), (0, 0, 0, 0), (0, 0, 0, 10_000_000)]
    rows = [
        f"{k}\t{nano}\t{hour}\t{minute}\t{second}\t0\t0\t9.8" for k, (hour, minute, second, nano) in enumerate(clocks)
    ]
    header = "PacketCounter\tUTC_Nano\tUTC_Hour\tUTC_Minute\tUTC_Second\tAcc_X\tAcc_Y\tAcc_Z"
    path.write_text("\n".join(["// General information:", header, *rows]) + "\n")
    assert read_imu(path).time_s == pytest.approx(0.01 * np.arange(4), abs=1e-6)


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-16"])
def test_what_windows_calls_unicode_is_text(encoding: str, tmp_path: Path) -> None:
    """Without its mark it was a binary file."""
    path = tmp_path / "imu.csv"
    path.write_bytes("time_s,acc_x,acc_y,acc_z\r\n0,0,0,9.8\r\n0.01,0,0,9.8\r\n".encode(encoding))
    assert read_imu(path).time_s == pytest.approx([0.0, 0.01])
    path.write_bytes(bytes(range(256)) * 4)
    with pytest.raises(pt.InputError, match="is a binary file"):
        read_imu(path)


@pytest.mark.parametrize(
    ("unit_s", "first_s", "rate_hz", "words"),
    [
        (86400.0, 45413.5 * 86400.0, 100.0, "days, of 100 Hz"),
        (86400.0, 45413.5 * 86400.0, 10.0, "days, of 10 Hz"),
        (86400.0, 43200.0, 100.0, "days, of 100 Hz"),
        (3600.0, 43200.0, 100.0, "hours, of 100 Hz"),
        (3600.0, 0.0, 200.0, "hours, of 200 Hz"),
    ],
)
def test_a_spreadsheets_days_are_told_by_their_size(
    unit_s: float, first_s: float, rate_hz: float, words: str, tmp_path: Path
) -> None:
    """Samples were 0.1 µs apart; "in milliseconds?", it said."""
    path = tmp_path / "imu.csv"
    rows = "".join(f"{(first_s + k / rate_hz) / unit_s:.12f},0,0,9.8\n" for k in range(50))
    path.write_text("time,acc_x,acc_y,acc_z\n" + rows)
    log = read_imu(path)
    assert np.diff(log.time_s) == pytest.approx(1.0 / rate_hz, abs=1e-4)
    assert words in log.warnings[0]


def test_bursts_are_no_days(tmp_path: Path) -> None:
    """Within them samples are microseconds apart, as those of a spreadsheet's days are."""
    path = tmp_path / "imu.csv"
    rows = "".join(f"{0.64 * (k // 64) + 1e-6 * (k % 64):.6f},0,0,9.8\n" for k in range(2000))
    path.write_text("time,acc_x,acc_y,acc_z\n" + rows)
    assert float(np.ptp(read_imu(path).time_s)) == pytest.approx(0.64 * 31, abs=0.01)


def test_a_quaternion_of_a_letter_and_three_numbers_is_one(tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text("time_s,acc_x,acc_y,acc_z,qw,q1,q2,q3\n0,0,0,9.8,1,0,0,0\n0.01,-,--,nan(ind),0.6,0,0.8,0\n")
    log = read_imu(path)
    assert log.q_world_sensor is not None
    assert log.q_world_sensor[1].tolist() == [0.6, 0.0, 0.8, 0.0]
    assert "columns q_w, q1, q2, q3 are taken as a quaternion's w, x, y, z" in log.warnings[0]
    assert log.acc is not None
    assert np.isnan(log.acc[1]).all()


def test_a_header_that_comes_again_is_named(tmp_path: Path) -> None:
    """Loggers append: time_s was 'time_s', expected a number."""
    path = tmp_path / "imu.csv"
    once = "time_s,acc_x,acc_y,acc_z\n0,0,0,9.8\n0.01,0,0,9.8\n"
    path.write_text(once + once)
    with pytest.raises(pt.InputError, match=r"imu\.csv:4: is the header of line 1 again, expected one recording"):
        read_imu(path)


def test_a_map_turns_signs(tmp_path: Path) -> None:
    """An iPhone's, or those of an axis that is mirrored."""
    path = tmp_path / "imu.csv"
    path.write_text(
        "a word\n\ntime_s,acc_x,acc_y,acc_z[mg],q_w,q_x,q_y,q_z\n0,1,2,-1000,1,0,0,0\n0.01,1,2,-1000,1,0,0,0\n"
    )
    log = read_imu(path, columns={"acc_x": "-acc_x", "acc_y": "acc_y", "acc_z": "-Acc_Z[mg]"})
    assert log.acc is not None
    assert log.acc[0] == pytest.approx([-1.0, 2.0, 9.80665])
    with pytest.raises(pt.InputError, match="expected a sign before acc_x, "):
        read_imu(path, columns={"q_x": "-q_x"})
    with pytest.raises(pt.InputError, match=r"columns\.acc_x is '-a', but the header has no such column"):
        read_imu(path, columns={"acc_x": "-a"})


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("2024/05/01 10:00:00.00", "2024/05/01 10:00:00.25"),
        ("01.05.2024 10:00:00,00", "01.05.2024 10:00:00,25"),
        ("04/30/2024 11:59:59.90 PM", "05/01/2024 12:00:00.15 AM"),
        ("20240501T105950.75Z", "20240501T105951Z"),
        ("2024-10-27T02:59:59.990+02:00", "2024-10-27T02:00:00.240+01"),
        ("11:59:59.9 am", "12:00:00.15 pm"),
        ("23:59:59.9", "00:00:00.15"),
        ("59:59.9", "00:00.15"),
        ("10:00:59:900", "10:01:00:150"),
        ("07/11/2024 23:59:59.90", "08/11/2024 00:00:00.15"),
        ("13/11/2024 23:59:59.90", "14/11/2024 00:00:00.15"),
    ],
)
def test_dates_are_read_as_others_write_them(first: str, second: str, tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text(f"time;acc_x;acc_y;acc_z\n{first};0;0;9.8\n{second};0;0;9.8\n")
    assert read_imu(path).time_s == pytest.approx([0.0, 0.25])
