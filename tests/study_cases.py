"""A small study, for the tests of studies."""

from __future__ import annotations

from pathlib import Path

import pytracker as pt
from pytracker.study import Study, StudyRecording, StudyTable

SCENE = pt.ArmScene(duration_s=2.0)
CIRCLE = StudyRecording(name="circle", scene=SCENE, pixel_sd=4.0)
METHODS = (pt.Layered(particles=100), pt.Layered(particles=200), pt.Ekf(corrections=("colour", "arm_length")))

TOML = """
schema = 1
seeds = 10

[[recording]]
name = "circle"
simulate = "arm"
scene = { duration_s = 2.0 }
pixel_sd = 4.0

[[method]]
name = "layered"
grid = { particles = [400, 2000, 8000] }

[[method]]
name = "ekf"
set = { corrections = ["colour", "arm_length"] }
"""


def small() -> Study:
    return Study(recordings=(CIRCLE,), methods=METHODS, seeds=(1, 2))


def asked(study: Study, out: Path) -> tuple[StudyTable, int]:
    """The table, and how many runs were known before."""
    known: list[int] = []
    table = pt.run_study(study, out, progress=lambda done, total: known.append(done))
    return table, known[0]
