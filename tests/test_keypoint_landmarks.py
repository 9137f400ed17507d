"""Keypoints as MediaPipe's users write them as JSON, and as YOLO does: every layout, and what is wrong in one."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_keypoints import is_right, place

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.models import COCO, MODELS
from pytracker.formats.keypoints.read import read_keypoints

SIZE = 400.0
"""Of the picture, px, where places are shares of it."""


def landmarks(share: float = 1.0) -> list[dict[str, float]]:
    """BlazePose's 33."""
    places = [place(joint) for joint in MODELS["blazepose_33"]]
    return [{"x": x * share, "y": y * share, "z": -0.1, "visibility": 0.9} for x, y in places]


def named() -> dict[str, dict[str, float]]:
    return {name.upper(): one for name, one in zip(MODELS["blazepose_33"], landmarks(), strict=True)}


def numbered() -> list[dict[str, float]]:
    return [{"id": k, **one} for k, one in enumerate(landmarks())]


def numbers() -> list[list[float]]:
    """As lists of x, y, z and visibility."""
    return [list(one.values()) for one in landmarks()]


def columns() -> dict[str, list[float]]:
    """Of COCO's joints all x, all y and how sure each is, as Ultralytics' `to_json` has them."""
    x, y = zip(*(place(joint) for joint in COCO), strict=True)
    return {"x": [*x], "y": [*y], "visible": [0.8] * len(COCO)}


WORLD = [{"x": 0.1, "y": 0.2, "z": 0.3, "visibility": 1.0}] * 33
PARTS = [
    {"part": joint, "position": dict(zip("xy", place(joint), strict=True)), "score": 0.8} for joint in reversed(COCO)
]


@pytest.mark.parametrize(
    "frames",
    [
        [{"frame": k, "landmarks": landmarks()} for k in range(3)],
        [{"frame_index": k, "world_landmarks": WORLD, "pose_landmarks": landmarks()} for k in range(3)],
        [{"timestamp_ms": 40 * k, "landmarks": [landmarks()], "hand_landmarks": [[]]} for k in range(3)],
        [{"frame": k, "pose": {"landmark": landmarks()}} for k in range(3)],
        [landmarks()] * 3,
        [named()] * 3,
        [{"frame": k, "keypoints": PARTS} for k in range(3)],
        {"fps": 30, "size": [640, 480], "frames": [{"frame": k, "landmarks": landmarks()} for k in range(3)]},
        {str(k): landmarks() for k in (2, 0, 1)},
        {f"frame_{k}": {"landmarks": named()} for k in range(3)},
        {"fps": 30, "data": {"frames": {str(k): landmarks() for k in range(3)}}},
        {"world_landmarks": [WORLD] * 3, "landmarks": [landmarks()] * 3},
        [[{"frame": k, "landmarks": landmarks()} for k in range(3)]],
        [{"frame": k, "lh": WORLD[:21], "pose_3d": WORLD, "pose_landmarks": landmarks()} for k in range(3)],
        [{"frame": k, "landmarks": dict(sorted(named().items()))} for k in range(3)],
        {f"{0.04 * k:.3f}": landmarks() for k in (2, 0, 1)},
        [numbers()] * 3,
        [[one[:3] for one in numbers()]] * 3,
        {"frames": [{"frame": k, "landmarks": numbers()} for k in range(3)]},
        [[{"name": "person", "box": {"x1": 1.0, "y1": 2.0}, "keypoints": columns()}] for _ in range(3)],
        [{"frame": k, "landmarks": numbered()[k:] + numbered()[:k]} for k in range(3)],
        [{"frame": k, "landmarks": {str(n): one for n, one in enumerate(landmarks())}} for k in range(3)],
        [{"frame": k, "keypoints": PARTS[k:] + PARTS[:k]} for k in range(3)],
        [{"frame": k, "landmarks": numbered()[: 25 + k]} for k in range(3)],
    ],
)
def test_every_layout_of_landmarks(tmp_path: Path, frames: Any) -> None:
    (tmp_path / "pose.json").write_text(json.dumps(frames), "utf-8")
    is_right(read_keypoints(tmp_path / "pose.json"))


def test_frames_and_times_are_those_of_the_records(tmp_path: Path) -> None:
    path = tmp_path / "pose.json"
    path.write_text(json.dumps([{"frame": k, "landmarks": landmarks(1 / SIZE) if k != 7 else []} for k in (3, 7, 9)]))
    keypoints = read_keypoints(path)
    assert keypoints.frames.tolist() == [3, 7, 9]
    assert keypoints.is_share
    assert np.isfinite(keypoints.points[..., 0]).all(axis=(1, 2)).tolist() == [True, False, True]
    path.write_text(json.dumps([{"timestamp_ms": t, "landmarks": None if t else landmarks()} for t in (0, 33, 67)]))
    keypoints = read_keypoints(path)
    assert keypoints.time_s is not None
    assert np.allclose(keypoints.time_s, [0.0, 0.033, 0.067])
    path.write_text(json.dumps({"10.0": landmarks(), "9.96": landmarks()}))
    keypoints = read_keypoints(path)
    assert keypoints.time_s is not None
    assert np.allclose(keypoints.time_s, [9.96, 10.0])
    dates = ("2026-12-01T23:59:59.980", "2026-12-02 00:00:00.020000Z")
    path.write_text(json.dumps([{"time": date, "landmarks": landmarks()} for date in dates]))
    keypoints = read_keypoints(path)
    assert keypoints.time_s is not None
    assert np.allclose(keypoints.time_s, [0.0, 0.04], atol=1e-6)
    assert "its first row is taken to be the first frame's" in keypoints.warnings[0]


