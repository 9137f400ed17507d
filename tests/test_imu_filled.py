"""Samples of an IMU that nobody measured: filled in by lines, held, or of what was off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from test_formats_imu import load
from test_imu_faults import ACC, FILLED, GYR, QUATERNION, arm, told

import pytracker as pt
from pytracker.inertial.check import check
from pytracker.inertial.filled import without_filled
from pytracker.inertial.log import ImuLog
from pytracker.rotation import Array

__all__ = ["arm"]


def filled(arm: Array, digits: int) -> Array:
    """Half a second of every reading on a straight line from the sample before to the one after."""
    table, first, last = arm.copy(), FILLED.start - 1, FILLED.stop
    share = np.linspace(0.0, 1.0, last - first + 1)[:, None]
    table[first : last + 1, 1:] = (1.0 - share) * arm[first, 1:] + share * arm[last, 1:]
    table[:, QUATERNION] /= np.linalg.norm(table[:, QUATERNION], axis=1, keepdims=True)
    return table.round(digits)


def held(arm: Array, columns: slice) -> Array:
    """Half a second that repeats the sample before."""
    table = arm.copy()
    table[FILLED, columns] = arm[FILLED.start - 1, columns]
    return table


def dead(arm: Array) -> NDArray[np.bool_]:
    """Where an accelerometer that is off says 0, 0, 0."""
    found = np.zeros(arm.shape, dtype=bool)
    found[FILLED, ACC] = True
    return found


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda arm: filled(arm, 9), "readings of 50 samples lie on straight lines"),
        (lambda arm: filled(arm, 4), "readings of 50 samples lie on straight lines"),
        (lambda arm: held(arm, slice(1, 11)), "readings of 50 samples lie on straight lines"),
        (lambda arm: held(arm, QUATERNION), "orientations of 50 samples stay the same while the sensor moves"),
        (lambda arm: held(arm, ACC), "accelerations of 50 samples stay the same while"),
        (
            lambda arm: np.where(dead(arm), 0.0, arm),
            "accelerations of 50 samples stay the same while",
        ),
    ],
)
def test_what_was_filled_in_or_hangs_is_a_gap_and_said(
    tmp_path: Path, arm: Array, spoil: Callable[[Array], Array], words: str
) -> None:
    said = told(tmp_path, spoil(arm))
    assert f"imu.csv:702: {words}" in said
    assert "longest for 0.490 s, to line 751" in said
    log = load(tmp_path / "imu.csv")
    assert np.allclose(log.time_s, np.delete(arm[:, 0], FILLED))


def test_both_are_left_out(tmp_path: Path, arm: Array) -> None:
    table = filled(arm, 6)
    table[1200:1300, QUATERNION] = table[1199, QUATERNION]
    said = told(tmp_path, table)
    assert "imu.csv:702: readings of 50 samples" in said
    assert "imu.csv:1202: orientations of 100 samples" in said
    assert len(load(tmp_path / "imu.csv").time_s) == len(arm) - 150


@pytest.mark.parametrize("has_gyr", [True, False])
def test_an_orientation_that_hangs_most_of_the_time_is_refused(arm: Array, has_gyr: bool) -> None:
    """Without a gyroscope nothing else tells."""
    q = arm[:, QUATERNION].copy()
    q[100:1400] = q[100]
    log = ImuLog(
        Path("imu.csv"), np.arange(len(arm)), arm[:, 0], arm[:, ACC], arm[:, GYR] if has_gyr else None, None, q
    )
    with pytest.raises(pt.InputError, match=r"imu\.csv:101: the orientation stays the same in 1299 of 2001 samples"):
        check(log)


@pytest.mark.parametrize("digit", [0.1, 0.01 * 9.80665])
def test_an_acceleration_of_coarse_digits_may_stay_while_the_sensor_turns_about_gravity(digit: float) -> None:
    time_s = np.arange(0.0, 20.0, 0.01)
    noise = np.random.default_rng(2)
    acc = np.array([0.0, 0.0, 9.81]) + noise.normal(0.0, 0.01, (len(time_s), 3))
    rate = 1.5 * np.sin(2.0 * time_s)
    gyr = np.column_stack([np.zeros((len(time_s), 2)), rate]) + noise.normal(0.0, 0.005, (len(time_s), 3))
    acc = digit * np.rint(acc / digit)
    log = without_filled(ImuLog(Path("imu.csv"), np.arange(len(time_s)), time_s, acc, gyr, None, None))
    assert len(log.time_s) == len(time_s)


def test_an_accelerometer_that_was_off_is_refused(arm: Array) -> None:
    acc = arm[:, ACC].copy()
    acc[100:1400] = 0.0
    log = ImuLog(Path("imu.csv"), np.arange(len(arm)), arm[:, 0], acc, arm[:, GYR], None, arm[:, QUATERNION])
    with pytest.raises(pt.InputError, match=r"imu\.csv:100: the acceleration stays the same in 1300 of 2001 samples"):
        check(log)


def resampled(arm: Array, times: int) -> Array:
    """The same with samples between its own, on straight lines."""
    time_s = np.linspace(arm[0, 0], arm[-1, 0], times * (len(arm) - 1) + 1)
    table = np.column_stack([time_s, *(np.interp(time_s, arm[:, 0], column) for column in arm.T[1:])])
    table[:, QUATERNION] /= np.linalg.norm(table[:, QUATERNION], axis=1, keepdims=True)
    return table


@pytest.mark.parametrize(
    "usual",
    [
        lambda arm: np.column_stack(
            [arm[:, 0], arm[:, ACC].round(1), arm[:, GYR].round(2), arm[:, QUATERNION].round(3)]
        ),
        lambda arm: resampled(arm, 2),
        lambda arm: resampled(arm, 12),
        lambda arm: np.column_stack([arm[:, 0], arm[np.arange(len(arm)) // 5 * 5, 1:]]),
        lambda arm: np.column_stack([arm[:, :7], arm[np.arange(len(arm)) // 10 * 10, 7:]]),
    ],
)
def test_coarse_digits_and_slow_sensors_are_no_gap(arm: Array, usual: Callable[[Array], Array]) -> None:
    table = usual(arm)
    log = ImuLog(
        Path("imu.csv"), np.arange(len(table)), table[:, 0], table[:, ACC], table[:, GYR], None, table[:, QUATERNION]
    )
    assert without_filled(log) is log


def test_a_sensor_that_lies_still_is_no_gap(arm: Array) -> None:
    """Its orientation may stay the same to the last digit, and its readings do tremble."""
    table = arm.copy()
    noise = np.random.default_rng(0).normal(0.0, [0.02] * 3 + [0.002] * 3, (400, 6))
    table[800:1200, 1:7] = np.concatenate([arm[800, ACC], [0.0, 0.0, 0.0]]) + noise
    table[800:1200, QUATERNION] = arm[800, QUATERNION]
    log = ImuLog(
        Path("imu.csv"), np.arange(len(table)), table[:, 0], table[:, ACC], table[:, GYR], None, table[:, QUATERNION]
    )
    assert without_filled(log) is log
