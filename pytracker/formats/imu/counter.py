"""A column that counts an IMU's samples: what it skips was lost, where times were written row by row."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pytracker.formats.text import cells_of

__all__ = ["as_counted", "counter_in", "steps_of"]

Float = NDArray[np.float64]

COUNTER = re.compile(
    r"((package|packet|sample|msg|message|seq(uence)?)(counter|count|cnt|number|num|no|nr)|counter|packet(index|idx|id)?)"
    r"|seq(uence)?"
)
"""What such a column is called; a frame's number may be a camera's, an index a table's."""
WRAPS = (2**8, 2**16, 2**32)
"""At which counters begin anew, from a few steps before on."""
MOST_STEP = 100
"""Who skips more counts something else."""
STRAIGHTER = 0.3
"""Times that were written row by row are this much straighter over rows than over counts."""
JUMPS = 1.15
"""Where samples are missing a sensor turns by so much more, from one to the next, than where none is."""


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
    wrap = next((wrap for wrap in WRAPS if wrap - MOST_STEP < counts.max() < wrap), 0)
    steps = np.where(steps < 0, steps + wrap, steps)
    usual = float(np.median(steps))
    if usual < 1 or (steps % usual != 0).any() or (steps < usual).any() or steps.max() > MOST_STEP * usual:
        return None
    return steps / usual


def as_counted(steps: Float, time_s: Float, gyr: Float | None, lines: NDArray[np.int64]) -> tuple[Float, str]:
    """Times with the samples in them that were lost, and words on it; as they are, and none, where they show them.

    A counter is believed where times go on evenly, row by row, and the sensor turns farther where samples are missing.
    """
    gaps = np.flatnonzero(steps > 1)
    if not gaps.size or gyr is None:
        return time_s, ""
    count = np.append(0.0, np.cumsum(steps))
    row = np.arange(len(time_s), dtype=np.float64)
    by_row, by_count = (_off_line(over, time_s) for over in (row, count))
    jump = np.linalg.norm(np.diff(gyr, axis=0), axis=1)
    farther = float(np.mean(jump[gaps])) / max(float(np.mean(jump[steps == 1])), 1e-9)
    if by_row > STRAIGHTER * by_count or not farther > JUMPS:
        return time_s, ""
    interval = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
    words = (
        f"its counter skips {int((steps[gaps] - 1).sum())} samples in {gaps.size} places, first before line "
        f"{lines[gaps[0] + 1]}, and its times go on as if they were there: the counter is believed"
    )
    return time_s[0] + count * interval, words


def _off_line(over: Float, time_s: Float) -> float:
    """How far times are off the straight line over something, RMS, s."""
    line = np.polyfit(over, time_s, 1)
    return float(np.sqrt(np.mean((time_s - np.polyval(line, over)) ** 2)))
