"""What was lately so: means and medians over the last moments of what frames say, as one frame may be wrong."""

from __future__ import annotations

import math
import statistics
from collections import deque

import numpy as np

from pytracker.rotation import Array

__all__ = ["ASK_EVERY_S", "AtFirst", "Lately", "mean_of_known", "median_of_known"]

ASK_EVERY_S = 0.06
"""What takes long to ask changes slowly: between such times it is not known."""
WINDOW_S = 0.25
"""Reasons are of this much time: one frame's mask may be wrong."""
FIRST_S = 0.25
"""What is seen in the first frames is how a person is whose pose is given."""


class Lately:
    """Rows of values `(K,)` of the last moments, frame by frame."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, Array]] = deque()

    def take(self, time_s: float, row: Array) -> Array:
        """Take a frame's, NaN where not known; all that are of lately `(T, K)`."""
        self._rows.append((time_s, row))
        while self._rows[0][0] <= time_s - WINDOW_S:
            self._rows.popleft()
        return np.array([row for _, row in self._rows])


class AtFirst:
    """The same of the first frames."""

    def __init__(self) -> None:
        self._began_s = float("nan")
        self._rows: list[Array] = []
        self.median = np.empty(0)
        """Column by column of what is known `(K,)`; NaN where nothing is."""

    def take(self, time_s: float, row: Array) -> None:
        """Take a frame's `(K,)`, NaN where not known."""
        if not self._rows:
            self._began_s = time_s
        if time_s <= self._began_s + FIRST_S:
            self._rows.append(row)
            self.median = median_of_known(np.array(self._rows))


def mean_of_known(rows: Array) -> Array:
    """Column by column of `(T, K)`, of what is known; NaN where nothing is."""
    known = np.isfinite(rows)
    counts = known.sum(axis=0)
    return np.asarray(np.where(counts > 0, np.where(known, rows, 0.0).sum(axis=0) / np.maximum(counts, 1), np.nan))


def median_of_known(rows: Array) -> Array:
    """The same, of which one wild row says nothing."""
    columns = ([value for value in column if math.isfinite(value)] for column in rows.T.tolist())
    return np.array([statistics.median(known) if known else math.nan for known in columns])
