"""A study: methods on the same seeds, on all cores, into one tidy table; stopped, it goes on where it was.

python docs/examples/study.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import pytracker as pt

STUDY = """
schema = 1
seeds = 3

[[recording]]
name = "circle, worn"
simulate = "arm"
scene = { worn = true, duration_s = 8.0 }
pixel_sd = 4.0

[[method]]
name = "mixture"

[[method]]
name = "layered"
grid = { particles = [500, 2000] }
"""


def main(out: Path) -> None:
    """Run it into `out`, and pool the wrist's error over the seeds."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "study.toml").write_text(STUDY, "utf-8")
    study = pt.read_study(out / "study.toml")
    table = pt.run_study(study, out / "study")  # study/table.csv too, for any other program
    for method in study.methods:
        errors = [row["rms_m"] for row in table.where(method=method, joint="wrist")]
        particles = method.parameters().get("particles")
        name = method.name if particles is None else f"{method.name}, {particles} particles"
        print(f"{name}: {100 * np.sqrt(np.mean(np.square(errors))):.1f} cm over {len(errors)} runs")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("example-study"))