def test_a_file_a_frame(tmp_path: Path) -> None:
    for k in range(3):
        by_name = {"landmarks": dict(sorted(named().items()))}
        (tmp_path / f"frame_{k:05d}.json").write_text(json.dumps(by_name), "utf-8")
    is_right(read_keypoints(tmp_path))
    (tmp_path / "frame_00003.json").write_text("{}", "utf-8")
    keypoints = read_keypoints(tmp_path)
    assert np.isfinite(keypoints.points[..., 0]).all(axis=(1, 2)).tolist() == [True, True, True, False]


@pytest.mark.parametrize(
    "people",
    [
        [landmarks(), landmarks()],
        {"0": landmarks(), "1": landmarks()},
        {"person_0": {"landmarks": landmarks()}, "person_1": {"landmarks": landmarks()}},
    ],
)
def test_nobody_of_several_is_lost(tmp_path: Path, people: Any) -> None:
    path = tmp_path / "pose.json"
    path.write_text(json.dumps([{"frame": k, "people": people} for k in range(3)]))
    keypoints = read_keypoints(path)
    assert keypoints.points.shape[:2] == (3, 2)
    assert np.isfinite(keypoints.points[..., 0]).all()


@pytest.mark.parametrize("nobody", [{"frame": 1}, {"frame": 1, "detected": False}, {"frame": 1, "landmarks": {}}, None])
def test_frames_without_anybody(tmp_path: Path, nobody: Any) -> None:
    path = tmp_path / "pose.jsonl.json"
    frames = [{"frame": 0, "landmarks": landmarks()}, nobody, {"frame": 2, "landmarks": landmarks()}]
    path.write_text("\n".join(map(json.dumps, frames)), "utf-8")
    keypoints = read_keypoints(path)
    assert keypoints.frames.tolist() == ([0, 1, 2] if nobody else [0, 2])
    assert np.isfinite(keypoints.points[[0, -1], :, :, 0]).all()


def yolo(parts: int, after: str = "") -> str:
    """A person's line."""
    joints = [[x / SIZE, y / SIZE, 0.9][:parts] for x, y in map(place, COCO)]
    return "0 0.5 0.5 0.2 0.9 " + " ".join(f"{value:.6f}" for joint in joints for value in joint) + after + "\n"


@pytest.mark.parametrize(("parts", "after"), [(3, ""), (3, " 0.87"), (3, " 0.87 1"), (2, ""), (2, " 0.87")])
def test_yolo(tmp_path: Path, parts: int, after: str) -> None:
    (tmp_path / "classes.txt").write_text("person\nball\n")
    (tmp_path / "clip_4.txt").write_text("32 0.5 0.5 0.1 0.1\n")
    (tmp_path / "clip_5.txt").touch()
    for k in (1, 2, 10):
        (tmp_path / f"clip_{k}.txt").write_text(2 * yolo(parts, after), "utf-8")
    keypoints = read_keypoints(tmp_path)
    assert keypoints.frames.tolist() == [0, 1, 3, 4, 9]
    keypoints = dataclasses.replace(keypoints, points=keypoints.points[[0, 1, 4]])
    assert keypoints.is_share
    assert keypoints.points.shape[1] == 2
    left_wrist = keypoints.points[:, 0, KEYPOINTS.index("left_wrist"), :2]
    assert np.allclose(left_wrist * SIZE, place("left_wrist"), atol=1e-3)


def test_what_is_wrong_is_named(tmp_path: Path) -> None:
    path = tmp_path / "pose.json"
    path.write_text(json.dumps([{"frame": 0, "landmarks": landmarks()}, {"frame": 1, "landmarks": [[1, 2]]}]))
    with pytest.raises(pt.InputError, match=r"pose.json: entry 1 of the frames holds no landmarks with x and y"):
        read_keypoints(path)
    path.write_text(json.dumps([[*landmarks()[:32], {"x": "left", "y": 1}]]))
    with pytest.raises(pt.InputError, match=r"pose.json: a landmark is \{'x': 'left', 'y': 1\}, expected numbers"):
        read_keypoints(path)
    path.write_text(json.dumps([landmarks()[:20]]))
    with pytest.raises(pt.InputError, match=r"people have 20 keypoints, expected"):
        read_keypoints(path)
    path.write_text(json.dumps({name: [{"frame": 0, "landmarks": landmarks()}] for name in ("person_0", "person_1")}))
    with pytest.raises(pt.InputError, match=r"has several lists of frames \(person_0, person_1\), expected one"):
        read_keypoints(path)
    path.write_text(json.dumps([{"keypoints": {"x": [1, 2], "y": [3]}}] * 2 + [{"keypoints": columns()}]))
    with pytest.raises(pt.InputError, match=r"entry 0 of the frames holds no landmarks with x and y"):
        read_keypoints(path)
    path.write_text(json.dumps([[{"name": "tail", **one}] for one in landmarks()[:3]]))
    with pytest.raises(pt.InputError, match=r"landmarks are called tail, expected such as left_wrist"):
        read_keypoints(path)
    labels = tmp_path / "labels"
    labels.mkdir()
    (labels / "clip_1.txt").write_text(yolo(3) + "0 0.5 0.5 0.2 0.9\n", "utf-8")
    with pytest.raises(pt.InputError, match=r"clip_1.txt:2: a person has 5 numbers, expected a box and COCO's 17"):
        read_keypoints(labels)
