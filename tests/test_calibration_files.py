"""Cameras that others have calibrated: Pose2Sim, Caliscope, Qualisys; and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.calibration import read_calibration

SHARED = Path(__file__).parents[2] / "shared" / "data"

ANIPOSE = """
[cam_0]
name = "left"
size = [640, 480]
matrix = [[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]]
distortions = [0.1, -0.2, 0.001, 0.002]
rotation = [0.0, 0.0, 1.5707963267948966]
translation = [0.1, 0.2, 3.0]

[cam_1]
name = "right"
matrix = [[601.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]]
fisheye = true

[metadata]
error = 0.4
"""


def shared(name: str) -> Path:
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"{path} is not there")
    return path


def test_a_table_a_camera(tmp_path: Path) -> None:
    path = tmp_path / "calib.toml"
    path.write_text(ANIPOSE)
    found = read_calibration(path, "left")
    assert found["distortion"] == [0.1, -0.2, 0.001, 0.002, 0.0]
    assert np.array(found["rotation"]) == pytest.approx(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), abs=1e-12)
    assert found["translation_m"] == [0.1, 0.2, 3.0]
    for name, words in (
        (None, "holds the cameras left, right, and none is named"),
        ("top", "'top' is named"),
        ("right", "fisheye"),
    ):
        with pytest.raises(pt.InputError, match=words):
            read_calibration(path, name)
    path.write_text(ANIPOSE.replace("[0.1, 0.2, 3.0]", '["x", 0.2, 3.0]'))
    with pytest.raises(pt.InputError, match=r"translation is .*, expected 3 numbers"):
        read_calibration(path, "left")


def test_files_of_ours_and_files_that_are_none(tmp_path: Path) -> None:
    ours = tmp_path / "camera.toml"
    ours.write_text("matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\nupper_arm_m = 0.3\n")
    assert read_calibration(ours)["upper_arm_m"] == 0.3
    for text in ("not a calibration", "<a><b></a>", "<calibration><cameras/></calibration>"):
        path = tmp_path / "calib.xml"
        path.write_text(text)
        with pytest.raises(pt.InputError, match=r"is no calibration|has no <camera>"):
            read_calibration(path)
    with pytest.raises(pt.InputError, match="no such file"):
        read_calibration(tmp_path / "nowhere.toml")


def test_one_rig_by_two_programs_is_the_same() -> None:
    """The rig's Qualisys file and what Pose2Sim made of it: the same cameras in the same places."""
    qualisys = shared("video/pose2sim_single/Calib.qca.txt")
    pose2sim = shared("people/pose2sim_truth/S00_Calibration/Calib_qualisys.toml")
    for number in (1, 2, 3, 4):
        a = pt.Camera(**read_calibration(qualisys, f"cam0{number}"), patch_offset_m=(0.0, 0.0, 0.0))
        b = pt.Camera(**read_calibration(pose2sim, f"cam_0{number}"), patch_offset_m=(0.0, 0.0, 0.0))
        assert a.matrix[0][0] == pytest.approx(b.matrix[0][0], rel=1e-4)
        apart = np.linalg.norm(np.array(a.position_m) - np.array(b.position_m))
        assert apart < 0.01, number
        assert np.array(a.rotation) == pytest.approx(np.array(b.rotation), abs=2e-3)


def test_caliscope() -> None:
    path = shared("calibration/charuco/camera_array.toml")
    camera = pt.Camera(**read_calibration(path, "0"), patch_offset_m=(0.0, 0.0, 0.0))
    assert camera.matrix[0][0] == pytest.approx(903.55, abs=0.01)
    assert np.linalg.det(np.array(camera.rotation)) == pytest.approx(1.0, abs=1e-6)
