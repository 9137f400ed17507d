"""Recordings that start amid a movement: cut from longer ones, or filmed before somebody was ready."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import pytracker as pt
from pytracker.methods.arm import ArmMethod
from pytracker.rotation import triple
from pytracker.simulate import ArmSimulation
from pytracker.tracking.arm import _speed_sd

LIVELY = pt.ArmScene(pattern="gesture", period_s=2.0, worn=True)


def cut_where_it_is_fastest(seed: int) -> tuple[pt.ArmRecording, pt.Sightings]:
    """From the fastest moment in its third to eighth second on; where the wrist is then is known to 1 cm."""
    simulation = ArmSimulation(LIVELY, seed)
    recording, time_s, pixels = simulation.recording(), simulation.frame_time_s, simulation.sightings(4.0)
    assert recording.truth is not None
    wrist = recording.truth.at("wrist", time_s)
    speed = np.linalg.norm(np.gradient(wrist, time_s, axis=0), axis=1)
    first = int(np.argmax(np.where((time_s > 3.0) & (time_s < 8.0), speed, 0.0)))
    assert speed[first] > 1.0
    start = triple(wrist[first] + np.random.default_rng(seed).normal(0.0, 0.01, 3))
    view = dataclasses.replace(recording.views[0], start_s=float(time_s[first]))
    arm = dataclasses.replace(recording.arm, wrist_start_m=start)
    cut = dataclasses.replace(recording, views=(view,), arm=arm)
    return cut, pt.Sightings.of(time_s[first:], pixels[first:])


@pytest.mark.parametrize(("method", "most_cm"), [(pt.Smooth(), 5.0), (pt.Mixture(), 12.0)])
def test_an_arm_that_moves_at_the_first_frame_is_followed_from_there(method: pt.Mixture, most_cm: float) -> None:
    found = []
    for seed in (201, 202, 203):
        recording, sightings = cut_where_it_is_fastest(seed)
        track = pt.track(recording, method, 1, sightings=sightings)
        assert track.method.velocity_start_sd >= 0.3
        assert pt.doubts(track) == ()
        found.append(pt.evaluate(track, recording.truth).joints["wrist"])
    assert 100 * np.sqrt(np.mean([wrist.rms_m**2 for wrist in found])) < most_cm
    assert np.mean([wrist.coverage for wrist in found], axis=0).min() > 0.9


def test_an_arm_that_was_taken_to_rest_would_not_be() -> None:
    recording, sightings = cut_where_it_is_fastest(201)
    track = pt.track(recording, pt.Mixture(velocity_start_sd=0.021), 1, sightings=sightings)
    assert track.method.velocity_start_sd == 0.021
    assert pt.evaluate(track, recording.truth).joints["wrist"].rms_m > 0.12


@pytest.mark.parametrize("method", [pt.Smooth(), pt.Mixture(), pt.Ekf(), pt.Joint(particles=200)])
def test_an_arm_that_rests_is_found_to(method: ArmMethod) -> None:
    simulation = ArmSimulation(LIVELY, 204)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(4.0)).first(50)
    track = pt.track(simulation.recording(), method, 1, sightings=sightings)
    assert track.method.velocity_start_sd == 0.02


def test_a_patch_that_is_not_seen_at_first_tells_by_the_second_in_which_it_is() -> None:
    """Of nothing seen all explain the same: it was taken to go slowly."""
    simulation = ArmSimulation(LIVELY, 204)
    pixels = simulation.sightings(4.0)
    for hidden, expected in ((5, 0.02), (40, 0.8), (len(pixels), 0.8)):
        seen = pixels.copy()
        seen[:hidden] = np.nan
        sightings = pt.Sightings.of(simulation.frame_time_s, seen)
        assert _speed_sd(simulation.recording(), sightings, pt.Mixture()) == expected


def test_a_start_that_only_the_ray_tells_may_move_and_be_elsewhere() -> None:
    simulation = ArmSimulation(LIVELY, 204)
    spreads = {"position_start_sd_m": 0.3, "velocity_start_sd": 0.8}
    recording = dataclasses.replace(simulation.recording(), spreads=spreads)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(4.0)).first(50)
    method = pt.track(recording, pt.Smooth(), 1, sightings=sightings).method
    assert (method.position_start_sd_m, method.velocity_start_sd) == (0.3, 0.8)


@pytest.mark.parametrize(("from_s", "to_s"), [(0.0, 12.0), (0.0, 2.0), (20.0, 32.0)])
@pytest.mark.parametrize("method", [pt.Mixture(), pt.Smooth()], ids=lambda method: type(method).__name__)
def test_a_sensor_that_was_there_for_a_part(from_s: float, to_s: float, method: ArmMethod) -> None:
    """Where it ended long before a window of smoothing, or began after a second, all of the track was lost."""
    simulation = ArmSimulation(pt.ArmScene(pattern="gesture", worn=True, duration_s=50.0), 1)
    recording = simulation.recording()
    imu = recording.imus[0]
    there = (imu.time_s >= from_s) & (imu.time_s < to_s)
    assert imu.gyr is not None
    acc, gyr, q = (np.ascontiguousarray(of[there]) for of in (imu.acc, imu.gyr, imu.q_world_segment))
    part = dataclasses.replace(imu, time_s=imu.time_s[there], acc=acc, gyr=gyr, q_world_segment=q)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(1.5))
    track = pt.track(dataclasses.replace(recording, imus=(part,)), method, 1, sightings=sightings)
    assert not track.lost
    known = (track.time_s >= from_s + 0.1) & (track.time_s < to_s)
    assert track.valid[known].mean() > 0.9
    assert not track.valid[track.time_s > to_s + 0.5].any()
    assert pt.doubts(track) == ()
