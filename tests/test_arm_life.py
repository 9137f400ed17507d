"""The arm on a living person.

What no arm can have is not believed, a pause is a new start, and the mixture's bands hold.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from test_cli import run

import pytracker as pt
from pytracker.doubting.doubts import unbelieved
from pytracker.evidence.sightings import Sightings
from pytracker.methods.arm import ArmMethod
from pytracker.rotation import multiply, rotation_vector_to_quaternion
from pytracker.simulate import ArmSimulation

HELD = "the wrist is beyond the arm's reach and its own band"
PATTERNS = ("circle", "reach", "gesture")


def played(scene: pt.ArmScene, seed: int, pixel_sd: float = 4.0) -> tuple[pt.ArmRecording, Sightings]:
    simulation = ArmSimulation(scene, seed)
    return simulation.recording(), Sightings.of(simulation.frame_time_s, simulation.sightings(pixel_sd))


def tilted(recording: pt.ArmRecording, degrees: float) -> pt.ArmRecording:
    imu = recording.imus[0]
    turn = np.broadcast_to(rotation_vector_to_quaternion(np.radians([degrees, 0.0, 0.0])), (len(imu.acc), 4))
    q = np.ascontiguousarray(multiply(turn, imu.q_world_segment))
    return dataclasses.replace(recording, imus=(dataclasses.replace(imu, q_world_segment=q),))


@pytest.mark.parametrize("method", [pt.Layered(), pt.Joint(particles=1000), pt.Mixture()], ids=lambda m: m.name)
@pytest.mark.parametrize("degrees", [5.0, 10.0, 20.0])
def test_a_track_that_runs_off_says_so(method: ArmMethod, degrees: float) -> None:
    """Layered went 88 m off with a standard deviation of 0, every frame valid."""
    recording, sightings = played(pt.ArmScene(), 3)
    try:
        track: pt.Track = pt.track(tilted(recording, degrees), method, 1, sightings=sightings)
    except pt.TrackingError as error:
        if error.track is None:
            raise
        track = error.track
    assert not track.lost or "the track ran away" in track.lost
    assert np.isfinite(track.joints["wrist"].mean[:20]).all()
    assert recording.truth is not None
    off = np.linalg.norm(track.joints["wrist"].mean - recording.truth.at("wrist", track.time_s), axis=1)
    assert not (track.valid & (off > 0.6)).any()
    wrong = np.nansum(off > 0.3)
    assert wrong == 0 or unbelieved(track) or pt.doubts(track)


def test_baselines_that_no_arm_holds_go_on_and_their_frames_are_not_valid() -> None:
    recording, sightings = played(pt.ArmScene(), 3)
    track = pt.track(tilted(recording, 3.0), pt.Plain(particles=500), 1, sightings=sightings)
    assert not track.lost
    assert HELD in track.reason[-1]
    assert not track.valid[-1]
    (words,) = unbelieved(track)
    assert "frames (" in words
    assert HELD in words


def test_most_frames_not_valid_is_a_failed_run_that_keeps_its_output(simulated: Path, tmp_path: Path) -> None:
    text = (simulated / "imu.csv").read_text().splitlines()
    folder = tmp_path / "turned"
    folder.mkdir()
    for path in simulated.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    rows = np.loadtxt(simulated / "imu.csv", delimiter=",", skiprows=1)
    rows[:, 1] += 2.0  # m/s² along the sensor's x
    np.savetxt(folder / "imu.csv", rows, "%.6f", ",", header=text[0], comments="")
    done = run("track", folder, "--out", tmp_path / "out", "--no-report", "--method", "inertial")
    assert done.returncode in (0, 1)
    assert (tmp_path / "out" / "track.csv").is_file()
    if done.returncode == 1:
        assert "are not valid, do not use them" in done.stderr


@pytest.mark.parametrize("pause_s", [2.0, 300.0])
@pytest.mark.parametrize("method", [pt.Layered(), pt.Joint(particles=2000), pt.Mixture()], ids=lambda m: m.name)
def test_after_a_pause_of_both_it_starts_again(method: ArmMethod, pause_s: float) -> None:
    """The wrist is elsewhere then: Layered was 0.5 to 74 m off after 2 s, 978 m after 300 s."""
    scene = pt.ArmScene(pattern="reach", duration_s=16.0)
    recording, sightings = played(scene, 5, 2.0)
    imu, before, after = recording.imus[0], 6.0, 8.3
    kept = (imu.time_s < before) | (imu.time_s >= after)
    frames = (sightings.time_s < before) | (sightings.time_s >= after)
    later = pause_s - (after - before)
    moved = dataclasses.replace(
        imu, time_s=(imu.time_s + later * (imu.time_s >= after))[kept], acc=imu.acc[kept],
        q_world_segment=imu.q_world_segment[kept], gyr=None if imu.gyr is None else imu.gyr[kept],
    )  # fmt: skip
    time_s = sightings.time_s + later * (sightings.time_s >= after)
    assert recording.truth is not None
    true = recording.truth.at("wrist", sightings.time_s[frames])
    seen = Sightings.of(time_s[frames], sightings.pixels[frames])
    track = pt.track(dataclasses.replace(recording, imus=(moved,)), method, 1, sightings=seen)
    wrist, new = track.joints["wrist"], seen.time_s > before
    off = np.linalg.norm(wrist.mean - true, axis=1)
    assert off[new].max() < 0.5
    # At once it is known across the picture only, and says so.
    first = int(np.argmax(new))
    assert np.linalg.norm(wrist.sd[first]) > 0.03
    if isinstance(method, pt.Mixture):  # the particle filters may settle in the wrong one of two branches
        assert (np.abs(wrist.mean - true) < 2 * wrist.sd + 0.02)[new].mean() > 0.9


@pytest.mark.parametrize("seen_at_once", [False, True])
def test_a_long_gap_in_the_frames_alone_is_survived(seen_at_once: bool) -> None:
    """The IMU goes on for 25 s; the first frames after it may not show the patch."""
    recording, sightings = played(pt.ArmScene(duration_s=32.0), 5)
    frames = (sightings.time_s < 3) | (sightings.time_s > 28)
    pixels = sightings.pixels.copy()
    if not seen_at_once:
        pixels[(sightings.time_s > 28) & (sightings.time_s < 28.2)] = np.nan
    seen = Sightings.of(sightings.time_s[frames], pixels[frames])
    track = pt.track(recording, pt.Mixture(), 1, sightings=seen)
    assert recording.truth is not None
    off = np.linalg.norm(track.joints["wrist"].mean - recording.truth.at("wrist", seen.time_s), axis=1)
    assert not track.lost
    assert np.isfinite(off).all()
    later = seen.time_s > 29
    assert off[later].max() < 0.4


def test_a_pause_online_and_offline_are_the_same_bits() -> None:
    recording, sightings = played(pt.ArmScene(duration_s=8.0), 5)
    imu = recording.imus[0]
    keep, frames = (imu.time_s < 3) | (imu.time_s > 5), (sightings.time_s < 3) | (sightings.time_s > 5)
    assert imu.gyr is not None
    cut = dataclasses.replace(
        imu, time_s=imu.time_s[keep], acc=imu.acc[keep], q_world_segment=imu.q_world_segment[keep], gyr=imu.gyr[keep]
    )
    seen = Sightings.of(sightings.time_s[frames], sightings.pixels[frames])
    for method in (pt.Layered(particles=100), pt.Mixture()):
        paused = dataclasses.replace(recording, imus=(cut,))
        track = pt.track(paused, method, 9, sightings=seen)
        tracker, online = pt.Tracker(paused, track.method, 9), []
        for k, observed in enumerate(paused.observations(seen)):
            tracker = pt.Tracker.restore(tracker.save()) if k % 200 == 0 else tracker
            if (estimate := tracker.observe(observed)) is not None:
                online.append(estimate.places["wrist"].mean)
        assert np.array_equal(online, track.joints["wrist"].mean)


def pooled(method: ArmMethod, scene: pt.ArmScene, seeds: range) -> tuple[float, np.ndarray]:
    """3-D RMS of the wrist over seeds, m, and coverage per axis."""

    def of_seed(seed: int) -> tuple[float, tuple[float, float, float]]:
        recording, sightings = played(scene, seed)
        try:
            track: pt.Track = pt.track(recording, method, 0, sightings=sightings)
        except pt.TrackingError as error:
            if error.track is None:
                raise
            track = error.track
        scores = pt.evaluate(track, recording.truth).joints["wrist"]
        return scores.rms_m**2, scores.coverage

    with ThreadPoolExecutor(2) as pool:
        square, inside = zip(*pool.map(of_seed, seeds), strict=True)
    return float(np.sqrt(np.mean(square))), np.mean(inside, axis=0)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_worn_the_mixture_is_better_than_what_was_the_default_and_its_bands_hold(pattern: str) -> None:
    """Tuned on seeds 21 to 26.

    Half the recordings of the issue's table have bands of the old default that hold a third.
    """
    scene = pt.ArmScene(pattern=pattern, worn=True, period_s=2.0 if pattern == "gesture" else 4.0)
    error, coverage = pooled(pt.Mixture(), scene, range(1, 6))
    before, _ = pooled(pt.Joint(), scene, range(1, 6))
    assert error < 0.11
    assert error < before
    assert coverage.min() > 0.88


def test_on_the_circle_it_is_better_than_the_filters_beside_it() -> None:
    """The price of slow arms: 3.4 cm where the length spoke in every frame anew for arms held straight, or folded."""
    error, coverage = pooled(pt.Mixture(), pt.ArmScene(), range(1, 6))
    assert error < 0.052
    assert coverage.min() > 0.93
    ekf, _ = pooled(
        pt.Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15), pt.ArmScene(), range(1, 6)
    )
    assert error < 0.8 * ekf


@pytest.mark.parametrize(
    ("method", "limit_m", "least"), [(pt.Smooth(), 0.15, 0.9), (pt.Mixture(), 0.22, 0.7)], ids=["smooth", "mixture"]
)
def test_slow_arms_are_put_at_the_right_depth_or_at_both(method: ArmMethod, limit_m: float, least: float) -> None:
    """Where the sensor feels next to nothing: 21 and 23 cm, bands that held half of it, sure that arms were folded."""
    scene = pt.ArmScene(pattern="gesture", worn=True, period_s=10.0)
    error, coverage = pooled(method, scene, range(201, 206))
    assert error < limit_m
    assert coverage.min() > least


def test_the_clock_is_found_while_tracking() -> None:
    """50 ms of difference between the clocks, on lively gestures: 11 cm without the clock in the state, 6 with it."""
    scene = pt.ArmScene(pattern="gesture", worn=True, period_s=2.0)
    with_clock, _ = pooled(pt.Mixture(), scene, range(1, 5))
    without, _ = pooled(pt.Mixture(clock_sd_s=1e-6), scene, range(1, 5))
    assert with_clock < without


def test_another_renderers_recording(shared: Callable[[str], Path]) -> None:
    recording = pt.load(shared("recordings/arm-circle"))
    assert isinstance(recording, pt.ArmRecording)
    track = pt.track(recording, pt.Mixture())
    scores = pt.evaluate(track, recording.truth).joints["wrist"]
    assert scores.rms_m < 0.045
    assert min(scores.coverage) > 0.9
    assert pt.doubts(track) == ()
    assert unbelieved(track) == ()


def test_one_component_is_a_filter_of_one_gaussian() -> None:
    recording, sightings = played(pt.ArmScene(duration_s=5.0), 2)
    one = pt.track(recording, pt.Mixture(components=1), sightings=sightings).joints["wrist"]
    # Gaussian bands are symmetrical about the mean.
    assert np.allclose(one.hi - one.mean, one.mean - one.lo, atol=2e-5)
    many = pt.track(recording, pt.Mixture(), sightings=sightings).joints["wrist"]
    assert np.abs((many.hi - many.mean) - (many.mean - many.lo)).max() > 1e-3
