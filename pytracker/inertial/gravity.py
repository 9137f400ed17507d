"""What gravity tells of an IMU.

Unit, scale and bias of the accelerometer, tilt of the orientation, and whether they are in step.

Turned to the world and averaged, the specific force is gravity but for what the wearer's velocity changed: nothing to
speak of over a long recording, or while the sensor lies still. So the tolerance shrinks with the length and with
rest.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.inertial.log import ImuLog
from pytracker.rotation import conjugate, rotate

__all__ = [
    "GRAVITY",
    "WINDOW_S",
    "at_rest",
    "check_size",
    "check_step",
    "check_up",
    "check_windows",
    "unsteadiness",
]

Float = NDArray[np.float64]

GRAVITY = 9.80665
UP = np.array([0.0, 0.0, GRAVITY])

REST_S = 0.5
REST_ACC = 0.15
REST_TURN = 0.15
"""At rest for so long the readings vary by less, RMS: m/s², rad/s."""
ENOUGH_REST_S = 1.0

IN_G = (0.8, 1.25)
"""The usual size of readings in units of g."""
SMALL, HAS_GRAVITY = 0.05, 0.4
"""The smallest twentieth of readings with gravity in them is a larger share of the usual ones; without it they come
near nothing, again and again."""
SIZE_OFF = (0.25, 0.6)
"""At rest the size of the reading is off by so much, m/s²: odd, wrong."""
VELOCITY = (4.0, 8.0)
"""By how much an arm's velocity may change over a recording, m/s, before gravity's mean is odd, wrong ..."""
MEAN_OFF = (0.5, 1.5)
"""... besides what sensor and orientation are off by, m/s²."""
TILT_DEG = (4.5, 12.0)
"""At rest the orientation's up is off by so much: odd, wrong."""
WINDOW_S = 2.0
WINDOW_OFF = (2.0, 3.5)
"""Median over windows of how far each one's mean is from gravity, m/s²; right ones have 0.6 at the most."""
ENOUGH_WINDOWS = 4
SETTLED_SHARE = 0.5
"""An orientation filter may settle during the first part of a recording."""

LAGS_S = np.arange(-0.5, 0.501, 0.05)
SMOOTH_S = 0.3
IN_STEP = (0.75, 0.5)
"""Another lag leaves this share of what is not gravity: odd, wrong."""
SLOW_M_S2 = 0.75
"""More that is not gravity (RMS), at any lag, is the movement's: round and round, a quarter turn hides another."""
LEAST_LAG_S = 0.08
TURNED = 0.12
"""Gravity must have turned by so much in the sensor (RMS of its direction), or lags tell nothing."""
MOST_OFF = 0.65 * GRAVITY
"""However short the recording: no arm changes its velocity by so much for long."""


def at_rest(log: ImuLog) -> list[slice]:
    """Stretches of `REST_S` in which the sensor lay still."""
    assert log.acc is not None
    edges = np.unique(np.searchsorted(log.time_s, np.arange(log.time_s[0], log.time_s[-1], REST_S)))
    found = []
    for a, b in itertools.pairwise(edges):
        if b - a < 4 or log.time_s[b - 1] - log.time_s[a] > 1.5 * REST_S:
            continue
        turns = np.zeros(3) if log.gyr is None else log.gyr[a:b]
        still = np.linalg.norm(log.acc[a:b].std(axis=0)) < REST_ACC and np.linalg.norm(turns.std(axis=0)) < REST_TURN
        if still:
            found.append(slice(int(a), int(b)))
    return found


