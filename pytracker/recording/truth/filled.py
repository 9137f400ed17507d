"""Markers that nobody measured: gaps of a truth that were filled in by straight lines, or held at the last place.

Nothing that lives goes straight on, to the last digit, and turns off at once: a track that is right is scored as wrong
there. What rests comes to rest and leaves it slowly.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pytracker.formats.markers import Markers
from pytracker.rotation import Array
from pytracker.series import last_digit, runs

__all__ = ["without_filled"]

LEAST_S, LEAST_ROWS = 0.3, 8
"""Shorter runs do no harm."""
STRIDE_S = 0.1
"""Rows so far apart are compared: of neighbours coarse digits tell nothing."""
STRAIGHT_M = 1e-5
"""Second differences of what is filled in are no larger, but for digits that are rounded."""
ROUNDED = 2.5
"""So many units of the last digit a second difference of rounded numbers may be off."""
TREMBLES = 0.3
"""Where no larger a share of a marker's other second differences is so small it trembles, never going straight on."""
CORNER, CORNER_DIGITS = 6.0, 5.0
"""Where it does not, they are so many times larger than usual where a filled run begins or ends, and than rounding."""
LEAVES_M, GOES_M = 0.015, 0.03
"""What is held is left by a leap of so much from one row to the next, and what is filled in by a line goes so far: what
rests, to its digits, rests, and is where it is said to be."""
JUMPS_M = 1.0
"""What leaps so far is no gap that was filled in: a stray."""
DIGITS = 6
"""Numbers of more decimals were computed, not rounded."""


def without_filled(file: Path, markers: Markers, name: str) -> tuple[Array, tuple[str, ...]]:
    """A marker's places, m `(T, 3)`, NaN where they were filled in; and a word where they were."""
    points = markers.positions_m[name]
    filled = list(_filled(markers.time_s, points))
    if not filled:
        return points, ()
    points = points.copy()
    for first, end in filled:
        points[first:end] = np.nan
    count = sum(end - first for first, end in filled)
    first, end = max(filled, key=lambda run: run[1] - run[0])
    from_s, to_s = markers.time_s[first], markers.time_s[end - 1]
    return points, (
        f"{file}: {name} goes straight on, or stays, to the last digit in {count} of {len(points)} rows, and turns off "
        f"at once, longest from {from_s:.3f} to {to_s:.3f} s: filled in or held, not measured, and left out of the "
        "scores",
    )


def _filled(time_s: Array, points: Array) -> Iterator[tuple[int, int]]:
    """First row and the one after the last, of what lies between two places that were measured."""
    interval_s = float(np.median(np.diff(time_s))) if len(points) > LEAST_ROWS + 2 else np.inf
    stride = max(1, round(STRIDE_S / interval_s))
    if len(points) < 2 * stride + LEAST_ROWS + 2:
        return
    bent = _bent(points, 1)
    most = max(STRAIGHT_M, ROUNDED * last_digit(points, DIGITS))
    is_straight = _bent(points, stride) <= most
    least = max(LEAST_ROWS, round(LEAST_S / interval_s))
    for first, after in runs(is_straight):
        # Of rows k, k + stride and k + 2 stride: rows first to last lie on one line.
        last = after - 1 + 2 * stride
        chord = np.linspace(points[first], points[last], last + 1 - first)
        if last - first < least + 2 or not np.abs(points[first : last + 1] - chord).max() <= 2.0 * most:
            continue
        usual = np.concatenate([bent[: max(first - 2, 0)], bent[last + 1 :]])
        usual = usual[np.isfinite(usual)]
        corners = np.concatenate([bent[max(first - 2, 0) : first + 1], bent[last - 2 : last + 1], [0.0]])
        corner_m = float(np.nanmax(corners))
        if not usual.size or corner_m > JUMPS_M:
            continue
        if not _does_harm(points, first, last):
            continue
        trembles = float((usual <= most).mean()) < TREMBLES
        if trembles or corner_m > max(CORNER * float(np.median(usual)), CORNER_DIGITS * most):
            yield first + 1, last


def _does_harm(points: Array, first: int, last: int) -> bool:
    """Whether a run goes somewhere, or is left or entered by a leap."""
    ends = [points[k : k + 2] for k in (first - 1, last) if 0 <= k < len(points) - 1]
    leaps = [float(np.linalg.norm(end[1] - end[0])) for end in ends if np.isfinite(end).all()]
    return float(np.linalg.norm(points[last] - points[first])) > GOES_M or max(leaps, default=0.0) > LEAVES_M


def _bent(points: Array, stride: int) -> Array:
    """Second differences of rows that are so far apart, m."""
    return np.asarray(
        np.linalg.norm(points[2 * stride :] - 2.0 * points[stride:-stride] + points[: -2 * stride], axis=1)
    )
