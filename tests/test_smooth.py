"""The arm over a whole recording: better than the filter it starts from, bands that hold, the clock found."""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE
from test_arm_life import played, pooled

import pytracker as pt
from pytracker.evidence.sightings import Sightings
from pytracker.tracking.found import found_by

KNOWN = pt.Smooth(
    upper_arm_sd_m=0.0, forearm_sd_m=0.0, shoulder_place_sd_m=0.0, mount_sd_rad=0.0, camera_turn_sd_rad=0.0,
    camera_distance_sd_m=0.0, focal_sd=0.0,
)  # fmt: skip
"""Lengths, shoulder and camera are as they are said to be."""
AS_WORN = pt.Smooth(
    upper_arm_sd_m=0.005, forearm_sd_m=0.005, shoulder_place_sd_m=0.005, camera_turn_sd_rad=0.005,
    camera_distance_sd_m=0.02, focal_sd=0.01,
)  # fmt: skip
"""They are known as well as the simulator of worn arms says that they are (`pytracker.simulate.worn`)."""
LIVELY = pt.ArmScene(pattern="gesture", worn=True, period_s=2.0)


@pytest.mark.parametrize(
    ("method", "scene", "most_m", "share"),
    [
        (pt.Smooth(), LIVELY, 0.042, 0.6),
        (pt.Smooth(), pt.ArmScene(pattern="reach", worn=True), 0.058, 0.65),
        (AS_WORN, pt.ArmScene(worn=True), 0.060, 1.1),
        (pt.Smooth(), pt.ArmScene(worn=True), 0.064, 1.15),
        (KNOWN, pt.ArmScene(), 0.022, 0.7),
        (pt.Smooth(), pt.ArmScene(), 0.030, 0.9),
    ],
    ids=["gestures", "reach", "circle", "circle, less known", "circle, not worn, of which all is known", "not worn"],
)
def test_what_comes_after_helps_and_its_bands_hold(
    method: pt.Smooth, scene: pt.ArmScene, most_m: float, share: float
) -> None:
    """Tuned on seeds 11 to 14."""
    error, coverage = pooled(method, scene, range(1, 6))
    filtered, _ = pooled(pt.Mixture(), scene, range(1, 6))
    assert error < most_m
    assert error < share * filtered
    assert coverage.min() > 0.92


@pytest.mark.parametrize("drift_ppm", [300.0, -30.0] if IS_ACCEPTANCE else [-30.0])
def test_a_clock_that_drifts_is_found_over_a_long_recording(drift_ppm: float) -> None:
    """To some 20 ppm within minutes of lively movement; what is found is what has to be added."""
    recording, sightings = played(
        dataclasses.replace(LIVELY, worn=False, duration_s=240.0 if IS_ACCEPTANCE else 150.0), 5
    )
    imu = recording.imus[0]
    slow = dataclasses.replace(imu, time_s=imu.time_s * (1.0 - 1e-6 * drift_ppm))
    track = pt.track(dataclasses.replace(recording, imus=(slow,)), pt.Smooth(), sightings=sightings)
    (drift,) = (found for found in found_by(track) if found.name == "drift_ppm")
    assert drift.is_told
    assert drift.sd < 30.0
    assert abs(drift.change - drift_ppm) < 3.0 * drift.sd
    short = pt.track(recording, pt.Smooth(), sightings=pt.Sightings.of(sightings.time_s[:500], sightings.pixels[:500]))
    assert not [found for found in found_by(short) if found.name == "drift_ppm"]


def test_same_bytes_for_any_number_of_threads() -> None:
    recording, sightings = played(dataclasses.replace(LIVELY, duration_s=6.0), 3)
    tracks = [pt.track(recording, pt.Smooth(), 1, sightings=sightings, threads=threads) for threads in (1, 2, 7)]
    for other in tracks[1:]:
        assert tracks[0].joints["wrist"].mean.tobytes() == other.joints["wrist"].mean.tobytes()
        assert tracks[0].joints["elbow"].hi.tobytes() == other.joints["elbow"].hi.tobytes()


def test_online_it_is_the_mixture() -> None:
    recording, sightings = played(pt.ArmScene(duration_s=4.0), 2)
    method = pt.Smooth()
    names = ("arm_length_sd_m", "forearm_sd_rad", "shoulder_motion_sd_m", "shoulder_density")
    alike = {name: getattr(method, name) for name in names}
    whole = pt.track(recording, pt.Mixture(**alike), sightings=sightings)
    tracker = pt.Tracker(recording, dataclasses.replace(method, velocity_start_sd=whole.method.velocity_start_sd))
    source = recording.observations(sightings)
    online = [found.places["wrist"].mean for observed in source if (found := tracker.observe(observed))]
    assert np.array_equal(online, whole.joints["wrist"].mean)


