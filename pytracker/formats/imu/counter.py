"""A column that counts an IMU's samples: what it leaves out was lost, whatever the times beside it say."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pytracker.formats.text import cells_of

__all__ = ["counter_in", "missing_words", "steps_of"]

Float = NDArray[np.float64]

COUNTER = re.compile(
    r"(package|packet|sample|frame|seq(uence)?|msg|message)?(counter|count|cnt|number|num|no|index|idx|id)?"
)
"""What such a column is called."""
WRAPS = (2**8, 2**16, 2**32)
"""At which counters begin anew."""
MOST_STEP = 100
"""Who skips more counts something else."""
LATER = 1.5
"""Times are later by so much, of the usual interval, where samples are missing: else they were written row by row."""


def counter_in(names: Sequence[str]) -> int | None:
    """The column of `names` that is called as counters are; None where there is none."""
    plain = [re.sub(r"[\s_.#]+", "", name) for name in names]
    return next((k for k, name in enumerate(plain) if name and COUNTER.fullmatch(name)), None)


def steps_of(lines: Sequence[str], rows: NDArray[np.int64], delimiter: str, at: int) -> Float | None:
    """By how many samples each row is later than the one before `(M - 1,)`; None where the column counts none."""
    try:
        counts = np.array([float(cells_of(lines[row - 1], delimiter)[at]) for row in rows])
    except (ValueError, IndexError):
        return None
    steps = np.diff(counts)
    if len(steps) < 2 or not np.isfinite(counts).all():
        return None
    if (steps < 0).any():
        wrap = next((wrap for wrap in WRAPS if counts.max() < wrap), None)
        steps = np.where(steps < 0, steps + (wrap or 0), steps)
    usual = float(np.median(steps))
    if usual < 1 or (steps % usual != 0).any() or (steps < usual).any() or steps.max() > MOST_STEP * usual:
        return None
    return steps / usual


def missing_words(steps: Float, time_s: Float, lines: NDArray[np.int64]) -> str:
    """In words that samples are missing which the times do not show; empty where none is, or they do."""
    gaps = np.flatnonzero(steps > 1)
    if not gaps.size:
        return ""
    interval = np.diff(time_s)
    usual = float(np.median(interval[steps == 1]))
    if float(np.median(interval[gaps] / steps[gaps])) * float(np.median(steps[gaps])) > LATER * usual:
        return ""
    return (
        f"its counter skips {int((steps[gaps] - 1).sum())} samples in {gaps.size} places, first before line "
        f"{lines[gaps[0] + 1]}, and its times go on as if they were there"
    )
