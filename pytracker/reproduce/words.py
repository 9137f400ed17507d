"""Numbers and comparisons in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pytracker.scores.intervals import Interval, mean_interval, paired_difference, paired_ratio

__all__ = ["averaged", "cm", "comparison", "plain_number", "share", "than", "times"]


def plain_number(value: float) -> str:
    """With as many digits as it deserves."""
    size = abs(value)
    if 0 < size < 0.001:
        return f"{value:.0e}"
    return f"{value:.{0 if size >= 100 else 1 if size >= 1 else 2 if size >= 0.1 else 3}f}"


def cm(interval: Interval) -> str:
    """Metres as `3.4 ± 0.5`, cm."""
    if not interval.count:
        return "–"
    value, half = 100 * interval.value, 100 * interval.half
    digits = 0 if abs(value) >= 100 else 2 if half < 0.1 else 1
    return f"{value:.{digits}f}" + ("" if math.isnan(half) else f" ± {half:.{digits}f}")


def share(*intervals: Interval) -> str:
    """Shares as `83 ± 4 %`, several as `83 ± 4 · 92 ± 2 %`."""
    if not all(interval.count for interval in intervals):
        return "–"
    halves = ["" if math.isnan(interval.half) else f" ± {100 * interval.half:.0f}" for interval in intervals]
    return " · ".join(f"{100 * i.value:.0f}{half}" for i, half in zip(intervals, halves, strict=True)) + " %"


def times(interval: Interval) -> str:
    """A ratio as `0.52 (0.44 to 0.61)`."""
    bounds = "" if math.isnan(interval.low) else f" ({plain_number(interval.low)} to {plain_number(interval.high)})"
    return f"{plain_number(interval.value)}{bounds}"


def comparison(first: Sequence[float], second: Sequence[float]) -> tuple[str, str, str, str]:
    """Two methods on the same seeds: ratio, difference in hundredths (m: cm), where the first is smaller, the verdict.

    The verdict is the ratio's: errors of filters that drift run over orders of magnitude, where a difference is that
    of the worst run.
    """
    pairs = [(a, b) for a, b in zip(first, second, strict=True) if math.isfinite(a) and math.isfinite(b)]
    if not pairs:
        return "–", "–", f"0 of {len(first)}", "not told apart"
    first, second = zip(*pairs, strict=True)
    ratio = paired_ratio(first, second)
    difference = paired_difference([100 * x for x in first], [100 * x for x in second])
    half = "" if math.isnan(difference.half) else f" ± {plain_number(difference.half)}"
    smaller = sum(a < b for a, b in zip(first, second, strict=True))
    if ratio.high < 1:
        verdict = "smaller"
    elif ratio.low > 1:
        verdict = "larger"
    else:
        verdict = "not told apart"
    return times(ratio), f"{plain_number(difference.value)}{half}", f"{smaller} of {len(first)}", verdict


def than(verdict: str) -> str:
    """A verdict before what it compares with."""
    return f"{verdict} from" if verdict == "not told apart" else f"{verdict} than"


def averaged(values: Sequence[float]) -> Interval:
    """The mean over those runs that have a value; NaN where none has."""
    known = [value for value in values if math.isfinite(value)]
    return mean_interval(known) if known else Interval(math.nan, math.nan, math.nan, 0)
