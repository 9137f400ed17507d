"""Cameras of laboratories with z up, and points called as joints are: what init makes of them."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tomlkit

import pytracker as pt
from pytracker.formats.trc import read_trc
from pytracker.formats.truth_csv import read_truth_csv
from pytracker.recording.truth.names import markers_of
from pytracker.recording.upright import to_up
from pytracker.setup import init
from pytracker.setup.checks.camera import check_up
from pytracker.setup.draft import Draft
from pytracker.setup.entries.truth import truth_lines
from pytracker.setup.upright import AS_TRC, axis_up, words_of

LEVEL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Looks along +y, z up."""


def test_which_axis_is_up_in_a_picture() -> None:
    assert axis_up(LEVEL) == "z"
    assert axis_up(LEVEL @ to_up("z", "y").T) == axis_up(LEVEL @ AS_TRC.T) == "y"
    assert axis_up(np.diag([1.0, 1.0, 1.0])) == "-y"
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.0, -0.8, -0.6]])
    assert axis_up(tilted) == ""  # z turned over, seen from below, or y seen from above
    for down_deg, found in ((20.0, "-z"), (50.0, ""), (60.0, ""), (70.0, "")):
        s, c = np.sin(np.radians(down_deg)), np.cos(np.radians(down_deg))
        assert axis_up(np.array([[1.0, 0.0, 0.0], [0.0, s, c], [0.0, -c, s]])) == found  # level: looks along -y
    askew = np.array([[0.71, 0.41, 0.58], [0.0, -0.58, 0.58], [-0.71, 0.41, 0.58]])
    askew[1, 0] = 0.58
    assert axis_up(askew) == ""


@pytest.mark.parametrize("given", ["x", "-x", "y", "-y", "z", "-z"])
@pytest.mark.parametrize("wanted", ["y", "z"])
def test_what_was_up_is_up(given: str, wanted: str) -> None:
    up = np.sign(-0.5 if given.startswith("-") else 0.5) * np.eye(3)["xyz".index(given[-1])]
    turn = to_up(given, wanted)
    assert np.array_equal(turn @ up, np.eye(3)["xyz".index(wanted)])
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_turns_in_words() -> None:
    assert words_of(to_up("z", "y")) == "x, z, -y"
    assert words_of(AS_TRC) == "y, z, x"


