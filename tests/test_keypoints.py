"""Keypoints of a detector: which files load, what is refused, what a confidence is worth."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.models import MODELS, name_of
from pytracker.formats.keypoints.read import Keypoints, read_keypoints
from pytracker.formats.video import VideoInfo
from pytracker.recording.keypoints.load import in_pixels, uncovered, unseen

INFO = VideoInfo(width=640, height=480, frame_count=3, rate_hz=30.0)


def place(joint: str) -> tuple[float, float]:
    """Where a joint is put in these files, px."""
    if joint in KEYPOINTS:
        k = KEYPOINTS.index(joint)
        return 100.0 + 10.0 * k, 200.0 - 5.0 * k
    if joint == "neck":
        left, right = place("left_shoulder"), place("right_shoulder")
        return 0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1])
    if joint in ("left_ear", "right_ear"):
        return (95.0, 200.0) if joint == "left_ear" else (105.0, 200.0)
    return 300.0 + 3.0 * (len(joint) % 7), 320.0


def person(model: str, confidence: float = 0.9) -> list[float]:
    return [value for joint in MODELS[model] for value in (*place(joint), confidence)]


def openpose(folder: Path, people: list[list[float]], frames: int = 3, first: int = 0) -> Path:
    folder.mkdir()
    for k in range(first, first + frames):
        data = {"version": 1.3, "people": [{"pose_keypoints_2d": one} for one in people]}
        (folder / f"clip_{k:012d}_keypoints.json").write_text(json.dumps(data), "utf-8")
    return folder


def is_right(keypoints: Keypoints, frames: int = 3) -> None:
    """Every joint is where it was put."""
    assert keypoints.points.shape[0] == frames
    for k, joint in enumerate(KEYPOINTS):
        assert np.allclose(keypoints.points[:, 0, k, :2], place(joint)), joint


@pytest.mark.parametrize("model", list(MODELS))
def test_every_order_of_joints_is_told_by_its_length_and_where_the_neck_is(tmp_path: Path, model: str) -> None:
    folder = openpose(tmp_path / "kp", [person(model)])
    is_right(read_keypoints(folder))
    is_right(read_keypoints(folder, model))
    assert set(KEYPOINTS) <= {*MODELS[model], "head"}


def test_a_list_of_coco_results_and_mmpose_are_read(tmp_path: Path) -> None:
    flat = person("coco_17")
    coco = [{"image_id": f"{k}.jpg", "keypoints": flat, "score": 1.0} for k in range(3)]
    (tmp_path / "coco.json").write_text(json.dumps(coco), "utf-8")
    is_right(read_keypoints(tmp_path / "coco.json"))
    instance = {"keypoints": [flat[k : k + 2] for k in range(0, 51, 3)], "keypoint_scores": flat[2::3]}
    frames = [{"frame_id": k, "instances": [instance, instance]} for k in (1, 2, 3)]
    (tmp_path / "mmpose.json").write_text(json.dumps({"meta_info": {}, "instance_info": frames}), "utf-8")
    found = read_keypoints(tmp_path / "mmpose.json")
    is_right(found)
    assert found.points.shape[1] == 2
    # Counted from one in a video of three frames.
    assert in_pixels(tmp_path, found, tmp_path / "v.mp4", INFO).frames.tolist() == [0, 1, 2]


def test_tables_are_read_by_the_names_of_their_columns(tmp_path: Path) -> None:
    joints = [*KEYPOINTS, "left_knee"]
    plain = ",".join(f"{joint}_{axis}" for joint in joints for axis in ("x", "y", "confidence"))
    row = ",".join(f"{place(joint)[0]},{place(joint)[1]},0.8" for joint in joints)
    (tmp_path / "plain.csv").write_text("\n".join(["frame," + plain, *(f"{k},{row}" for k in range(3))]), "utf-8")
    is_right(read_keypoints(tmp_path / "plain.csv"))
    heads = [["scorer", *["net"] * 30], ["bodyparts", *[j for j in joints for _ in "xyl"]]]
    heads.append(["coords", *["x", "y", "likelihood"] * 10])
    (tmp_path / "dlc.csv").write_text(
        "\n".join([*(",".join(head) for head in heads), *(f"img{k}.png,{row}" for k in range(3))]), "utf-8"
    )
    is_right(read_keypoints(tmp_path / "dlc.csv"))
    media = ",".join(f"{axis}_{joint.upper()}" for joint in joints[1:] for axis in ("X", "Y", "Z", "visibility"))
    shares = [((x + 0.5) / 640, (y + 0.5) / 480) for x, y in map(place, joints[1:])]
    row = ",".join(f"{u},{v},0.1,0.99" for u, v in shares)
    (tmp_path / "media.csv").write_text("\n".join(["time," + media, *(f"{k},{row}" for k in range(3))]), "utf-8")
    found = in_pixels(tmp_path, read_keypoints(tmp_path / "media.csv"), tmp_path / "v.mp4", INFO)
    assert np.allclose(found.points[:, 0, 1, :2], place("left_shoulder"))


def test_cocos_annotations_are_of_the_frames_that_their_files_name(tmp_path: Path) -> None:
    """A data set numbers its pictures anyhow."""
    images = [{"id": 9000 - k, "file_name": f"clip/frame_{k:04d}.png"} for k in range(3)]
    annotations = [{"image_id": 9000 - k, "keypoints": person("coco_17")} for k in range(3)]
    path = tmp_path / "coco.json"
    path.write_text(json.dumps({"images": images, "annotations": annotations}), "utf-8")
    keypoints = read_keypoints(path)
    is_right(keypoints)
    assert keypoints.frames.tolist() == [0, 1, 2]


def test_cocos_annotations_of_images_that_are_not_listed_are_refused(tmp_path: Path) -> None:
    """They were laid into other frames, as a second person, and both left out: 88 of 232 frames."""
    images = [{"id": 9000 - k, "file_name": f"clip/frame_{k:04d}.png"} for k in range(3)]
    annotations = [{"image_id": number, "keypoints": person("coco_17")} for number in (9000, 8999, 2)]
    path = tmp_path / "coco.json"
    path.write_text(json.dumps({"images": images, "annotations": annotations}), "utf-8")
    with pytest.raises(pt.InputError, match="of image_id 2, which is not among those of the 3 images of the file"):
        read_keypoints(path)
    # Listed, but its file's name is no number: the id is, and is another picture's.
    images[2] = {"id": 1, "file_name": "clip/last.png"}
    annotations[2]["image_id"] = 1
    path.write_text(json.dumps({"images": images, "annotations": annotations}), "utf-8")
    with pytest.raises(pt.InputError, match="are both of frame 1, expected one a frame"):
        read_keypoints(path)


@pytest.mark.parametrize(
    ("images", "ids"),
    [
        ([{"id": k, "file_name": f"{k:06d}.jpg"} for k in range(3)], ["000000", "000001", "000002"]),
        ([{"id": k, "file_name": f"{k:06d}.jpg"} for k in range(3)], ["000000.jpg", "000001.jpg", "000002.jpg"]),
        ([{"id": float(k), "file_name": f"{k:06d}.jpg"} for k in range(3)], [0, 1, 2]),
        ([{"file_name": f"{k:06d}.jpg"} for k in range(3)], [0, 1, 2]),
        ([{"id": 7 - k, "file_name": f"{k:06d}.jpg"} for k in range(3)], ["007", "006", "005"]),
    ],
    ids=["zeros", "names", "floats", "without ids", "other numbers"],
)
def test_an_id_may_be_written_otherwise(tmp_path: Path, images: list[dict[str, object]], ids: list[object]) -> None:
    annotations = [{"image_id": one, "keypoints": person("coco_17")} for one in ids]
    path = tmp_path / "coco.json"
    path.write_text(json.dumps({"images": images, "annotations": annotations}), "utf-8")
    assert read_keypoints(path).frames.tolist() == [0, 1, 2]


def sports2d(path: Path, scale: float = 1.0) -> Path:
    """As Sports2D writes what it saw: its unit says m, whatever it is."""
    names = {"Hip": "hip", "RWrist": "right_wrist", "LWrist": "left_wrist", "Head": "head_top", "Nose": "head"}
    for side, of in (("R", "right"), ("L", "left")):
        names |= {f"{side}{joint.title()}": f"{of}_{joint}" for joint in ("shoulder", "elbow", "hip")}
    lines = [
        "PathFileType\t4\t(X/Y/Z)\tclip_px_person00.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"30\t30\t3\t{len(names)}\tm\t30\t0\t3",
        "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
        "\t\t" + "\t".join(f"X{k + 1}\tY{k + 1}\tZ{k + 1}" for k in range(len(names))),
        "",
    ]
    for k in range(3):
        cells = [f"{scale * v}" for joint in names.values() for v in (*place(joint), 0.0)]
        lines.append("\t".join([str(k + 12), f"{(k + 12) / 30:.6f}", *cells]))
    path.write_text("\n".join(lines) + "\n")
    return path


def test_sports2d_in_pixels(tmp_path: Path) -> None:
    keypoints = read_keypoints(sports2d(tmp_path / "clip_px_person00.trc"))
    is_right(keypoints)
    assert keypoints.time_s == pytest.approx(np.array([12, 13, 14]) / 30, abs=1e-6)
    path = tmp_path / "clip_px_person00.trc"
    path.write_text(path.read_text().replace("\t3\t", "\t5\t", 1))
    assert "NumFrames is 5, and 3 rows follow: the file is cut short" in " ".join(read_keypoints(path).warnings)
    with pytest.raises(pt.InputError, match=r"clip_m_person00.trc: is in metres, expected pixels"):
        read_keypoints(sports2d(tmp_path / "clip_m_person00.trc", 1e-3))


@pytest.mark.parametrize(
    ("words", "expected"),
    [("LShoulder", "left_shoulder"), ("R.Wrist", "right_wrist"), ("shoulder_left", "left_shoulder"), ("Nose", "nose"),
     ("LEFT_EAR", "left_ear"), ("elbow", "other_elbow"), ("LEye", "left_eye"), ("CHip", "other_chip")],
)  # fmt: skip
def test_a_name_is_known_however_it_is_written(words: str, expected: str) -> None:
    assert name_of(words) in (expected, expected.removeprefix("other_"))
    assert (name_of(words) in KEYPOINTS) == (expected in KEYPOINTS)


def folder(path: Path) -> Path:
    path.mkdir()
    return path


def write(path: Path, text: str) -> Path:
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda p: p / "none", "no such file or folder, expected keypoints"),
        (lambda p: p, "holds no .json file, expected one a frame"),
        (lambda p: write(folder(p / "cam1_json") / "1.json", "{}").parents[1], "cam1_json below it do"),
        (lambda p: write(p / "a.h5", "x"), "a.h5: is no table of DeepLabCut's that can be read"),
        (lambda p: write(p / "a.xml", "x"), "keypoints as .xml are not read"),
        (lambda p: write(p / "a.json", "{"), "a.json: is not JSON"),
        (lambda p: write(p / "a.json", "[" * 100000), "a.json: is not JSON"),
        (lambda p: write(p / "a.json", "3"), "is neither MMPose's, COCO's"),
        (lambda p: write(p / "a.json", "[{}]"), "entry 0 has no image_id"),
        (lambda p: write(p / "a.json", '[{"image_id": 1.5, "keypoints": []}]'), "a frame is '1.5', expected a frame"),
        (lambda p: write(p / "a.json", '[{"image_id": 1, "keypoints": [1, 2]}]'), "expected x, y and confidence"),
        (lambda p: write(p / "a.json", '[{"image_id": 1, "keypoints": [1, 2, 1e999]}]'), "keypoints hold inf"),
        (lambda p: write(p / "a.json", '[{"image_id": 1, "keypoints": [1, 2, 3]}]'), "have 1 keypoints, expected 9"),
        (lambda p: write(p / "a.json", '{"instance_info": [{"instances": [{}]}]}'), "a frame has no instances"),
        (lambda p: openpose(p / "kp", []), "nobody is seen in any of 3 frames"),
        (lambda p: openpose(p / "kp", [person("coco_17"), person("body_25")]), r"people have \[17, 25\] keypoints"),
        (lambda p: write(p / "a.csv", "a,b\n1,2"), "a.csv:1: header names no joint"),
        (lambda p: write(p / "a.csv", "left_wrist_x,left_wrist_y\n1"), "a.csv:2: row has 1 cells, expected 2"),
        (lambda p: write(p / "a.csv", "left_wrist_x,left_wrist_y\n1,b"), "a.csv:2: a keypoint is 'b'"),
        (lambda p: write(p / "a.csv", "left_wrist_x,left_wrist_y\n,"), "has a header but no rows"),
        (lambda p: write(p / "a.csv", "left_wrist_x,left_wrist_y\nnan,1"), "no joint is seen in any of 1 frames"),
        (lambda p: write(p / "a.csv", "head_x,head_y,head_confidence\n5,1,0"), "every confidence is 0"),
        (lambda p: write(p / "a.csv", "head_x,head_y,head_confidence\n5,1,"), "every confidence is empty"),
        (lambda p: openpose(p / "kp", [person("coco_17", 0.0)]), "every confidence is 0, .* in any of 3 frames"),
        (lambda p: write(p / "a.csv", "scorer,a\nbodyparts,b"), "has no rows of bodyparts and coords"),
    ],
)  # fmt: skip
def test_what_is_no_keypoints_is_refused_by_name(tmp_path: Path, make: Callable[[Path], Path], expected: str) -> None:
    with pytest.raises(pt.InputError, match=expected):
        read_keypoints(make(tmp_path))


ODD = st.none() | st.floats() | st.text(max_size=5)


@given(ODD | st.lists(ODD | st.lists(ODD, max_size=3), max_size=3))
def test_no_json_ends_in_another_error(tmp_path_factory: pytest.TempPathFactory, value: Any) -> None:
    path = tmp_path_factory.mktemp("json") / "a.json"
    for data in (
        value,
        {"instance_info": value},
        {"annotations": value},
        [{"image_id": value, "keypoints": value}],
        [{"frame": value, "landmarks": [{"x": value, "y": [value]}] * 33}],
        [[[[[[value]]]]]],
    ):
        path.write_text(json.dumps(data), "utf-8")
        with pytest.raises(pt.InputError):
            read_keypoints(path)


def test_keypoints_of_another_video_are_refused(tmp_path: Path) -> None:
    keypoints = read_keypoints(openpose(tmp_path / "kp", [person("coco_17")], frames=5))
    with pytest.raises(pt.InputError, match=r"has frame 4, expected below the 3 frames of .*v.mp4"):
        in_pixels(tmp_path, keypoints, tmp_path / "v.mp4", INFO)
    small = VideoInfo(width=120, height=90, frame_count=5, rate_hz=30.0)
    with pytest.raises(pt.InputError, match=r"100% of the keypoints lie outside the 120 x 90 px"):
        in_pixels(tmp_path, keypoints, tmp_path / "v.mp4", small)


@pytest.mark.parametrize(("count", "model"), [(17, "coco_17"), (136, "halpe_136"), (135, "body_135")])
@pytest.mark.parametrize("layout", ["list", "instance_info", "people"])
def test_a_folder_of_a_file_a_frame(tmp_path: Path, count: int, model: str, layout: str) -> None:
    wrist = MODELS[model].index("left_wrist")
    for frame in range(3):
        points = [[10.0 + k, 20.0 + k + frame] for k in range(count)]
        if layout == "people":
            data: Any = {"people": [{"pose_keypoints_2d": [x for point in points for x in (*point, 0.9)]}]}
        else:
            people = [{"keypoints": points, "keypoint_scores": [0.9] * count}]
            data = people if layout == "list" else {"meta_info": {}, "instance_info": people}
        (tmp_path / f"{frame:05d}.json").write_text(json.dumps(data), "utf-8")
    found = read_keypoints(tmp_path).points[:, 0, KEYPOINTS.index("left_wrist")]
    assert found.tolist() == [[10 + wrist, 20 + wrist + frame, 0.9] for frame in range(3)]


def test_what_people_wrote_loads(shared: Callable[[str], Path]) -> None:
    """OpenPose's BODY_25B of four cameras: its neck is told from BODY_25's; MediaPipe's table of a clip."""
    trial = shared("data/people/pose2sim_truth/S00_P00_SingleParticipant/S00_P00_T01_BalancingTrial/pose")
    for camera in sorted(trial.iterdir()):
        found = read_keypoints(camera)
        assert len(found.frames) == 100
        shoulders, hips = found.points[:, 0, 1:3, 1].mean(axis=1), found.points[:, 0, 7:9, 1].mean(axis=1)
        assert np.nanmedian(hips - shoulders) > 50  # px, downwards
    clips = shared("data/people/gestures")
    assert len(read_keypoints(next(clips.glob("0_1_20*mediapipe*"))).frames) == 232


