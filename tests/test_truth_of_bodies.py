"""Truth of a body in points: read, refused, and what is scored against it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from test_cli import run
from test_truth_points import BOTH, HEAD, MAP, RIGHT

import pytracker as pt
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.report.files.tables import TrackFile
from pytracker.rotation import Matrix
from pytracker.scores.evaluate import held
from pytracker.tracking.tracks import JointTrack


def of_points(simulated_body: Path, to: Path, truth: str, *, z_up: bool = False) -> Path:
    """The body's folder with its truth as a TRC of hips and the other joints, and its first pose as a file."""
    recording = pt.load(simulated_body)
    assert isinstance(recording, pt.BodyRecording)
    assert recording.truth is not None
    shutil.copytree(simulated_body, to)
    joints = dict(recording.truth.joints_m)
    aside = np.array([0.1, 0.0, 0.0])
    markers = {"HipL": joints["root"] + aside, "HipR": joints["root"] - aside}
    markers |= {f"m {name}": rows for name, rows in joints.items() if name != "root"}
    if z_up:
        markers = {name: rows[:, [0, 2, 1]] * [1, -1, 1] for name, rows in markers.items()}
    names = "Frame#\tTime\t" + "".join(f"{name}\t\t\t" for name in markers)
    table = np.column_stack([recording.truth.time_s, *markers.values()])
    rows = ["\t".join([str(k), *(f"{x:.6f}" for x in row)]) for k, row in enumerate(table)]
    rate_hz = (len(table) - 1) / (table[-1, 0] - table[0, 0])
    head = HEAD.replace("mm", "m").replace("100\t100", f"{rate_hz:g}\t{rate_hz:g}")
    (to / "truth.trc").write_text(head + "\n".join([names, "", "", *rows]) + "\n", "utf-8")
    pose = zip(recording.skeleton.channels, recording.initial, strict=True)
    lines = [f"{name} = {value if name[-2] == 't' else np.degrees(value):.6f}" for name, value in pose]
    (to / "initial.toml").write_text("\n".join(lines), "utf-8")
    text = (to / "recording.toml").read_text("utf-8").split("[truth]")[0]
    (to / "recording.toml").write_text(f'{text}[initial]\nangles = "initial.toml"\n\n[truth]\n{truth}\n', "utf-8")
    return to


@pytest.mark.parametrize("z_up", [False, True])
def test_a_body_is_scored_against_points(simulated_body: Path, tmp_path: Path, z_up: bool) -> None:
    truth = MAP.format(more=', right_wrist = "m right_wrist"', after='\nup = "z"' if z_up else "")
    folder = of_points(simulated_body, tmp_path / "points", truth, z_up=z_up)
    result = run("track", folder, "--out", tmp_path / "out")
    assert result.returncode == 0, result.stderr
    assert "first pose held" in result.stdout
    assert "median error of each joint" in result.stdout
    recording, angles = pt.load(folder), pt.load(simulated_body)
    assert recording.truth is not None
    assert angles.truth is not None
    for joint, rows in recording.truth.joints_m.items():
        assert np.allclose(rows, angles.truth.joints_m[joint], atol=2e-6)
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    assert "first pose held" in page
    assert "left elbow</th>" not in page  # no truth of it
    assert "Joint by joint" in page
    assert "<td>left wrist</td>" in page
    assert "first pose held" in (tmp_path / "out" / "scores.json").read_text("utf-8")


@pytest.mark.parametrize(
    ("truth", "expected"),
    [
        ('file = "truth.trc"', "truth.markers is missing, and .* has HipL, HipR"),
        ('file = "truth.trc"\nmarkers = { toe = "HipL" }', "truth.markers.toe is no joint of the body"),
        ('file = "truth.trc"\nmarkers = { root = "Hip" }', "truth.markers.root is 'Hip', expected a marker of"),
        (
            'file = "truth.xlsx"',
            "truth.file is 'truth.xlsx', expected an .amc motion, or points: .tsv, .csv, .trc, .c3d",
        ),
        ('file = "truth.trc"\nmarkers = { root = [] }', "truth.markers.root is empty, expected a marker"),
        ('file = "motion.amc"', "truth.rate_hz is missing"),
        ('file = "motion.amc"\nrate_hz = 120.0\nup = "z"', "truth.up goes with a file of markers"),
    ],
)
def test_a_truth_that_is_not_understood_is_refused(
    simulated_body: Path, tmp_path: Path, truth: str, expected: str
) -> None:
    folder = of_points(simulated_body, tmp_path / "points", truth)
    with pytest.raises(pt.InputError, match=expected):
        pt.load(folder)


@pytest.mark.parametrize("rate_hz", [30.0, 200.0])
def test_the_rate_of_points_may_be_said(simulated_body: Path, tmp_path: Path, rate_hz: float) -> None:
    """As a BVH of 100 Hz whose Frame Time is a thirtieth of a second: nothing else could put it right."""
    as_is = pt.load(of_points(simulated_body, tmp_path / "points", MAP.format(more="", after=""))).truth
    said = pt.load(
        of_points(simulated_body, tmp_path / "said", MAP.format(more="", after=f"\nrate_hz = {rate_hz}"))
    ).truth
    assert as_is is not None
    assert said is not None
    np.testing.assert_allclose(said.time_s, np.arange(len(as_is.time_s)) / rate_hz, atol=1e-3)