def test_a_real_calibration_whose_x_axis_is_up(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """The clips' own calibration and triangulated points, as they are: the prepared folder's camera sees them so."""
    clips = shared("data/people/gestures")
    video, trc = clips / "0_1_31_p1.cam2.avi", clips / "0_1_31_p1.trc"
    path = init(tmp_path / "p", video=video, truth=trc, camera=clips / "Calib_board.toml", camera_name="cam2")
    path.write_text(path.read_text().replace("# height_m = 1.70", "height_m = 1.57"))
    text = path.read_text()
    assert "has its x axis up" in text
    assert 'up = "z"' in text
    shutil.copy(shared("recordings/people-gesture-31") / "initial.toml", tmp_path / "p")
    path.write_text(text.replace("[initial]", '[initial]\nangles = "initial.toml"'))
    recording, prepared = pt.load(tmp_path / "p"), pt.load(shared("recordings/people-gesture-31"))
    assert isinstance(recording, pt.BodyRecording)
    assert isinstance(prepared, pt.BodyRecording)
    assert recording.truth is not None
    theirs = read_truth_csv(shared("recordings/people-gesture-31") / "truth.csv").positions_m
    for wrist in ("left_wrist", "right_wrist"):
        # Of half the size, and from the same three cameras.
        pixels = recording.view.camera.project(recording.truth.joints_m[wrist][::20])
        count = len(pixels)
        assert np.abs(pixels - 2.0 * prepared.view.camera.project(theirs[wrist][::20][:count])).max() < 2.0


def test_a_trc_in_the_calibrations_own_axes(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """Not every TRC is turned as Pose2Sim turns it: which is which is seen in the picture."""
    clips = shared("data/people/gestures")
    lines = (clips / "0_1_31_p1.trc").read_text().splitlines()
    for k in range(5, len(lines)):
        cells = lines[k].split("\t")
        count = (len(cells) - 2) // 3
        for point in range(count):
            x, y, z = cells[2 + 3 * point : 5 + 3 * point]
            cells[2 + 3 * point : 5 + 3 * point] = [z, x, y]
        lines[k] = "\t".join(cells)
    (tmp_path / "own.trc").write_text("\n".join(lines) + "\n")
    truths = []
    for name, trc in (("theirs", clips / "0_1_31_p1.trc"), ("own", tmp_path / "own.trc")):
        init(
            tmp_path / name,
            video=clips / "0_1_31_p1.cam2.avi",
            truth=trc,
            camera=clips / "Calib_board.toml",
            camera_name="cam2",
        )
        draft = Draft(tmp_path / name)
        rotation, up = np.array(draft.get("camera.rotation")), draft.get("truth.up")
        turn = to_up(up or "y", "y")
        points = read_trc(trc).positions_m["RWrist"][:50] @ turn.T
        truths.append(points @ rotation.T + np.array(draft.get("camera.translation_m")))
    assert np.abs(truths[0] - truths[1]).max() < 1e-6


def test_an_arms_calibration_is_turned_too(simulated: Path, tmp_path: Path) -> None:
    draft = Draft(simulated)
    own = np.array(draft.get("camera.rotation"), dtype=float)
    known = tmp_path / "camera.toml"
    known.write_text(f"rotation = {(own @ to_up('y', 'z')).tolist()}\n")
    init(tmp_path / "arm", video=simulated / "video.mp4", imu=simulated / "imu.csv", camera=known)
    made = np.array(Draft(tmp_path / "arm").get("camera.rotation"))
    assert axis_up(made) == axis_up(own) == "z"


def test_a_camera_of_another_world_is_told(simulated: Path, tmp_path: Path) -> None:
    """Of an arm's it was not: clock, heading and mount were looked for in vain."""
    folder = shutil.copytree(simulated, tmp_path / "arm")
    draft = Draft(folder)
    rotation = np.array(draft.get("camera.rotation"), dtype=float)
    assert not check_up(draft)
    draft.set("camera.rotation", (rotation @ to_up("x", "z")).tolist())
    draft.save()
    (found,) = check_up(Draft(folder))
    assert found.verdict == "doubtful"
    assert "its world's x axis is up in the picture, and an arm is in a world whose z axis is" in found.evidence


def test_of_a_steep_camera_nothing_is_concluded(simulated: Path, tmp_path: Path) -> None:
    """From 53° down on a level axis was taken to be up, and a right rotation was to be turned."""
    draft = Draft(shutil.copytree(simulated, tmp_path / "arm"))
    s, c = np.sin(np.radians(60.0)), np.cos(np.radians(60.0))
    draft.set("camera.rotation", np.array([[1.0, 0.0, 0.0], [0.0, -s, -c], [0.0, c, -s]]).tolist())
    draft.save()
    (found,) = check_up(draft)
    assert found.verdict == "cannot be told"
    assert "whether the z axis of its world is up" in found.evidence
    known = tmp_path / "camera.toml"
    known.write_text(f"rotation = {draft.get('camera.rotation')}\n")
    path = init(tmp_path / "new", video=simulated / "video.mp4", imu=simulated / "imu.csv", camera=known)
    assert "not turned, the camera looks up, down or askew: z is to be up here" in path.read_text()


def test_points_are_joints_by_how_they_are_called() -> None:
    names = ["RHip", "LHip", "R_Shoulder", "left elbow", "subject:RWrist", "Nose", "RSHO"]
    assert markers_of(names, "body") == {
        "root": ["LHip", "RHip"],
        "right_shoulder": "R_Shoulder",
        "left_elbow": "left elbow",
        "right_wrist": "subject:RWrist",
    }
    assert markers_of(names, "arm", "left") == {"elbow": "left elbow"}
    assert markers_of(["A", "B"], "body") == {}


def test_what_init_says_of_a_truth(tmp_path: Path) -> None:
    file = tmp_path / "joints.csv"
    assert truth_lines('"motion.amc"', tmp_path / "motion.amc", "body", "right", "")[1:] == [
        'file = "motion.amc"',
        "",
    ]
    file.write_text("time_s,RElbow_x_m,RElbow_y_m,RElbow_z_m\n0,0,0,0\n1,0,0,0\n")
    lines = truth_lines('"joints.csv"', file, "arm", "right", "z")
    assert lines[2].startswith('markers = { elbow = "RElbow" }')
    assert lines[3].startswith('up = "z"')
    file.write_text('time_s,R"Elbow_x_m,R"Elbow_y_m,R"Elbow_z_m\n0,0,0,0\n1,0,0,0\n')
    written = "\n".join(truth_lines('"joints.csv"', file, "arm", "right", ""))
    assert tomlkit.parse(written)["truth"]["markers"] == {"elbow": 'R"Elbow'}
    file.write_text("nothing\n")
    assert "cannot be read" in truth_lines('"joints.csv"', file, "arm", "right", "")[2]


def test_a_rotation_that_is_none_is_left_to_the_loader(simulated_body: Path, tmp_path: Path) -> None:
    known = tmp_path / "camera.toml"
    known.write_text("rotation = [[1, 0], [0, 1]]\n")
    path = init(tmp_path / "out", video=simulated_body / "video.mp4", camera=known)
    assert "rotation = [[1, 0], [0, 1]]" in path.read_text()
