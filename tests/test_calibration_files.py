"""Cameras that others have calibrated: Pose2Sim, Caliscope, Qualisys; and what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from test_cli import run

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


def camera_of(found: dict[str, Any]) -> pt.Camera:
    return pt.Camera(**{key: of for key, of in found.items() if key != "size_px"}, patch_offset_m=(0.0, 0.0, 0.0))


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
    path.write_text(re.sub(r"rotation = .*", "rotation = [0.0, 0.0, 90.0]", ANIPOSE))
    with pytest.raises(pt.InputError, match=r"rotation vector is 90 long, expected radians, .*: are they degrees"):
        read_calibration(path, "left")
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
        a = camera_of(read_calibration(qualisys, f"cam0{number}"))
        b = camera_of(read_calibration(pose2sim, f"cam_0{number}"))
        assert a.matrix[0][0] == pytest.approx(b.matrix[0][0], rel=1e-4)
        apart = np.linalg.norm(np.array(a.position_m) - np.array(b.position_m))
        assert apart < 0.01, number
        assert np.array(a.rotation) == pytest.approx(np.array(b.rotation), abs=2e-3)


def test_caliscope() -> None:
    path = shared("calibration/charuco/camera_array.toml")
    camera = camera_of(read_calibration(path, "0"))
    assert camera.matrix[0][0] == pytest.approx(903.55, abs=0.01)
    assert np.linalg.det(np.array(camera.rotation)) == pytest.approx(1.0, abs=1e-6)


def opencv_file(path: Path, matrices: dict[str, np.ndarray]) -> Path:
    """As OpenCV itself writes it."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    for name, matrix in matrices.items():
        storage.write(name, matrix)
    storage.release()
    return path


K = np.array([[700.0, 0, 320], [0, 710.0, 240], [0, 0, 1]])


@pytest.mark.parametrize("suffix", ["yml", "yaml", "xml"])
def test_files_of_opencv(tmp_path: Path, suffix: str) -> None:
    rvec, tvec = np.array([[0.1], [-0.2], [0.3]]), np.array([[0.5], [0.1], [2.5]])
    matrices = {"camera_matrix": K, "distortion_coefficients": np.array([[0.1, -0.2, 0.001, 0.002, 0.05]])}
    path = opencv_file(tmp_path / f"camera.{suffix}", matrices | {"rvec": rvec, "tvec": tvec})
    found = read_calibration(path)
    assert found["matrix"] == K.tolist()
    assert found["distortion"] == [0.1, -0.2, 0.001, 0.002, 0.05]
    assert np.allclose(found["rotation"], cv2.Rodrigues(rvec)[0])
    assert found["translation_m"] == [0.5, 0.1, 2.5]
    sized = read_calibration(opencv_file(tmp_path / f"s.{suffix}", {"K": K, "image_size": np.array([[1280.0, 960.0]])}))
    assert sized["size_px"] == [1280, 960]
    alone = read_calibration(
        opencv_file(tmp_path / f"alone.{suffix}", {"cameraMatrix": K, "distCoeffs": np.zeros((1, 4))})
    )
    assert alone == {"matrix": K.tolist(), "distortion": [0.0] * 5}


@pytest.mark.parametrize(
    ("matrices", "expected"),
    [
        ({"essential": K}, "holds essential, expected camera_matrix"),
        ({"camera_matrix": K[:2]}, "matrix is"),
        ({"camera_matrix": K, "dist": np.array([[0.1, 0, 0, 0, 0, 0.3, 0, 0]])}, "8 distortions"),
        ({"camera_matrix": K, "K": K}, "has camera_matrix and K, expected one of them"),
        ({"M1": K, "D1": np.zeros((1, 5)), "M2": K, "D2": np.zeros((1, 5))}, "has M2, of a second camera"),
        ({"camera_matrix": K, "R": np.eye(3), "T": np.array([[100.0, 0, 2500]])}, "2502 long, expected metres"),
    ],
)
def test_what_a_file_of_opencv_lacks_is_said(tmp_path: Path, matrices: dict[str, np.ndarray], expected: str) -> None:
    with pytest.raises(pt.InputError, match=expected):
        read_calibration(opencv_file(tmp_path / "camera.yml", matrices))