@pytest.mark.parametrize("late_s", [-0.06, 0.0, 0.08])
def test_the_clock_is_found_with_its_spread(late_s: float) -> None:
    """The camera sees so much later than the IMU's clock says; the last column of the state is that."""
    recording, sightings = played(dataclasses.replace(LIVELY, worn=False), 4)
    imu = recording.imus[0]
    late = dataclasses.replace(recording, imus=(dataclasses.replace(imu, time_s=imu.time_s + late_s),))
    track = pt.track(late, pt.Smooth(), sightings=sightings)
    found, sd = track.state_mean[-1, -1], track.state_sd[-1, -1]
    assert abs(found - late_s) < 0.012
    assert sd < 0.012
    scores = pt.evaluate(track, recording.truth).joints["wrist"]
    assert scores.rms_m < 0.05


def test_after_a_pause_it_starts_again_and_nothing_crosses_it() -> None:
    recording, sightings = played(pt.ArmScene(pattern="reach", duration_s=12.0), 5, 2.0)
    imu = recording.imus[0]
    assert imu.gyr is not None
    keep, frames = (imu.time_s < 5) | (imu.time_s > 7.5), (sightings.time_s < 5) | (sightings.time_s > 7.5)
    cut = dataclasses.replace(
        imu, time_s=imu.time_s[keep], acc=imu.acc[keep], q_world_segment=imu.q_world_segment[keep], gyr=imu.gyr[keep]
    )
    seen = Sightings.of(sightings.time_s[frames], sightings.pixels[frames])
    track = pt.track(dataclasses.replace(recording, imus=(cut,)), pt.Smooth(), sightings=seen)
    assert recording.truth is not None
    off = np.linalg.norm(track.joints["wrist"].mean - recording.truth.at("wrist", seen.time_s), axis=1)
    assert np.isfinite(off).all()
    assert off.max() < 0.3


def test_where_it_finds_no_trajectory_the_filters_estimates_stay_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    recording, sightings = played(pt.ArmScene(duration_s=2.0), 2)

    class Lost:
        def __init__(self, *arguments: object) -> None:
            self.tracker = pt.Tracker(*arguments)  # type: ignore[arg-type]  # as they come

        def __getattr__(self, name: str) -> object:
            return getattr(self.tracker, name)

        def smoothed(self, *_: object, **__: object) -> None:
            raise pt.TrackingError("no way")

    monkeypatch.setattr("pytracker.tracking.arm.Tracker", Lost)
    track = pt.track(recording, pt.Smooth(), sightings=sightings)
    assert np.isfinite(track.joints["wrist"].mean).all()
    assert not track.valid.any()
    assert "could not be smoothed" in track.reason[0]


@pytest.mark.parametrize(
    "values",
    [
        {"bias": False}, {"tilt_start_sd_rad": 0.0}, {"shoulder_motion_sd_m": 0.0}, {"shoulder": False},
        {"patch_offset": False}, {"clock_sd_s": 0.0}, {"components": 1}, {"bias_density": 0.0, "tilt_density": 0.0},
    ],
    ids=str,
)  # fmt: skip
def test_what_is_known_exactly_is_no_trouble(values: dict[str, Any]) -> None:
    recording, sightings = played(pt.ArmScene(duration_s=4.0), 2, 2.0)
    track = pt.track(recording, pt.Smooth(**values), sightings=sightings)
    assert track.valid.mean() > 0.95
    assert pt.evaluate(track, recording.truth).joints["wrist"].rms_m < 0.12


def test_frames_before_the_first_sample_and_after_the_last_are_survived() -> None:
    recording, sightings = played(pt.ArmScene(duration_s=6.0), 2)
    imu = recording.imus[0]
    assert imu.gyr is not None
    keep = (imu.time_s > 0.5) & (imu.time_s < 5.5)
    short = dataclasses.replace(
        imu, time_s=imu.time_s[keep], acc=imu.acc[keep], q_world_segment=imu.q_world_segment[keep], gyr=imu.gyr[keep]
    )
    track = pt.track(dataclasses.replace(recording, imus=(short,)), pt.Smooth(), sightings=sightings)
    tracked = np.isfinite(track.joints["wrist"].mean[:, 0])
    assert not tracked[sightings.time_s < 0.49].any()
    assert tracked[sightings.time_s > 0.52].all()
    assert not track.valid[sightings.time_s > 5.6].any()