def test_keypoints_of_every_second_frame_are_told() -> None:
    points = np.zeros((60, 1, len(KEYPOINTS), 3))
    (said,) = uncovered(Path("k.csv"), Keypoints(np.arange(60), points), VideoInfo(320, 240, 121, 60.0))
    assert "of one frame in 2 (a column frame says which)?" in said


def test_keypoints_that_are_missing_within_are_told() -> None:
    """A third of a folder's files: nothing was said, as it begins and ends with the video."""
    points, info = np.zeros((120, 1, len(KEYPOINTS), 3)), VideoInfo(320, 240, 120, 60.0)
    assert uncovered(Path("k"), Keypoints(np.arange(120), points), info) == ()
    some = np.delete(np.arange(120), np.arange(40, 80))
    (said,) = uncovered(Path("k"), Keypoints(some, points[some]), info)
    assert "no keypoints in frames 40 to 79" in said
    nobody = points.copy()
    nobody[40:80] = np.nan
    assert uncovered(Path("k"), Keypoints(np.arange(120), nobody), info) == (said,)
    nobody[:] = 0.0
    nobody[70:] = np.nan
    (said,) = uncovered(Path("k"), Keypoints(np.arange(120), nobody), info)
    assert "are of frames 0 to 69, and the video has 120" in said
    often = np.zeros((480, 1, len(KEYPOINTS), 3))
    for k in range(100, 400, 80):
        often[k : k + 30] = np.nan
    (said,) = uncovered(Path("k"), Keypoints(np.arange(480), often), VideoInfo(320, 240, 480, 60.0))
    assert "in 120 frames, 100 to 129 among them" in said


