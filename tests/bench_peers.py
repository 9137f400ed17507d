"""The Rust core against its NumPy twin, alternating in one process: medians and ratios. `make bench-peers`.

Both do the same job: four IMU samples composed, two layers with residual resampling, mean, covariance and 95 % band.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from conftest import arm_tracker
from numpy_body_twin import NumpyKinematics
from numpy_body_twin import missed_edges as numpy_missed_edges
from numpy_twin import NumpyLayered, resample_residual

import pytracker as pt
from pytracker._core import missed_edges as rust_missed_edges
from pytracker.recording import WeakPerspective
from pytracker.simulate import ArmSimulation
from pytracker.skeleton import UPPER_BODY, average_skeleton
from pytracker.tracking import resample

BATCH_S = 0.25


def alternate(ours: Callable[[], object], twin: Callable[[], object], repeats: int) -> tuple[float, float, float]:
    """Median seconds of a call of each, and the median of the ratios pair by pair.

    Calls run in batches, as frames of a recording do: a processor that has gone to sleep between calls says little.
    """
    batches = []
    for call in (ours, twin):
        call()
        begun = time.perf_counter()
        call()
        batches.append(max(1, round(BATCH_S / (time.perf_counter() - begun))))
    pairs = []
    for _ in range(repeats):
        seconds = []
        for call, count in zip((ours, twin), batches, strict=True):
            begun = time.perf_counter()
            for _ in range(count):
                call()
            seconds.append((time.perf_counter() - begun) / count)
        pairs.append(seconds)
    return (
        statistics.median(a for a, _ in pairs),
        statistics.median(b for _, b in pairs),
        statistics.median(b / a for a, b in pairs),
    )


def frame_pair(particles: int) -> tuple[Callable[[], object], Callable[[], object]]:
    simulation = ArmSimulation(seed=1)
    imu, method = simulation.imu, pt.Layered(particles=particles)
    camera = simulation.cameras[0]
    pixel = camera.project(np.array([simulation.arm.wrist_start_m]))[0]
    q, acc = imu.q_world_segment[0], imu.acc[0]
    tracker = arm_tracker(simulation.arm, camera, method, 1)
    twin = NumpyLayered(simulation.arm, camera, method, 1)
    clock = {"now": 0.0}

    def ours() -> None:
        for _ in range(4):
            tracker.observe(pt.Observation.inertial(clock["now"], acc, q))
            clock["now"] += 0.01
        tracker.observe(pt.Observation.patch(clock["now"] - 1e-4, pixel))

    def numpy() -> None:
        for _ in range(4):
            twin.predict(0.01, acc, q)
        twin.update(pixel, q)

    return ours, numpy


def resampling_pair(particles: int) -> tuple[Callable[[], object], Callable[[], object]]:
    rng = np.random.default_rng(1)
    weights = rng.random(particles) ** 3
    weights /= weights.sum()
    return lambda: resample("residual", weights, particles, 1), lambda: resample_residual(weights, rng)


def body_pairs(particles: int) -> list[tuple[str, tuple[Callable[[], object], Callable[[], object]]]]:
    """Kinematics of the 11-DOF upper body; the edge cue of its six outlines over a 320x240 image."""
    rng = np.random.default_rng(1)
    skeleton = average_skeleton(1.75)
    pose = np.zeros(len(skeleton.channels))
    states = 0.3 * rng.standard_normal((particles, 11))
    camera = WeakPerspective(affine=((139.0, 0.0, 0.0, 160.0), (0.0, -139.0, 0.0, 120.0)))
    view = pt.BodyView(camera=camera, video=Path())
    tracker = pt.Tracker(pt.BodyRecording(view=view, skeleton=skeleton, initial=pose), pt.BodyPlain())
    twin = NumpyKinematics(skeleton, pose, UPPER_BODY)
    edges = (rng.random((240, 320)) < 0.1).astype(np.uint8)
    # A torso, a head and four limbs: 1042 px a particle, as in the design's measurement.
    sizes = np.array([(50.0, 90.0), (20.0, 30.0), (16.0, 65.0), (16.0, 65.0), (12.0, 70.5), (12.0, 70.5)])
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    turns = rng.uniform(0, np.pi, (particles, 6))
    rotation = np.stack(
        [np.stack([np.cos(turns), -np.sin(turns)], -1), np.stack([np.sin(turns), np.cos(turns)], -1)], -2
    )
    places = np.array([160.0, 120.0]) + rng.uniform(-60, 60, (particles, 6, 1, 2))
    outlines = (places + (sizes[:, None, :] * corners) @ rotation.swapaxes(-1, -2)).reshape(-1, 4, 2)
    flat = np.ascontiguousarray(outlines.reshape(-1, 8))
    return [
        (f"body, kinematics, N = {particles}", (lambda: tracker.pose(states), lambda: twin(states))),
        (
            f"body, edge cue, N = {particles}",
            (lambda: rust_missed_edges(edges, flat), lambda: numpy_missed_edges(edges, outlines)),
        ),
    ]


def main() -> None:
    threads = os.environ.get("RAYON_NUM_THREADS", "all")
    print(f"{'work':<44}{'pytracker':>12}{'NumPy':>12}{'ratio':>8}   (threads: {threads})")
    rows = [
        ("arm, one camera frame, layered, N = 500", frame_pair(500), 12),
        ("arm, one camera frame, layered, N = 5000", frame_pair(5_000), 12),
        ("arm, one camera frame, layered, N = 50000", frame_pair(50_000), 12),
        ("residual resampling, N = 10000", resampling_pair(10_000), 12),
        *((name, pair, 12) for name, pair in body_pairs(300)),
        *((name, pair, 12) for name, pair in body_pairs(3000)[:1]),
    ]
    for name, (ours, twin), repeats in rows:
        a, b, ratio = alternate(ours, twin, repeats)
        print(f"{name:<44}{1e6 * a:>9.1f} µs{1e6 * b:>9.1f} µs{ratio:>8.1f}")


if __name__ == "__main__":
    main()
