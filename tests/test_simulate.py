"""The simulator says of itself what physics says of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import load_arm

import pytracker as pt
from pytracker.evidence import sightings_of
from pytracker.formats import video
from pytracker.rotation import conjugate, multiply, rotate
from pytracker.simulate import ArmSimulation
from pytracker.simulate.patterns import PATTERNS

CLEAN = pt.ArmScene(acc_noise=0.0, acc_bias=0.0, gyr_noise=0.0, gyr_bias=0.0, orientation_error_deg=0.0)


def angle_deg(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(np.degrees(2 * np.arcsin(np.linalg.norm(multiply(conjugate(a), b)[:, 1:], axis=1))))


def test_arm_has_its_lengths_and_the_sensor_points_to_the_elbow() -> None:
    simulation = ArmSimulation(pt.ArmScene(shoulder_motion_m=0.02), seed=2)
    time_s = np.linspace(0, 20, 300)
    shoulder, elbow, wrist = simulation.shoulder(time_s), simulation.elbow(time_s), simulation.wrist(time_s)
    assert np.allclose(np.linalg.norm(elbow - shoulder, axis=1), 0.30)
    assert np.allclose(np.linalg.norm(elbow - wrist, axis=1), 0.25)
    tip = wrist + rotate(simulation.q_world_sensor(time_s), np.array([0.0, 0.25, 0.0]))
    assert np.allclose(tip, elbow)
    assert 0.01 < np.sqrt(((shoulder - simulation.scene.shoulder_m) ** 2).sum(axis=1).mean()) < 0.03


def test_imu_integrates_to_the_motion() -> None:
    simulation = ArmSimulation(CLEAN, seed=1)
    imu = simulation.imu
    world = rotate(imu.q_world_segment, imu.acc) - [0, 0, 9.80665]
    velocity = np.cumsum((world[1:] + world[:-1]) / 2 * np.diff(imu.time_s)[:, None], axis=0)
    travelled = np.cumsum(velocity * np.diff(imu.time_s)[:, None], axis=0)
    true = simulation.wrist(imu.time_s)
    assert np.abs(travelled[:500] - (true[1:501] - true[0])).max() < 0.01
    assert imu.gyr is not None
    step = np.diff(imu.time_s)[:, None] * (imu.gyr[:-1] + imu.gyr[1:]) / 2
    turned = multiply(conjugate(imu.q_world_segment[:-1]), imu.q_world_segment[1:])
    assert np.allclose(2 * turned[:, 1:] * np.sign(turned[:, :1]), step, atol=2e-5)


def test_noise_is_as_large_as_asked() -> None:
    clean, noisy = ArmSimulation(CLEAN, seed=5), ArmSimulation(pt.ArmScene(), seed=5)
    off = noisy.imu.acc - clean.imu.acc
    assert np.linalg.norm(off.mean(axis=0)) == pytest.approx(0.1, abs=0.005)
    assert off.std(axis=0) == pytest.approx([0.03] * 3, rel=0.1)
    errors = []
    for seed in range(20):
        imu = ArmSimulation(pt.ArmScene(), seed).imu
        errors.append(angle_deg(imu.q_world_segment, clean.q_world_sensor(imu.time_s)))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(1.0, abs=0.1)
    pixels = noisy.sightings(4.0)[:, 0] - noisy.cameras[0].project(noisy.patch(noisy.frame_time_s))
    assert pixels.std(axis=0) == pytest.approx([4.0, 4.0], rel=0.15)


def test_seeds_repeat_and_differ() -> None:
    same = [ArmSimulation(pt.ArmScene(duration_s=1.0), seed) for seed in (3, 3, 4)]
    assert np.array_equal(same[0].imu.acc, same[1].imu.acc)
    assert np.array_equal(same[0].sightings(), same[1].sightings())
    assert not np.array_equal(same[0].imu.acc, same[2].imu.acc)


@pytest.mark.parametrize("pattern", list(PATTERNS))
def test_patterns_start_at_rest_and_stay_smooth(pattern: str) -> None:
    time_s = np.arange(0, 12, 1e-3)
    path = PATTERNS[pattern](time_s, 4.0)
    speed = np.linalg.norm(np.diff(path, axis=0), axis=1) / 1e-3
    assert speed[0] < 0.01
    assert speed.max() < 6.0
    assert np.abs(np.diff(speed)).max() < 0.1


def test_dropped_samples_and_frames_are_missing(tmp_path: Path) -> None:
    scene = pt.ArmScene(duration_s=4.0, dropped_imu=0.2, dropped_frames=0.2)
    simulation = ArmSimulation(scene, seed=6)
    assert 300 < len(simulation.imu.time_s) < 345
    assert 70 < len(simulation.frame_time_s) < 90
    folder = pt.simulate_arm(tmp_path / "dropped", scene, seed=6)
    recording = load_arm(folder)
    assert " between samples" in recording.warnings[0]
    # A camera that drops a frame shows the one before again; that is no sighting.
    assert len(list(video.frames(folder / "video.mp4"))) == 100
    sightings = sightings_of(recording)
    repeated = [k for k, words in enumerate(sightings.reasons) if words == "the frame repeats the one before"]
    dropped = set(range(100)) - {round(25 * t) for t in simulation.frame_time_s}
    assert set(repeated) == dropped
    scores = pt.evaluate(
        pt.track(recording, pt.Joint(particles=2000, bias=True), 1, sightings=sightings), recording.truth
    )
    assert scores.joints["wrist"].rms_m < 0.08


def test_a_second_camera_stands_a_quarter_turn_on() -> None:
    first, second = ArmSimulation(pt.ArmScene(cameras=2)).cameras
    a, b = (np.array(camera.rotation)[2] * [1, 1, 0] for camera in (first, second))
    assert a @ b == pytest.approx(0.0, abs=1e-12)
    for camera in (first, second):
        assert camera.project(np.array([[0.05, 0.30, 0.0]]))[0] == pytest.approx([320, 240])
