"""What goes wrong amid a recording of an arm is told by its last frames."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE

import pytracker as pt
from pytracker.doubting.description import of_last_frames
from pytracker.evidence.sightings import Sightings
from pytracker.recording.recording import Imu
from pytracker.rotation import Array, multiply, rotate, rotation_vector_to_quaternion
from pytracker.simulate.arm import ArmSimulation

DURATION_S = 60.0
UP, ALONG_X = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def drifting(imu: Imu) -> Imu:
    """By 30° a minute: a gyroscope that is 0.5°/s off."""
    angle = np.radians(30.0) * imu.time_s / 60.0
    q = multiply(rotation_vector_to_quaternion(angle[:, None] * UP), imu.q_world_segment)
    return dataclasses.replace(imu, q_world_segment=np.ascontiguousarray(q))


def slipping(imu: Imu, about: Array, degrees: float) -> Imu:
    """In a second amid the recording."""
    angle = np.radians(degrees) * np.clip(imu.time_s - 0.5 * DURATION_S, 0.0, 1.0)
    turn = rotation_vector_to_quaternion(angle[:, None] * about)
    back = turn * np.array([1.0, -1.0, -1.0, -1.0])
    q = np.ascontiguousarray(multiply(imu.q_world_segment, turn))
    gyr = None if imu.gyr is None else rotate(back, imu.gyr)
    return dataclasses.replace(imu, acc=rotate(back, imu.acc), gyr=gyr, q_world_segment=q)


@pytest.mark.parametrize("pattern", ["gesture", "rectangle"] if IS_ACCEPTANCE else ["gesture"])
def test_an_orientation_that_drifts_and_a_strap_that_slips_are_told(pattern: str) -> None:
    """Neither was, but as a camera that rolls and a patch elsewhere; the wrist 8 to 16 cm off at the end."""
    simulation = ArmSimulation(pt.ArmScene(pattern=pattern, worn=True, duration_s=DURATION_S, period_s=3.0), 42)
    recording = simulation.recording()
    sightings = Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    assert pt.doubts(pt.track(recording, pt.Mixture(), 1, sightings=sightings)) == ()
    imu = recording.imus[0]
    for wrong, words in (
        (drifting(imu), "turned by -"),
        (slipping(imu, UP, 30.0), "turned by -"),
        (slipping(imu, ALONG_X, -30.0), "mount turned by +30°"),
    ):
        worse = dataclasses.replace(recording, imus=(wrong,))
        track = pt.track(worse, pt.Mixture(), 1, sightings=sightings)
        # All that is asked takes its time, and is asked of one in every run.
        is_whole = IS_ACCEPTANCE or "mount" in words
        (said,) = pt.doubts(track) if is_whole else of_last_frames(track, worse, sightings)
        assert "from about 40 s on camera and IMU agree better with" in said
        assert words in said


def test_a_sensor_that_ends_early_is_asked_of_what_it_measured() -> None:
    """Of the last frames it says nothing: they ended in an IndexError."""
    simulation = ArmSimulation(pt.ArmScene(pattern="gesture", worn=True, duration_s=40.0), 7)
    recording, imu = simulation.recording(), simulation.recording().imus[0]
    sightings = Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    some = imu.time_s < 15.0
    gyr = None if imu.gyr is None else imu.gyr[some]
    short = dataclasses.replace(
        imu, time_s=imu.time_s[some], acc=imu.acc[some], gyr=gyr, q_world_segment=imu.q_world_segment[some]
    )
    track = pt.track(dataclasses.replace(recording, imus=(short,)), pt.Mixture(), 1, sightings=sightings)
    assert pt.doubts(track) == ()
