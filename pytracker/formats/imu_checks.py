"""What every IMU log must pass, whatever file it came from: numbers, times, units, and that it agrees with itself."""

from __future__ import annotations

import dataclasses

import numpy as np

from pytracker._core import InputError
from pytracker.formats.imu_agreement import check_gravity_is_up, check_turns, repeats
from pytracker.formats.imu_log import ImuLog

__all__ = ["check"]

NORM_TOLERANCE = 0.02
RATE_TOLERANCE = 0.05
GAP_INTERVALS = 1.5
SLOWEST_S = 0.2
JUMP_S = 600.0


def check(log: ImuLog) -> ImuLog:
    """Everything that would give a wrong answer quietly; returns the log with unit quaternions and warnings.

    Raises `InputError` for missing acceleration, times that do not increase, a rate that contradicts them,
    values that are no numbers, quaternions that are not of unit length, acceleration that is in g or shows no
    gravity, and orientation that contradicts gravity or the gyroscope.
    """
    if log.acc is None:
        raise InputError(f"{log.path}: has no acceleration, expected columns acc_x, acc_y, acc_z (Acc_X, Acc_Y, Acc_Z)")
    if len(log.time_s) < 2:
        raise InputError(f"{log.path}: has {len(log.time_s)} sample, expected at least 2")
    _check_numbers(log)
    warnings = [*log.warnings, *_check_times(log)]
    _check_gravity(log)
    warnings += repeats(log)
    if log.q_world_sensor is None:
        return dataclasses.replace(log, warnings=tuple(warnings))
    norm = np.linalg.norm(log.q_world_sensor, axis=1)
    off = np.flatnonzero(np.abs(norm - 1) > NORM_TOLERANCE)
    if off.size:
        raise InputError(
            f"{log.path}:{log.lines[off[0]]}: quaternion has norm {norm[off[0]]:.4f}, expected 1 ± {NORM_TOLERANCE} "
            f"({off.size} of {len(norm)} samples)"
        )
    log = dataclasses.replace(log, q_world_sensor=log.q_world_sensor / norm[:, None])
    check_gravity_is_up(log, "orientation that takes sensor vectors to a world with z up, w first")
    return dataclasses.replace(log, warnings=(*warnings, *check_turns(log)))


def _check_numbers(log: ImuLog) -> None:
    for name in ("time_s", "acc", "gyr", "q_world_sensor"):
        values = getattr(log, name)
        if values is None:
            continue
        bad = np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))
        if bad.size:
            raise InputError(
                f"{log.path}:{log.lines[bad[0]]}: {name} is {values[bad[0]].tolist()}, expected finite numbers "
                f"({bad.size} of {len(values)} samples)"
            )


def _check_times(log: ImuLog) -> list[str]:
    interval = np.diff(log.time_s)
    back = np.flatnonzero(interval <= 0)
    if back.size:
        k = back[0] + 1
        raise InputError(
            f"{log.path}:{log.lines[k]}: time {log.time_s[k]:.6f} s after {log.time_s[k - 1]:.6f} s, expected "
            f"increasing times ({back.size} such rows)"
        )
    usual = float(np.median(interval))
    if usual > SLOWEST_S:
        raise InputError(
            f"{log.path}: samples are {usual:g} s apart, expected at most {SLOWEST_S} s: are the times in milliseconds?"
        )
    rate = log.rate_hz
    if rate is not None and abs(usual * rate - 1) > RATE_TOLERANCE:
        raise InputError(
            f"{log.path}: the rate is stated as {rate:g} Hz, but the times are {1 / usual:.2f} Hz apart "
            f"(median interval {usual:.6f} s), expected them to agree within {RATE_TOLERANCE:.0%}"
        )
    jump = int(np.argmax(interval))
    if interval[jump] > JUMP_S:
        raise InputError(
            f"{log.path}:{log.lines[jump + 1]}: time jumps by {interval[jump]:.6g} s, expected one recording without "
            f"gaps of more than {JUMP_S:g} s"
        )
    gaps = np.flatnonzero(interval > GAP_INTERVALS * usual)
    if not gaps.size:
        return []
    longest = gaps[np.argmax(interval[gaps])]
    return [
        f"{log.path}: {gaps.size} gaps between samples, the longest {interval[longest]:.3f} s at line "
        f"{log.lines[longest + 1]} ({log.time_s[longest]:.3f} s); usual interval {usual:.4f} s"
    ]


def _check_gravity(log: ImuLog) -> None:
    assert log.acc is not None
    size = float(np.median(np.linalg.norm(log.acc, axis=1)))
    if 0.8 < size < 1.25:
        raise InputError(
            f"{log.path}: acceleration has a median length of {size:.3f}, which looks like units of g, expected m/s² "
            "with gravity (about 9.81 at rest)"
        )
    if not 6.0 < size < 16.0:
        raise InputError(
            f"{log.path}: acceleration has a median length of {size:.3f} m/s², expected about 9.81: the raw reading "
            "with gravity, not the free acceleration"
        )
