"""In which order observations come to a tracker: late, twice, out of order, of the same time."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from conftest import load_arm
from test_track import sightings, simulation, tracker_of

import pytracker as pt
from pytracker.evidence import sightings_of
from pytracker.evidence.observations import AT_ONCE
from pytracker.simulate import ArmSimulation

__all__ = ["sightings", "simulation"]


def test_what_comes_late_is_put_in_order_and_refused_beyond_the_delay(
    simulation: ArmSimulation, sightings: pt.Sightings
) -> None:
    """The camera is 0.1 s behind the IMU: the same bytes, only later."""
    recording, method = simulation.recording(), pt.Layered(particles=100)
    track = pt.track(recording, method, 4, sightings=sightings)
    source = sorted(recording.observations(sightings), key=lambda o: o.time_s + 0.1 * o.is_frame)
    late = pt.Tracker(recording, method, 4, delay_s=0.15)
    found = [estimate for observed in source if (estimate := late.observe(observed))]
    assert len(found) < len(sightings.time_s)
    with pytest.raises(
        pt.InputError,
        match=r"cannot be saved while .* wait, expected none: finish\(\) first",
    ):
        late.save()
    found += late.finish()
    assert np.array_equal([e.places["wrist"].mean for e in found], track.joints["wrist"].mean)
    with pytest.raises(pt.InputError, match=r"frame 3: frame at 0\.12 s comes .* s after a later one"):
        late.observe(pt.Observation.patch(0.12, (300.0, 250.0), 3))


def test_what_comes_twice_is_told_of_itself_where_late_ones_are_waited_for(
    simulation: ArmSimulation, sightings: pt.Sightings
) -> None:
    """It was told of a later observation, when both were due, and estimates stayed behind it."""
    recording, method = simulation.recording(), pt.Ekf()
    tracker, found = pt.Tracker(recording, method, delay_s=0.1), []
    for observed in recording.observations(sightings):
        found += [estimate for estimate in [tracker.observe(observed)] if estimate]
        with pytest.raises(pt.InputError, match=f"{observed.index}: .* comes .*{observed.time_s:g}"):
            tracker.observe(observed)
    found += tracker.finish()
    track = pt.track(recording, method, sightings=sightings)
    assert np.array_equal([e.places["wrist"].mean for e in found], track.joints["wrist"].mean)


def test_two_cameras_of_a_folder_are_one_time_axis(tmp_path: Path) -> None:
    folder = pt.simulate_arm(tmp_path / "two", pt.ArmScene(duration_s=2.0, cameras=2), seed=2)
    recording = load_arm(folder)
    sightings = sightings_of(recording)
    assert sightings.pixels.shape == (50, 2, 2)
    assert sightings.valid.all()
    scores = pt.evaluate(pt.track(recording, pt.Plain(), 1, sightings=sightings), recording.truth)
    assert scores.joints["wrist"].rms_m < 0.02


def test_an_imu_time_that_jumps_is_met_not_waited_for(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    recording = simulation.recording()
    for value, expected in (
        (np.nan, r"IMU sample 60 has time nan s after"),
        (99.0, r"IMU sample 61 has time 0\.61 s after 99\.0 s"),
    ):
        time_s = recording.imus[0].time_s.copy()
        time_s[60] = value
        imu = dataclasses.replace(recording.imus[0], time_s=time_s)
        with pytest.raises(pt.InputError, match=expected):
            pt.track(dataclasses.replace(recording, imus=(imu,)), pt.Layered(particles=50), sightings=sightings)


def test_sightings_out_of_order_are_refused(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    """They had been sorted for the tracker, and the rows written as they came."""
    for swap, expected in (([11, 10], r"frame 11 has time 0\.4 s after 0\.44 s"), ([10, 10], "frame 11 has time")):
        time_s = sightings.time_s.copy()
        time_s[[10, 11]] = time_s[swap]
        other = dataclasses.replace(sightings, time_s=time_s)
        with pytest.raises(pt.InputError, match=expected):
            pt.track(simulation.recording(), pt.Ekf(), sightings=other)
    none = dataclasses.replace(sightings, time_s=np.zeros(0), pixels=np.zeros((0, 1, 2)), reasons=())
    with pytest.raises(pt.InputError, match="the sightings hold no frame"):
        pt.track(simulation.recording(), pt.Ekf(), sightings=none)


def test_the_same_frame_twice_is_refused(simulation: ArmSimulation) -> None:
    tracker, imu = tracker_of(pt.Layered()), simulation.imu
    tracker.observe(pt.Observation.inertial(0.0, imu.acc[0], imu.q_world_segment[0]))
    tracker.observe(pt.Observation.patch(0.0, None))
    with pytest.raises(pt.InputError, match="frame at 0 s comes after 0 s was reached"):
        tracker.observe(pt.Observation.patch(0.0, None))


def test_a_sample_comes_before_the_frame_of_its_time() -> None:
    """Also where one stretch of samples ends and the next begins: frames at every fourth sample, the thousandth too."""
    recording = ArmSimulation(pt.ArmScene(duration_s=25.0), 1).recording()
    times = recording.imus[0].time_s
    assert len(times) > 2 * AT_ONCE
    frame_times = times[3::4]
    sightings = pt.Sightings.of(frame_times, np.zeros((len(frame_times), 2)))
    found = list(recording.observations(sightings))
    assert [o.time_s for o in found] == sorted(o.time_s for o in found)
    assert [o.index for o in found if o.is_frame] == list(range(len(frame_times)))
    assert [o.index for o in found if not o.is_frame] == list(range(len(times)))
    before = [found[k - 1] for k, o in enumerate(found) if o.is_frame]
    assert [(o.is_frame, o.time_s) for o in before] == [(False, time_s) for time_s in frame_times]
