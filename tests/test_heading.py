"""A worn IMU's heading, weighed by what a worn sensor and a living shoulder do; tuned on other seeds."""

from __future__ import annotations

import numpy as np
import pytest

import pytracker as pt
from pytracker.setup.heading import ABOUT, heading_of
from pytracker.setup.worn import Worn
from pytracker.simulate import ArmSimulation

AXIS = np.array([0.0, 1.0, 0.0])


def found(pattern: str, seed: int, given_deg: float, duration_s: float = 20.0) -> tuple[float, float]:
    """Heading and its standard deviation, degrees, of a worn arm whose true one is 0."""
    simulation = ArmSimulation(pt.ArmScene(worn=True, pattern=pattern, duration_s=duration_s), seed)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(1.5))
    heading, sd = heading_of(simulation.recording(), sightings, Worn(0.0, np.radians(given_deg), AXIS))
    return float(np.degrees(heading)), float(np.degrees(sd))


@pytest.mark.parametrize("given_deg", [-12.0, 12.0])
def test_a_heading_that_is_off_is_found_better_and_how_well_is_known(given_deg: float) -> None:
    """The fast search was sure of such to 1°."""
    headings = [
        found(pattern, seed, given_deg) for pattern, seed in (("gesture", 81), ("rectangle", 82), ("circle", 83))
    ]
    off, sds = np.array(headings).T
    assert np.sqrt(np.mean(off**2)) < 0.65 * abs(given_deg)
    assert np.sqrt(np.mean((off / sds) ** 2)) < 2.0
    assert sds.min() > 1.5


def test_where_nothing_tells_it_stays_and_that_is_said() -> None:
    simulation = ArmSimulation(pt.ArmScene(duration_s=5.0), 1)
    unseen = pt.Sightings.of(simulation.frame_time_s, np.full((len(simulation.frame_time_s), 2), np.nan))
    seen = unseen.pixels.copy()
    seen[0] = simulation.sightings(1.0)[0]
    sightings = pt.Sightings(unseen.time_s, seen, unseen.reasons)
    heading, sd = heading_of(simulation.recording(), sightings, Worn(0.0, 0.3, AXIS))
    assert heading == 0.3
    assert sd == pytest.approx(ABOUT[-1])
