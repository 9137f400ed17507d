"""The orientation of an IMU that gives none: from its turn rate, acceleration and magnetic field, by VQF."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.inertial.bias import bias_at_rest, bias_by_gravity
from pytracker.inertial.gravity import WINDOW_S, check_up, check_windows, unsteadiness
from pytracker.inertial.log import ImuLog

__all__ = [
    "AS_GIVEN",
    "LEAST_UNSTEADY",
    "MIRRORED",
    "OTHER_SIGNS",
    "STEADIER",
    "orient",
    "steadiest_in_words",
    "unsteadiness_by_gyroscope",
    "unsteadiness_otherwise",
]

Float = NDArray[np.float64]

MOST_STEPS = 4
"""Steps of VQF for every sample, at the most."""
AS_GIVEN = "its heading is what heading_deg says"
"""Of an orientation about which nothing else is odd."""
BRIDGED_S = 1.0
"""Nobody knows how a sensor turned in a longer gap."""
SILENT_S = 0.5
"""A magnetic field is interpolated over no longer pauses: magnetometers are slow, and an arm turns."""
BIASED = 0.05
"""A gyroscope at rest that reads more is worth a word, rad/s."""
OTHER_UNITS: dict[str, Float] = {
    "it is in degrees per second": np.full(3, np.pi / 180),
    "it is 57 times as much, which is the other way round": np.full(3, 180 / np.pi),
}
OTHER_SIGNS: dict[str, Float] = {
    "its x has the other sign": np.array([-1.0, 1.0, 1.0]),
    "its y has the other sign": np.array([1.0, -1.0, 1.0]),
    "its z has the other sign": np.array([1.0, 1.0, -1.0]),
}
MIRRORED: dict[str, Float] = {
    "the accelerometer's x has the other sign": np.array([1.0, -1.0, -1.0]),
    "the accelerometer's y has the other sign": np.array([-1.0, 1.0, -1.0]),
    "the accelerometer's z has the other sign": np.array([-1.0, -1.0, 1.0]),
    "all its axes have the other sign": np.array([-1.0, -1.0, -1.0]),
}
"""What the gyroscope would have to read by; an accelerometer that is mirrored turns as one does that is not, but for
the signs of the two other axes."""
LEAST_UNSTEADY = 0.25
"""Gravity that is as steady tells of no fault, m/s²: a sensor that lies still has less, whatever its gyroscope."""
AS_STEADY = 1.1
"""Without a bias gravity is as steady as with it, but for this."""
UNSURE = 0.02
"""A gyroscope whose bias is known no better turns the heading away, rad/s."""
STEADIER = 0.7
"""Another gyroscope must leave gravity this much steadier to be named: 3 of 169 right ones, slices of BROAD, do."""
MUCH_STEADIER = 0.5
"""And this much to be asked for, or to be one of `MIRRORED`: who turns about one axis alone is as steady with two
others turned round (0.59 at least, of 64 arms that circle and 60 slices of BROAD)."""
NEARLY = 2.0
"""What leaves gravity less steady by no more may be right as well: of 111 that had a sign turned that one always."""


def orient(log: ImuLog, *, has_heading: bool = False) -> ImuLog:
    """Fill in a missing orientation by VQF (Laidig & Seel 2023).

    From gyroscope, acceleration and, where there is one, the magnetometer. `has_heading`: what its heading is in the
    world is given. Raises `InputError` without a gyroscope, or where what comes of it contradicts gravity.
    """
    if log.q_world_sensor is not None:
        return log
    if log.gyr is None or log.acc is None:
        beside = f" (it has {', '.join(log.unread)[:200]} beside, which are not read)" if log.unread else ""
        raise InputError(
            f"{log.path}: has neither orientation nor a gyroscope{beside}, expected q_w, q_x, q_y, q_z or "
            "gyr_x, gyr_y, gyr_z"
        )

    bias, told_by = _bias(log)
    mag, none = _magnetometer(log)
    q = _by_vqf(log, log.gyr - bias, mag)
    if has_heading:
        heading = AS_GIVEN
    elif mag is None:
        heading = f"{none}, so the heading is arbitrary: set heading_deg"
    else:
        heading = "its heading is magnetic north along +y (ENU): set heading_deg to turn it to the world"
    warning = f"{log.path}: has no orientation; computed from its gyroscope by VQF; {heading}"
    if np.linalg.norm(bias) > BIASED:
        warning += f". {told_by} {np.round(bias, 3).tolist()} rad/s, which is taken off"
    if mag is None and (longest_s := float(np.diff(log.time_s).max())) > BRIDGED_S:
        warning += f". Over its longest gap, {longest_s:.3g} s, the heading is taken to have stayed"
    oriented = dataclasses.replace(log, q_world_sensor=q, warnings=(*log.warnings, warning))
    try:
        odd = _check_gyroscope(oriented, bias)
        up = check_up(oriented, "computed from the gyroscope: is gyr in rad/s, and in the axes of acc?")
    except InputError as error:
        # A clock whose unit was guessed may be all that is wrong with it.
        raise InputError("; ".join([str(error), *log.warnings])) from None
    return dataclasses.replace(oriented, warnings=(*oriented.warnings, *odd, *(up or check_windows(oriented))))


def unsteadiness_by_gyroscope(log: ImuLog) -> float:
    """How far gravity goes from its place in the world by an orientation that is computed, m/s² (`unsteadiness`).

    Of a log with a gyroscope and an accelerometer, in our terms.
    """
    assert log.gyr is not None
    return unsteadiness(dataclasses.replace(log, q_world_sensor=_by_vqf(log, log.gyr, None)))


def _magnetometer(log: ImuLog) -> tuple[Float | None, str]:
    """The magnetic field at every sample `(M, 3)`, interpolated where it has none; else None, and why."""
    if log.mag is None:
        return None, "there is no magnetometer"
    known = np.isfinite(log.mag).all(axis=1)
    seen_s = log.time_s[known]
    if not known.any() or np.ptp(log.mag[known], axis=0).max() == 0:
        return None, "the magnetometer says nothing, or always the same"
    silent_s = float(np.diff([log.time_s[0], *seen_s, log.time_s[-1]]).max())
    if silent_s > SILENT_S:
        return None, f"the magnetometer says nothing for {silent_s:.3g} s"
    return np.stack([np.interp(log.time_s, seen_s, log.mag[known, d]) for d in range(3)], axis=1), ""


def _bias(log: ImuLog) -> tuple[Float, str]:
    """Of the gyroscope `(3,)`, rad/s, and in words what tells it."""
    assert log.gyr is not None
    still = bias_at_rest(log)
    if still is not None:
        return still, "At rest the gyroscope reads"
    moving, unsure = bias_by_gravity(log)
    if not moving.any():
        return moving, ""
    without, beside = (
        unsteadiness(dataclasses.replace(log, q_world_sensor=_by_vqf(log, log.gyr - bias, None)))
        for bias in (np.zeros(3), moving)
    )
    if beside > AS_STEADY * without:
        return np.zeros(3), ""
    known = ""
    if (left := float(np.linalg.norm(unsure))) > UNSURE:
        known = (
            f" (about its axis {np.round(unsure / left, 2).tolist()} to ± {left:.2f} rad/s only: the heading may drift "
            f"by {np.degrees(left):.0f}° a second; let the sensor lie still for some seconds)"
        )
    said = f"The sensor never lies still, and gravity stays where it is if the gyroscope is biased{known} by"
    return moving, said


def _by_vqf(log: ImuLog, gyr: Float, mag: Float | None) -> Float:
    """Orientation of every sample `(M, 4)`.

    VQF wants a steady rate: gaps are bridged, each sample takes its nearest. Over longer ones than `BRIDGED_S`, as if
    they lasted that, nothing turns.
    """
    import vqf  # noqa: PLC0415 - only recordings without orientation pay for it

    assert log.acc is not None
    steps = np.diff(log.time_s)
    time_s = np.concatenate([[0.0], np.cumsum(np.minimum(steps, BRIDGED_S))])
    # Where samples come in bursts, their usual distance is none that a recording could be cut into.
    interval = max(float(np.median(steps)), time_s[-1] / (MOST_STEPS * len(time_s)))
    grid = np.arange(round(time_s[-1] / interval) + 1) * interval

    def steady(values: Float) -> Float:
        return np.stack([np.interp(grid, time_s, values[:, d]) for d in range(3)], axis=1)

    turning = steady(gyr)
    for k in np.flatnonzero(steps > BRIDGED_S):
        turning[(grid > time_s[k]) & (grid < time_s[k + 1])] = 0.0
    out = vqf.offlineVQF(turning, steady(log.acc), None if mag is None else steady(mag), interval)
    q = out["quat6D"] if mag is None else out["quat9D"]
    nearest = np.clip(np.rint(time_s / interval).astype(int), 0, len(grid) - 1)
    return np.asarray(q[nearest])


def _check_gyroscope(log: ImuLog, bias: Float) -> tuple[str, ...]:
    """A word where with another unit, or other signs, gravity is steadier. Raises `InputError` where it is by far."""
    off = unsteadiness(log)
    if off < LEAST_UNSTEADY:
        return ()
    others = unsteadiness_otherwise(log, {**OTHER_UNITS, **OTHER_SIGNS}, bias)
    mirrored = unsteadiness_otherwise(log, MIRRORED, bias)
    if min(mirrored.values()) < MUCH_STEADIER * off:
        others |= mirrored
    least = min(others.values())
    if least >= STEADIER * off:
        return ()
    words = (
        f"{log.path}: turned by the orientation, the mean acceleration is {off:.2f} m/s² from gravity (median of "
        f"{WINDOW_S:g} s), and {least:.2f} if {steadiest_in_words(others)}; computed from the gyroscope: is gyr in "
        'rad/s, and in the axes of acc? (columns = { acc_x = "-acc_x" } turns a sign)'
    )
    if least < MUCH_STEADIER * off:
        raise InputError(words)
    return (words,)


def unsteadiness_otherwise(log: ImuLog, otherwise: Mapping[str, Float], bias: Float | float = 0.0) -> dict[str, float]:
    """How far gravity goes by gyroscopes that are `otherwise`, m/s²."""
    assert log.gyr is not None
    return {
        words: unsteadiness(dataclasses.replace(log, q_world_sensor=_by_vqf(log, (log.gyr - bias) * factor, None)))
        for words, factor in otherwise.items()
    }


def steadiest_in_words(others: Mapping[str, float]) -> str:
    """Which of `unsteadiness_otherwise` leaves gravity steadiest, and which may, the steadiest first."""
    least = min(others.values())
    near = sorted((left, words) for words, left in others.items() if left < NEARLY * least)
    return " or ".join(words for _, words in near)
