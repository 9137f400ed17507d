"""What a stream says of itself as it comes: a patch that is not seen, accelerations without gravity."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import estimated

import pytracker as pt
from pytracker.inertial.gravity import GRAVITY
from pytracker.methods.arm import ArmMethod
from pytracker.simulate import ArmSimulation


def doubts_of_stream(
    method: ArmMethod, hidden_from_s: float, unit: float, turn_unit: float | None = None
) -> list[tuple[float, str]]:
    """Times and doubts of five seconds whose patch is hidden from a time on, acceleration and turns in other units."""
    simulation = ArmSimulation(pt.ArmScene(duration_s=5.0), 1)
    imu, said = simulation.imu, list[tuple[float, str]]()
    tracker = pt.Tracker(simulation.recording(), method, 1)
    assert imu.gyr is not None
    samples = iter(zip(imu.time_s, imu.acc, imu.q_world_segment, imu.gyr, strict=True))
    taken_s = -np.inf
    for frame_s, pixels in zip(simulation.frame_time_s, simulation.sightings(), strict=True):
        while taken_s < frame_s and (sample := next(samples, None)) is not None:
            taken_s, acc, q, gyr = sample
            turn_rate = None if turn_unit is None else turn_unit * gyr
            tracker.observe(pt.Observation.inertial(taken_s, unit * acc, q, turn_rate))
        seen = list(pixels) if frame_s < hidden_from_s else [None]
        said.append((frame_s, estimated(tracker, pt.Observation.patch(max(frame_s, taken_s), seen)).doubt))
    return said


@pytest.mark.parametrize("method", [pt.Mixture(), pt.Layered(particles=200)])
def test_a_stream_without_its_patch_is_doubted(method: ArmMethod) -> None:
    """A wrist that was not seen for 15 s was 26 cm off, beside its band, and nothing was said."""
    hidden = doubts_of_stream(method, 3.0, 1.0)
    assert not any(words for time_s, words in hidden if time_s < 3.2)
    assert all(words for time_s, words in hidden if time_s > 3.4)
    assert "no camera sees the patch" in {words for _, words in hidden}


def test_a_stream_in_g_is_doubted() -> None:
    said = doubts_of_stream(pt.Mixture(), np.inf, 1.0 / GRAVITY)
    assert "the acceleration shows no gravity" in said[-1][1]
    assert not any(words for _, words in doubts_of_stream(pt.Mixture(), np.inf, 1.0))


def test_a_stream_whose_gyroscope_is_in_degrees_is_doubted() -> None:
    """27 cm off, and nothing was said: of a file it is refused."""
    said = doubts_of_stream(pt.Mixture(), np.inf, 1.0, np.degrees(1.0))
    assert "the gyroscope turns otherwise than the orientation" in said[-1][1]
    assert not any(words for _, words in doubts_of_stream(pt.Mixture(), np.inf, 1.0, 1.0))