def check_size(log: ImuLog) -> list[str]:
    """Unit and scale of the accelerometer. Returns warnings; raises `InputError`."""
    assert log.acc is not None
    sizes = np.linalg.norm(log.acc, axis=1)
    size, small = float(np.median(sizes)), float(np.quantile(sizes, SMALL))
    for unit, units in (("g", 1.0), ("mg (which a header may name: acc_x (mg))", 1e3)):
        if IN_G[0] * units < size < IN_G[1] * units and small > HAS_GRAVITY * size:
            raise InputError(
                f"{log.path}: acceleration has a median length of {size:.3f}, which looks like units of {unit}, "
                "expected m/s² with gravity (about 9.81 at rest)"
            )
    if not 4.0 < size < 60.0:
        raise InputError(
            f"{log.path}: acceleration has a median length of {size:.3f} m/s², expected about 9.81: the raw reading "
            "with gravity, not the free acceleration"
        )
    _check_parts_in_g(log)
    rest = at_rest(log)
    if len(rest) * REST_S < ENOUGH_REST_S:
        return []
    still = float(np.median([np.linalg.norm(log.acc[part].mean(axis=0)) for part in rest]))
    off = abs(still - GRAVITY)
    words = (
        f"{log.path}: at rest ({len(rest) * REST_S:g} s) the acceleration is {still:.2f} m/s², expected "
        f"{GRAVITY:.2f}: is its scale or unit another, or an axis biased?"
    )
    return _odd_or_wrong(words, off, SIZE_OFF)


def _check_parts_in_g(log: ImuLog) -> None:
    """No stretch of `WINDOW_S` is in units of g where others are in m/s². Raises `InputError`."""
    assert log.acc is not None
    edges = np.unique(np.searchsorted(log.time_s, np.arange(log.time_s[0], log.time_s[-1], WINDOW_S)))
    for a, b in itertools.pairwise([*edges, len(log.time_s)]):
        size = float(np.median(np.linalg.norm(log.acc[a:b], axis=1)))
        if IN_G[0] < size < IN_G[1] and log.time_s[b - 1] - log.time_s[a] > 0.5 * WINDOW_S:
            raise InputError(
                f"{log.path}:{log.lines[a]}: for {WINDOW_S:g} s from here on the acceleration has a median length of "
                f"{size:.3f}, which looks like units of g, and elsewhere it is in m/s²: expected m/s² all along"
            )


def check_up(log: ImuLog, hint: str) -> list[str]:
    """Turned to the world, gravity is up. Returns warnings; raises `InputError`, with `hint`."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    world = rotate(log.q_world_sensor, log.acc)
    span = log.time_s[-1] - log.time_s[0]
    mean, after = world.mean(axis=0), world[int(SETTLED_SHARE * len(world)) :].mean(axis=0)
    off = min(np.linalg.norm(mean - UP), np.linalg.norm(after - UP))
    odd, wrong = (a + v / max(span, 1e-9) for a, v in zip(MEAN_OFF, VELOCITY, strict=True))
    words = (
        f"{log.path}: turned by the orientation, the mean acceleration is "
        f"({mean[0]:.2f}, {mean[1]:.2f}, {mean[2]:.2f}) m/s², expected about (0, 0, 9.81): "
    )
    if off > min(wrong, MOST_OFF):
        inverse = rotate(conjugate(log.q_world_sensor), log.acc).mean(axis=0)
        if np.linalg.norm(inverse - UP) <= 0.35 * GRAVITY:
            hint += "; the inverse fits, so these seem to take the world to the sensor"
        elif np.linalg.norm(mean + UP) <= 0.35 * GRAVITY:
            hint += (
                '; here it is down: is earth "z down" (north, east, down), or acc_reads "gravity", as an iPhone has it?'
            )
        raise InputError(words + hint)
    rest = at_rest(log)
    if len(rest) * REST_S >= ENOUGH_REST_S:
        ups = np.array([world[part].mean(axis=0) for part in rest])
        tilt = float(np.median(np.degrees(np.arctan2(np.hypot(ups[:, 0], ups[:, 1]), ups[:, 2]))))
        tilted = (
            f"{log.path}: at rest ({len(rest) * REST_S:g} s) the orientation's up is {tilt:.1f}° beside gravity, "
            "expected less than 2°: is the orientation tilted, or an axis of the accelerometer biased or flipped?"
        )
        if found := _odd_or_wrong(tilted, tilt, TILT_DEG):
            return found
    if off > odd:
        return [words + hint]
    unsteady = (
        f"{log.path}: turned by the orientation, the acceleration of {WINDOW_S:g} s is {unsteadiness(log):.1f} m/s² "
        "from gravity (median), expected less than 1: do the axes of acceleration and orientation differ, "
        "or is one flipped?"
    )
    return _odd_or_wrong(unsteady, unsteadiness(log), WINDOW_OFF) if span > 3 * WINDOW_S else []


def unsteadiness(log: ImuLog) -> float:
    """Median over windows of how far their mean acceleration in the world is from gravity, m/s².

    0 where there is none.
    """
    off, _ = _off_gravity(log)
    return float(np.median(off)) if len(off) else 0.0


def check_windows(log: ImuLog) -> list[str]:
    """A word on the window that is farthest from gravity, where no arm moves like that and others are not."""
    off, first = _off_gravity(log)
    if len(off) < ENOUGH_WINDOWS or off.max() < WINDOW_OFF[1] or np.median(off) > WINDOW_OFF[0]:
        return []
    worst = int(np.argmax(off))
    return [
        f"{log.path}:{log.lines[first[worst]]}: for {WINDOW_S:g} s from here on the acceleration, turned by the "
        f"orientation, is {off[worst]:.1f} m/s² from gravity, and {np.median(off):.1f} elsewhere (median): is the "
        "gyroscope in another unit there, or was the sensor turned on its segment?"
    ]


def _off_gravity(log: ImuLog) -> tuple[Float, NDArray[np.intp]]:
    """How far the mean acceleration of each window is from gravity in the world, m/s², and its first sample."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    world = rotate(log.q_world_sensor, log.acc)
    edges = np.unique(np.searchsorted(log.time_s, np.arange(log.time_s[0], log.time_s[-1] + WINDOW_S, WINDOW_S)))
    long = [(a, b) for a, b in itertools.pairwise(edges) if log.time_s[b - 1] - log.time_s[a] > 0.5 * WINDOW_S]
    means = np.array([world[a:b].mean(axis=0) for a, b in long]).reshape(-1, 3)
    return np.linalg.norm(means - UP, axis=1), np.array([a for a, _ in long], dtype=np.intp)


