"""What happens when one thing of a recording is wrong: told before, told after, harmless, or silent. `make faults`.

Sixty-one kinds of fault in IMU, video, camera, patch, arm and truth, at three strengths each, one at a time, on three
arms: a simulated circle, simulated gestures as bad as life, and a recording by another renderer where the shared data
are. Then right recordings, of which nothing may be said. Writes the table as Markdown.
"""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from fault_kinds import faults

import pytracker as pt
from pytracker.doubting.doubts import unbelieved
from pytracker.evidence import sightings_of
from pytracker.simulate import ArmSimulation

SHARED = Path(__file__).parents[2] / "shared" / "recordings" / "arm-circle"
TRUTH = re.compile(r"^\[truth\]\n(?:[^\[\n].*\n?|\n)*", re.MULTILINE)
"""Its table in recording.toml."""
HARMLESS = 1.2
"""An error of so many times the right one's is no harm."""
SILENT_M, SILENT_COVERAGE = 0.10, 0.70
"""A fault that is not told must not be worse than this."""


def judged(folder: Path, sightings: pt.Sightings | None, truth: pt.Truth | None) -> tuple[str, float, float, str]:
    """What is said of a folder, its error by the truth, its least coverage, and the words."""
    try:
        recording = pt.load(folder)
        assert isinstance(recording, pt.ArmRecording)
        if recording.warnings:
            return "told before", np.nan, np.nan, recording.warnings[0]
        seen = sightings if sightings is not None else sightings_of(recording)
        track = pt.track(recording, pt.Smooth(), 1, sightings=seen)
    except pt.InputError as error:
        return "told before", np.nan, np.nan, str(error)
    except pt.TrackingError as error:
        return "told after", np.nan, np.nan, str(error)
    said = (*unbelieved(track), *pt.doubts(track))
    wrist = pt.evaluate(track, truth or recording.truth).joints["wrist"]
    return ("told after" if said else ""), wrist.rms_m, min(wrist.coverage), said[0] if said else ""


def recordings(scratch: Path) -> dict[str, Path]:
    """The arms that faults are tried on."""
    found = {
        "circle": pt.simulate_arm(scratch / "circle", pt.ArmScene(patch_offset_m=(0.0, 0.0, 0.0)), 41),
        "gestures, worn": pt.simulate_arm(
            scratch / "gesture", pt.ArmScene(pattern="gesture", period_s=2.5, worn=True), 42
        ),
    }
    if SHARED.exists():
        folder = shutil.copytree(SHARED, scratch / "shared")
        text = (folder / "recording.toml").read_text("utf-8")
        # The same keys as a simulated folder has.
        (folder / "recording.toml").write_text(
            text.replace("patch_box", "patch_offset_m = [0.0, 0.0, 0.0]\npatch_box", 1)
        )
        for path in folder.iterdir():
            path.chmod(0o644)
        found["another renderer"] = folder
    return found


def without_truth(folder: Path, truth: pt.Truth | None) -> pt.Truth | None:
    """The truth; the recording names none any more: what it would tell no clinic is told."""
    path = folder / "recording.toml"
    path.write_text(
        re.sub(r"^\[truth\]\n(?:[^\[\n].*\n?|\n)*", "", path.read_text("utf-8"), flags=re.MULTILINE), "utf-8"
    )
    return truth


Row = tuple[tuple[str, str, str], str, float, float, str]


def of_recording(name: str, folder: Path) -> tuple[float, list[Row]]:
    """Every fault on one recording; first the error of the right one."""
    right = pt.load(folder)
    assert isinstance(right, pt.ArmRecording)
    sightings = sightings_of(right)
    verdict, error, _, words = judged(folder, sightings, None)
    if verdict:
        raise SystemExit(f"{name}: something is said of the right recording: {words}")
    rows = []
    for fault in faults():
        spoilt = folder.with_name(f"{folder.name}-spoilt")
        shutil.copytree(folder, spoilt)
        fault.change(spoilt)
        truth = None if fault.where == "truth" else without_truth(spoilt, right.truth)
        verdict, rms, coverage, words = judged(spoilt, sightings if fault.same_video else None, truth)
        if not verdict:
            verdict = "harmless" if rms <= HARMLESS * error else "silent"
        rows.append(((fault.where, fault.kind, fault.strength), verdict, rms, coverage, words))
        shutil.rmtree(spoilt)
    return error, rows


