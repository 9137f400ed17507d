"""95 % confidence intervals over runs: of a mean, and of two methods compared on the same seeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pytracker._core import InputError
from pytracker.student import student_975

__all__ = ["Interval", "mean_interval", "paired_difference", "paired_ratio"]


@dataclass(frozen=True)
class Interval:
    """A figure over runs and where it lies with 95 % confidence (Student's t); no interval for a single run.

    Attributes:
        value: the mean.
        low: lower end; NaN for a single run.
        high: upper end; NaN for a single run.
        count: how many runs.
    """

    value: float
    low: float
    high: float
    count: int

    @property
    def half(self) -> float:
        """Half its width."""
        return (self.high - self.low) / 2


def mean_interval(values: Sequence[float]) -> Interval:
    """The mean of `values` and its interval. Raises `InputError` for none, or for one that is not finite."""
    array = np.asarray(values, dtype=float)
    if not array.size or not np.isfinite(array).all():
        raise InputError(f"an interval was asked of {array.size} values {array[:5]}, expected finite ones")
    mean = float(array.mean())
    if array.size == 1:
        return Interval(mean, math.nan, math.nan, 1)
    half = student_975(array.size - 1) * float(array.std(ddof=1)) / math.sqrt(array.size)
    return Interval(mean, mean - half, mean + half, int(array.size))


def paired_difference(first: Sequence[float], second: Sequence[float]) -> Interval:
    """Mean of `first - second`, run by run: what the runs share (recording, noise) falls out.

    Raises `InputError` where they differ in length, or as `mean_interval`.
    """
    _check_pairs(first, second)
    return mean_interval(np.subtract(first, second).tolist())


def paired_ratio(first: Sequence[float], second: Sequence[float]) -> Interval:
    """Geometric mean of `first / second`, run by run: the fair way where errors run over orders of magnitude.

    Raises `InputError` as `paired_difference`.
    """
    _check_pairs(first, second)
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithm = mean_interval(np.log(np.divide(first, second)).tolist())
    return Interval(math.exp(logarithm.value), math.exp(logarithm.low), math.exp(logarithm.high), logarithm.count)


def _check_pairs(first: Sequence[float], second: Sequence[float]) -> None:
    if len(first) != len(second):
        raise InputError(f"there are {len(first)} and {len(second)} values, expected pairs")
