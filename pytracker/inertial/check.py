"""What every IMU log must pass, whatever file it came from: numbers, times, units, and that it agrees with itself."""

from __future__ import annotations

import dataclasses

import numpy as np

from pytracker._core import InputError
from pytracker.inertial.agreement import check_turns
from pytracker.inertial.bursts import comes_in_bursts, evened
from pytracker.inertial.filled import without_filled
from pytracker.inertial.gravity import check_size, check_step, check_up
from pytracker.inertial.interleaved import check_interleaved
from pytracker.inertial.log import ImuLog
from pytracker.inertial.noise import check_noise, repeats
from pytracker.inertial.outliers import without_outliers
from pytracker.inertial.saturation import saturates

__all__ = ["check"]

RATE_TOLERANCE = 0.05
"""A stated rate agrees with the times to this share."""
GAP_INTERVALS = 1.5
"""An interval that is longer than so many usual ones is a gap."""
SLOWEST_S, FASTEST_S = 0.2, 5e-5
"""No sensor's samples are farther apart, or nearer on average, s."""
JUMP_S = 600.0
"""No recording has a longer gap, s."""
RESTART_S = 1.0
"""Whoever was started anew said nothing for so long, and an orientation filter then may have another heading."""


def check(log: ImuLog) -> ImuLog:
    """Everything that would give a wrong answer quietly; returns the log with unit quaternions and warnings.

    Single samples that no sensor can have given, and those that were filled in or held, are left out, with a warning.
    Raises `InputError` for missing acceleration, times that do not increase, a rate that contradicts them, samples of
    several sensors in turn, many values that are no numbers or beyond any sensor, quaternions that are not of unit
    length, acceleration that is in g or shows no gravity, and orientation that contradicts gravity or the gyroscope.
    """
    if log.acc is None:
        raise InputError(f"{log.path}: has no acceleration, expected columns acc_x, acc_y, acc_z (Acc_X, Acc_Y, Acc_Z)")
    if len(log.time_s) < 2:
        raise InputError(f"{log.path}: has {len(log.time_s)} sample, expected at least 2")
    if not np.isfinite(log.time_s).all():
        k = int(np.argmin(np.isfinite(log.time_s)))
        raise InputError(f"{log.path}:{log.lines[k]}: time_s is {log.time_s[k]}, expected a finite number")
    guessed = log.warnings
    log = evened(log)
    times = _check_times(log)
    times += check_interleaved(log)
    log = without_filled(without_outliers(log))
    standing = saturates(log)
    try:
        itself = _check_itself(dataclasses.replace(log, warnings=()))
    except InputError as error:
        # A range that is too small, or a unit that was guessed, may be all that is wrong with it.
        raise InputError("; ".join([*standing[:1], str(error), *guessed])) from None
    return dataclasses.replace(itself, warnings=(*log.warnings, *times, *standing, *itself.warnings))


def _check_itself(log: ImuLog) -> ImuLog:
    """Whether it agrees with itself: gravity, orientation and turns."""
    warnings = [*check_size(log), *repeats(log), *check_noise(log)]
    if log.q_world_sensor is None:
        return dataclasses.replace(log, warnings=tuple(warnings))
    norm = np.linalg.norm(log.q_world_sensor, axis=1)
    log = dataclasses.replace(log, q_world_sensor=log.q_world_sensor / norm[:, None])
    turns = check_turns(log)
    up = check_up(log, "orientation that takes sensor vectors to a world with z up, w first")
    return dataclasses.replace(log, warnings=(*warnings, *up, *turns, *([] if up else check_step(log))))


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
            f"{log.path}: samples are {usual:g} s apart, expected at most {SLOWEST_S} s: are the times in "
            f"{'micro' if usual > 1000 * SLOWEST_S else 'milli'}seconds?"
        )
    if interval.mean() < FASTEST_S:
        raise InputError(
            f"{log.path}: samples are {interval.mean():.3g} s apart on average, expected at least {FASTEST_S:g} s: are "
            "the times in seconds or milliseconds, and taken for smaller units?"
        )
    rate = log.rate_hz
    # Rounded times are off one by one, and right on average; gaps make it the other way round.
    if rate is not None and min(abs(step * rate - 1) for step in (usual, float(interval.mean()))) > RATE_TOLERANCE:
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
    if comes_in_bursts(log):
        return []
    gaps = np.flatnonzero(interval > GAP_INTERVALS * usual)
    if not gaps.size:
        return []
    longest = gaps[np.argmax(interval[gaps])]
    restart = (
        ": was the sensor started anew there? Its heading may be another from then on"
        if interval[longest] > RESTART_S
        else ""
    )
    return [
        f"{log.path}: {gaps.size} gap{'s' if gaps.size > 1 else ''} between samples, the longest "
        f"{interval[longest]:.3f} s at line {log.lines[longest + 1]} ({log.time_s[longest]:.3f} s); "
        f"usual interval {usual:.4f} s{restart}"
    ]
