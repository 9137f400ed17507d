"""Units, quaternion and earth frame of an IMU file, found from its numbers alone.

A sensor that turns tells order and direction of its quaternion: the gyroscope turns as the orientation does. Gravity
tells the accelerometer's unit, and which way is up.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import get_args

import numpy as np

from pytracker.inertial.agreement import turns
from pytracker.inertial.conventions import Conventions, Direction, GyrUnit, Order, in_our_terms
from pytracker.inertial.gravity import GRAVITY, unsteadiness
from pytracker.inertial.log import ImuLog
from pytracker.inertial.orientation import (
    LEAST_UNSTEADY,
    MIRRORED,
    OTHER_SIGNS,
    STEADIER,
    steadiest_in_words,
    unsteadiness_by_gyroscope,
    unsteadiness_otherwise,
)
from pytracker.rotation import rotate

__all__ = ["FoundConventions", "find_conventions"]

MOST_S = 86_400.0
TURN_S = 0.1
"""Turns are compared over so long, s."""
LEAST_TURN_RAD = 3.0
"""A recording that turns by less in all, beside its noise, says little of its quaternion."""
ALIKE, APART = 0.85, (0.02, 3.0)
"""Cosine between the turns of gyroscope and orientation: of the right convention at least; the next best must lack
more of one, by so much and so many times what the best lacks."""
STEADY, UNSTEADY = 2.5, 1.6
"""Without a gyroscope: gravity in the world varies by less, m/s², and by so many times more with the next best."""
IN_G, IN_SI = (0.7, 1.6), (6.5, 20.0)
"""Median length of the specific force, in g and in m/s²."""
IN_DEG = (35.0, 90.0)
"""The gyroscope in degrees turns so many times as fast as the orientation."""


FEW_DEG = 10.0
"""A gyroscope of an arm that moves reads more in degrees, nineteen times of twenty."""


@dataclass(frozen=True)
class FoundConventions:
    """What the numbers say.

    Attributes:
        conventions: the best.
        unknown: fields of it that cannot be told; they are as in `Conventions()`.
        evidence: in words with numbers, by field.
    """

    conventions: Conventions
    unknown: tuple[str, ...]
    evidence: Mapping[str, str]


def find_conventions(log: ImuLog) -> FoundConventions:
    """Of a log as it was read, before anything is turned or checked."""
    conventions, unknown, words = Conventions(), [], dict.fromkeys(("acc_unit", "earth"), "the file has none")
    if log.acc is not None:
        size = float(np.nanmedian(np.linalg.norm(log.acc, axis=1)))
        words["acc_unit"] = f"the specific force has a median length of {size:.3g}"
        is_g = IN_G[0] < size < IN_G[1]
        conventions = Conventions(acc_unit="g" if is_g else "m/s2")
        unknown += [] if is_g or IN_SI[0] < size < IN_SI[1] else ["acc_unit"]
    if not _has_times(log):
        others = ("gyr_unit", "quaternion", "quaternion_takes", "earth")
        words |= dict.fromkeys(others, "the times are no times of one recording")
        return FoundConventions(conventions, (*unknown, *others), words)
    if log.q_world_sensor is None:
        conventions, is_told, words["gyr_unit"] = _unit_by_gravity(log, conventions)
        unknown += [] if is_told or log.gyr is None else ["gyr_unit"]
        return FoundConventions(conventions, tuple(unknown), words)
    by_turns = log.gyr is not None and _turned(log) > LEAST_TURN_RAD
    conventions, sure, said = _by_gyroscope(log, conventions) if by_turns else _by_gravity(log, conventions)
    words |= dict.fromkeys(("gyr_unit", "quaternion", "quaternion_takes"), said)
    if not sure:
        unknown += ["quaternion", "quaternion_takes", *(["gyr_unit"] if log.gyr is not None else [])]
        conventions = dataclasses.replace(Conventions(), acc_unit=conventions.acc_unit)
    ours = in_our_terms(log, conventions)
    if ours.acc is not None and ours.q_world_sensor is not None:
        up = float(np.nanmean(rotate(ours.q_world_sensor, ours.acc)[:, 2]))
        words["earth"] = f"turned to the world the specific force is {up:+.1f} m/s² along z on average"
        if abs(up) < 0.6 * GRAVITY:
            unknown.append("earth")
        elif up < 0:
            conventions = dataclasses.replace(conventions, earth="z down")
    return FoundConventions(conventions, tuple(unknown), words)


def _has_times(log: ImuLog) -> bool:
    """Finite, increasing, and not of more than a day: what was read is not checked yet."""
    steps = np.diff(log.time_s)
    return bool(np.isfinite(log.time_s).all() and len(steps) and (steps > 0).all() and steps.sum() < MOST_S)


def _quaternions(of: Conventions) -> Iterator[Conventions]:
    for order, direction in itertools.product(get_args(Order), get_args(Direction)):
        yield dataclasses.replace(of, quaternion=order, quaternion_takes=direction)


def _turned(log: ImuLog) -> float:
    """How far the orientation turns in all, rad: a conjugate, or another order, turns as far."""
    _, by_orientation, _, _ = turns(_unit(log), TURN_S)
    return float(np.linalg.norm(by_orientation, axis=1).sum())


def _unit(log: ImuLog) -> ImuLog:
    assert log.q_world_sensor is not None
    norm = np.linalg.norm(log.q_world_sensor, axis=1, keepdims=True)
    return dataclasses.replace(log, q_world_sensor=log.q_world_sensor / np.where(norm > 0, norm, 1.0))


def _by_gyroscope(log: ImuLog, conventions: Conventions) -> tuple[Conventions, bool, str]:
    """The order and direction with which both turn alike, and the gyroscope's unit."""
    found = []
    for candidate in _quaternions(conventions):
        by_gyroscope, by_orientation, _, _ = turns(in_our_terms(_unit(log), candidate), TURN_S)
        along, gyr, q = (np.nansum(a * b) for a, b in _pairs(by_gyroscope, by_orientation))
        found.append((float(along / np.sqrt(gyr * q + 1e-30)), float(np.sqrt(gyr / (q + 1e-30))), candidate))
    found.sort(key=lambda one: -one[0])
    (cosine, ratio, best), (second, *_) = found[0], found[1]
    if IN_DEG[0] < ratio < IN_DEG[1]:
        best = dataclasses.replace(best, gyr_unit="deg/s")
    words = (
        f"gyroscope and orientation turn alike with a cosine of {cosine:.2f} ({second:.2f} with the next best order or "
        f"direction), the gyroscope {ratio:.3g} times as much"
    )
    return best, cosine > ALIKE and 1 - second > APART[0] + APART[1] * (1 - cosine), words