def beside(recording: pt.ArmRecording, sightings: Sightings, by_m: float) -> pt.Track:
    """Tracked with the shoulder said to be so far to the side."""
    x, y, z = recording.arm.shoulder_m
    moved = dataclasses.replace(recording.arm, shoulder_m=(x + by_m, y, z))
    return pt.track(dataclasses.replace(recording, arm=moved), pt.Smooth(), sightings=sightings)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_shoulder_that_is_elsewhere_is_found_and_told(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """By 10 cm to the side, on lively gestures, the wrist is as right as with the true shoulder; 15 cm are told."""
    monkeypatch.setattr(importlib.import_module("pytracker.doubting.arm"), "of_description", lambda *_: ())
    recording, sightings = played(LIVELY, seed)
    assert pt.doubts(beside(recording, sightings, 0.0)) == ()
    wrist = pt.evaluate(beside(recording, sightings, 0.1), recording.truth).joints["wrist"]
    assert wrist.rms_m < 0.05
    assert min(wrist.coverage) > 0.8
    (words,) = pt.doubts(beside(recording, sightings, 0.15))
    assert "another shoulder along x" in words
    assert "check shoulder_m" in words


def test_what_was_measured_once_is_found_with_its_spread() -> None:
    """Lengths and camera, off by one to two standard deviations: nearer than they were given, within two sds."""
    recording, sightings = played(dataclasses.replace(LIVELY, worn=False), 6)
    arm, view = recording.arm, recording.views[0]
    (fx, skew, cx), row, last = view.camera.matrix
    given = dataclasses.replace(view.camera, matrix=((fx, skew, cx + 12.0), row, last))
    wrong = dataclasses.replace(
        recording, arm=dataclasses.replace(arm, upper_arm_m=arm.upper_arm_m + 0.015),
        views=(dataclasses.replace(view, camera=given),),
    )  # fmt: skip
    found = {one.what: one for one in found_by(pt.track(wrong, pt.Smooth(), sightings=sightings))}
    upper, pan = found["upper arm"], found["camera's pan"]
    assert abs(upper.change + 1.5) < 1.5
    assert abs(upper.change + 1.5) < 2 * upper.sd
    # A picture whose centre is said to be 12 px to the right is one that is panned by as much.
    assert pan.change == pytest.approx(-np.degrees(12.0 / fx), abs=2 * pan.sd)
    assert pan.is_told
    assert not found["camera's focal length"].is_told


def test_what_the_recording_says_of_spreads_stands_for_the_methods_own() -> None:
    recording, sightings = played(pt.ArmScene(duration_s=3.0), 2)
    said = dataclasses.replace(recording, spreads={"upper_arm_sd_m": 0.002, "clock_sd_s": 0.01})
    track = pt.track(said, pt.Smooth(), sightings=sightings)
    assert isinstance(track.method, pt.Smooth)
    assert (track.method.upper_arm_sd_m, track.method.clock_sd_s) == (0.002, 0.01)
    assert {one.what: one.given_sd for one in found_by(track)}["upper arm"] == pytest.approx(0.2)
    assert pt.track(said, pt.Layered(particles=50), sightings=sightings).method == pt.Layered(particles=50)


def test_a_long_recording_is_smoothed_window_by_window_and_its_clock_may_drift() -> None:
    """Windows overlap: nothing jumps between them; 100 ppm over 80 s are 8 ms."""
    scene = pt.ArmScene(pattern="gesture", period_s=2.0, duration_s=80.0)
    recording, sightings = played(scene, 2)
    imu = recording.imus[0]
    drifting = dataclasses.replace(recording, imus=(dataclasses.replace(imu, time_s=imu.time_s * (1 + 1e-4)),))
    done: list[int] = []
    track = pt.track(
        drifting, pt.Smooth(), sightings=sightings,
        progress=lambda stage, frames: done.append(frames) if stage == "smooth" else None,
    )  # fmt: skip
    assert len(done) > 1
    assert done[-1] == len(sightings.time_s)
    scores = pt.evaluate(track, recording.truth).joints["wrist"]
    assert scores.rms_m < 0.045
    assert min(scores.coverage) > 0.85
    clock = track.state_mean[:, -1]
    assert clock[-1] - clock[0] == pytest.approx(0.006, abs=0.006)
    assert recording.truth is not None
    off = track.joints["wrist"].mean - recording.truth.at("wrist", track.time_s)
    jumps = np.linalg.norm(np.diff(off, axis=0), axis=1)
    assert np.nanmax(jumps) < 0.03
    for seam in done[:-1]:
        assert jumps[seam - 5 : seam + 5].max() < 2.0 * np.nanquantile(jumps, 0.95)
