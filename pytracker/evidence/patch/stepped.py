"""Whether a clock steps amid a recording: frames of the video that were cut out or dropped, samples that were lost.

What comes before and what comes after are laid over the sensor's movement each by itself
(`pytracker.evidence.patch.clocks` does so for one clock): where each goes with it, at times of its own, something is
missing between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pytracker.evidence.patch.clocks import Way, lively, way_of
from pytracker.evidence.patch.lag import EDGE_S, GRID_S, MOST_EXPLAINED, banded, explained_by
from pytracker.rotation import Array

__all__ = ["Step", "find_step"]

EACH_S = 4.0
"""A shorter stretch goes with any movement at some time."""
EVERY_S, TIMES = 1.0, 30
"""So far apart, at the least, and so often at the most, it is tried where the clock steps."""
MOST_S = 12.0
"""No longer piece is thought to be missing."""
NEAR_S = 1.5
"""Clocks so near the given one are looked at by themselves: of what comes round another turn may be worth more."""
AS_GOOD, WELL, SAME_S = 0.93, 0.88, 0.3
"""Pairs that are worth so much of the best, and explain so much, are as good; steps that are nearer are the same."""
LEAST_LAID = 0.5
"""So much of a stretch must be laid over the sensor's movement."""


@dataclass(frozen=True)
class Step:
    """Two stretches of a video, one after the other.

    Attributes:
        until_s: the end of the first, by the video's clock.
        from_s: the beginning of the second: later where the sensor has nothing of what is between.
        later_s: so much has to be added to the IMU's times, in either.
        explained: share of the movement in the picture that the IMU's explains then, in either.
        worth_s: of both together, as of a `Clock`; where several are as good, of the best.
        is_told: whether no other step is as good, as there is where movement comes round.
    """

    until_s: float
    from_s: float
    later_s: tuple[float, float]
    explained: tuple[float, float]
    worth_s: float
    is_told: bool


@dataclass(frozen=True)
class _Laid:
    """A stretch, from one position of the grid to another, where it goes best with the IMU."""

    first: int
    after: int
    later_s: float
    explained: float
    worth_s: float


_Pair = tuple[_Laid, _Laid]


def find_step(frame_s: Array, pixels: Array, imu_s: Array, acceleration: Array, later_s: float = 0.0) -> Step | None:
    """The two stretches of the video's first minute that are worth most by clocks near `later_s`.

    Of those that are worth as much the ones between which it steps least.

    Arguments as of `pytracker.evidence.patch.clocks.find_clock`; None where too little is seen or moves.
    """
    way = way_of(frame_s, pixels, imu_s)
    if way is None:
        return None
    imu_s = imu_s + later_s
    about = np.abs(imu_s - np.clip(imu_s, way.from_s, way.from_s + GRID_S * len(way.pixels))) <= MOST_S + 2.0 * EDGE_S
    imu_s, acceleration = imu_s[about], acceleration[about]
    if len(imu_s) < 2:
        return None
    imu_start, imu = banded(imu_s, acceleration, integrations=2)
    edge, count, each = round(EDGE_S / GRID_S), len(way.pixels), round(EACH_S / GRID_S)
    if len(imu) < 3 * edge:
        return None
    imu = imu[edge:-edge]
    every = max(round(EVERY_S / GRID_S), -(-(count - 2 * each) // TIMES))
    places = range(each, count - each + 1, every)
    before = [laid for place in places for laid in _laid(way, imu, imu_start, 0, place)]
    behind = [laid for place in places for laid in _laid(way, imu, imu_start, place, count)]
    pairs = [(one, other) for one in before for other in behind if _may_follow(one, other)]
    if not pairs:
        return None
    best = max(pairs, key=_worth_s)
    most_s = _worth_s(best)
    good = [pair for pair in pairs if _worth_s(pair) >= AS_GOOD * most_s and min(_explained(pair)) >= WELL] or [best]
    smallest_s = min(abs(_step_s(pair)) for pair in good)
    small = [pair for pair in good if abs(_step_s(pair)) < smallest_s + SAME_S]
    one, other = chosen = max(small, key=_worth_s)
    return Step(
        until_s=way.from_s + GRID_S * one.after,
        from_s=way.from_s + GRID_S * other.first,
        later_s=(later_s + one.later_s, later_s + other.later_s),
        explained=_explained(chosen),
        worth_s=lively(way.pixels[way.seen > 0]) * most_s,
        is_told=all(abs(_step_s(pair) - _step_s(chosen)) < SAME_S for pair in good),
    )


def _worth_s(pair: _Pair) -> float:
    return pair[0].worth_s + pair[1].worth_s


def _explained(pair: _Pair) -> tuple[float, float]:
    return pair[0].explained, pair[1].explained


def _step_s(pair: _Pair) -> float:
    return pair[1].later_s - pair[0].later_s


def _may_follow(one: _Laid, other: _Laid) -> bool:
    """Between them may be what the sensor has nothing of, no longer than its clock steps."""
    between_s = GRID_S * (other.first - one.after)
    step_s = other.later_s - one.later_s
    return abs(step_s) <= MOST_S and 0.0 <= between_s <= max(0.0, step_s) + EVERY_S * (between_s > 0.0)


def _laid(way: Way, imu: Array, imu_start: float, first: int, after: int) -> list[_Laid]:
    """Where a stretch goes best near the given clock, and where farther from it.

    `imu` begins `EDGE_S` after `imu_start`, as the way does after its own beginning.
    """
    seen = np.zeros_like(way.seen)
    seen[first:after] = way.seen[first:after]
    share, overlap = explained_by(way.pixels, imu, seen)
    later_s = way.from_s - imu_start - GRID_S * np.arange(1 - len(way.pixels), 1 - len(way.pixels) + len(share))
    is_laid = (np.abs(later_s) < MOST_S) & (overlap > LEAST_LAID * (after - first))
    worth_s = np.where(is_laid, -np.log1p(-np.minimum(share, MOST_EXPLAINED)) * GRID_S * overlap, -np.inf)
    is_near = np.abs(later_s) < NEAR_S
    places = (int(np.where(some, worth_s, -np.inf).argmax()) for some in (is_near, ~is_near))
    return [
        _Laid(first, after, float(later_s[k]), float(share[k]), float(worth_s[k]))
        for k in places
        if np.isfinite(worth_s[k])
    ]