def _unit_by_gravity(log: ImuLog, conventions: Conventions) -> tuple[Conventions, bool, str]:
    """With the gyroscope's unit that leaves gravity where it is; whether that tells, and words.

    Degrees that are taken for radians turn it all about; what is 57 times too small hardly does.
    """
    if log.gyr is None or log.acc is None or not (np.isfinite(log.gyr).all() and np.isfinite(log.acc).all()):
        return conventions, False, "there is nothing to compare it with"
    units: tuple[GyrUnit, ...] = get_args(GyrUnit)
    found = [dataclasses.replace(conventions, gyr_unit=unit) for unit in units]
    off = [unsteadiness_by_gyroscope(in_our_terms(log, one)) for one in found]
    best, other = sorted(range(len(off)), key=lambda k: off[k])
    signs = {**OTHER_SIGNS, **MIRRORED}
    others = min(
        (unsteadiness_otherwise(in_our_terms(log, one), signs) for one in found), key=lambda of: min(of.values())
    )
    if (least := min(others.values())) < STEADIER * off[best]:
        words = f"gravity varies by {off[best]:.2f} m/s² in {units[best]} and by {off[other]:.2f} in {units[other]}"
        return conventions, False, f"{words}, by {least:.2f} if {steadiest_in_words(others)}"
    is_told = off[other] > LEAST_UNSTEADY and off[best] < STEADIER * off[other]
    turns_by = float(np.quantile(np.linalg.norm(log.gyr, axis=1), 0.95))
    if is_told and units[best] == "deg/s" and turns_by < FEW_DEG:
        words = f"gravity varies by {off[best]:.2f} m/s² in {units[best]} and by {off[other]:.2f} in {units[other]}"
        return conventions, False, f"{words}; but it reads {turns_by:.2g} at most, as radians do: are its axes acc's?"
    words = (
        f"by an orientation computed from it gravity varies by {off[best]:.2f} m/s², by {off[other]:.2f} in "
        f"{units[other]}"
    )
    return found[best] if is_told else conventions, is_told, words


def _pairs(a: np.ndarray, b: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    return (a, b), (a, a), (b, b)


def _by_gravity(log: ImuLog, conventions: Conventions) -> tuple[Conventions, bool, str]:
    """The order and direction with which gravity stays where it is."""
    if log.acc is None:
        return conventions, False, "there is nothing to compare the orientation with"
    found = []
    for candidate in _quaternions(conventions):
        for earth in ("z up", "z down"):
            one = dataclasses.replace(candidate, earth=earth)
            found.append((unsteadiness(in_our_terms(_unit(log), one)), candidate))
    found.sort(key=lambda one: one[0])
    off, best = found[0]
    second = next((other for other, candidate in found if candidate != best), np.inf)
    words = f"gravity varies by {off:.1f} m/s² in the world, by {second:.1f} with the next best order or direction"
    return best, bool(off < STEADY and second > UNSTEADY * max(off, 0.3)), words
