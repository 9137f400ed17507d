"""One sensor of several that tick on their own, as in a phone's folder: its samples, and what lies between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["Stream"]

Float = NDArray[np.float64]

APART_S = 0.01
"""Clocks that begin no farther apart are one: that of the day is in milliseconds, of when samples arrived."""
FAR_S = 60.0
"""Those that begin farther apart are different clocks, such as one of the day and one of the phone's start."""
LONG_GAP, LONG_GAP_S = 10.0, 0.2
"""A sensor that is silent for so many of its usual intervals, and so long, has lost samples: nothing is between."""


@dataclass(frozen=True, eq=False)
class Stream:
    """What one sensor said.

    Attributes:
        path: its file.
        lines: line numbers of its samples `(M,)`.
        time_s: their times, s `(M,)`.
        values: `(M, K)`.
        began_s: when its times began, by the clock of the day, s; NaN where that is not said.
    """

    path: Path
    lines: NDArray[np.int64]
    time_s: Float
    values: Float
    began_s: float = np.nan

    def beside(self, other: Stream) -> Stream:
        """The same, by the clock of the other: MetaWear counts each sensor's times from its own first sample."""
        later_s = self.began_s - other.began_s
        return replace(self, time_s=self.time_s + later_s) if APART_S < abs(later_s) < FAR_S else self

    def at(self, time_s: Float) -> Float:
        """Between its samples `(T, K)`."""
        return np.stack([np.interp(time_s, self.time_s, column) for column in self.values.T], axis=1)

    def covers(self, time_s: Float) -> NDArray[np.bool_]:
        """At which times `(T,)` it is between two samples that follow each other."""
        if len(self.time_s) < 2:
            return np.zeros(len(time_s), dtype=bool)
        wait = np.diff(self.time_s)
        after = np.clip(np.searchsorted(self.time_s, time_s), 1, len(wait))
        inside = (time_s >= self.time_s[0]) & (time_s <= self.time_s[-1])
        # Those that come in batches share a time.
        apart = wait[wait > 0]
        usual_s = float(np.median(apart)) if len(apart) else 0.0
        return np.asarray(inside & (wait[after - 1] <= max(LONG_GAP_S, LONG_GAP * usual_s)))
