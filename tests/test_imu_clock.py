"""The clock of an IMU's file: dates, times of day, units that are not said, rows that are only counted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.check import check
from pytracker.inertial.log import ImuLog


def test_rows_without_a_time_follow_at_the_rate_that_is_given(tmp_path: Path) -> None:
    path = tmp_path / "x-imu.csv"
    path.write_text("Packet number,Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)\n7,0,0,1\n8,0,0,1\n")
    with pytest.raises(pt.InputError, match=r"no column time_s .*, or rate_hz for rows without a time"):
        read_imu(path)
    assert read_imu(path, rate_hz=256.0).time_s.tolist() == [0.0, 1 / 256]


def test_a_date_that_is_none_is_named(tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text("time,acc_x,acc_y,acc_z\n2024-02-28 12:00:00.00,0,0,9.8\n2024-02-31 12:00:00.01,0,0,9.8\n")
    with pytest.raises(pt.InputError, match=r"imu\.csv:3: time is '2024-02-31 12:00:00.01', expected a date and time"):
        read_imu(path)


@pytest.mark.parametrize("clock", ["24:00:00.01", "12:00:61", "12:00:00 XM", "13.13.2024 12:00:00", "12:00:00.01.2"])
def test_a_time_of_day_that_is_none_is_named(clock: str, tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text(f"time,acc_x,acc_y,acc_z\n12:00:00.00,0,0,9.8\n{clock},0,0,9.8\n")
    with pytest.raises(pt.InputError, match=rf"imu\.csv:3: time is '{clock}', expected a date and time, a time of day"):
        read_imu(path)


def test_a_time_of_day_that_goes_back_is_not_the_next_day(tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text("time;acc_x;acc_y;acc_z\n12:00:00,01;0;0;9,8\n12:00:00,00;0;0;9,8\n12:00:00,02;0;0;9,8\n")
    assert read_imu(path).time_s == pytest.approx([0.0, -0.01, 0.01], abs=1e-9)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("12:59:59.99", "01:00:00.00", "12 hours without AM and PM"),
        ("2024-10-27 02:59:59.99", "2024-10-27 02:00:00.00", "set back by an hour"),
    ],
)
def test_a_clock_of_half_a_day_or_that_was_set_goes_on(before: str, after: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    clocks = [before[:-2] + f"{k:02}" for k in range(90, 100)] + [after[:-2] + f"{k:02}" for k in range(10)]
    path.write_text("time,acc_x,acc_y,acc_z\n" + "".join(f"{clock},0,0,9.8\n" for clock in clocks))
    log = read_imu(path)
    assert log.time_s == pytest.approx(0.01 * np.arange(20), abs=1e-6)
    (said,) = log.warnings
    assert words in said
    assert "imu.csv:12: its clock goes by" in said


def test_a_clock_that_counts_samples_goes_at_the_rate_that_is_given(tmp_path: Path) -> None:
    """It was taken for milliseconds of 1000 Hz, and the rate that it asked for was refused."""
    path = tmp_path / "imu.csv"
    path.write_text("time,acc_x,acc_y,acc_z\n" + "".join(f"{k},0,0,9.8\n" for k in range(50)))
    assert "Or does it count samples? rate_hz would say how fast" in read_imu(path).warnings[0]
    log = read_imu(path, rate_hz=60.0)
    assert np.diff(log.time_s) == pytest.approx(1 / 60)
    assert log.warnings == (f"{path}: its clock counts samples: taken at 60 Hz",)
    assert check(log).rate_hz == log.rate_hz


def test_ticks_of_a_clock_are_told_by_their_size_or_the_rate(tmp_path: Path) -> None:
    """Of .NET's 100 ns an IMU of 100 Hz was one of 10 Hz: 23 cm off, valid, and the camera was blamed."""

    def of(first: int, step: int, **more: float) -> ImuLog:
        path = tmp_path / "imu.csv"
        rows = "".join(f"{first + k * step},0,0,9.8\n" for k in range(50))
        path.write_text("timestamp,acc_x,acc_y,acc_z\n" + rows)
        return read_imu(path, **more)  # type: ignore[arg-type]

    for first in (638_500_000_000_000_000, 133_500_000_000_000_000):
        log = of(first, 100_000)
        assert np.diff(log.time_s) == pytest.approx(0.01, abs=1e-4)
        assert "taken as ticks of 100 ns, of 100 Hz" in log.warnings[0]
    log = of(0, 100_000)
    assert "taken as microseconds, of 10 Hz" in log.warnings[0]
    assert "Or is it in ticks of 100 ns, of 100 Hz? rate_hz would say it" in log.warnings[0]
    assert np.diff(of(0, 100_000, rate_hz=100.0).time_s) == pytest.approx(0.01)
    assert np.diff(of(0, 100, rate_hz=100.0).time_s) == pytest.approx(0.01)


def test_what_was_guessed_is_said_where_a_log_contradicts_itself(tmp_path: Path) -> None:
    """The hint at another unit of the gyroscope led from a clock that was read ten times too slow to a wrong track."""
    path = tmp_path / "imu.csv"
    path.write_text("timestamp,acc_x,acc_y,acc_z\n" + "".join(f"{k * 100_000},0,0,1\n" for k in range(50)))
    with pytest.raises(pt.InputError, match=r"units of g.*its clock does not say its unit"):
        check(read_imu(path))
