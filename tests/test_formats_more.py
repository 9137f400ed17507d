"""MATLAB's files as an IMU's and as truth, and BVH as truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

import pytracker as pt
from pytracker.formats.bvh import read_bvh
from pytracker.formats.imu.read import read_imu
from pytracker.formats.mat import read_mat_points
from pytracker.inertial.check import check
from pytracker.inertial.orientation import orient
from pytracker.recording.truth.names import markers_of


@pytest.mark.parametrize(
    ("name", "gaps"), [("10_undisturbed_slow_translation_A", 42), ("21_undisturbed_fast_combined", 219)]
)
def test_broad_is_read(shared: Callable[[str], Path], name: str, gaps: int) -> None:
    """Turned to the world by what VQF makes of it, gravity is up; and the optical truth is beside it."""
    path = shared(f"data/imu/broad/{name}.mat")
    log = orient(check(read_imu(path)))
    assert log.rate_hz == pytest.approx(285.714, abs=0.01)
    assert log.mag is not None
    assert log.q_world_sensor is not None
    points = read_mat_points(path)
    assert list(points.positions_m) == ["opt_pos"]
    assert points.gaps == {"opt_pos": gaps}
    assert len(points.time_s) == len(log.time_s)


def test_a_mat_file_is_what_a_csv_would_be(tmp_path: Path) -> None:
    acc, gyr = np.tile([0.1, 0.2, 9.8], (50, 1)), np.full((50, 3), 0.01)
    q = np.tile([1.0, 0, 0, 0], (50, 1))
    savemat(tmp_path / "imu.mat", {"acc": acc, "gyr": gyr, "quat": q, "fs": 100.0, "label": "who"})
    log = read_imu(tmp_path / "imu.mat")
    for found, expected in ((log.acc, acc), (log.gyr, gyr), (log.q_world_sensor, q)):
        assert found is not None
        assert np.array_equal(found, expected)
    assert log.time_s[-1] == pytest.approx(0.49)


@pytest.mark.parametrize("is_matlab", [True, False])
def test_arrays_in_hdf5_are_read(tmp_path: Path, is_matlab: bool) -> None:
    """MATLAB 7.3, which writes column by column behind a header; and BROAD's, whose rate is an attribute."""
    rng = np.random.default_rng(2)
    arrays = {"imu_acc": rng.normal(size=(50, 3)), "imu_gyr": rng.normal(size=(50, 3))}
    path = tmp_path / ("imu.mat" if is_matlab else "imu.hdf5")
    with h5py.File(path, "w", userblock_size=512 if is_matlab else 0) as file:
        for name, values in arrays.items():
            of = file.create_dataset(name, data=values.T if is_matlab else values)
            if is_matlab:
                of.attrs["MATLAB_class"] = np.bytes_("double")
        if is_matlab:
            file.create_dataset("sampling_rate", data=[[100.0]]).attrs["MATLAB_class"] = np.bytes_("double")
        else:
            file.attrs["sampling_rate"] = 100.0
    if is_matlab:
        with path.open("r+b") as bytes_of:
            bytes_of.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    log = read_imu(path)
    assert log.acc is not None
    assert log.gyr is not None
    assert np.array_equal(log.acc, arrays["imu_acc"])
    assert np.array_equal(log.gyr, arrays["imu_gyr"])
    assert log.time_s[-1] == pytest.approx(0.49)


