"""How a sensor is worn, found from a whole recording: what hidden frames must not change."""

from __future__ import annotations

import dataclasses

import numpy as np

import pytracker as pt
from pytracker.setup.worn import Worn, lags_of, weighed
from pytracker.simulate.arm import ArmSimulation


def test_a_way_to_wear_it_is_not_preferred_for_what_it_leaves_out() -> None:
    """Frames before the sensor began were forgiven for as many with a hidden patch: clocks were seconds off."""
    simulation = ArmSimulation(pt.ArmScene(pattern="circle", occlusions=((5.0, 8.0),)), 1)
    recording, pixels = simulation.recording(), simulation.sightings(2.0)
    hidden = (simulation.frame_time_s > 5.0) & (simulation.frame_time_s < 8.0)
    sightings = pt.Sightings.of(simulation.frame_time_s, np.where(hidden[:, None, None], np.nan, pixels))
    true = Worn(0.0, 0.0, np.array([0.0, 1.0, 0.0]))
    late = weighed(recording, sightings, dataclasses.replace(true, offset_s=3.0))
    assert weighed(recording, sightings, true).log_evidence > late.log_evidence + 100.0
    lags = lags_of(recording, sightings)
    assert abs(lags[0].offset_s) < 0.25
