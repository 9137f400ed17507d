"""A body from a video with a detector's keypoints: joints with bands, which of them are valid, and an Acclaim motion.

python docs/examples/body.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import pytracker as pt
from pytracker.formats import write_amc
from pytracker.tracking import default_method


def main(out: Path) -> None:
    """Simulate, load, track by the default method, write an AMC into `out`."""
    folder = pt.simulate_body(out / "recording", pt.BodyScene(duration_s=3.0, keypoint_sd_px=3.0), seed=2)
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    method = default_method(recording)
    track = pt.track(recording, method, seed=1)
    scores = pt.evaluate(track, recording.truth)
    print(f"{method.name}: eight joints are off by {100 * scores.average_m:.1f} cm on average")
    for name, joint in track.joints.items():
        half = 100 * np.nanmedian(joint.hi - joint.lo, axis=0) / 2
        valid = 100 * np.mean(joint.valid)
        print(f"  {name:15} ±{half[0]:4.1f}, {half[1]:4.1f}, {half[2]:4.1f} cm, valid in {valid:.0f} % of the frames")
    write_amc(out / "motion.amc", recording.skeleton, track.poses)
    print("wrote", out / "motion.amc")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("example-body"))
