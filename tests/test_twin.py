"""The Rust core against plain NumPy: the EKF to the last digits, the particle filter in distribution."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from numpy_twin import NumpyLayered, resample_residual

import pytracker as pt
from pytracker.rotation import rotate
from pytracker.simulate import ArmSimulation
from pytracker.tracking import resample

Float = NDArray[np.float64]


def samples_per_frame(simulation: ArmSimulation) -> list[tuple[list[tuple[float, Float, Float]], Float]]:
    """For every frame: (interval, acceleration, orientation) since the last, and the orientation there."""
    imu = simulation.imu
    frames, last = [], None
    for time_s in simulation.frame_time_s:
        steps: list[tuple[float, Float, Float]] = []
        if last is not None:
            edges = [last, *imu.time_s[(imu.time_s > last) & (imu.time_s < time_s)], time_s]
            for start, end in itertools.pairwise(edges):
                k = int(np.searchsorted(imu.time_s, start + 1e-9) - 1)
                steps.append((end - start, imu.acc[k], imu.q_world_segment[k]))
        k = int(np.searchsorted(imu.time_s, time_s + 1e-9) - 1)
        frames.append((steps, imu.q_world_segment[k]))
        last = time_s
    return frames


def without_gyroscope(simulation: ArmSimulation) -> pt.ArmRecording:
    recording = simulation.recording()
    imu = recording.imus[0]
    plain = pt.Imu(time_s=imu.time_s, acc=imu.acc, q_world_segment=imu.q_world_segment)
    return pt.ArmRecording(views=recording.views, imus=(plain,), arm=recording.arm, truth=recording.truth)


@pytest.fixture(scope="module")
def simulation() -> ArmSimulation:
    return ArmSimulation(pt.ArmScene(duration_s=2.0), seed=21)


def test_ekf_is_the_textbook(simulation: ArmSimulation) -> None:
    """Written out once more, with numerical slopes."""
    method = pt.Ekf(corrections=("colour", "arm_length"))
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings())
    track = pt.track(without_gyroscope(simulation), method, sightings=sightings)
    arm, camera = simulation.arm, simulation.cameras[0]
    mean = np.array([*arm.wrist_start_m, 0, 0, 0], dtype=float)
    covariance = np.diag([0.02**2] * 6)
    for k, (steps, q) in enumerate(samples_per_frame(simulation)):
        for dt, acc, orientation in steps:
            a = rotate(orientation, acc) - [0, 0, 9.80665]
            f = np.block([[np.eye(3), dt * np.eye(3)], [np.zeros((3, 3)), np.eye(3)]])
            g = np.concatenate([dt**3 / 6 * np.eye(3), dt**2 * np.eye(3)]) * 0.1 / dt**1.5
            mean = f @ mean + np.concatenate([dt * dt / 2 * a, dt * a])
            covariance = f @ covariance @ f.T + g @ g.T
        forearm = rotate(q, np.array([0, arm.forearm_m, 0]))

        def length(x: Float, forearm: Float = forearm) -> Float:
            return np.atleast_1d(np.asarray(np.linalg.norm(x[:3] + forearm - arm.shoulder_m)))

        def pixel(x: Float) -> Float:
            return np.asarray(camera.project(x[None, :3])[0])

        for h, z, r in ((pixel, sightings.pixels[k, 0], 16.0), (length, np.array([arm.upper_arm_m]), 1e-4)):
            slope = np.stack([(h(mean + e) - h(mean - e)) / 2e-6 for e in 1e-6 * np.eye(6)], axis=1)
            gain = covariance @ slope.T @ np.linalg.inv(slope @ covariance @ slope.T + r * np.eye(len(z)))
            mean = mean + gain @ (z - h(mean))
            covariance = covariance - gain @ slope @ covariance
        assert np.allclose(track.state_mean[k], mean, atol=1e-6), k
        assert np.allclose(track.wrist_covariance[k], covariance[:3, :3], atol=1e-7), k
        assert np.allclose(np.square(track.state_sd[k]), np.diag(covariance), atol=1e-7), k


def test_layered_agrees_with_numpy_in_distribution(simulation: ArmSimulation) -> None:
    """Over many seeds both give the same means, spreads and sample sizes, within their Monte-Carlo error.

    One run against one run says little: the two branches of the arm make single runs differ.
    """
    method, seeds, frames = pt.Layered(particles=1500), 80, 25
    recording, steps = without_gyroscope(simulation), samples_per_frame(simulation)[:frames]
    pixels = simulation.sightings()[:frames]
    sightings = pt.Sightings.of(simulation.frame_time_s[:frames], pixels)
    ours, twins = [], []
    for seed in range(seeds):
        track = pt.track(recording, method, seed, sightings=sightings)
        wrist = track.joints["wrist"]
        ours.append(np.hstack([track.state_mean, track.state_sd, wrist.lo, wrist.hi, track.ess[:, None]]))
        twin, rows = NumpyLayered(simulation.arm, simulation.cameras[0], method, seed), []
        for k, (since_last, q) in enumerate(steps):
            for step in since_last:
                twin.predict(*step)
            e = twin.update(pixels[k, 0], q)
            rows.append(np.hstack([e["mean"], np.sqrt(np.diag(e["covariance"])), e["lo"], e["hi"], e["ess"]]))
        twins.append(np.array(rows))
    a, b = np.array(ours), np.array(twins)
    standard_error = np.sqrt((a.var(axis=0) + b.var(axis=0)) / seeds)
    z = (a.mean(axis=0) - b.mean(axis=0)) / standard_error
    assert np.abs(z).max() < 5, np.unravel_index(np.abs(z).argmax(), z.shape)
    assert (z**2).mean() == pytest.approx(1.0, abs=0.6)
    ratio = a.std(axis=0) / b.std(axis=0)
    assert np.median(ratio) == pytest.approx(1.0, abs=0.05)
    assert 0.6 < ratio.min() < ratio.max() < 1.7


def test_residual_resampling_has_the_same_expectation(rng: np.random.Generator) -> None:
    weights = rng.random(200) ** 4
    weights /= weights.sum()
    ours = sum(np.bincount(resample("residual", weights, 200, seed), minlength=200) for seed in range(2000))
    twin = sum(np.bincount(resample_residual(weights, rng), minlength=200) for _ in range(2000))
    error = np.sqrt(np.maximum(weights * 200, 0.01) * 2000)
    assert np.all(np.abs(ours - weights * 200 * 2000) < 5 * error)
    assert np.all(np.abs(twin - weights * 200 * 2000) < 5 * error)
