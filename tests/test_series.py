"""What rows show by themselves: runs, last digits, noise."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import DTypeLike

from pytracker.series import last_digit, noise_sd, runs


@given(st.lists(st.booleans(), max_size=40), st.integers(1, 4))
def test_runs_hold_all_that_is_so_and_nothing_else(is_so: list[bool], least: int) -> None:
    found, inside = runs(is_so), np.zeros(len(is_so), dtype=bool)
    for first, after in found:
        assert all(is_so[first:after])
        inside[first:after] = True
    assert inside.tolist() == is_so
    assert all(a[1] < b[0] for a, b in itertools.pairwise(found))
    assert runs(is_so, least) == [run for run in found if run[1] - run[0] >= least]


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("digits", [0, 1, 3])
def test_the_last_digit_is_found_of_large_numbers_too(digits: int, dtype: DTypeLike) -> None:
    rng = np.random.default_rng(3)
    values = np.round(rng.uniform(-2000.0, 2000.0, (200, 2)), digits).astype(dtype).astype(float)
    values[3] = np.nan
    assert last_digit(values, 3) == pytest.approx(10.0**-digits)


def test_numbers_of_full_precision_have_no_last_digit() -> None:
    assert last_digit(np.random.default_rng(3).uniform(0.0, 2000.0, (200, 2)), 3) == 0.0


def test_noise_is_told_beside_a_trend_and_jumps() -> None:
    rng = np.random.default_rng(5)
    values = 0.2 * rng.standard_normal((4000, 2)) + np.linspace(0.0, 50.0, 4000)[:, None]
    values[2000:] += 90.0
    assert noise_sd(values) == pytest.approx([0.2, 0.2], rel=0.1)
