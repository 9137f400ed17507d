"""Samples that no sensor measured: readings filled in by straight lines or held, and an orientation that hangs.

A sensor trembles: none of its readings goes straight on, to the last digit, for long. A filled gap that is believed
looks like an arm that moved evenly; left out it is a gap, over which bands open.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.rotation import conjugate, rotate
from pytracker.series import last_digit, runs

__all__ = ["without_filled"]

Float = NDArray[np.float64]

RUN, RUN_S = 10, 0.1
"""So many samples in a row, for so long, lie on a straight line only where nothing was measured."""
HANGS_S = 0.3
"""An orientation that stays the same for so long while the sensor moves hangs; some are written more slowly, s."""
STRAIGHT = {"acc": 0.002, "gyr": 0.0002}
"""What lies on a line is no farther off it than this (m/s², rad/s), or than digits that are rounded."""
TREMBLE = 10.0
"""Other readings are usually so many times farther off it: else straightness tells nothing."""
TURNS_RAD, TURNS_RAD_S = 0.1, 0.1
"""A gyroscope that goes so far at such a rate, beyond what it usually reads, turns."""
SHAKES = 0.5
"""An acceleration that varies by so much is that of a sensor that moves, m/s², standard deviation."""
DIGITS = 5
"""Numbers of more decimals were computed, not rounded."""
COARSE = 0.005
"""An orientation of coarser digits may stay the same."""
GRAVITY_TURNS, DIGITS_TURNED = 0.5, 3.0
"""An acceleration that stays the same while gravity goes farther in the sensor, m/s², and by so many digits, hangs."""
MOST_SHARE = 0.5
"""An orientation, or acceleration, that hangs in more than this share of the samples is none."""


def without_filled(log: ImuLog) -> ImuLog:
    """The log without samples that nobody measured, each cause with a warning.

    Raises `InputError` where orientation or acceleration hang in most of them.
    """
    for find, what, words in (
        (_on_lines, "readings", "lie on straight lines, to the last digit: filled in or held, not measured"),
        (_hanging, "orientations", "stay the same while the sensor moves: they hang"),
        (_held_alone, "accelerations", "stay the same while gravity turns in the sensor, or are all 0: they hang"),
    ):
        found = find(log)
        spans = runs(found)
        if not spans:
            continue
        a, b = max(((a, after - 1) for a, after in spans), key=lambda span: log.time_s[span[1]] - log.time_s[span[0]])
        warning = (
            f"{log.path}:{log.lines[a]}: {what} of {int(found.sum())} samples {words}, and are left out as a "
            f"gap; longest for {log.time_s[b] - log.time_s[a]:.3f} s, to line {log.lines[b]}"
        )
        log = dataclasses.replace(log.kept(~found), warnings=(*log.warnings, warning))
    return log


def _on_lines(log: ImuLog) -> NDArray[np.bool_]:
    """Which samples lie between their neighbours in every reading, for long, or are the same as before `(M,)`."""
    found = np.zeros(len(log.time_s), dtype=bool)
    if len(found) < RUN + 2:
        return found
    step = np.diff(log.time_s)
    share = (step[1:] / (step[1:] + step[:-1]))[:, None]
    straight, held = np.ones(len(found) - 2, dtype=bool), np.ones(len(found), dtype=bool)
    for name, least in STRAIGHT.items():
        values = getattr(log, name)
        if values is None:
            continue
        off = np.abs(values[1:-1] - share * values[:-2] - (1 - share) * values[2:]).max(axis=1)
        most = max(least, 1.01 * last_digit(values, DIGITS))
        if np.median(off) < TREMBLE * most:
            return found
        straight &= off <= most
        held[1:] &= np.all(values[1:] == values[:-1], axis=1)
    for a, after in _long(straight, log.time_s[1:-1], RUN_S):
        # The last of what is held has its end elsewhere.
        found[a + 1 : after + 1 + held[after + 1]] = True
    return found


def _hanging(log: ImuLog) -> NDArray[np.bool_]:
    """Which samples have the orientation of the one before though the sensor moves `(M,)`."""
    found = np.zeros(len(log.time_s), dtype=bool)
    q = log.q_world_sensor
    if q is None or last_digit(q, DIGITS) > COARSE:
        return found
    same = np.concatenate([[False], np.all(q[1:] == q[:-1], axis=1)])
    for a, after in _long(same, log.time_s, HANGS_S):
        found[a:after] = _moves(log, a, after)
    if found.mean() > MOST_SHARE:
        raise InputError(
            f"{log.path}:{log.lines[int(np.argmax(found))]}: the orientation stays the same in {int(found.sum())} of "
            f"{len(found)} samples while the sensor moves, expected it to turn: does the orientation stand still, or "
            "is it written too slowly?"
        )
    return found


def _held_alone(log: ImuLog) -> NDArray[np.bool_]:
    """Which samples have the acceleration of the one before though gravity turns in the sensor, or none `(M,)`."""
    found = np.zeros(len(log.time_s), dtype=bool)
    if log.acc is None:
        return found
    is_none = np.all(log.acc == 0.0, axis=1)
    for a, after in _long(is_none, log.time_s, RUN_S):
        found[a:after] = True
    steps = np.abs(np.diff(log.acc, axis=0))
    digit = float(steps[steps > 0.0].min(initial=np.inf))
    same = np.concatenate([[False], np.all(steps == 0.0, axis=1)])
    for a, after in _long(same, log.time_s, RUN_S):
        found[a:after] |= _gravity_turns(log, a, after) > max(GRAVITY_TURNS, DIGITS_TURNED * digit)
    if found.mean() > MOST_SHARE:
        raise InputError(
            f"{log.path}:{log.lines[int(np.argmax(found))]}: the acceleration stays the same in {int(found.sum())} of "
            f"{len(found)} samples while gravity turns in the sensor, expected it to turn too: was it off?"
        )
    return found


def _gravity_turns(log: ImuLog, a: int, b: int) -> float:
    """How far gravity goes in the sensor from sample `a` up to `b`, by gyroscope or else orientation, m/s²."""
    if log.gyr is not None and log.acc is not None:
        rate = log.gyr[a:b] - np.median(log.gyr, axis=0)
        size = float(np.linalg.norm(log.acc[a]))
        aside = np.cross(rate[1:], log.acc[a] / size if size > 0.0 else np.zeros(3))
        turned = np.cumsum(aside * np.diff(log.time_s[a:b])[:, None], axis=0)
        return GRAVITY * float(np.linalg.norm(turned, axis=1).max())
    if log.q_world_sensor is None:
        return 0.0
    up = rotate(conjugate(log.q_world_sensor[a:b]), np.array([0.0, 0.0, GRAVITY]))
    return float(np.linalg.norm(up - up[0], axis=1).max())


def _moves(log: ImuLog, a: int, b: int) -> bool:
    """Whether the readings from sample `a` up to `b` are those of a sensor that moves."""
    if log.acc is not None and log.acc[a:b].std(axis=0).max() > SHAKES:
        return True
    if log.gyr is None:
        return False
    rate = log.gyr[a:b] - np.median(log.gyr, axis=0)
    turned = np.cumsum(rate[1:] * np.diff(log.time_s[a:b])[:, None], axis=0)
    farthest = np.linalg.norm(turned, axis=1).max()
    return bool(farthest > TURNS_RAD and np.linalg.norm(rate, axis=1).mean() > TURNS_RAD_S)


def _long(is_so: NDArray[np.bool_], time_s: Float, least_s: float) -> list[tuple[int, int]]:
    """Runs that are long: first sample and the one after the last."""
    return [(a, after) for a, after in runs(is_so, RUN) if time_s[after - 1] - time_s[a] >= 0.99 * least_s]
