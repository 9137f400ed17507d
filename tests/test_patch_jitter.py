"""How uncertain centres of a patch are, as they jump; and bands that know it."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

import pytracker as pt
from pytracker.simulate.arm import ArmSimulation

PATTERNS = ("circle", "rectangle", "reach", "gesture")


@cache
def simulated(seed: int, pattern: str, frame_rate_hz: float) -> ArmSimulation:
    return ArmSimulation(pt.ArmScene(worn=True, pattern=pattern, frame_rate_hz=frame_rate_hz), seed)


def seen(
    pixel_sd: float, seed: int, pattern: str = "circle", frame_rate_hz: float = 25.0
) -> tuple[pt.ArmRecording, pt.Sightings]:
    simulation = simulated(seed, pattern, frame_rate_hz)
    return simulation.recording(), pt.Sightings.of(simulation.frame_time_s, simulation.sightings(pixel_sd))


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("rate_hz", [10.0, 25.0, 60.0])
@pytest.mark.parametrize("pixel_sd", [0.0, 4.0, 10.0])
def test_jitter_is_told_from_movement(pattern: str, rate_hz: float, pixel_sd: float) -> None:
    """Slow frames and lively arms too."""
    found = [seen(pixel_sd, seed, pattern=pattern, frame_rate_hz=rate_hz)[1].jitter_px for seed in (1, 2, 3)]
    assert np.mean(found) == pytest.approx(pixel_sd, rel=0.12, abs=0.5)
    assert max(found) < 1.25 * pixel_sd + 0.5


def test_frames_that_were_dropped_or_not_seen_are_no_jitter() -> None:
    _, sightings = seen(2.0, 1)
    kept = np.ones(len(sightings.time_s), dtype=bool)
    kept[40::10] = False
    pixels = sightings.pixels[kept].copy()
    pixels[200:230] = np.nan
    found = pt.Sightings.of(sightings.time_s[kept], pixels).jitter_px
    assert found == pytest.approx(sightings.jitter_px, rel=0.2)
    assert np.isnan(pt.Sightings.of(sightings.time_s[:50], sightings.pixels[:50]).jitter_px)
    assert np.isnan(pt.Sightings.of(sightings.time_s[:1], sightings.pixels[:1]).jitter_px)


def test_centres_that_jump_more_than_is_expected_widen_the_bands_and_are_told() -> None:
    inside = []
    for seed, pattern in enumerate(PATTERNS):
        recording, sightings = seen(10.0, seed, pattern=pattern)
        track = pt.track(recording, pt.Smooth(), seed, sightings=sightings)
        assert track.method.pixel_sd == sightings.jitter_px
        inside.append(pt.evaluate(track, recording.truth).joints["wrist"].coverage)
        (doubt,) = pt.doubts(track)
        assert re.search(r"the centre of the patch jumps by (9|1\d)\.\d px from frame to frame", doubt)
    assert np.mean(inside, axis=0).min() > 0.85
    recording, sightings = seen(10.0, 1)
    own = pt.track(recording, pt.Mixture(pixel_sd=3.0), 1, sightings=sightings)
    assert own.method == pt.Mixture(pixel_sd=3.0, velocity_start_sd=own.method.velocity_start_sd)
    assert "is taken to be known to 3 px" in pt.doubts(own)[0]
    usual = pt.track(*seen(4.0, 1)[:1], pt.Mixture(), 1, sightings=seen(4.0, 1)[1])
    assert usual.method == pt.Mixture(velocity_start_sd=usual.method.velocity_start_sd)
    assert pt.doubts(usual) == ()
