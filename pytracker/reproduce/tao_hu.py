"""Tao & Hu (2008): what is run. Circle, rectangle and reaching on a table, filmed by one camera.

The patch's centre comes with the paper's noise of 4 px and, for the circle, as Camshift finds it in a rendered video.
"""

from __future__ import annotations

from pytracker.methods.arm import ArmMethod, Ekf, Inertial, Joint, Layered, Plain
from pytracker.simulate import ArmScene
from pytracker.study import Study, StudyRecording

__all__ = ["DURATION_S", "METHODS", "PATTERNS", "PIXEL_SD", "SHORTEST_S", "VIDEO", "make_study", "scene"]

DURATION_S = 20.0

SHORTEST_S = 3.2
"""The paper speaks of 80 frames."""

PIXEL_SD = 4.0
"""Of eq. (11)."""

METHODS: dict[str, ArmMethod] = {
    "Inertial only": Inertial(),
    "EKF": Ekf(bias=True, accel_density=0.03),
    "PF": Plain(particles=500),
    "PF with constraint": Layered(particles=500),
    "EKF, projected to the arm": Ekf(corrections=("colour", "arm_projection"), accel_density=0.02),
    "EKF with constraint": Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15),
    "PF, joint": Joint(patch_offset=False),
}
"""The paper's four, then ours; each tuned on simulated circles of seeds from 101 on."""

PATTERNS = {"circle": "circle", "rectangle": "rectangle", "reaching": "reach"}
"""What the hand does, and the simulator's word for it."""

VIDEO = "circle, from video"


def scene(pattern: str, duration_s: float) -> ArmScene:
    """A pattern on the table, with the simulator's defaults."""
    return ArmScene(pattern=PATTERNS[pattern], duration_s=duration_s)


def make_study(seeds: tuple[int, ...], duration_s: float) -> Study:
    """Everything that the page averages: every run's seed draws its recording too."""
    recordings = [StudyRecording(name=name, scene=scene(name, duration_s), pixel_sd=PIXEL_SD) for name in PATTERNS]
    recordings.append(StudyRecording(name=VIDEO, scene=scene("circle", duration_s)))
    return Study(recordings=tuple(recordings), methods=tuple(METHODS.values()), seeds=seeds)
