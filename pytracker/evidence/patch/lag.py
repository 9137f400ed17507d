"""By how much two clocks differ: a patch's way in the picture laid over an IMU's way in the world.

Neither camera, heading nor mount need to be known: whatever they are, a small movement in the picture is some linear
map of the movement in the world. Both are held between two frequencies, where the IMU, integrated twice, drifts little
and the picture is seen well; at every lag one is regressed on the other, where the patch was seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pytracker.rotation import Array
from pytracker.series import runs

__all__ = [
    "BAND_HZ",
    "EDGE_S",
    "GAP_S",
    "GRID_S",
    "LEAST_OVERLAP_S",
    "MOST_EXPLAINED",
    "Lag",
    "banded",
    "explained_by",
    "find_lags",
    "was_seen",
]

GRID_S = 0.02
BAND_HZ = (0.3, 4.0)
EDGE_S = 1.0
"""Ends of a signal that the filter makes up."""
GAP_S = 0.3
"""Over longer gaps a patch's way is made up too, and half as long before and after them, but no longer than at ends."""
LEAST_OVERLAP_S = 4.0
LEAST_SHARE = 0.35
"""Shorter overlaps than this share of the shorter recording are not tried."""
MOST_EXPLAINED = 0.995
LEAST_SEEN_S = 4.0
"""For so long the patch must be seen: between what is seen a way is made up, and laid over anything."""
PEAKS = 60
APART_S = 0.15
WORTH = 0.45
"""A lag that is worth less than this share of the best is none."""


@dataclass(frozen=True)
class Lag:
    """One way to lay the recordings over each other.

    Attributes:
        offset_s: video time = IMU time + offset.
        explained: share of the movement in the picture that the IMU's movement explains.
        overlap_s: for how long.
        worth: what lags are compared by.
    """

    offset_s: float
    explained: float
    overlap_s: float
    worth: float