def test_a_ros_file_and_one_that_was_cut(tmp_path: Path) -> None:
    text = (
        "image_width: 640\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
        "  data: [700., 0, 320, 0, 710, 240, 0, 0, 1]\ndistortion_model: plumb_bob\n"
        "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]\n"
    )
    (tmp_path / "ros.yaml").write_text(text, "utf-8")
    assert read_calibration(tmp_path / "ros.yaml")["matrix"] == K.tolist()
    (tmp_path / "cut.yaml").write_text(text.replace(", 0, 0, 1]", "]"), "utf-8")
    with pytest.raises(pt.InputError, match=r"camera_matrix is .*, expected 3 x 3 numbers"):
        read_calibration(tmp_path / "cut.yaml")


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("plumb_bob", "equidistant", "distortion_model is 'equidistant', expected one of: plumb_bob"),
        ("distortion_model: plumb_bob", "fisheye_model: 1", "the camera is a fisheye"),
        ("  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]", " [0.1, 0, 0, 0, 0]", "distortion_coefficients cannot be"),
        ("  rows: 1\n  cols: 5\n", "  cols: 5\n  rows: 1\n", "distortion_coefficients cannot be"),
        ("distortion_coefficients:", "camera_matrix:", "has camera_matrix more than once"),
    ],
)  # fmt: skip
def test_a_lens_is_not_passed_over(tmp_path: Path, old: str, new: str, expected: str) -> None:
    text = (
        "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [700., 0, 320, 0, 710, 240, 0, 0, 1]\n"
        "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]\n"
    )
    assert old in text
    (tmp_path / "camera.yaml").write_text(text.replace(old, new), "utf-8")
    with pytest.raises(pt.InputError, match=expected):
        read_calibration(tmp_path / "camera.yaml")


OURS = """
matrix = [[612.5, 0.0, 318.25], [0.0, 610.0, 241.0], [0.0, 0.0, 1.0]]
distortion = [0.1, -0.2, 0.001, 0.002, 0.03]
rotation = [[0.0, -1.0, 0.0], [0.6, 0.0, -0.8], [0.8, 0.0, 0.6]]
translation_m = [0.1, 0.2, 3.0]
"""


@pytest.mark.parametrize("suffix", ["toml", "yml"])
def test_what_is_written_for_others_is_read_back(tmp_path: Path, suffix: str) -> None:
    known, out = tmp_path / "camera.toml", tmp_path / f"theirs.{suffix}"
    known.write_text(OURS)
    done = run("calibrate", "export", known, out, "--size", "640x480", "--name", "left")
    assert done.returncode == 0, done.stderr
    ours, theirs = read_calibration(known), read_calibration(out)
    for key, value in ours.items():
        assert np.array(theirs[key]) == pytest.approx(np.array(value), abs=1e-12), key
    refused = run("calibrate", "export", known, out, "--size", "640x480")
    assert refused.returncode == 2
    assert "already exists" in refused.stderr


def test_opencv_reads_what_is_written_for_it(tmp_path: Path) -> None:
    (tmp_path / "camera.toml").write_text(OURS)
    assert run("calibrate", "export", tmp_path / "camera.toml", tmp_path / "o.yml", "--size", "640x480").returncode == 0
    storage = cv2.FileStorage(str(tmp_path / "o.yml"), cv2.FILE_STORAGE_READ)
    ours = read_calibration(tmp_path / "camera.toml")
    assert storage.getNode("image_width").real() == 640
    for node, key in (
        ("camera_matrix", "matrix"),
        ("rotation_matrix", "rotation"),
        ("translation_vector", "translation_m"),
    ):
        assert storage.getNode(node).mat().squeeze() == pytest.approx(np.array(ours[key]))


