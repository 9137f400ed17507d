"""How a sensor is worn, found from a whole recording: what hidden frames must not change."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from captured_arm import CapturedArm, captured
from conftest import IS_ACCEPTANCE

import pytracker as pt
from pytracker.rotation import triple
from pytracker.setup.checks.worn import check_worn
from pytracker.setup.worn import Worn, lags_of, put_on, weighed
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


def test_frames_without_samples_tell_no_mount_from_another() -> None:
    """A video that went on 5 s after the sensor had stopped: a right mount was written over by one 74° off (24 cm)."""
    simulation = ArmSimulation(pt.ArmScene(worn=True, pattern="gesture", period_s=2.0), 3)
    whole, sightings = simulation.recording(), pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    imu = whole.imus[0]
    keep = (imu.time_s > 2.0) & (imu.time_s < 15.0)
    assert imu.gyr is not None
    short = dataclasses.replace(
        imu,
        time_s=imu.time_s[keep],
        acc=imu.acc[keep],
        gyr=imu.gyr[keep],
        q_world_segment=imu.q_world_segment[keep],
    )
    cut = dataclasses.replace(whole, imus=(short,))
    true = Worn(0.0, 0.0, np.array([0.0, 1.0, 0.0]))
    across = dataclasses.replace(true, axis=np.array([1.0, 0.0, 0.0]))
    best = weighed(whole, sightings, true).log_evidence
    # As if all had been seen as most of it was: no frame that nobody could explain counts.
    assert abs(weighed(cut, sightings, true).log_evidence - best) < 100.0
    assert weighed(cut, sightings, across).log_evidence < best - 200.0
    never = dataclasses.replace(true, offset_s=100.0)
    assert weighed(cut, sightings, never).log_evidence < best - 1000.0


def test_samples_long_after_the_last_frame_tell_nothing() -> None:
    """Of a long recording the first frames are looked at; every way to wear the sensor took all of its samples."""
    simulation = ArmSimulation(pt.ArmScene(worn=True, pattern="gesture", duration_s=6.0), 3)
    recording = simulation.recording()
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0)).first(75)
    imu, last_s = recording.imus[0], float(sightings.time_s[-1])
    moved = dataclasses.replace(imu, acc=np.where(imu.time_s[:, None] > last_s + 1.0, 50.0, imu.acc))
    way = Worn(0.0, 0.0, np.array([0.0, 1.0, 0.0]))
    (one, *_), (other, *_) = (put_on(dataclasses.replace(recording, imus=(of,)), way, sightings) for of in (imu, moved))
    assert last_s < one.imus[0].time_s[-1] < last_s + 1.05 < imu.time_s[-1]
    assert np.array_equal(one.imus[0].acc, other.imus[0].acc)


def test_of_a_camera_that_is_turned_nothing_is_called_mirrored(shared: Callable[[str], Path]) -> None:
    """Of two explanations that are both none the mirrored one was better, and a right video would be turned over."""
    simulation = CapturedArm(*captured(shared("data").parent, "49_18 L"), 1)
    recording = simulation.recording()
    camera = recording.views[0].camera
    c, s = np.cos(np.radians(-3.0)), np.sin(np.radians(-3.0))
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    x, y, z = (triple(row) for row in turn @ np.array(camera.rotation))
    translation_m = triple(turn @ np.array(camera.translation_m))
    turned = dataclasses.replace(camera, rotation=(x, y, z), translation_m=translation_m)
    recording = dataclasses.replace(recording, views=(dataclasses.replace(recording.views[0], camera=turned),))
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    given = Worn(0.0, 0.0, np.array([0.0, 1.0, 0.0]))
    found, worn = check_worn(recording, sightings, given, (False, False, False), 640)
    (said,) = (finding for finding in found if finding.what == "picture")
    assert worn is None
    assert "neither as it is nor mirrored" in said.evidence
    assert "check the camera's pose" in said.evidence


def test_where_a_circle_fits_two_mounts_the_clock_alone_is_written() -> None:
    """One of them was written, and 44 cm off, all valid; the clock is the same by both."""
    simulation = ArmSimulation(pt.ArmScene(worn=True, pattern="circle", duration_s=8.0), 102)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    given = Worn(0.0, 0.0, np.array([1.0, 0.0, 0.0]))
    clock, mount = check_worn(simulation.recording(), sightings, given, (False, False, False), 640)[0]
    assert set(clock.writes) == {"imu.offset_s", "imu.offset_sd_s"}
    assert clock.writes["imu.offset_s"] == pytest.approx(0.0, abs=0.15)
    assert (mount.what, mount.verdict, dict(mount.writes)) == ("heading and mount", "cannot be told", {})


@pytest.mark.parametrize("pattern", ["gesture", "rectangle"] if IS_ACCEPTANCE else ["gesture"])
def test_of_a_mirrored_video_neither_heading_nor_mount_is_written(pattern: str) -> None:
    """Some mount explains it too: one 69° off was written, 46 cm off and all valid."""
    simulation = ArmSimulation(pt.ArmScene(worn=True, pattern=pattern, period_s=3.0, duration_s=10.0), 11)
    recording, pixels = simulation.recording(), simulation.sightings(2.0)
    mirrored = np.stack([639.0 - pixels[:, 0, 0], pixels[:, 0, 1]], axis=1)
    given = Worn(0.0, 0.0, np.array([0.0, 1.0, 0.0]))
    for of, expected in ((pixels, False), (mirrored, True)):
        sightings = pt.Sightings.of(simulation.frame_time_s, of)
        found, worn = check_worn(recording, sightings, given, (False, False, False), 640)
        wrong = [finding for finding in found if finding.what == "picture"]
        assert bool(wrong) == (worn is None) == expected
        if expected:
            assert wrong[0].verdict == "wrong"
            assert "mirrored" in wrong[0].evidence
            assert not any("heading_deg" in place or "mount" in place for one in found for place in one.writes)
