"""Intervals over runs: Student's t against SciPy, coverage by simulation, pairing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

import pytracker as pt
from pytracker.scores.intervals import mean_interval, paired_difference, paired_ratio
from pytracker.student import student_975


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 5, 6, 7, 10, 32, 39, 500])
def test_quantile_of_students_t(freedom: int) -> None:
    assert student_975(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=1e-4)


def test_interval_is_that_of_scipy(rng: np.random.Generator) -> None:
    values = rng.normal(3.0, 2.0, 10)
    found = mean_interval(values.tolist())
    low, high = stats.t.interval(0.95, 9, loc=values.mean(), scale=stats.sem(values))
    assert found.count == 10
    assert found.low == pytest.approx(low, rel=1e-4)
    assert found.high == pytest.approx(high, rel=1e-4)
    assert found.half == pytest.approx((high - low) / 2, rel=1e-3)


def test_intervals_hold_the_mean_as_often_as_they_say(rng: np.random.Generator) -> None:
    held = [i.low <= 1.0 <= i.high for i in (mean_interval(rng.normal(1.0, 1.0, 5).tolist()) for _ in range(2000))]
    assert 0.935 < np.mean(held) < 0.965


def test_pairing_removes_what_the_runs_share(rng: np.random.Generator) -> None:
    shared = rng.normal(0.0, 10.0, 12)
    first, second = shared + 1.0 + rng.normal(0, 0.1, 12), shared + rng.normal(0, 0.1, 12)
    difference = paired_difference(first.tolist(), second.tolist())
    assert difference.low > 0.8
    assert difference.high < 1.2
    assert mean_interval(first.tolist()).half > 10 * difference.half


def test_ratio_is_geometric() -> None:
    ratio = paired_ratio([2.0, 8.0], [1.0, 1.0])
    assert ratio.value == pytest.approx(4.0)
    assert ratio.low < 4.0 < ratio.high


def test_what_has_no_interval() -> None:
    single = mean_interval([2.0])
    assert (single.value, single.count) == (2.0, 1)
    assert np.isnan([single.low, single.high]).all()
    for values in ([], [1.0, float("nan")], [1.0, float("inf")]):
        with pytest.raises(pt.InputError, match="expected finite ones"):
            mean_interval(values)
    with pytest.raises(pt.InputError, match="there are 3 and 1 values, expected pairs"):
        paired_difference([1.0, 2.0, 3.0], [1.0])
    with pytest.raises(pt.InputError, match="expected finite ones"):
        paired_ratio([1.0, 2.0], [0.0, 1.0])
