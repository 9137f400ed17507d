"""Cameras of laboratories with z up, and points called as joints are: what init makes of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tomlkit

from pytracker.setup import init
from pytracker.setup.truth_entry import markers_of, truth_lines
from pytracker.setup.upright import as_trc, as_z_up, axis_up

LEVEL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Looks along +y, z up."""


def test_which_axis_is_up_in_a_picture() -> None:
    assert axis_up(LEVEL) == "z"
    assert axis_up(as_z_up(LEVEL)) == axis_up(as_trc(LEVEL)) == "y"
    assert axis_up(np.diag([1.0, 1.0, 1.0])) == "-y"
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.0, -0.8, -0.6]])
    assert axis_up(tilted) == "-z"
    askew = np.array([[0.71, 0.41, 0.58], [0.0, -0.58, 0.58], [-0.71, 0.41, 0.58]])
    askew[1, 0] = 0.58
    assert axis_up(askew) == ""


@pytest.mark.parametrize(("turned", "place"), [(as_z_up, (1, 3, -2)), (as_trc, (2, 3, 1))])
def test_a_turned_camera_sees_turned_points_where_it_saw_them(turned: object, place: tuple[int, int, int]) -> None:
    at = np.array([0.3, 2.0, 1.1])
    moved = np.array([np.sign(k) * at[abs(k) - 1] for k in place])
    assert callable(turned)
    assert np.allclose(turned(LEVEL) @ moved, LEVEL @ at)
    assert np.linalg.det(turned(LEVEL)) == pytest.approx(1.0)


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
    assert truth_lines('"motion.amc"', tmp_path / "motion.amc", "body", "right", is_turned=False)[1:] == [
        'file = "motion.amc"',
        "",
    ]
    file.write_text("time_s,RElbow_x_m,RElbow_y_m,RElbow_z_m\n0,0,0,0\n1,0,0,0\n")
    lines = truth_lines('"joints.csv"', file, "arm", "right", is_turned=True)
    assert lines[2].startswith('markers = { elbow = "RElbow" }')
    assert lines[3].startswith('up = "z"')
    file.write_text('time_s,R"Elbow_x_m,R"Elbow_y_m,R"Elbow_z_m\n0,0,0,0\n1,0,0,0\n')
    written = "\n".join(truth_lines('"joints.csv"', file, "arm", "right", is_turned=False))
    assert tomlkit.parse(written)["truth"]["markers"] == {"elbow": 'R"Elbow'}
    file.write_text("nothing\n")
    assert "cannot be read" in truth_lines('"joints.csv"', file, "arm", "right", is_turned=False)[2]


def test_a_rotation_that_is_none_is_left_to_the_loader(simulated_body: Path, tmp_path: Path) -> None:
    known = tmp_path / "camera.toml"
    known.write_text("rotation = [[1, 0], [0, 1]]\n")
    path = init(tmp_path / "out", video=simulated_body / "video.mp4", camera=known)
    assert "rotation = [[1, 0], [0, 1]]" in path.read_text()
