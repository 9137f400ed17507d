"""Real arms' movement with worn sensors: errors, and bands that hold where the depth is not known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from captured_arm import KEPT, pooled, scored

import pytracker as pt
from pytracker.methods import ArmMethod


@pytest.mark.parametrize(
    ("method", "most_m", "least"), [(pt.Smooth(), 0.08, 0.92), (pt.Mixture(), 0.11, 0.87)], ids=["smooth", "mixture"]
)
def test_arms_of_people_are_followed(
    shared: Callable[[str], Path], method: ArmMethod, most_m: float, least: float
) -> None:
    """On clips that nothing was tuned on."""
    error, inside, still = pooled(shared("data").parent, KEPT, method, (1, 2))
    assert error < most_m
    assert error < 0.35 * still
    assert inside.min() > least


def test_where_two_depths_are_as_likely_the_band_holds_both(shared: Callable[[str], Path]) -> None:
    """An arm held out to the side, across the picture: started at one depth, a smoother is 20 cm off and sure."""
    for seed in (3, 5):
        score, _ = scored(shared("data").parent, "49_18 R", pt.Smooth(), seed)
        assert min(score.coverage) > 0.9