def test_what_cannot_be_written_is_said(tmp_path: Path) -> None:
    known = tmp_path / "camera.toml"
    known.write_text("distortion = [0.0, 0.0, 0.0, 0.0, 0.0]\n")
    for out, size, words in (
        ("c.toml", "640x480", "matrix of the camera is None, expected 3 x 3 numbers"),
        ("c.txt", "640x480", r"expected a name that ends in .toml"),
        ("c.toml", "640", "--size is '640', expected width and height"),
        ("c.toml", "\u00b2x480", "expected width and height"),
    ):
        done = run("calibrate", "export", known, tmp_path / out, "--size", size)
        assert done.returncode == 2
        assert words in " ".join(done.stderr.split())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("translation_m = [0.1, 0.2, 3.0]", ""), "the camera has rotation, expected both"),
        (("rotation = [[0.0, -1.0, 0.0]", "rotation = [[0.0, 1.0, 0.0]"), "rotation"),
        (("[[612.5", "[[0.0"), "focal"),
    ],
    ids=["half a pose", "mirrored", "no focal length"],
)
def test_a_camera_that_is_none_is_not_written(tmp_path: Path, change: tuple[str, str], words: str) -> None:
    known, out = tmp_path / "camera.toml", tmp_path / "theirs.toml"
    known.write_text(OURS.replace(*change))
    done = run("calibrate", "export", known, out, "--size", "640x480")
    assert done.returncode == 2
    assert words in " ".join(done.stderr.split())
    assert not out.exists()
    known.write_text(OURS)
    done = run("calibrate", "export", known, out, "--size", "640x480", "--camera", "nobody")
    assert "'nobody' is named" in " ".join(done.stderr.split())


def test_what_was_passed_over_is_read_or_refused(tmp_path: Path) -> None:
    """A distortion by another name was dropped, millimetres passed, of two tables of one name the last was taken."""
    path = tmp_path / "calib.toml"
    path.write_text(ANIPOSE.replace("distortions =", "distortion ="))
    found = read_calibration(path, "left")
    assert found["distortion"] == [0.1, -0.2, 0.001, 0.002, 0.0]
    assert found["size_px"] == [640, 480]
    path.write_text(ANIPOSE.replace("[0.1, 0.2, 3.0]", "[100.0, 200.0, 3000.0]"))
    with pytest.raises(pt.InputError, match=r"the camera's translation is 3008 long, expected metres"):
        read_calibration(path, "left")
    path.write_text(ANIPOSE.replace('"right"', '"left"'))
    with pytest.raises(pt.InputError, match="holds the cameras left, left, and 'left' is named, expected one of them"):
        read_calibration(path, "left")


FORMER = """
schema = 1
kind = "arm"
[[camera]]
video = "old.mp4"
matrix = [[600.0, 0.0, 319.5], [0.0, 600.0, 239.5], [0.0, 0.0, 1.0]]
distortion = [0.1, -0.2, 0.001, 0.002, 0.0]
rotation = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
translation_m = [0.1, 0.2, 3.0]
[arm]
side = "left"
shoulder_m = [0.0, 0.0, 1.4]
upper_arm_m = 0.3
upper_arm_sd_m = 0.02
forearm_m = 0.25
"""


def begun(simulated: Path, folder: Path, known: Path) -> str:
    """The recording.toml of an arm of which `known` is known."""
    made = pt.setup.init(folder, video=simulated / "video.mp4", imu=simulated / "imu.csv", camera=known)
    return made.read_text("utf-8")