def said_of_right(seed: int) -> str:
    """What is said of a right simulated recording; empty: nothing."""
    patterns = ("circle", "rectangle", "reach", "gesture")
    worn = seed % 2 == 0
    scene = pt.ArmScene(pattern=patterns[seed % 4], worn=worn, period_s=(2.0, 3.0, 4.0)[seed % 3])
    simulation = ArmSimulation(scene, seed)
    recording = simulation.recording()
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0 + seed % 3))
    try:
        track = pt.track(recording, pt.Smooth(), seed, sightings=sightings)
    except (pt.InputError, pt.TrackingError) as error:
        return f"seed {seed}: {error}"
    said = (*unbelieved(track), *pt.doubts(track))
    return f"seed {seed} ({scene.pattern}{', worn' if worn else ''}): {said[0]}" if said else ""


def main(out: Path) -> int:
    """Write the table; the number of silent faults that are worse than they may be, and of false alarms."""
    lines = [
        "# One thing wrong at a time",
        "",
        "Made by `make faults`, with the default method. *told before*: an error or a warning of the recording; "
        "*told after*: frames that are not valid, a track that is lost, or a doubt; *harmless*: nothing is said, and "
        "the wrist is off by at most 1.2 times the right recording's error; *silent*: nothing is said. Behind the "
        "verdict: 3-D RMS of the wrist in cm, least share of frames whose band holds the truth on an axis. But for "
        "faults of the truth no recording has one: what only a truth tells counts as not told.",
        "",
    ]
    bad = unheld = 0
    with tempfile.TemporaryDirectory() as scratch, ProcessPoolExecutor() as pool:
        arms = recordings(Path(scratch))
        found = dict(zip(arms, pool.map(of_recording, arms, arms.values()), strict=True))
        lines += [
            "| where | what | strength | " + " | ".join(f"{n} ({100 * e:.1f} cm)" for n, (e, _) in found.items()) + " |"
        ]
        lines += ["|---|---|---|" + "---|" * len(found)]
        counts: dict[str, int] = {}
        for rows in zip(*(rows for _, rows in found.values()), strict=True):
            cells = []
            for _, verdict, rms, coverage, _ in rows:
                counts[verdict] = counts.get(verdict, 0) + 1
                is_bad = verdict == "silent" and (rms > SILENT_M or coverage < SILENT_COVERAGE)
                bad += is_bad
                unheld += verdict == "harmless" and coverage < SILENT_COVERAGE
                numbers = "" if np.isnan(rms) else f" ({100 * rms:.1f}, {100 * coverage:.0f} %)"
                cells.append(("**" if is_bad else "") + verdict + numbers + ("**" if is_bad else ""))
            lines.append(f"| {' | '.join(rows[0][0])} | {' | '.join(cells)} |")
        alarms = [words for words in pool.map(said_of_right, range(201, 261)) if words]
    lines += ["", "Together: " + ", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items())) + "."]
    lines += [f"Silent and worse than 10 cm, or with bands that hold the truth in under 70 %: {bad} (in bold)."]
    lines += [f"Harmless, but with bands that hold the truth in under 70 %: {unheld}."]
    lines += [f"Of 60 right recordings, half of them worn, something was said of {len(alarms)}."]
    lines += [f"- {words}" for words in alarms]
    out.write_text("\n".join(lines) + "\n", "utf-8")
    print("\n".join(lines[-4 - len(alarms) :]))
    return bad + len(alarms)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
