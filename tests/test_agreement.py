"""Whether a truth belongs to a track: turned, mirrored, later, of another rate, exchanged; and another recording's."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_cli import run

import pytracker as pt
from pytracker.recording.recording import Truth
from pytracker.rotation import Array
from pytracker.scores.agreement import disagreement
from pytracker.simulate.arm import ArmSimulation


@pytest.fixture(scope="module")
def tracked() -> tuple[pt.Track, Truth]:
    """An arm that goes about a rectangle, whose sides are not alike."""
    simulation = ArmSimulation(pt.ArmScene(pattern="rectangle", duration_s=12.0), 3)
    recording = simulation.recording()
    assert recording.truth is not None
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(1.0))
    return pt.track(recording, pt.Smooth(), 1, sightings=sightings), recording.truth


def by(truth: Truth, turn: Array) -> Truth:
    return replace(truth, joints_m={joint: points @ turn.T for joint, points in truth.joints_m.items()})


QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t, ""),
        (lambda t: by(t, QUARTER), "turned by"),
        (lambda t: by(t, Y_UP), "turned by"),
        (lambda t: by(t, np.diag([-1.0, 1.0, 1.0])), "mirrored"),
        (lambda t: replace(t, time_s=t.time_s + 0.5), "it came -0.50 s later"),
        (lambda t: replace(t, time_s=2.0 * t.time_s), "0.5 times as far apart"),
        (lambda t: replace(t, time_s=t.time_s / 1.2), "1.2 times as far apart"),
    ],
)
def test_a_truth_that_is_described_otherwise_is_told(
    tracked: tuple[pt.Track, Truth], change: object, words: str
) -> None:
    track, truth = tracked
    said = disagreement(track, change(truth))  # type: ignore[operator]
    assert len(said) == bool(words)
    assert words in " ".join(said)
    assert disagreement(track, None) == ()


def test_exchanged_sides_are_told(body: pt.BodyRecording) -> None:
    track, truth = pt.track(body, pt.Partitioned(), 1), body.truth
    assert truth is not None
    assert disagreement(track, truth) == ()
    at = truth.joints_m
    sides = {
        f"{a}_{joint}": at[f"{b}_{joint}"]
        for joint in ("elbow", "wrist")
        for a, b in (("left", "right"), ("right", "left"))
    }
    assert "left and right were exchanged" in " ".join(disagreement(track, replace(truth, joints_m={**at, **sides})))


def test_a_track_of_another_recording_is_not_scored(simulated: Path, tmp_path: Path) -> None:
    other = pt.simulate_arm(tmp_path / "other", pt.ArmScene(duration_s=3.0), seed=12)
    out = tmp_path / "out"
    run("track", other, "--out", out, "--no-report", "--method", "mixture")
    refused = run("evaluate", simulated, out)
    assert "is of a run on another video" in refused.stderr
    # What was added to the recording since does no harm, nor a table without its metadata.
    (other / "recording.toml").write_text((other / "recording.toml").read_text("utf-8") + "\n# seen again\n", "utf-8")
    assert "rms_m" in run("evaluate", other, out).stdout
    shutil.copy(out / "track.csv", tmp_path / "track.csv")
    assert "rms_m" in run("evaluate", simulated, tmp_path / "track.csv").stdout
