"""A clock that counts whole seconds, as dates without a fraction do: where within them samples were measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.rotation import Array

__all__ = ["counts_seconds", "in_seconds"]

WHOLE = 1e-6
"""Times of arrival are no whole seconds, to within so much."""
LEAST_SECONDS = 3
"""Fewer have no rate."""
UNEVEN = 3.0
"""Seconds begin within so many samples of an even rate, where none are lost."""
MOST = 0.75
"""So many of the seconds lost nothing."""
FEWER = 0.97
"""A second with fewer of its samples than this share of the usual lost some."""


def counts_seconds(time_s: Array) -> bool:
    """Whether times `(M,)` are whole seconds, counted from wherever they begin."""
    since = time_s - time_s[0]
    return bool((np.abs(since - np.rint(since)) < WHOLE).all() and np.count_nonzero(np.diff(time_s)) >= LEAST_SECONDS)


def in_seconds(time_s: Array) -> tuple[Array, NDArray[np.bool_], str]:
    """Times `(M,)` at which samples can have been measured, s, which of them are kept, and in words what was done.

    At an even rate by the first sample of each second; where some were lost second by second, without those that lost
    some: where within them is not known. What begins at 0 begins with its first sample.
    """
    begins = np.flatnonzero(np.diff(time_s) > 0) + 1
    counts = np.diff(begins)
    slope, start = np.polyfit(begins, time_s[begins], 1)
    even = start + slope * np.arange(len(time_s))
    early, kept = (time_s - even)[begins], np.ones(len(time_s), dtype=bool)
    words = "its times are in whole seconds, expected those at which samples were measured: they are put "
    if np.ptp(early) <= UNEVEN * slope and np.diff(time_s).max() < 1.0 + WHOLE:
        out, words = even + early.max(), f"{words}at an even {1.0 / slope:.4g} Hz"
    else:
        usual = float(np.quantile(counts, MOST))
        out = np.concatenate([_within(part, usual, is_first=not k) for k, part in enumerate(np.split(time_s, begins))])
        fewer = counts < FEWER * usual
        kept[begins[0] : begins[-1]] = np.repeat(~fewer, counts)
        words += (
            f"second by second, without {int(fewer.sum())} of {len(counts)} that have fewer than the usual {usual:.0f} "
            "samples: where those were lost is not known"
        )
    return (out - out[0] if time_s[0] == 0.0 else out), kept, words


def _within(second: Array, usual: float, *, is_first: bool) -> Array:
    """Of one second's samples: the first second's end with it, the others begin with it."""
    count = len(second)
    step_s = 1.0 / (usual if is_first else max(usual, count))
    return np.asarray(second + (1.0 - step_s * count if is_first else 0.0) + step_s * np.arange(count))
