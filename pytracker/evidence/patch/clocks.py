"""Whether a video's and an IMU's clocks go together: a patch's way laid over the IMU's, at other rates and other times.

A video whose frame rate is told wrongly, or a sensor's file whose rate is, has a clock that is right at one moment
only; two files that were started by hand have one that is right at none. As with a lag (`pytracker.evidence.patch.lag`)
neither camera, heading nor mount need to be known.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pytracker._core import ARM_ALIKE
from pytracker.evidence.patch.lag import (
    BAND_HZ,
    EDGE_S,
    GAP_S,
    GRID_S,
    LEAST_OVERLAP_S,
    MOST_EXPLAINED,
    banded,
    explained_by,
    was_seen,
)
from pytracker.rotation import Array
from pytracker.series import noise_sd, without_spikes

__all__ = ["FIRST_S", "NEAR_S", "SPIKE_PX", "Clock", "Way", "clock_as_given", "find_clock", "lively", "way_of"]

MOST, STEP = 0.25, 0.005
"""Rates from 24 frames/s for 30, to those so near that a minute does not tell them apart."""
FIRST_S = 60.0
NEAR_S = 0.6
"""A clock that is nearer than this to one that is given is the one that is given, or at another rate."""
LEAST_S = 10.0
"""Less fits at many a rate and time."""
LEAST_ROWS = 20
BLOCK_S = 0.5
"""Movement is counted in stretches so long: where most of them rest, few say anything."""
LEAST_SWIFT = 0.15
"""So much of the movement, RMS, must be as swift as is laid over each other: of what is slow only its remains are."""
LEAST_CLEAR = 2.2
"""And so many times more than what its centre jumps by: of a fifth that is noise nothing can be explained."""
SPIKE_PX = ARM_ALIKE["spike_px"]
"""A centre that leaps as far, alone, was not of the patch."""
LEAST_M = 0.04
"""A detector's wrist, or a patch that is half hidden, may be off by half of this, now to one side, now to another."""
WORN, WORN_GROWTH = 0.085, 0.3
"""What a worn sensor is off by, m/s/√s, and so much more of it per m/s² (as `pytracker.Mixture` has it)."""
EXCUSED = 2.5
"""So many times what noise leaves unexplained may be: of right ones, fast and slow, 2.1 times at most."""


@dataclass(frozen=True)
class Clock:
    """A clock of the IMU that lays it over the picture.

    Attributes:
        slower: by so large a share more time passes between the IMU's samples than is given.
        later_s: so much has to be added to the IMU's times.
        explained: share of the movement in the picture that the IMU's movement explains.
        worth_s: minus the logarithm of what is left unexplained, times the seconds that are laid over each other and in
            which something moves.
        swift_px: how far the patch moves as swiftly as is laid over each other, RMS.
        noise_m: by how much a sensor that is worn is off as swiftly, across the picture, RMS.
    """

    slower: float
    later_s: float
    explained: float
    worth_s: float
    swift_px: float
    noise_m: float

    def is_strange(self, px_per_m: float, most: float) -> bool:
        """Whether it explains less than such a share of the patch's way, and noise is no excuse for it.

        `px_per_m` is how large a metre is where the patch is.
        """
        swift_m = self.swift_px / px_per_m
        return swift_m > LEAST_M and self.explained < min(most, 1.0 - EXCUSED * (self.noise_m / swift_m) ** 2)

    @property
    def is_last(self) -> bool:
        """Whether no rate was tried that is farther from the given one: the best may be."""
        return abs(self.slower) > MOST - STEP


@dataclass(frozen=True, eq=False)
class Way:
    """The patch's way on the grid, as swift as is laid over each other.

    Attributes:
        from_s: begins `EDGE_S` before the first of them.
        pixels: `(G, 2)`.
        seen: where it was seen, 1 or 0 `(G,)`.
        swift_px: how far it moves, RMS.
    """

    from_s: float
    pixels: Array
    seen: Array
    swift_px: float


def find_clock(
    frame_s: Array, pixels: Array, imu_s: Array, acceleration: Array, near_s: float = NEAR_S
) -> tuple[Clock, Clock] | None:
    """The best clock within `near_s` at the rates that are given, and the best of all that are tried.

    Tried are other rates within `near_s`, and at the given rates every time. None where too little is seen, or moves
    too slowly, or the IMU measured too little of it. `pixels` `(T, 2)` are where the patch was at `frame_s`;
    `acceleration` `(M, 3)` is the IMU's at `imu_s`, by the video's clock as far as it is known, in an earth frame
    without gravity.
    """
    way = way_of(frame_s, pixels, imu_s)
    if way is None or len(imu_s) < 2:
        return None
    as_given = _laid(way, imu_s, acceleration, 0.0, near_s)
    none = Clock(0.0, 0.0, 0.0, 0.0, way.swift_px, _noise_m(acceleration))
    given = max((clock for clock in as_given if abs(clock.later_s) < near_s), key=_worth, default=none)
    # At another rate only what is about there is looked at.
    at_s, about_s = imu_s + given.later_s, min(near_s, MOST * FIRST_S) + MOST * FIRST_S + 2.0 * EDGE_S
    about = np.abs(at_s - np.clip(at_s, way.from_s, frame_s[frame_s <= frame_s[0] + FIRST_S][-1])) <= about_s
    rates = [STEP * step for step in range(-round(MOST / STEP), round(MOST / STEP) + 1) if step]
    imu_s, acceleration = imu_s[about], acceleration[about]
    others = [clock for rate in rates for clock in _laid(way, imu_s, acceleration, rate, near_s)]
    best = max((*as_given, *(clock for clock in others if abs(clock.later_s) < near_s)), key=_worth, default=None)
    if best is None:
        return None
    share = lively(way.pixels[way.seen > 0])
    given, best = (replace(clock, worth_s=share * clock.worth_s) for clock in (given, best))
    return given, best


