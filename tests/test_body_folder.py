"""A body's folder: faults in it are named, what is not there is said or found, what a run leaves."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats import read_amc, read_asf
from pytracker.simulate.body import camera_before


@pytest.fixture
def folder(simulated_body: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(simulated_body, tmp_path / "recording"))


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("height_m = 1.75", "height_m = 3.0", "skeleton.height_m is 3.0, expected: input should be less than or equal"),
        ("height_m = 1.75", "", "[skeleton] has neither, expected file or height_m"),
        ("height_m = 1.75", 'file = "none.asf"', "none.asf: no such file"),
        ("height_m", "heigth_m", "skeleton.heigth_m is not a known key, did you mean 'height_m'?"),
        ('points = "points.csv"', "", "camera[0] has none, expected one of points, affine, matrix"),
        ('points = "points.csv"', "affine = [[1, 2], [3, 4]]", "camera[0].affine has rows of [2, 2] numbers"),
        (
            'points = "points.csv"',
            "affine = [[139, 0, 5000], [0, -139, 280]]",
            "at the first frame the root is seen at (",
        ),
        ('points = "points.csv"', "matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "camera[0].rotation is missing"),
        ('background = "background.png"', 'background = "b.png"', "b.png: no such file"),
        ('points = "points.csv"', "affine = [[0, 0, 160], [0, -139, 280]]", "expected rows in px/m that are not zero"),
        ('points = "points.csv"', "affine = [[1e-9, 0, 160], [0, -1e-9, 120]]", "root and head are"),
        ('points = "points.csv"', 'points = "points.csv"\ndistortion = [1, 0, 0, 0, 0]', "distortion goes with matrix"),
        ("rate_hz = 120.0", "", "truth.rate_hz is missing"),
        ('file = "motion.amc"', 'file = "motion.fbx"', "truth.file is 'motion.fbx', expected an .amc motion"),
        ("[truth]", "[initial]\nframe = 99999\n[truth]", "initial.frame is 99999, expected below 241"),
        ("[truth]", '[initial]\nangles = "no.toml"\n[truth]', "no.toml: no such file, expected the first pose"),
        ("rate_hz = 120.0", "rate_hz = 120.0\noffset_s = 9.0", "expected it to cover the first frame, or [initial]"),
    ],
)
def test_a_fault_in_a_folder_is_named(folder: Path, old: str, new: str, expected: str) -> None:
    path = folder / "recording.toml"
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")
    with pytest.raises(pt.InputError) as error:
        pt.load(folder)
    assert expected in str(error.value)


def test_without_a_first_pose_it_is_said_who_finds_one(folder: Path) -> None:
    path = folder / "recording.toml"
    text = path.read_text("utf-8")
    path.write_text(text[: text.index("[truth]")], "utf-8")
    with pytest.raises(pt.InputError, match=r"has no \[initial\] angles .*: pytracker check --write finds it"):
        pt.load(folder)


def test_points_that_do_not_fit(folder: Path) -> None:
    path = folder / "points.csv"
    lines = path.read_text().split("\n")
    path.write_text("\n".join([lines[0], *("0.1,1.0,0.0,10,10" for _ in range(9))]))
    with pytest.raises(pt.InputError, match="the points lie on one line of the image plane"):
        pt.load(folder)
    path.write_text("\n".join([lines[0], lines[1], lines[2]]))
    with pytest.raises(pt.InputError, match="there are 2 point pairs, expected at least 4"):
        pt.load(folder)
    path.write_text("x,y\n1,2\n")
    with pytest.raises(pt.InputError, match=r"points.csv:1: header has no column x_m, y_m, z_m, u, v"):
        pt.load(folder)


def test_points_in_millimetres_or_in_one_column(folder: Path) -> None:
    path = folder / "points.csv"
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    header = path.read_text().split("\n")[0]

    def write(values: np.ndarray) -> None:
        np.savetxt(path, values, fmt="%.5f", delimiter=",", header=header, comments="")

    write(table * [1000, 1000, 1000, 1, 1])
    with pytest.raises(pt.InputError, match=r"root and head are .* px apart, expected at least 8 px: check the units"):
        pt.load(folder)
    write(np.column_stack([table[:, :3], np.full(len(table), 160.0), table[:, 4]]))
    with pytest.raises(pt.InputError, match=r"points.csv: u is 160 in every pair"):
        pt.load(folder)


def test_truth_keeps_its_frames_times_and_says_what_it_does_not_cover(folder: Path) -> None:
    path = folder / "motion.amc"
    whole = path.read_text("latin-1").split("\n")
    starts = [k for k, line in enumerate(whole) if line.isdigit()]
    without = whole[: starts[60]] + whole[starts[100] : starts[200]]
    path.write_text("\n".join(without) + "\n", "latin-1")
    recording = pt.load(folder)
    assert recording.truth is not None
    assert recording.truth.time_s[60] == pytest.approx(100 / 120)
    assert np.isnan(recording.truth.at("head", np.array([80 / 120]))).all()
    words = "\n".join(recording.warnings)
    assert "frame 101 follows frame 60; what lies between is not scored" in words
    assert "motion.amc: the truth covers 0.000 to 1.658 s and the video" in words


def test_a_recording_is_never_replaced_by_a_report(folder: Path) -> None:
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    track = pt.track(recording, pt.BodyPlain(particles=10))
    with pytest.raises(pt.InputError, match=r"holds a recording \(recording.toml\), expected another folder"):
        pt.write_report([track], folder, force=True, page=False)
    assert (folder / "video.mp4").is_file()


def test_a_video_without_truth_starts_from_angles(folder: Path) -> None:
    path = folder / "recording.toml"
    text = path.read_text("utf-8")
    path.write_text(text[: text.index("[truth]")], "utf-8")
    with pytest.raises(pt.InputError, match=r"has no \[initial\] angles and no \[truth\]"):
        pt.load(folder)
    whole = path.read_text("utf-8")
    path.write_text(whole + '\n[initial]\nangles = "initial.toml"\n', "utf-8")
    (folder / "initial.toml").write_text("root_ty = 0.93\nlhumerus_ry = -75\nrhumerus_ry = 75\nlradius_rx = 10\n")
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    assert recording.truth is None
    assert recording.initial[recording.skeleton.channels.index("lhumerus_ry")] == pytest.approx(np.radians(-75))
    track = pt.track(recording, pt.Partitioned(particles=50))
    assert np.isfinite(track.poses).all()
    (folder / "initial.toml").write_text("nose_rx = 1\n")
    with pytest.raises(pt.InputError, match="nose_rx is no channel of the skeleton"):
        pt.load(folder)


def test_without_a_background_the_median_serves(folder: Path) -> None:
    path = folder / "recording.toml"
    path.write_text(path.read_text("utf-8").replace('background = "background.png"\n', ""), "utf-8")
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    assert recording.view.background is None
    assert np.isfinite(pt.track(recording, pt.BodyPlain(particles=30)).poses).all()


def test_a_calibrated_camera_serves_as_well(body: pt.BodyRecording) -> None:
    """Perspective and its weak approximation put the joints within a few pixels of each other."""
    assert body.truth is not None
    camera = camera_before(body.truth.joints_m["root"], 4.0)
    head = body.truth.joints_m["head"]
    assert np.abs(camera.project(head) - body.view.camera.project(head)).max() < 6.0
    view = dataclasses.replace(body.view, camera=camera)
    pinhole = dataclasses.replace(body, view=view)
    errors = [
        pt.evaluate(pt.track(recording, pt.Partitioned(), 2), body.truth).average_m for recording in (body, pinhole)
    ]
    assert errors[1] < errors[0] + 0.03


def test_a_run_leaves_motion_and_tables(body: pt.BodyRecording, tmp_path: Path) -> None:
    track = pt.track(body, pt.Partitioned(particles=100), 1)
    out = pt.write_report([track], tmp_path / "out", page=False)
    header = (out / "track.csv").read_text().split("\n")[0]
    for name in ("left_wrist_z_hi_m", "lhumerus_rx_rad", "lhumerus_rx_sd_rad", "root_tx_m", "ess", "reason"):
        assert f",{name}" in header
    # With its skeleton, as whoever has no recording of ours reads it.
    skeleton = read_asf(out / "track.asf")
    again = read_amc(out / "track.amc", skeleton)
    assert np.abs(again.poses - track.poses[:, body.skeleton.columns(skeleton.channels)]).max() < 1e-5
    assert "30 frames/s" in (out / "track.amc").read_text().splitlines()[0]


def test_frames_that_were_not_tracked_leave_a_gap_in_the_motion(body: pt.BodyRecording, tmp_path: Path) -> None:
    track = pt.track(body, pt.Partitioned(particles=50), 1)
    poses = track.poses.copy()
    poses[3:7] = np.nan
    out = pt.write_report([dataclasses.replace(track, poses=poses)], tmp_path / "out", page=False)
    numbers = [line for line in (out / "track.amc").read_text().splitlines() if line.isdigit()]
    assert numbers[:4] == ["1", "2", "3", "8"]
    assert len(numbers) == len(poses) - 4