def test_arms_that_a_detector_never_saw_are_named() -> None:
    points = np.ones((4, 1, len(KEYPOINTS), 3))
    assert unseen(Path("k.csv"), Keypoints(np.arange(4), points)) == ()
    points[:, :, [KEYPOINTS.index("right_elbow"), KEYPOINTS.index("right_wrist")]] = np.nan
    (said,) = unseen(Path("k.csv"), Keypoints(np.arange(4), points))
    assert "k.csv: keypoints have no right_elbow, right_wrist in any frame" in said


def test_confidences_in_per_cent_are_shares_of_one(tmp_path: Path) -> None:
    """They were all one class: nothing was a guess, and somebody else's points were blamed."""
    rows = ["left_wrist_x,left_wrist_y,left_wrist_confidence,left_elbow_x,left_elbow_y,left_elbow_confidence"]
    rows += [f"{100 + k},200,{40 + 2 * k},120,{220 + k},95" for k in range(20)]
    path = tmp_path / "k.csv"
    path.write_text("\n".join(rows))
    found = read_keypoints(path)
    assert float(np.nanmax(found.points[..., 2])) == pytest.approx(0.95)
    assert float(np.nanmin(found.points[..., 2])) == pytest.approx(0.4)
    assert found.warnings == (f"{path}: confidences reach to 95: taken as per cent",)