def banded(time_s: Array, values: Array, *, integrations: int = 0) -> tuple[float, Array]:
    """Start, s, and values `(G, K)` every `GRID_S`, between the frequencies, integrated so many times.

    Rows that are no numbers are bridged.
    """
    known = np.isfinite(values).all(axis=1)
    grid = np.arange(time_s[0], time_s[-1], GRID_S)
    steady = np.stack([np.interp(grid, time_s[known], column) for column in values[known].T], axis=1)
    steady -= np.linspace(0, 1, len(grid))[:, None] * (steady[-1] - steady[0]) + steady[0]
    steady -= steady.mean(axis=0)
    padded = 2 * len(grid)
    hz = np.fft.rfftfreq(padded, GRID_S)
    low, high = BAND_HZ
    gain = 1.0 / ((1.0 + (low / np.maximum(hz, 1e-9)) ** 8) * (1.0 + (hz / high) ** 8)) ** 0.5
    gain = gain / np.maximum(2 * np.pi * hz, 1e-9) ** integrations * (-1.0) ** (integrations // 2)
    gain[0] = 0.0
    mirrored = np.concatenate([steady, steady[::-1]])
    out = np.fft.irfft(np.fft.rfft(mirrored, axis=0) * gain[:, None], padded, axis=0)[: len(grid)]
    return float(grid[0]), out


def was_seen(time_s: Array, values: Array) -> Array:
    """On the grid of `banded` `(G,)`: 1 where what it gives was seen, 0 where it is made up."""
    grid = np.arange(time_s[0], time_s[-1], GRID_S)
    seen = np.ones(len(grid))
    for first, after in runs(~np.isfinite(values).all(axis=1)):
        begin_s, end_s = time_s[max(0, first - 1)], time_s[min(after, len(time_s) - 1)]
        if end_s - begin_s > GAP_S:
            about_s = min(EDGE_S, 0.5 * (end_s - begin_s))
            seen[(grid > begin_s - about_s) & (grid < end_s + about_s)] = 0.0
    return seen


def find_lags(frame_s: Array, pixels: Array, imu_s: Array, acceleration: Array) -> tuple[Lag, ...]:
    """The best ways to lay them over each other, best first; none where too little is seen or they overlap too briefly.

    `pixels` `(T, 2)` are where the patch was at `frame_s`, by the video's clock; `acceleration` `(M, 3)` is the IMU's
    in its own earth frame without gravity, by its own clock.
    """
    if len(frame_s) < 2 or np.isfinite(pixels).all(axis=1).sum() * np.median(np.diff(frame_s)) < LEAST_SEEN_S:
        return ()
    camera_start, camera = banded(frame_s, pixels)
    imu_start, imu = banded(imu_s, acceleration, integrations=2)
    edge = round(EDGE_S / GRID_S)
    if len(camera) < 3 * edge or len(imu) < 3 * edge:
        return ()
    seen = was_seen(frame_s, pixels)[edge:-edge]
    camera, imu = camera[edge:-edge], imu[edge:-edge]
    explained, overlap = explained_by(camera, imu, seen)
    least = max(LEAST_OVERLAP_S, LEAST_SHARE * GRID_S * min(float(seen.sum()), len(imu)))
    worth = np.where(overlap * GRID_S >= least, -np.log1p(-np.minimum(explained, MOST_EXPLAINED)) * overlap, 0.0)
    # Position k: the camera's first sample is met by the IMU's number k - (len(camera) - 1).
    shift = np.arange(len(worth)) - (len(camera) - 1)
    offsets = camera_start - imu_start - shift * GRID_S
    found: list[Lag] = []
    for k in np.argsort(-worth):
        if len(found) == PEAKS or worth[k] <= 0 or (found and worth[k] * GRID_S < WORTH * found[0].worth):
            break
        if all(abs(offsets[k] - other.offset_s) > APART_S for other in found):
            found.append(
                Lag(float(offsets[k]), float(explained[k]), float(overlap[k] * GRID_S), float(worth[k] * GRID_S))
            )
    return tuple(found)


def explained_by(camera: Array, imu: Array, seen: Array) -> tuple[Array, Array]:
    """At every shift: share of the camera's square that a linear map of the IMU explains; how many samples overlap.

    Of `camera` `(G, 2)` those count that were `seen` `(G,)`, 1 or 0.
    """
    count = len(camera) + len(imu) - 1
    shift = np.arange(count) - (len(camera) - 1)
    first_imu, first_camera = np.maximum(shift, 0), np.maximum(-shift, 0)
    overlap = np.minimum(len(imu) - first_imu, len(camera) - first_camera)
    size = 1 << (count - 1).bit_length()
    camera = seen[:, None] * camera
    spectra = np.fft.rfft(imu, size, axis=0), np.fft.rfft(camera[::-1], size, axis=0)
    across = np.empty((count, 3, 2))
    for i in range(3):
        for j in range(2):
            across[:, i, j] = np.fft.irfft(spectra[0][:, i] * spectra[1][:, j], size)[:count]
    products = imu[:, :, None] * imu[:, None, :]
    if seen.all():  # as sums, which take a part of the time
        inner = _sums(products, first_imu, overlap)
    else:
        of_seen = np.fft.rfft(seen[::-1], size)[:, None, None]
        inner = np.fft.irfft(np.fft.rfft(products, size, axis=0) * of_seen, size, axis=0)[:count]
    whole = _sums((camera**2).sum(axis=1), first_camera, overlap)
    trace = np.trace(inner, axis1=1, axis2=2)
    # Where nothing was seen there is what rounding left.
    inner = inner + 1e-3 * (trace + 1e-6 * np.abs(trace).max() + 1e-30)[:, None, None].clip(1e-30) * np.eye(3)
    told = np.einsum("kij,kij->k", across, np.linalg.solve(inner, across))
    return np.clip(told / np.maximum(whole, 1e-30), 0.0, 1.0), _sums(seen, first_camera, overlap)


def _sums(values: Array, first: Array, count: Array) -> Array:
    sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    return np.asarray(sums[first + count] - sums[first])
