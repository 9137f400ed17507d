"""One kind of IMU log for every file format, and the checks that every log must pass."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.rotation import conjugate, multiply, quaternion_to_rotation_vector, rotate

__all__ = ["ImuLog", "check"]

Float = NDArray[np.float64]

GRAVITY = 9.80665
NORM_TOLERANCE = 0.02
RATE_TOLERANCE = 0.05
GAP_INTERVALS = 1.5
SLOWEST_S = 0.2
TURN_S = 0.1
"""Turns of gyroscope and orientation are compared over so long: noise of the orientation is small beside them, s."""
TURNING = 0.5
"""What counts as turning, rad/s."""
ENOUGH_S = 1.0
"""Less turning than this says nothing; an accelerometer that repeats itself for longer stands still, s."""


@dataclass(frozen=True, eq=False)
class ImuLog:
    """What an IMU file holds, in its own time and frames, SI units.

    Attributes:
        path: the file.
        lines: line number of every sample, `(M,)`.
        time_s: `(M,)`, s.
        acc: specific force, m/s² `(M, 3)`.
        gyr: turn rate, rad/s `(M, 3)`.
        mag: magnetic field, any unit `(M, 3)`.
        q_world_sensor: sensor to the sensor's earth frame, w first `(M, 4)`.
        rate_hz: as the file states it.
        warnings: what is odd but usable.
    """

    path: Path
    lines: NDArray[np.int64]
    time_s: Float
    acc: Float | None = None
    gyr: Float | None = None
    mag: Float | None = None
    q_world_sensor: Float | None = None
    rate_hz: float | None = None
    warnings: tuple[str, ...] = ()


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
    warnings += _repeats(log)
    if log.q_world_sensor is None:
        return dataclasses.replace(log, warnings=tuple(warnings))
    norm = np.linalg.norm(log.q_world_sensor, axis=1)
    off = np.flatnonzero(np.abs(norm - 1) > NORM_TOLERANCE)
    if off.size:
        raise InputError(
            f"{log.path}:{log.lines[off[0]]}: quaternion has norm {norm[off[0]]:.4f}, expected 1 ± {NORM_TOLERANCE} "
            f"({off.size} of {len(norm)} samples)"
        )
    log = dataclasses.replace(log, q_world_sensor=log.q_world_sensor / norm[:, None], warnings=tuple(warnings))
    _check_orientation(log)
    _check_turns(log)
    return log


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


def _check_orientation(log: ImuLog) -> None:
    """Turned to the world and averaged, acceleration is gravity: up, 9.81."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    mean = rotate(log.q_world_sensor, log.acc).mean(axis=0)
    if np.linalg.norm(mean - [0.0, 0.0, GRAVITY]) <= 0.35 * GRAVITY:
        return
    inverse = rotate(log.q_world_sensor * [1.0, -1.0, -1.0, -1.0], log.acc).mean(axis=0)
    hint = "orientation that takes sensor vectors to a world with z up, w first"
    if np.linalg.norm(inverse - [0.0, 0.0, GRAVITY]) <= 0.35 * GRAVITY:
        hint += "; the inverse fits, so these seem to take the world to the sensor"
    raise InputError(
        f"{log.path}: turned by the orientation, the mean acceleration is "
        f"({mean[0]:.2f}, {mean[1]:.2f}, {mean[2]:.2f}) m/s², expected about (0, 0, 9.81): {hint}"
    )


def _check_turns(log: ImuLog) -> None:
    """What the gyroscope measures is what the orientation does: a unit, an axis, a sensor that stands still."""
    if log.gyr is None:
        return
    assert log.q_world_sensor is not None
    stride = max(1, round(TURN_S / float(np.median(np.diff(log.time_s)))))
    at = np.arange(0, len(log.time_s), stride)
    lasted = np.diff(log.time_s[at])
    q = log.q_world_sensor[at]
    by_orientation = quaternion_to_rotation_vector(multiply(conjugate(q[:-1]), q[1:])) / lasted[:, None]
    steps = 0.5 * (log.gyr[1:] + log.gyr[:-1]) * np.diff(log.time_s)[:, None]
    angle = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])[at]
    by_gyroscope = np.diff(angle, axis=0) / lasted[:, None]
    rates = np.stack([np.linalg.norm(by_gyroscope, axis=1), np.linalg.norm(by_orientation, axis=1)])
    turning = np.flatnonzero(rates.max(axis=0) > TURNING)
    if lasted[turning].sum() < ENOUGH_S:
        return
    # 1 where they are the same, 0 where one stands still or turns about another axis.
    agreement = np.sum(by_gyroscope * by_orientation, axis=1)[turning] / rates.max(axis=0)[turning] ** 2
    if np.median(agreement) >= 0.5:
        return
    usual = np.median(rates[:, turning], axis=1)
    ratio = usual[1] / max(usual[0], np.finfo(float).tiny)
    hint = "their axes differ"
    if 1 / 80 < ratio < 1 / 40:
        hint = "these look like degrees per second"
    elif ratio < 0.2:
        hint = "the orientation stands still"
    elif ratio > 5:
        hint = "the gyroscope stands still"
    worst = turning[agreement < 0.5][0]
    raise InputError(
        f"{log.path}:{log.lines[at[worst]]}: the gyroscope turns at {rates[0, worst]:.3g} rad/s and the orientation at "
        f"{rates[1, worst]:.3g} rad/s, expected them to agree; over the recording {usual[0]:.3g} and {usual[1]:.3g} "
        f"rad/s: {hint}"
    )


def _repeats(log: ImuLog) -> list[str]:
    """Warns of an accelerometer that says the same for long: noise never does, a sensor that hangs does."""
    assert log.acc is not None
    changes = np.flatnonzero(np.any(np.diff(log.acc, axis=0) != 0, axis=1)) + 1
    edges = np.concatenate([[0], changes, [len(log.acc)]])
    starts, ends = edges[:-1], edges[1:] - 1
    lasted = log.time_s[ends] - log.time_s[starts]
    longest = int(np.argmax(lasted))
    if lasted[longest] <= ENOUGH_S:
        return []
    return [
        f"{log.path}:{log.lines[starts[longest]]}: the acceleration stays at {log.acc[starts[longest]].tolist()} m/s² "
        f"for {lasted[longest]:.3f} s, expected some noise: did the sensor hang?"
    ]