@pytest.mark.parametrize(
    ("arrays", "expected"),
    [
        ({"gyr": np.zeros((5, 3)), "fs": 100.0}, r"has gyr \(5, 3\), fs \(1, 1\), expected imu_acc or acc"),
        ({"acc": np.zeros((5, 3))}, "expected sampling_rate in Hz, or time_s"),
        ({"acc": np.zeros((5, 3)), "fs": 0.0}, "its rate is 0 Hz, expected 1 to 100000 Hz"),
        ({"acc": np.zeros((5, 3)), "time": np.array([0, 0.1, 0.05, 0.2, 0.3])}, "its times do not increase all along"),
        ({"acc": np.zeros((5, 3)), "time": np.arange(4.0)}, "has 4 times for 5 rows"),
        ({"acc": np.zeros((5, 3)), "time": np.arange(5.0), "fs": 50.0}, "says 50 Hz and has times at 1 Hz"),
        (
            {"acc": np.zeros((5, 3)), "gyr": np.zeros((5, 3), complex), "fs": 50.0},
            "gyr is no plain array of real numbers",
        ),
        ({"acc": np.zeros((3, 5)), "fs": 100.0}, r"acc has shape \(3, 5\), expected \(5, 3\), a row"),
        ({"acc": np.zeros((5, 3)), "gyr": np.zeros((4, 3)), "fs": 100.0}, r"gyr has shape \(4, 3\), expected \(5, 3\)"),
    ],
)
def test_what_a_mat_file_lacks_is_said(tmp_path: Path, arrays: dict[str, object], expected: str) -> None:
    savemat(tmp_path / "imu.mat", arrays)
    with pytest.raises(pt.InputError, match=expected):
        read_imu(tmp_path / "imu.mat")


def test_points_of_another_length_are_not_left_out_unsaid(tmp_path: Path) -> None:
    savemat(tmp_path / "truth.mat", {"elbow": np.ones((5, 3)), "wrist": np.ones((4, 3)), "fs": 100.0})
    with pytest.raises(pt.InputError, match="wrist has 4 rows and others 5, expected as many"):
        read_mat_points(tmp_path / "truth.mat")


@pytest.mark.parametrize(
    ("head", "expected"),
    [
        (b"MATLAB 7.3 MAT-file", "is no file of arrays that can be read"),
        (b"MATLAB 5.0 MAT-file", "no MATLAB file that can be read"),
    ],
)
def test_a_mat_file_that_is_none(tmp_path: Path, head: bytes, expected: str) -> None:
    # 7.3 is HDF5 behind a header of 512 bytes whose version is 2.
    text = head.ljust(124, b" ") + (b"\x00\x02IM" if b"7.3" in head else b"\x00\x01IM") + b"\x89HDF\r\n" * 80
    (tmp_path / "imu.mat").write_bytes(text)
    with pytest.raises(pt.InputError, match=expected):
        read_imu(tmp_path / "imu.mat")


BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftArm
  {
    OFFSET 0 100 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 60 0 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.02
0 90 0 0 0 0 0 0 0
0 90 0 0 0 0 90 0 0
"""


def test_a_bvh_may_take_liberties(tmp_path: Path) -> None:
    """Comments and blank lines above, other letters, and the unit of CMU's motions."""
    (tmp_path / "a.bvh").write_text(BVH)
    usual = read_bvh(tmp_path / "a.bvh")
    (tmp_path / "b.bvh").write_text(
        "# made by hand\n\n" + BVH.replace("position", "POSITION").replace("rotation", "Rotation")
    )
    for name, places in read_bvh(tmp_path / "b.bvh").positions_m.items():
        np.testing.assert_allclose(places, usual.positions_m[name])
    scale = 0.015 / (0.0254 / 0.45)

    def smaller(line: str) -> str:
        words = line.split()
        return (
            " ".join(["OFFSET", *(f"{scale * float(x):.9f}" for x in words[1:])]) if words[:1] == ["OFFSET"] else line
        )

    head, motion = BVH.split("MOTION")
    (tmp_path / "c.bvh").write_text("\n".join(map(smaller, head.split("\n"))) + "MOTION" + motion)
    found = read_bvh(tmp_path / "c.bvh").positions_m
    expected = 1.5 * (usual.positions_m["LeftArm"][0] - usual.positions_m["Hips"][0])
    np.testing.assert_allclose(found["LeftArm"][0] - found["Hips"][0], expected, atol=1e-6)


def test_a_bvh_file_is_where_its_joints_are(tmp_path: Path) -> None:
    (tmp_path / "a.bvh").write_text(BVH.replace("\n", "\r\n"), "utf-8")
    found = read_bvh(tmp_path / "a.bvh")
    assert found.rate_hz == pytest.approx(50.0)
    assert found.time_s.tolist() == [0.0, 0.02]
    expected = {"Hips": [[0, 0.9, 0]] * 2, "LeftArm": [[0, 1.9, 0]] * 2, "LeftArm_end": [[0.6, 1.9, 0], [0, 2.5, 0]]}
    assert found.positions_m.keys() == expected.keys()
    for name, places in expected.items():
        assert np.allclose(found.positions_m[name], places), name


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("HIERARCHY", "SKELETON", "a.bvh:1: starts with 'SKELETON', expected HIERARCHY"),
        ("CHANNELS 3", "CHANNELS 2", "a.bvh:9: 'CHANNELS 2 Zrotation Xrotation Yrotation' is no line"),
        ("OFFSET 60 0 0", "OFFSET 60 0", "a.bvh:12: 'OFFSET 60 0' is no line"),
        ("OFFSET 60 0 0", "OFFSET 60 x 0", "a.bvh:12"),
        ("Zrotation Xrotation Yrotation\n  JOINT", "Wrotation Xrotation Yrotation\n  JOINT", "a.bvh:5"),
        ("MOTION\n", "", "is no line of a hierarchy here"),
        ("Frames: 2", "Frames: 3", "has 2 frames, expected 3 as it says"),
        ("Frame Time: 0.02", "Frame Time: 0", "Frame Time is 0.0, expected 0.0001 to 1 s"),
        ("0 90 0 0 0 0 90 0 0", "0 90 0 0 0 0 90 0", "a.bvh:20: row has 8 numbers, expected 9"),
        ("0 90 0 0 0 0 90 0 0", "0 90 0 0 0 0 nan 0 0", "row 2 of the motion has nan"),
        ("OFFSET 60 0 0", "OFFSET 2500 0 0", "the skeleton is 2500 units large"),
        ("JOINT LeftArm", "JOINT Hips", "two joints of one name"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_bvh_file_is_said(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert old in BVH
    (tmp_path / "a.bvh").write_text(BVH.replace(old, new), "utf-8")
    with pytest.raises(pt.InputError, match=expected):
        read_bvh(tmp_path / "a.bvh")


def test_names_of_a_bvh_file_are_joints() -> None:
    """Its LeftShoulder is the collar bone: an arm begins at LeftArm."""
    names = ["Hips", "LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand"]
    assert markers_of(names, "body") == {
        "left_shoulder": "LeftArm",
        "left_elbow": "LeftForeArm",
        "left_wrist": "LeftHand",
    }
    acclaim = ["root", "lhumerus", "lradius", "lwrist", "lhand"]
    assert markers_of(acclaim, "arm", "left") == {"shoulder": "lhumerus", "elbow": "lradius", "wrist": "lhand"}
    vicon = ["Ann:LSHO", "Ann:LELB", "Ann:LWRA", "Ann:LWRB", "Ann:RWRA", "Ann:RELB"]
    assert markers_of(vicon, "arm", "left") == {
        "shoulder": "Ann:LSHO",
        "elbow": "Ann:LELB",
        "wrist": ["Ann:LWRA", "Ann:LWRB"],
    }
    assert markers_of(vicon, "arm", "right") == {"elbow": "Ann:RELB", "wrist": "Ann:RWRA"}


def test_a_skeleton_in_inches_is_a_person_too(tmp_path: Path) -> None:
    (tmp_path / "a.bvh").write_text(BVH.replace("OFFSET 0 100 0", "OFFSET 0 68.9 0"), "utf-8")
    assert read_bvh(tmp_path / "a.bvh").positions_m["LeftArm"][0, 1] == pytest.approx((90 + 68.9) * 0.0254)


def test_a_compressed_file_that_was_damaged(tmp_path: Path) -> None:
    savemat(
        tmp_path / "imu.mat", {"acc": np.random.default_rng(1).normal(size=(500, 3)), "fs": 100.0}, do_compression=True
    )
    whole = bytearray((tmp_path / "imu.mat").read_bytes())
    for at in range(200, len(whole), 997):
        (tmp_path / "imu.mat").write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        with pytest.raises(pt.InputError, match=r"imu\.mat"):
            read_imu(tmp_path / "imu.mat")