def test_a_former_recording_is_known_beforehand(simulated: Path, tmp_path: Path) -> None:
    """It was read, and nothing of it used."""
    (tmp_path / "recording.toml").write_text(FORMER, "utf-8")
    text = begun(simulated, tmp_path / "new", tmp_path / "recording.toml")
    for line in FORMER.splitlines()[5:]:
        assert line in text
    assert "old.mp4" not in text
    tables = FORMER.replace("[[camera]]", "[camera]").replace('video = "old.mp4"', "patch_box = [1, 2, 3, 4]")
    (tmp_path / "known.toml").write_text(tables, "utf-8")
    again = begun(simulated, tmp_path / "again", tmp_path / "known.toml")
    assert again == text.replace("new", "again")
    assert "guessed" not in text


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        ([640, 480], "matrix = [[600.0, 0.0, 319.5], [0.0, 600.0, 239.5], [0.0, 0.0, 1.0]]"),
        ([640, 488], "matrix = [[600.0, 0.0, 319.5], [0.0, 600.0, 239.5], [0.0, 0.0, 1.0]]"),
        ([1280, 960], "matrix = [[300.0, 0.0, 159.5], [0.0, 300.0, 119.5], [0.0, 0.0, 1.0]]  # scaled from 1280 x 960"),
        ([480, 640], "is of pictures of 480 x 640 px, and .* has 640 x 480, expected the same, or scaled alike"),
        ([640], "size_px is .640., expected width and height"),
    ],
)
def test_a_calibration_is_of_pictures_of_a_size(
    simulated: Path, tmp_path: Path, size: list[int], expected: str
) -> None:
    """At another size it was taken as it is: 8.6 cm, all valid."""
    known = tmp_path / "camera.toml"
    box = "patch_box = [600, 400, 30, 30]\n"
    known.write_text(f"{box}size_px = {size}\n" + "\n".join(FORMER.splitlines()[5:9]), "utf-8")
    if expected.startswith("matrix"):
        text = begun(simulated, tmp_path / "new", known)
        assert expected in text
        assert (box in text) == ("scaled" not in expected)
    else:
        with pytest.raises(pt.InputError, match=expected):
            begun(simulated, tmp_path / "new", known)


def test_a_calibration_of_other_pictures_that_says_no_size_is_refused(simulated: Path, tmp_path: Path) -> None:
    """Of twice the size a body was 4 m off, all valid, and the track called right."""
    known = tmp_path / "camera.toml"
    known.write_text("matrix = [[1400.0, 0, 639.5], [0, 1400.0, 479.5], [0, 0, 1]]\n", "utf-8")
    with pytest.raises(pt.InputError, match=r"640 x 480 px as .* has, expected size_px .*about \[1280, 960\], if they"):
        pt.setup.init(tmp_path / "new", video=simulated / "video.mp4", camera=known)


def test_a_key_that_is_none_is_named(simulated: Path, tmp_path: Path) -> None:
    known = tmp_path / "camera.toml"
    known.write_text("distortions = [0.1, 0.0, 0.0, 0.0, 0.0]\n", "utf-8")
    with pytest.raises(pt.InputError, match=r"distortions is no key of .*, did you mean 'distortion'\?"):
        pt.setup.init(tmp_path / "new", video=simulated / "video.mp4", camera=known)


def test_what_is_no_calibration_says_what_is(tmp_path: Path) -> None:
    path = tmp_path / "camera_info.yaml"
    path.write_text("width: 640\nheight: 480\nK: [600, 0, 320, 0, 600, 240, 0, 0, 1]\nD: [0.1, 0, 0, 0, 0]\n")
    with pytest.raises(pt.InputError, match=r"expected TOML .*, YAML or XML of OpenCV or ROS \(each matrix with rows"):
        read_calibration(path)
    matrix = "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [600, 0, 320, 0, 600, 240, 0, 0, 1]\n"
    path.write_text(f"Image_Width: 640\nImage_Height: 480\n{matrix}")
    assert read_calibration(path)["size_px"] == [640, 480]
    path.write_text(f"{matrix}D: [0.1, 0, 0, 0, 0]\n")
    with pytest.raises(pt.InputError, match="D cannot be read, expected rows, cols and data"):
        read_calibration(path)
