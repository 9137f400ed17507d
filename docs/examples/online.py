"""Live: observations as they come, some of them late, and an estimate a tenth of a second after every frame.

python docs/examples/online.py
"""

from __future__ import annotations

from collections.abc import Iterator

import pytracker as pt
from pytracker.simulate import ArmSimulation

LATE_S = 0.05
"""The camera's frames arrive so much after the sensor's samples of the same time."""


def source(simulation: ArmSimulation) -> Iterator[pt.Observation]:
    """In the order in which they arrive; a real one reads a sensor and a camera."""
    imu = simulation.imu
    assert imu.gyr is not None
    arriving = [
        (time_s, pt.Observation.inertial(time_s, acc, q, gyr))
        for time_s, acc, q, gyr in zip(imu.time_s, imu.acc, imu.q_world_segment, imu.gyr, strict=True)
    ]
    for time_s, pixels in zip(simulation.frame_time_s, simulation.sightings(), strict=True):
        arriving.append((time_s + LATE_S, pt.Observation.patch(time_s, list(pixels))))
    for _, observation in sorted(arriving, key=lambda pair: pair[0]):
        yield observation


def main() -> None:
    """Follow a simulated wrist, and say where it is once a second."""
    simulation = ArmSimulation(pt.ArmScene(duration_s=5.0), seed=1)
    tracker = pt.Tracker(simulation.recording(), pt.Mixture(), seed=1, delay_s=0.1)
    shown_s = 0.0
    for observation in source(simulation):
        estimate = tracker.observe(observation)
        if estimate is not None and estimate.time_s >= shown_s:
            wrist = estimate.places["wrist"]
            x, y, z = (100 * wrist.mean).round(1)
            print(
                f"{estimate.time_s:5.2f} s  wrist at {x}, {y}, {z} cm, ± {(196 * wrist.sd).round(1)} cm",
                estimate.doubt or "",
            )
            shown_s += 1.0
    print(len(tracker.finish()), "estimates were waiting still")


if __name__ == "__main__":
    main()
