"""A gyroscope's bias: what it reads where the sensor lies still, else what keeps gravity where it is."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from pytracker.inertial.gravity import at_rest
from pytracker.inertial.log import ImuLog
from pytracker.rotation import multiply, rotate, rotation_vector_to_quaternion
from pytracker.series import noise_sd

__all__ = ["BY_GRAVITY", "bias_at_rest", "bias_by_gravity"]

Float = NDArray[np.float64]

LIES_STILL = 0.02
"""Standard deviation of a gyroscope that lies still, at most, rad/s."""
TIMES_NOISE = 2.0
"""Or so many times its noise: real ones at rest have 0.8 to 1.3, circling evenly 5 to 8."""
MOST_ALIKE = 0.8
"""Of such stretches so many must read the same, but for `LIES_STILL`."""
WINDOW_S = 4.0
"""Over so long a bias turns gravity by more than an arm's own acceleration does."""
MOST_WINDOWS = 20
"""More tell little more."""
EACH_S = 0.05
"""Samples are taken together over so long."""
BY_GRAVITY = 0.05
"""What gravity tells well is off by up to 0.025 on arms that move: less is left to VQF, rad/s."""
WELL = 0.03
"""Along such axes, standard deviation, rad/s."""
CAUTIOUS = 1.5
"""Standard deviations are taken to be so many times too large: of 0.7, 1, 1.5 and 3 best of 64 worn arms."""
LEAST_WINDOWS = 3
LASTS_S = 1.0
"""How long an arm's own acceleration stays alike."""
TOLD = 0.25
"""Along an axis that is known worse nothing is told, rad/s, standard deviation."""
MOST = 1.0
"""No gyroscope is biased by more, rad/s."""
ROUNDS = 8
"""A bias is large beside what its effect is linear in."""


def bias_at_rest(log: ImuLog) -> Float | None:
    """What the gyroscope reads where the sensor lies still `(3,)`, rad/s; None where it never does, or not alike.

    Who turns evenly reads evenly too, but not to the noise, nor the same each time.
    """
    assert log.gyr is not None
    still, parts = [], []
    for part in at_rest(log):
        if np.linalg.norm(log.gyr[part].std(axis=0)) <= max(
            LIES_STILL, TIMES_NOISE * float(np.linalg.norm(noise_sd(log.gyr[part])))
        ):
            still.append(log.gyr[part].mean(axis=0))
            parts.append(part)
    if len(still) < LEAST_WINDOWS:
        return None
    bias = np.median(still, axis=0)
    alike = np.linalg.norm(still - bias, axis=1) <= LIES_STILL
    return np.asarray(bias) if alike.mean() >= MOST_ALIKE and not _turns_by(log, parts, bias) else None


def _turns_by(log: ImuLog, parts: list[slice], rate: Float) -> bool:
    """Whether gravity turns in these parts as it does for who turns at a rate `(3,)`: then that is no bias."""
    assert log.acc is not None
    seen = expected = 0.0
    for part in parts:
        middle = (part.start + part.stop) // 2
        before, after = log.acc[part.start : middle].mean(axis=0), log.acc[middle : part.stop].mean(axis=0)
        turned = -np.cross(rate, 0.5 * (before + after)) * 0.5 * (log.time_s[part.stop - 1] - log.time_s[part.start])
        seen, expected = seen + float((after - before) @ turned), expected + float(turned @ turned)
    return seen > 0.5 * expected


def bias_by_gravity(log: ImuLog) -> tuple[Float, Float]:
    """That with which gravity stays where it is while the sensor moves `(3,)`, rad/s, and how well it is known.

    Turned back by the gyroscope to where a window began, the acceleration is gravity but for what the arm does, which
    averages out. A bias b turns it by phi(t) b, phi the integral of what turned it back: least squares over windows.
    About an axis that stays upright a bias turns nothing: of that it is known to be as large as the others, as badly as
    that is known (its standard deviation, with the axis as its direction `(3,)`). 0 where what is known well is small.
    """
    bias, parts = np.zeros(3), _windows(log)
    sds, axes = np.full(3, np.inf), np.eye(3)
    for _ in range(ROUNDS if len(parts) >= LEAST_WINDOWS else 0):
        rows = [_window(log, a, b, bias) for a, b in parts]
        slopes, off = (np.concatenate([row[k] for row in rows]) for k in (0, 1))
        weights, axes = np.linalg.eigh(slopes.T @ slopes)
        weights = np.maximum(weights, 1e-9)
        # What an arm does lasts for many samples: they are no more than so few.
        sds = np.sqrt(off.var() * LASTS_S / EACH_S / weights)
        # An axis of which gravity hardly tells would run away along itself.
        along = np.where(sds < TOLD, axes.T @ (slopes.T @ off), 0.0) / weights
        bias = bias + axes @ along
    along, is_well = axes.T @ bias, sds < WELL
    large = float(np.sqrt(np.mean(along[is_well] ** 2))) if is_well.any() else 0.0
    if not BY_GRAVITY <= np.linalg.norm(along[is_well]) <= MOST or np.linalg.norm(bias) > MOST:
        return np.zeros(3), np.zeros(3)
    errors = np.minimum(sds, TOLD) / CAUTIOUS
    shares = np.where(is_well, 1.0, large**2 / (large**2 + errors**2))
    left = np.where(is_well, 0.0, 2.0 * large * errors / np.hypot(large, errors))
    return axes @ (shares * along), axes[:, int(np.argmax(left))] * left.max()


def _windows(log: ImuLog) -> list[tuple[int, int]]:
    """First sample, and that after the last, of windows without gaps."""
    edges = np.unique(np.searchsorted(log.time_s, np.arange(log.time_s[0], log.time_s[-1], WINDOW_S)))
    whole = [
        (int(a), int(b))
        for a, b in itertools.pairwise(edges)
        if b - a > 1 and np.diff(log.time_s[a:b]).max() < 0.1 * WINDOW_S
    ]
    return whole[:: max(1, len(whole) // MOST_WINDOWS)]


def _window(log: ImuLog, a: int, b: int, bias: Float) -> tuple[Float, Float]:
    """Slopes `(3 K, 3)` and what is left to explain `(3 K,)`, m/s²."""
    assert log.gyr is not None
    assert log.acc is not None
    time_s = log.time_s[a:b]
    steps = np.diff(time_s)
    turns = rotation_vector_to_quaternion(0.5 * (log.gyr[a : b - 1] + log.gyr[a + 1 : b] - 2 * bias) * steps[:, None])
    q = np.zeros((b - a, 4))
    q[0, 0] = 1.0
    for k in range(1, b - a):
        q[k] = multiply(q[k - 1], turns[k - 1])
    back = np.stack([rotate(q, axis) for axis in np.eye(3)], axis=2)
    phi = np.concatenate([np.zeros((1, 3, 3)), np.cumsum(0.5 * (back[1:] + back[:-1]) * steps[:, None, None], axis=0)])
    force = rotate(q, log.acc[a:b])
    gravity = force.mean(axis=0)
    slope = np.cross((phi - phi.mean(axis=0)).transpose(0, 2, 1), gravity).transpose(0, 2, 1)
    every = max(1, round(EACH_S / float(np.median(steps))))
    return slope[::every].reshape(-1, 3), (force - gravity)[::every].reshape(-1)