def test_a_truth_in_other_units_is_refused(simulated_body: Path, tmp_path: Path) -> None:
    folder = of_points(simulated_body, tmp_path / "points", MAP.format(more=BOTH, after=""))
    lines = (folder / "truth.trc").read_text("utf-8").splitlines()
    rows = [line.split("\t") for line in lines[5:]]
    lines[5:] = ["\t".join([*row[:2], *(str(1000 * float(x)) for x in row[2:])]) for row in rows]
    (folder / "truth.trc").write_text("\n".join(lines) + "\n", "utf-8")
    with pytest.raises(pt.InputError, match=r"left_shoulder and left_elbow are \d+ m apart .* expected 0\.\d\d to"):
        pt.load(folder)


def test_a_truth_of_another_scale_is_told(simulated_body: Path, tmp_path: Path) -> None:
    """Calibrated with squares of another size: 25 cm off, and nothing was said."""
    folder = of_points(simulated_body, tmp_path / "points", MAP.format(more=BOTH + RIGHT, after=""))
    assert not pt.load(folder).warnings
    lines = (folder / "truth.trc").read_text("utf-8").splitlines()
    rows = [line.split("\t") for line in lines[5:]]
    lines[5:] = ["\t".join([*row[:2], *(str(1.25 * float(x)) for x in row[2:])]) for row in rows]
    (folder / "truth.trc").write_text("\n".join(lines) + "\n", "utf-8")
    assert "its bones are 1.2" in " ".join(pt.load(folder).warnings)


def test_points_that_are_called_nearly_like_joints_are_proposed(simulated_body: Path, tmp_path: Path) -> None:
    folder = of_points(simulated_body, tmp_path / "points", MAP.format(more=BOTH, after=""))
    path = folder / "recording.toml"
    path.write_text(re.sub(r"(?m)^markers = .*\n", "", path.read_text("utf-8")), "utf-8")
    text = (folder / "truth.trc").read_text("utf-8")
    (folder / "truth.trc").write_text(
        text.replace("m left_elbow", "LElbow").replace("m right_elbow", "RElbow"), "utf-8"
    )
    with pytest.raises(pt.InputError, match=r'perhaps markers = {.*left_elbow = "LElbow"'):
        pt.load(folder)


def test_a_truth_of_another_world_is_told(simulated_body: Path, tmp_path: Path) -> None:
    """It was scored without a word."""
    right = of_points(simulated_body, tmp_path / "right", MAP.format(more=BOTH, after='\nup = "z"'), z_up=True)
    assert not pt.load(right).warnings
    wrong = of_points(simulated_body, tmp_path / "wrong", MAP.format(more=BOTH, after=""), z_up=True)
    (said,) = pt.load(wrong).warnings
    assert "in the first frame its joints are" in said
    assert 'with truth.up = "z" they would fit' in said


def test_points_without_a_first_pose_are_not_enough(simulated_body: Path, tmp_path: Path) -> None:
    folder = of_points(simulated_body, tmp_path / "points", MAP.format(more="", after=""))
    text = (folder / "recording.toml").read_text("utf-8").replace('[initial]\nangles = "initial.toml"\n', "")
    (folder / "recording.toml").write_text(text, "utf-8")
    with pytest.raises(pt.InputError, match=r"no \[truth\] with angles \(.amc\)"):
        pt.load(folder)


def test_the_held_pose_is_the_first_estimate(body: pt.BodyRecording) -> None:
    track = pt.track(body, pt.Partitioned(particles=50), 1)
    still = held(track)
    assert np.ptp(still.joints["left_wrist"].mean, axis=0).max() == 0
    scores = pt.evaluate(still, body.truth)
    assert np.isnan(scores.joints["left_wrist"].coverage).all()
    assert body.truth is not None
    expected = np.linalg.norm(track.joints["left_wrist"].mean[0] - body.truth.at("left_wrist", track.time_s), axis=1)
    assert scores.joints["left_wrist"].average_m == pytest.approx(float(np.nanmean(expected)))
    assert scores.joints["left_wrist"].median_m == pytest.approx(float(np.nanmedian(expected)))


@pytest.mark.parametrize("pinhole", [False, True])
def test_an_error_is_taken_apart_into_picture_and_depth(body: pt.BodyRecording, pinhole: bool) -> None:
    away = np.array([0.6, 0.0, 0.8])  # the camera's own z, in the world
    rotation: Matrix = ((0.8, 0.0, -0.6), (0.0, -1.0, 0.0), (-0.6, 0.0, -0.8))
    weak = WeakPerspective(affine=((80.0, 0.0, -60.0, 160.0), (0.0, -100.0, 0.0, 120.0)))
    matrix: Matrix = ((500.0, 0.0, 160.0), (0.0, 500.0, 120.0), (0.0, 0.0, 1.0))
    far = Camera(matrix=matrix, rotation=rotation, translation_m=(0.0, 0.0, 1e4))
    camera = far if pinhole else weak
    assert body.truth is not None
    truth = {name: rows[:20] for name, rows in body.truth.joints_m.items()}
    off = np.zeros((20, 3))
    off[:, 1] = 0.03  # across the picture in every frame, in depth in most; far across in five
    off[:15] += 0.1 * away
    off[15:, 1] = 0.3
    bare = np.zeros((20, 3))
    joints = {}
    for name in ("root", "left_wrist"):
        mean = truth[name] + off
        joints[name] = JointTrack(mean=mean, mode=mean, sd=bare, lo=mean, hi=mean)
    scored = TrackFile(body.truth.time_s[:20], joints, np.ones(20, dtype=bool), camera)
    for score in pt.evaluate(scored, body.truth).joints.values():
        assert score.across_m == pytest.approx(0.03, abs=1e-4)
        assert score.depth_m == pytest.approx(0.1, abs=1e-4)
        assert score.median_m == pytest.approx(np.hypot(0.03, 0.1), abs=1e-6)
        assert score.lost_share == 0.25
