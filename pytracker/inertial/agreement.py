"""Whether gyroscope and orientation agree: what one turns by, the other does."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.inertial.bursts import comes_in_bursts
from pytracker.inertial.log import ImuLog
from pytracker.rotation import (
    conjugate,
    multiply,
    quaternion_to_rotation_vector,
    rotate,
    rotation_vector_to_quaternion,
)
from pytracker.series import runs

__all__ = ["check_turns", "turns"]

Float = NDArray[np.float64]

TURN_S = 0.1
"""Turns are compared over so long: short beside a swing of the arm, long beside a sample, s."""
STILL_S = 0.5
STILL_RAD = 0.3
"""A still gyroscope is looked for where the orientation turns by so much in so long: many times its noise."""
TURNING = 0.5
"""What counts as turning, rad/s."""
MOST_BIAS = 0.6
"""A gyroscope that usually reads less may stand still and be biased; more is turning, rad/s."""
ENOUGH_S = 1.0
"""Less turning than this says nothing, s."""
AGREE = (0.5, 2.0)
"""Ratios of the two rates, axis by axis: beyond these they contradict each other."""
ODD = (0.75, 1.33)
"""Beyond these one of them is odd, such as one that lags or is scaled."""
STANDS = 0.05
"""An orientation that turns by a smaller share of the gyroscope stands still."""
ALIKE, LEAST_RATE = 0.1, 0.05
"""Axes that are off by the same ratio, to within so much, may be so by the rate; by less than the second, by a unit."""
APART_S, GRID_S = 1.0, 0.05
"""What an orientation turns by without the gyroscope is looked for between means over so long, so far apart, s."""
APART_RAD = 0.175
"""More is a jump or a disturbance, rad (10°): filters are corrected by less, and their errors change by less."""
ROUNDS = 6
"""Of weighing anew what fits."""
HELD = 0.5
"""An orientation that is the same as before in more of the samples comes more slowly than the turn rate."""
AXES = "xyz"


def check_turns(log: ImuLog) -> list[str]:
    """What the gyroscope measures is what the orientation does.

    Returns a warning where one is odd. Raises `InputError` where they contradict each other: a unit, an axis, a sign, a
    sensor that stands still.
    """
    if log.gyr is None or log.q_world_sensor is None or comes_in_bursts(log):
        return []
    _check_gyroscope_moves(log)
    by_gyroscope, by_orientation, lasted, _ = turns(log, TURN_S)
    ratio, is_known = np.ones(3), np.zeros(3, bool)
    for axis in range(3):
        g, o = by_gyroscope[:, axis], by_orientation[:, axis]
        usual = np.median(g / lasted) if len(g) else 0.0
        if abs(usual) < MOST_BIAS:  # a bias of the gyroscope is not its scale
            g, o = g - usual * lasted, o - np.median(o / lasted) * lasted if len(o) else o
        # Chosen by the gyroscope, whose noise is small: noise of the orientation then averages out.
        turning = np.abs(g) > TURNING * lasted
        if lasted[turning].sum() >= ENOUGH_S:
            ratio[axis], is_known[axis] = np.sum(g[turning] * o[turning]) / np.sum(g[turning] ** 2), True
    odd = np.flatnonzero((ratio < ODD[0]) | (ratio > ODD[1]))
    if not odd.size:
        return _apart(log)
    found = ", ".join(f"{ratio[axis]:.3g} times about {AXES[axis]}" for axis in odd)
    words = f"{log.path}: the orientation turns as the gyroscope does {found}, expected 1"
    rate = _other_rate(log, ratio[is_known])
    if np.all((ratio >= AGREE[0]) & (ratio <= AGREE[1])):
        return [f"{words}: does one of them lag, or have another scale?{rate}"]
    raise InputError(f"{words}: {_reason(ratio[odd])}{rate}")


def _other_rate(log: ImuLog, ratio: Float) -> str:
    """A further question where all axes are off alike: time that passes too slowly is taken for turns too large."""
    if len(ratio) < 2 or ratio.min() < LEAST_RATE or ratio.max() > (1.0 + ALIKE) * ratio.min():
        return ""
    hz = 1.0 / float(np.median(np.diff(log.time_s)))
    return (
        f" Or were its samples taken at {hz / ratio.mean():.3g} Hz, where their times or the stated rate say {hz:.3g}?"
    )


def _reason(ratio: Float) -> str:
    if np.all((ratio > 1 / 80) & (ratio < 1 / 40)):
        return "is gyr in degrees per second? Radians are expected"
    if np.all(np.abs(ratio) < STANDS):
        return "does the orientation stand still, or the two have other axes?"
    return "do their axes, signs or units differ?"


def _check_gyroscope_moves(log: ImuLog) -> None:
    """Whatever way a body takes from one orientation to another, it turns by at least the angle between them."""
    _, turned, lasted, start = turns(log, STILL_S)
    angle, path = np.linalg.norm(turned, axis=1), turns(log, STILL_S, path=True)[0]
    still = np.flatnonzero((angle > STILL_RAD) & (path < AGREE[0] * angle))
    if len(still) < 2:
        return
    first = still[0]
    raise InputError(
        f"{log.path}:{log.lines[start[first]]}: the orientation turns by {angle[first]:.3g} rad in {lasted[first]:.3g} "
        f"s and the gyroscope by {path[first]:.3g}, expected at least as much ({len(still)} of {len(angle)} such "
        "stretches): does the gyroscope stand still, or is it in other units than rad/s?"
    )


def _apart(log: ImuLog) -> list[str]:
    """A warning where the orientation turns by itself for a while: it was reset, disturbed, or settles."""
    assert log.q_world_sensor is not None
    if (np.diff(log.q_world_sensor, axis=0) == 0).all(axis=1).mean() > HELD:
        return []
    own, turned = _ways(log)
    many = round(APART_S / GRID_S)
    if len(own) < 2 * many + 1:
        return []
    # What it is late by, and the gyroscope's scale, turn it too.
    late = np.gradient(turned, GRID_S, axis=0)
    gone, by_late, by_scale = (_from_mean_to_mean(way, many) for way in (own, late, turned))
    angle = np.linalg.norm(_left(gone, by_late, by_scale), axis=1)
    found = runs(angle > APART_RAD)
    if not found:
        return []
    at_s = log.time_s[0] + GRID_S * (many + int(np.argmax(angle)))
    line = log.lines[np.searchsorted(log.time_s, at_s)]
    others = f" (and in {len(found) - 1} other places)" if len(found) > 1 else ""
    return [
        f"{log.path}:{line}: about {at_s:.1f} s the orientation turns by {np.degrees(angle.max()):.0f}° that the "
        f"gyroscope does not{others}, expected less than {np.degrees(APART_RAD):.0f}°: was its heading reset, or "
        "disturbed by iron, or had it not settled? From then on it is another"
    ]


def _ways(log: ImuLog) -> tuple[Float, Float]:
    """How far the orientation has turned without the gyroscope, and the gyroscope itself, in the world, rad.

    `(G, 3)` each, every `GRID_S`; without the gyroscope's bias.
    """
    assert log.gyr is not None
    assert log.q_world_sensor is not None
    interval, q = np.diff(log.time_s)[:, None], log.q_world_sensor
    by_gyroscope = 0.5 * (log.gyr[1:] + log.gyr[:-1]) * interval
    turn = multiply(conjugate(q[:-1]), q[1:])
    own = quaternion_to_rotation_vector(multiply(conjugate(rotation_vector_to_quaternion(by_gyroscope)), turn))
    own -= np.median(own / interval, axis=0) * interval
    # Over a gap nobody knows how the sensor turned.
    own[interval[:, 0] > TURN_S] = 0.0
    grid_s = np.arange(log.time_s[0], log.time_s[-1], GRID_S)

    def way(steps: Float) -> Float:
        gone = np.concatenate([np.zeros((1, 3)), np.cumsum(rotate(q[1:], steps), axis=0)])
        return np.stack([np.interp(grid_s, log.time_s, gone[:, d]) for d in range(3)], axis=1)

    return way(own), way(by_gyroscope)


def _left(gone: Float, *explained_by: Float) -> Float:
    """What multiples of the others leave of `gone` `(K, 3)`; rows that these do not explain hardly say how large."""
    known, weight = np.stack([way.ravel() for way in explained_by], axis=1), np.ones((gone.size, 1))
    left = gone
    for _ in range(ROUNDS):
        factors = np.linalg.lstsq(weight * known, weight[:, 0] * gone.ravel(), rcond=None)[0]
        left = gone - (known @ factors).reshape(gone.shape)
        weight = 1.0 / (1.0 + (left.reshape(-1, 1) / max(float(np.median(np.abs(left))), 1e-6)) ** 2)
    return left


def _from_mean_to_mean(way: Float, many: int) -> Float:
    """The mean of the next so many rows less that of those before `(G - 2 many + 1, 3)`: noise averages out."""
    sums = np.cumsum(np.concatenate([np.zeros((1, 3)), way]), axis=0)
    means = (sums[many:] - sums[:-many]) / many
    return np.asarray(means[many:] - means[:-many])


def turns(log: ImuLog, over_s: float, *, path: bool = False) -> tuple[Float, Float, Float, NDArray[np.intp]]:
    """What both say of stretches of `over_s` without gaps.

    Returns the turn by the gyroscope `(K, 3)` rad, or its path `(K,)` where asked; the turn by the orientation `(K, 3)`
    rad; how long each lasts `(K,)` s; its first sample `(K,)`.
    """
    assert log.gyr is not None
    assert log.q_world_sensor is not None
    interval = np.diff(log.time_s)
    at = np.unique(np.searchsorted(log.time_s, np.arange(log.time_s[0], log.time_s[-1], over_s)))
    rate = np.linalg.norm(log.gyr, axis=1, keepdims=True) if path else log.gyr
    steps = 0.5 * (rate[1:] + rate[:-1]) * interval[:, None]
    turned = np.diff(np.concatenate([np.zeros((1, rate.shape[1])), np.cumsum(steps, axis=0)])[at], axis=0)
    q = log.q_world_sensor[at]
    by_orientation = quaternion_to_rotation_vector(multiply(conjugate(q[:-1]), q[1:]))
    longest = np.maximum.reduceat(interval, at[:-1]) if len(at) > 1 else np.empty(0)
    whole = longest <= 1.5 * over_s
    return (
        (turned[:, 0] if path else turned)[whole],
        by_orientation[whole],
        np.diff(log.time_s[at])[whole],
        at[:-1][whole],
    )
