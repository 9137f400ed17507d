"""Keypoints in tables: how columns are named, numbered and left empty."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.models import MODELS
from pytracker.formats.keypoints.read import Keypoints, read_keypoints


@pytest.mark.parametrize("first", [0, 1])
def test_columns_that_number_the_joints_of_a_model(first: int, tmp_path: Path) -> None:
    header = ",".join(f"x{k},y{k},z{k},v{k}" for k in range(first, first + 33))
    rows = [",".join(f"{0.01 * k + 0.001 * row:.3f},0.5,-0.1,0.9" for k in range(33)) for row in range(3)]
    (tmp_path / "k.csv").write_text("\n".join([header, *rows]) + "\n", "utf-8")
    found = read_keypoints(tmp_path / "k.csv")
    wrist = MODELS["blazepose_33"].index("left_wrist")
    expected = [[0.01 * wrist + 0.001 * row, 0.5, 0.9] for row in range(3)]
    assert found.points[:, 0, KEYPOINTS.index("left_wrist")] == pytest.approx(np.array(expected))
    assert found.is_share
    (tmp_path / "k.csv").write_text("x0,y0,x1,y1\n1,2,3,4\n", "utf-8")
    with pytest.raises(pt.InputError, match="header names no joint"):
        read_keypoints(tmp_path / "k.csv")


@pytest.mark.parametrize(
    "names",
    ["left_wrist_u,left_wrist_v,left_wrist_visibility", "LeftWrist.x,LeftWrist.y,LeftWrist.conf",
     "left_wrist_x_px,left_wrist_y_px,left_wrist_prob", "left wrist x,left wrist y,left wrist p"],
)  # fmt: skip
def test_columns_are_named_in_many_ways(tmp_path: Path, names: str) -> None:
    (tmp_path / "k.csv").write_text(f"frame,{names}\n0,101,52,0.4\n1,102,53,0.5\n", "utf-8")
    found = read_keypoints(tmp_path / "k.csv").points[:, 0, KEYPOINTS.index("left_wrist")]
    assert found.tolist() == [[101, 52, 0.4], [102, 53, 0.5]]


@pytest.mark.parametrize(
    ("names", "cells", "expected"),
    [
        ("left_wrist_x,left_wrist_y,left_wrist_v", "101,152,0.93", [101, 152, 0.93]),
        ("left_wrist_x,left_wrist_y,left_wrist_u,left_wrist_v", "101,152,3,0.93", [101, 152, 0.93]),
        ("left_wrist_x,left_wrist_y,left_wrist_x_px,left_wrist_y_px", "0.3,0.4,101,152", [101, 152, 1]),
        ("left_wrist_x,left_wrist_y,left_wrist.x,left_wrist.y", "101,152,0.3,0.4", [101, 152, 1]),
        ("left_wrist_x,left_wrist_y,left_wrist_visibility,left_wrist_presence", "101,152,0.4,0.99", [101, 152, 0.4]),
    ],
)
def test_of_two_columns_of_one_axis_one_is_taken(tmp_path: Path, names: str, cells: str, expected: list[float]) -> None:
    (tmp_path / "k.csv").write_text(f"frame,{names}\n0,{cells}\n1,{cells}\n", "utf-8")
    found = read_keypoints(tmp_path / "k.csv").points[0, 0, KEYPOINTS.index("left_wrist")]
    assert found.tolist() == expected


PLAIN = "right_shoulder_x,right_shoulder_y,right_wrist_x,right_wrist_y"


def plain(path: Path, rows: list[str], header: str = PLAIN) -> Keypoints:
    path.write_text("\n".join([header, *rows]) + "\n", "utf-8")
    return read_keypoints(path)


def test_a_row_of_commas_is_a_frame(tmp_path: Path) -> None:
    found = plain(tmp_path / "a.csv", ["100,50,120,90", ",,,", "102,50,124,90", ",,,"])
    assert found.frames.tolist() == [0, 1, 2]
    assert np.isnan(found.points[1]).all()
    assert np.nanmax(found.points[2, ..., 0]) == 124


def test_shares_of_the_picture_are_told(tmp_path: Path) -> None:
    assert plain(tmp_path / "a.csv", ["0.2,0.3,0.4,0.5", "0.2,0.3,0.41,0.5"]).is_share
    assert not plain(tmp_path / "b.csv", ["20,30,40,50", "20,30,41,50"]).is_share


def test_columns_that_name_joints_come_before_numbered_ones(tmp_path: Path) -> None:
    numbered = [f"{axis}{k}" for k in range(17) for axis in "xy"]
    path = tmp_path / "k.csv"
    path.write_text(
        ",".join(["left_wrist_x", "left_wrist_y", *numbered]) + "\n" + ",".join(["100", "200", *["0.5"] * 34])
    )
    left_wrist = read_keypoints(path).points[0, 0, KEYPOINTS.index("left_wrist")]
    assert left_wrist[:2].tolist() == [100.0, 200.0]


@pytest.mark.parametrize("nowhere", ["0", "-1", "nan"])
def test_what_was_not_found_is_no_place(nowhere: str, tmp_path: Path) -> None:
    """Minus one was taken for a place beside the picture: valid 5 %, "somebody else"."""
    path = tmp_path / "k.csv"
    names = ("nose", "left_ear", "right_ear", "left_wrist", "right_wrist")
    path.write_text(
        ",".join(f"{name}_{axis}" for name in names for axis in "xy")
        + f"\n60,50,{nowhere},{nowhere},70,50,100,200,{nowhere},{nowhere}\n61,51,62,50,72,50,101,201,150,210\n"
    )
    found = read_keypoints(path).points[:, 0, :, :2]
    head, left, right = (KEYPOINTS.index(name) for name in ("head", "left_wrist", "right_wrist"))
    assert found[:, head].tolist() == [[60.0, 50.0], [67.0, 50.0]]
    assert found[0, left].tolist() == [100.0, 200.0]
    assert np.isnan(found[0, right]).all()
    assert found[1, right].tolist() == [150.0, 210.0]


def test_numbered_columns_may_have_a_line_between(tmp_path: Path) -> None:
    axes = ("x", "y", "z", "visibility")
    path = tmp_path / "k.csv"
    path.write_text(
        ",".join(f"{axis}_{k}" for k in range(33) for axis in axes)
        + "\n"
        + ",".join(f"{0.5 + k / 100},{0.4 + k / 100},0,0.9" for k in range(33))
    )
    found = read_keypoints(path)
    assert found.is_share
    assert np.isfinite(found.points[0, 0, 1:, :2]).all()


@pytest.mark.parametrize("frames", [(0, 0, 1, 1), (0, 1, 0, 1)])
def test_several_people_in_a_table_are_named(frames: tuple[int, ...], tmp_path: Path) -> None:
    """In turn, or one below the other, as SLEAP writes its tracks."""
    path = tmp_path / "people.csv"
    rows = "".join(f"{frame},{k},{k},0.9\n" for k, frame in enumerate(frames, start=1))
    path.write_text("frame,left_wrist_u,left_wrist_v,left_wrist_confidence\n" + rows)
    with pytest.raises(pt.InputError, match=r"several people in a frame\? Keep the rows of one"):
        read_keypoints(path)
