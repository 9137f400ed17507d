"""Keypoints of several people in any order; what files say of their joints, pictures and units."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_keypoint_tables import plain
from test_keypoints import is_right, person, place

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.models import MODELS
from pytracker.formats.keypoints.people import in_order
from pytracker.formats.keypoints.read import read_keypoints
from pytracker.formats.keypoints.rows import numbers_of
from pytracker.recording.keypoints.spreads import with_spreads
from pytracker.rotation import Array


def two(frames: int, rng: np.random.Generator) -> Array:
    """Somebody who stands, and somebody who walks by 300 px, 0.5 px about where they are `(T, 2, 9, 3)`."""
    points = np.ones((frames, 2, len(KEYPOINTS), 3))
    points[..., :2] = rng.uniform(0.0, 60.0, (2, len(KEYPOINTS), 2)) + 0.5 * rng.standard_normal(points[..., :2].shape)
    points[:, 1, :, 0] += np.linspace(120.0, 420.0, frames)[:, None]
    return points


@given(st.integers(0, 1000))
def test_people_are_who_they_were_in_whatever_order_they_are_listed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = two(40, rng)
    points[10:20, 1] = np.nan
    listed = np.stack([people[rng.permutation(2)] for people in points])
    found = in_order(listed)
    first = 0 if np.allclose(found[0, 0], points[0, 0]) else 1
    np.testing.assert_array_equal(found[:, first], points[:, 0])
    np.testing.assert_array_equal(found[:, 1 - first], points[:, 1])


def test_nobody_is_lost_where_more_are_there_than_before(rng: np.random.Generator) -> None:
    points = two(6, rng)
    points[:3, 1] = np.nan
    points[4, 0] = np.nan
    # Whoever is first there has the first place.
    np.testing.assert_array_equal(in_order(points[:, ::-1]), points)
    np.testing.assert_array_equal(in_order(points[:, 1:]), points[:, 1:])


def test_a_list_in_another_order_is_no_jump(tmp_path: Path, rng: np.random.Generator) -> None:
    """OpenPose lists people in any order: spreads were those of jumps from one to the other, 22.7 px."""
    order = [MODELS["ours"].index(joint) for joint in MODELS["ours"]]
    for k, people in enumerate(two(60, rng)):
        listed = [one[order].ravel().tolist() for one in people[:: 1 if k % 2 else -1]]
        text = json.dumps({"people": [{"pose_keypoints_2d": one} for one in listed]})
        (tmp_path / f"c_{k:012d}_keypoints.json").write_text(text, "utf-8")
    assert np.nanmax(with_spreads(read_keypoints(tmp_path))[..., 2]) < 1.5


def test_somebody_of_whom_only_hands_were_found_is_left_out(tmp_path: Path) -> None:
    for k in range(3):
        found: list[dict[str, Any]] = [{"pose_keypoints_2d": person("body_25")}, {"pose_keypoints_2d": []}]
        (tmp_path / f"c_{k}_keypoints.json").write_text(json.dumps({"people": found}), "utf-8")
    is_right(read_keypoints(tmp_path))


@pytest.mark.parametrize("name", ["{:05d}_cam2.json", "img_{:04d}_v2_keypoints.json", "007_frame{:05d}.json"])
def test_frames_are_what_counts_in_the_files_names(name: str, tmp_path: Path) -> None:
    for k in range(3):
        text = json.dumps({"people": [{"pose_keypoints_2d": person("body_25")}]})
        (tmp_path / name.format(k)).write_text(text, "utf-8")
        (tmp_path / f"._{name.format(k)}").write_bytes(b"\0\5\x16\7Mac OS X")
    is_right(read_keypoints(tmp_path))


def test_shares_of_the_picture_are_told_in_json_too(tmp_path: Path) -> None:
    """OpenPose's `--keypoint_scale 3`, taken as pixels: 163 cm off, and the truth was blamed."""
    for k in range(3):
        shares = np.array(person("body_25")).reshape(-1, 3) / [640.0, 480.0, 1.0]
        text = json.dumps({"people": [{"pose_keypoints_2d": shares.ravel().tolist()}]})
        (tmp_path / f"c_{k}_keypoints.json").write_text(text, "utf-8")
    assert read_keypoints(tmp_path).is_share


def alphapose(path: Path, images: list[str]) -> Path:
    flat = [value for xyc in np.array(person("coco_17")).reshape(-1, 3).tolist() for value in xyc]
    path.write_text(json.dumps([{"image_id": image, "keypoints": flat, "score": 2.0} for image in images]), "utf-8")
    return path


def test_names_of_pictures_in_one_file_are_numbered_as_those_of_a_folder(tmp_path: Path) -> None:
    """All frames but one were lost: each was frame 2."""
    path = alphapose(tmp_path / "alphapose.json", [f"frame_{k:06d}_cam2.jpg" for k in range(3)])
    assert read_keypoints(path).frames.tolist() == [0, 1, 2]
    path = alphapose(path, ["a/000000.jpg", "b/000000.jpg"])
    with pytest.raises(pt.InputError, match=r"'a/000000.jpg' and 'b/000000.jpg' are both of frame 0, .* another clip"):
        read_keypoints(path)


