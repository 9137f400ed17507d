"""What was lately so: means and medians over the last moments of what frames say, as one frame may be wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.rotation import Array

__all__ = ["ASK_EVERY_S", "first_rows", "mean_lately", "median_of_known"]

ASK_EVERY_S = 0.06
"""What takes long to ask changes slowly: between such times it is not known."""
WINDOW_S = 0.25
"""Reasons are of this much time: one frame's mask may be wrong."""


def first_rows(time_s: Array) -> NDArray[np.intp]:
    """The first row of every row's window `(T,)`, at increasing times."""
    return np.searchsorted(time_s, time_s - WINDOW_S, side="right")


def mean_lately(time_s: Array, values: Array) -> Array:
    """Mean of what is known of `(T, K)` over every row's window; NaN where nothing is."""
    known = np.isfinite(values)
    sums = np.cumsum(np.vstack([np.zeros((1, values.shape[1])), np.where(known, values, 0.0)]), axis=0)
    counts = np.cumsum(np.vstack([np.zeros((1, values.shape[1])), known]), axis=0)
    first, last = first_rows(time_s), np.arange(1, len(time_s) + 1)
    with np.errstate(invalid="ignore"):
        return np.asarray((sums[last] - sums[first]) / (counts[last] - counts[first]))


def median_of_known(rows: Array) -> Array:
    """Column by column of `(T, K)`, of what is known: one wild row says nothing; NaN where nothing is."""
    known = np.isfinite(rows)
    return np.array([np.median(rows[of, k]) if (of := known[:, k]).any() else np.nan for k in range(rows.shape[1])])
