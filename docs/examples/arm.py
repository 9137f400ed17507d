"""An arm from a recording folder to a page: three methods on one recording, and what a second sensor is worth.

python docs/examples/arm.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytracker as pt
from pytracker.evidence import sightings_of


def main(out: Path) -> None:
    """Simulate, load, track, compare, write a page into `out`."""
    # Yours is a folder of the same kind: pytracker init and check make it.
    scene = pt.ArmScene(worn=True, duration_s=8.0, senses=("upper_arm",))
    recording = pt.load(pt.simulate_arm(out / "recording", scene, seed=3))
    assert isinstance(recording, pt.ArmRecording)
    for words in recording.warnings:
        print("warning:", words)

    # The patch is looked for once, for all methods.
    sightings = sightings_of(recording)
    methods = (pt.Smooth(), pt.Mixture(), pt.Layered(particles=2000))
    tracks = [pt.track(recording, method, seed=1, sightings=sightings) for method in methods]
    for track in tracks:
        wrist = pt.evaluate(track, recording.truth).joints["wrist"]
        held = ", ".join(f"{100 * share:.0f} %" for share in wrist.coverage)
        print(f"{track.method.name:8} {100 * wrist.rms_m:5.1f} cm   bands hold the truth in {held} (x, y, z)")
    for words in tracks[0].doubts:
        print("doubt:", words)

    page = pt.write_report(tracks, out / "report")
    print("wrote", page / "index.html")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("example-arm"))