@pytest.mark.parametrize("form", ["open", "cmu"])
def test_alphaposes_other_formats_are_read(tmp_path: Path, form: str) -> None:
    flat = [value for xyc in np.array(person("coco_18")).reshape(-1, 3).tolist() for value in xyc]
    people = {"open": {"people": [{"pose_keypoints_2d": flat}]}, "cmu": {"bodies": [{"joints": flat}]}}
    path = tmp_path / "alphapose-results.json"
    path.write_text(json.dumps({f"{k}.jpg": {"version": "AlphaPose v0.3", **people[form]} for k in range(3)}), "utf-8")
    found = read_keypoints(path)
    is_right(found)
    assert found.frames.tolist() == [0, 1, 2]


def mmpose(path: Path, model: list[str], *, about: bool) -> Path:
    """As MMPose's inferencer writes a video: a list of frames; or with what its data set says of the joints."""
    instance = {"keypoints": [list(place(joint)) for joint in model], "keypoint_scores": [0.9] * len(model)}
    frames = [{"frame_id": k, "instances": [instance]} for k in range(3)]
    names = {str(k): joint for k, joint in enumerate(model)}
    whole = {"meta_info": {"keypoint_id2name": names}, "instance_info": frames}
    path.write_text(json.dumps(whole if about else frames), "utf-8")
    return path


def test_mmposes_lists_of_frames_are_read_and_its_names_are_believed(tmp_path: Path) -> None:
    is_right(read_keypoints(mmpose(tmp_path / "a.json", list(MODELS["coco_17"]), about=False)))
    other = ["root", "right_hip", "right_knee", "right_foot", "left_hip", "left_knee", "left_foot", "spine", "thorax"]
    other += [
        "nose",
        "head",
        *(f"{side}_{joint}" for side in ("left", "right") for joint in ("shoulder", "elbow", "wrist")),
    ]
    is_right(read_keypoints(mmpose(tmp_path / "b.json", other, about=True)))


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["frame_000012_270x480.jpg", "frame_000007_270x480.jpg"], [12, 7]),
        (["frame12.mp4.rf.3a9.jpg", "frame13.mp4.rf.77b1c2.jpg"], [12, 13]),
        (["cam1/clip2_0003.png", "cam1/clip2_0001.png"], [3, 1]),
        (["9.jpg"], [9]),
        (["frame_12_640x480.jpg"], [12]),
        (["frame_0001_t0.033.jpg", "frame_0002_t0.066.jpg", "frame_0003_t0.100.jpg"], [1, 2, 3]),
        (["000001_1700000000123.png", "000002_1700000000156.png"], [1, 2]),
        (["frame_000001_hash8f3a.jpg", "frame_000002_hash77.jpg"], [1, 2]),
        (["a.jpg", "b2.jpg"], [None, 2]),
        ([], []),
    ],
)
def test_pictures_are_numbered_by_what_differs_in_their_names(names: list[str], expected: list[int | None]) -> None:
    assert numbers_of(names) == expected


def test_feet_below_the_picture_make_no_pixels_of_shares(tmp_path: Path) -> None:
    """MediaPipe guesses ankles outside the picture: 1.7 of its height was taken for pixels."""
    joints = [*KEYPOINTS, "left_ankle", "right_ankle"]
    header = ",".join(f"{joint}_{axis}" for joint in joints for axis in "xy")
    row = ",".join("0.4,1.7" if "ankle" in joint else "0.5,0.6" for joint in joints)
    assert plain(tmp_path / "shares.csv", [row] * 5, header).is_share
    pixels = ",".join("0.0,0.0" if "wrist" in joint else "120.5,90.0" for joint in joints)
    assert not plain(tmp_path / "pixels.csv", [pixels] * 5, header).is_share
    nobody = ",".join("-1,-1" for _ in joints)
    assert not plain(tmp_path / "seldom.csv", [pixels, *[nobody] * 9], header).is_share


def test_coco_says_the_order_of_its_joints_and_boxes_hold_nothing(tmp_path: Path) -> None:
    """A data set of our own, right before left: sides were exchanged."""
    order = [joint.replace("left", "?").replace("right", "left").replace("?", "right") for joint in MODELS["coco_17"]]
    annotations: list[dict[str, Any]] = [
        {"image_id": k, "keypoints": [x for joint in order for x in (*place(joint), 2)]} for k in range(3)
    ]
    annotations.append({"image_id": 1, "bbox": [0, 0, 9, 9]})
    path = tmp_path / "coco.json"
    path.write_text(json.dumps({"categories": [{"keypoints": order}], "annotations": annotations}), "utf-8")
    is_right(read_keypoints(path))


def test_a_frame_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    path = mmpose(tmp_path / "a.json", list(MODELS["coco_17"]), about=False)
    path.write_text(path.read_text("utf-8").replace('"frame_id": 2', '"frame_id": 1'), "utf-8")
    with pytest.raises(pt.InputError, match="frame 1 is there twice"):
        read_keypoints(path)