def check_step(log: ImuLog) -> list[str]:
    """Acceleration and orientation are of the same times. Returns warnings; raises `InputError`."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    interval = float(np.median(np.diff(log.time_s)))
    smooth = max(1, round(SMOOTH_S / interval))
    if len(log.time_s) * interval < 8.0:
        return []
    up = rotate(conjugate(log.q_world_sensor), UP / GRAVITY)
    if np.linalg.norm(up.std(axis=0)) < TURNED:
        return []
    left = np.array([_not_gravity(log, round(lag / interval), smooth) for lag in LAGS_S])
    best, now = int(np.argmin(left)), left[len(LAGS_S) // 2]
    if abs(LAGS_S[best]) < LEAST_LAG_S or best in (0, len(LAGS_S) - 1) or not now > 0:
        return []
    if left[best] > IN_STEP[1] * now and left[best] > SLOW_M_S2**2:
        return []
    words = (
        f"{log.path}: the acceleration fits the orientation better {abs(LAGS_S[best]):.2f} s "
        f"{'earlier' if LAGS_S[best] > 0 else 'later'} (what is not gravity falls to {left[best] / now:.0%}), "
        "expected both at the same times"
    )
    return _odd_or_wrong(words, 1 - left[best] / now, (1 - IN_STEP[0], 1 - IN_STEP[1]))


def _not_gravity(log: ImuLog, lag: int, smooth: int) -> float:
    """Mean square of the slow part of what is not gravity in the world, the acceleration being `lag` samples late."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    count = len(log.time_s)
    rows = np.arange(max(0, -lag), min(count, count - lag))
    world = rotate(log.q_world_sensor[rows], log.acc[rows + lag]) - UP
    sums = np.cumsum(np.vstack([np.zeros((1, 3)), world]), axis=0)
    slow = (sums[smooth:] - sums[:-smooth]) / smooth
    return float((slow**2).sum(axis=1).mean())


def _odd_or_wrong(words: str, off: float, limits: tuple[float, float]) -> list[str]:
    odd, wrong = limits
    if off > wrong:
        raise InputError(words)
    return [words] if off > odd else []