def clock_as_given(frame_s: Array, pixels: Array, imu_s: Array, acceleration: Array) -> Clock | None:
    """That which is given, or one near it; arguments as above.

    None where `find_clock` finds none, or they overlap too briefly.
    """
    way = way_of(frame_s, pixels, imu_s)
    clocks = [] if way is None else _laid(way, imu_s, acceleration, 0.0, NEAR_S)
    return max((clock for clock in clocks if abs(clock.later_s) < NEAR_S), key=_worth, default=None)


def _measured(frame_s: Array, pixels: Array, imu_s: Array) -> Array:
    """The patch's way without where the IMU paused, whose way is made up there; `(T, 2)` px."""
    if len(imu_s) < 2:
        return pixels
    after = np.clip(np.searchsorted(imu_s, frame_s), 1, len(imu_s) - 1)
    return np.where((imu_s[after] - imu_s[after - 1] > GAP_S)[:, None], np.nan, pixels)


def way_of(frame_s: Array, pixels: Array, imu_s: Array) -> Way | None:
    """Of the first minute; None where too little is seen of it while the IMU measures, or it goes too slowly."""
    pixels = _measured(frame_s, pixels, imu_s)
    first = frame_s <= frame_s[0] + FIRST_S
    pixels = without_spikes(pixels, SPIKE_PX)
    seen = np.isfinite(pixels[first]).all(axis=1)
    if seen.sum() < LEAST_ROWS or seen.mean() * np.ptp(frame_s[first]) < LEAST_S:
        return None
    from_s, way = banded(frame_s[first], pixels[first])
    edge = round(EDGE_S / GRID_S)
    whole_px = float(np.linalg.norm(np.nanstd(pixels[first], axis=0)))
    if len(way) < 3 * edge:
        return None
    swift_px = float(np.linalg.norm(way[edge:-edge].std(axis=0)))
    interval_s = float(np.median(np.diff(frame_s[first])))
    noise_px = float(np.linalg.norm(noise_sd(pixels[first][seen]))) * np.sqrt(min(1.0, 2.0 * interval_s * BAND_HZ[1]))
    if not swift_px > max(LEAST_SWIFT * whole_px, LEAST_CLEAR * noise_px):
        return None
    return Way(from_s, way[edge:-edge], was_seen(frame_s[first], pixels[first])[edge:-edge], swift_px)


def _noise_m(acceleration: Array) -> float:
    """Of white noise that is integrated twice, what is as swift as is laid over each other."""
    density = WORN * (1.0 + WORN_GROWTH * np.linalg.norm(acceleration, axis=1))
    return float(np.sqrt(2.0 * np.mean(np.square(density)) / (3.0 * np.pi * (2.0 * np.pi * BAND_HZ[0]) ** 3)))


def lively(camera: Array) -> float:
    """In how large a share of the time it moves: 1 where in all of it alike."""
    block = round(BLOCK_S / GRID_S)
    energy = np.square(camera[: len(camera) // block * block]).reshape(-1, block, 2).sum(axis=(1, 2))
    return float(energy.sum() ** 2 / max(len(energy) * np.square(energy).sum(), 1e-30))


def _worth(clock: Clock) -> float:
    return clock.worth_s


def _laid(way: Way, imu_s: Array, acceleration: Array, slower: float, near_s: float) -> list[Clock]:
    """At a rate: the best clock near the one that is given, and the best of all others."""
    if len(imu_s) < 2:
        return []
    imu_start, imu = banded(imu_s + slower * (imu_s - way.from_s), acceleration, integrations=2)
    edge = round(EDGE_S / GRID_S)
    if len(imu) < 3 * edge:
        return []
    share, overlap = explained_by(way.pixels, imu[edge:-edge], way.seen)
    # Position k: the camera's first sample is met by the IMU's number k - (len(camera) - 1).
    first = 1.0 - len(way.pixels)
    later_s: Array = way.from_s - imu_start - GRID_S * np.arange(first, first + len(share))
    laid_s = GRID_S * overlap
    is_near = np.abs(later_s) < near_s
    is_laid = laid_s > np.where(is_near, LEAST_OVERLAP_S, LEAST_S)
    worth_s = np.where(is_laid, -np.log1p(-np.minimum(share, MOST_EXPLAINED)) * laid_s, -np.inf)
    found = _best(slower, later_s, share, worth_s, (is_near, ~is_near))
    return [Clock(*clock, way.swift_px, _noise_m(acceleration)) for clock in found]


def _best(
    slower: float, later_s: Array, share: Array, worth_s: Array, among: tuple[NDArray[np.bool_], ...]
) -> Iterator[tuple[float, float, float, float]]:
    for some in among:
        k = int(np.where(some, worth_s, -np.inf).argmax())
        if some[k] and np.isfinite(worth_s[k]):
            yield slower, float(later_s[k]), float(share[k]), float(worth_s[k])
