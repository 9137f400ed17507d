"""What a stream says of itself as it comes: a patch that is not seen, accelerations without gravity."""

from __future__ import annotations

from collections.abc import Callable

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


def refused_in_stream(
    delay_s: float, sent_s: Callable[[float], float], said_s: Callable[[int, float], float]
) -> tuple[list[str], list[str]]:
    """Doubts and errors of five seconds whose samples arrive, and say that they were taken, when they did not."""
    simulation = ArmSimulation(pt.ArmScene(duration_s=5.0), 1)
    imu = simulation.imu
    arriving = [
        (sent_s(t), 0, pt.Observation.inertial(said_s(k, t), acc, q))
        for k, (t, acc, q) in enumerate(zip(imu.time_s, imu.acc, imu.q_world_segment, strict=True))
    ]
    frames = zip(simulation.frame_time_s, simulation.sightings(), strict=True)
    arriving += [(t, 1, pt.Observation.patch(t, list(pixels))) for t, pixels in frames if t > imu.time_s[0]]
    tracker, doubts, errors = pt.Tracker(simulation.recording(), pt.Mixture(), 1, delay_s), list[str](), list[str]()
    for _, _, observation in sorted(arriving, key=lambda one: one[:2]):
        try:
            estimate = tracker.observe(observation)
        except pt.InputError as error:
            errors.append(str(error))
        else:
            doubts += [estimate.doubt or ""] if estimate is not None else []
    return doubts, errors


@pytest.mark.parametrize("delay_s", [0.0, 0.1])
def test_a_stream_that_had_to_do_without_many_samples_is_doubted(delay_s: float) -> None:
    """Samples that come in bursts, later than is waited for: 27 cm off, and nothing was said but by the errors."""
    doubts, errors = refused_in_stream(delay_s, lambda t: np.ceil(t / 0.3) * 0.3, lambda _, t: t)
    assert len(errors) > 100
    assert sum("many IMU samples were refused" in doubt for doubt in doubts) > 0.8 * len(doubts)
    doubts, errors = refused_in_stream(delay_s, lambda t: t, lambda _, t: t)
    assert not errors
    assert not any(doubts)


@pytest.mark.parametrize("delay_s", [0.0, 0.1])
def test_one_wild_time_does_not_end_a_stream(delay_s: float) -> None:
    """All that came after it was late for ever."""
    doubts, (error,) = refused_in_stream(delay_s, lambda t: t, lambda k, t: 1e9 if k == 100 else t)
    assert "IMU sample at 1000000000 s comes more than" in error
    assert len(doubts) > 100
    assert not any(doubts)


@pytest.mark.parametrize("ahead_s", [60.0, 3600.0])
def test_nor_does_one_that_is_minutes_ahead_where_observations_may_come_late(ahead_s: float) -> None:
    """All that came after it was refused."""
    doubts, (error,) = refused_in_stream(0.1, lambda t: t, lambda k, t: t + ahead_s if k == 100 else t)
    assert "comes more than 10 s after the last at" in error
    assert len(doubts) > 100
    assert not any(doubts)


def test_a_pause_costs_one_observation() -> None:
    """A sensor, and a camera, that were off for a minute: a second observation says what the first did."""
    doubts, errors = refused_in_stream(
        0.1, lambda t: t if t < 3.0 else t + 60.0, lambda _, t: t if t < 3.0 else t + 60.0
    )
    assert len(errors) == 1
    assert len(doubts) > 100
