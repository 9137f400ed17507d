"""What rows of numbers show by themselves: runs of what is so, the last digit that was written, and noise."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from pytracker.rotation import Array

__all__ = ["SD_OF_MEDIAN", "last_digit", "noise_sd", "runs", "without_spikes"]

OFF_DIGITS, OFF_SHARE = 1e-3, 2e-7
"""What is a multiple of a unit is off it by no more units than this, or than the share of itself that a float32 is."""
SPIKE_ROWS, SPIKE_NOISE = 5, 6.0
"""A spike is told from so many rows about it, by so many times the noise."""
SD_OF_MEDIAN = 1.4826
"""A Gaussian's standard deviation, of the median of its size."""


def runs(is_so: ArrayLike, least: int = 1) -> list[tuple[int, int]]:
    """First row and the one after the last of every run of True in `(T,)` that has at least so many rows."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], np.asarray(is_so, dtype=bool), [False]])))
    return [(int(first), int(after)) for first, after in edges.reshape(-1, 2) if after - first >= least]


def last_digit(values: Array, digits: int) -> float:
    """What all finite values are multiples of: 1, 0.1, ... of so many digits; 0 where they were written with more."""
    seen = values[np.isfinite(values)]
    for k in range(digits + 1):
        units = seen * 10.0**k
        if np.allclose(units, np.rint(units), rtol=OFF_SHARE, atol=OFF_DIGITS):
            return float(10.0**-k)
    return 0.0


def noise_sd(values: Array) -> Array:
    """Standard deviation of the white noise in each column of `(T, K)`, `(K,)`: of what no trend explains.

    Told from second differences, whose variance is six times its own. Their median takes no notice of jumps.
    """
    return np.asarray(SD_OF_MEDIAN * np.median(np.abs(np.diff(values, n=2, axis=0)), axis=0) / np.sqrt(6.0))


def without_spikes(values: Array, least: float) -> Array:
    """The same `(T, K)`, NaN in rows that stand alone: farther from the median of those about them than `least`.

    And farther than noise is. What goes on is no spike, however fast.
    """
    known = np.isfinite(values).all(axis=1)
    seen = values[known]
    if len(seen) < SPIKE_ROWS:
        return values
    about = sliding_window_view(np.pad(seen, ((SPIKE_ROWS // 2,) * 2, (0, 0)), mode="reflect"), SPIKE_ROWS, axis=0)
    off = np.linalg.norm(seen - np.median(about, axis=-1), axis=1)
    out = values.copy()
    out[np.flatnonzero(known)[off > max(least, SPIKE_NOISE * float(np.linalg.norm(noise_sd(seen))))]] = np.nan
    return out
