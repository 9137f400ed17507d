"""Bodies tracked by a detector's keypoints, without the video that they were found in."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE
from test_body_senses import load, with_keypoints, without
from test_people import KEPT_BACK, WRISTS, errors

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.evidence.pose.points_borne_out import median_off_m, worst_arm_off_m
from pytracker.rotation import Array
from pytracker.setup import check

OTHER_SIDE = [0, 2, 1, 4, 3, 6, 5, 8, 7]
"""Of `pytracker.evidence.KEYPOINTS`, left for right."""


def alone(folder: Path, to: Path, size: str, rate_hz: float) -> Path:
    """The same folder with its keypoints, and no video."""
    shutil.copytree(folder, to, ignore=shutil.ignore_patterns("*.mp4", "*.png"))
    lines = (to / "recording.toml").read_text("utf-8").splitlines()
    kept = [line for line in lines if not line.startswith(("video", "background"))]
    kept.insert(kept.index("[[camera]]") + 1, f"size_px = {size}\nrate_hz = {rate_hz}")
    (to / "recording.toml").write_text("\n".join(kept) + "\n", "utf-8")
    return to


def test_keypoints_alone_are_tracked(sensed: Path, tmp_path: Path) -> None:
    folder = alone(sensed, tmp_path / "alone", "[320, 240]", 30.0)
    recording = without(load(folder), imus=2)
    assert recording.view.video is None
    track = pt.track(recording, pt.Partitioned(), 1)
    assert len(track.time_s) == len(pt.track(without(load(sensed)), pt.Partitioned(particles=20)).time_s)
    assert track.valid.mean() > 0.95
    off = pt.evaluate(track, recording.truth).joints
    assert np.mean([off[joint].average_m for joint in WRISTS]) < 0.2
    out = pt.write_report([track], tmp_path / "report")
    page = (out / "index.html").read_text("utf-8")
    assert "There was no video, only keypoints of one." in page
    assert not (out / "overlay.webm").exists()
    assert pt.doubts(track) == ()
    (video,) = (finding for finding in check(folder).findings if finding.what == "video")
    assert (video.verdict, video.evidence[:13]) == ("cannot be told", "there is none")
    # Without sensors: frames' times differ by rounding, and a sample at such a time comes before or after its frame.
    seen, unseen = (pt.track(without(load(of)), pt.BodyMixture()) for of in (sensed, folder))
    # Wild ones are left out where skin tells; where none is they are the same.
    assert np.allclose(seen.joints["root"].mean[0], unseen.joints["root"].mean[0], atol=1e-6)
    apart = np.linalg.norm(seen.joints["left_wrist"].mean - unseen.joints["left_wrist"].mean, axis=1)
    assert np.median(apart) < 0.01
    assert pt.record_cycle(recording, pt.Partitioned(), 1, frame=40).frame == 40
    with pytest.raises(
        pt.InputError, match="BodyPlain weighs by what a video shows and the recording has keypoints alone"
    ):
        pt.track(recording, pt.BodyPlain())
    with pytest.raises(pt.InputError, match="BodyPlain weighs by"):
        pt.record_cycle(recording, pt.BodyPlain(), 1, frame=40)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("rate_hz = 30.0\n", "", "camera[0].rate_hz is missing, expected it where there is no video"),
        ("size_px = [320, 240]\n", "", "camera[0].size_px is missing"),
        ("keypoints", "# keypoints", "camera[0] has neither, expected video or keypoints"),
        ("size_px = [320, 240]", "size_px = [100, 80]", "of the keypoints lie outside the 100 x 80 px"),
        ("rate_hz", 'background = "b.png"\nrate_hz', "camera[0].background goes with a video"),
    ],
)
def test_what_keypoints_alone_need_is_named(sensed: Path, tmp_path: Path, old: str, new: str, expected: str) -> None:
    path = alone(sensed, tmp_path / "alone", "[320, 240]", 30.0) / "recording.toml"
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    with pytest.raises(pt.InputError) as error:
        pt.load(path.parent)
    assert expected in str(error.value)


def changed_points(recording: pt.BodyRecording, change: Callable[[Any, Array], None]) -> pt.BodyRecording:
    """`change` gets frames and points `(T, P, 9, 3)`, to be changed in place."""
    keypoints = recording.view.keypoints
    assert keypoints is not None
    points = keypoints.points.copy()
    change(keypoints.frames, points)
    view = dataclasses.replace(recording.view, keypoints=dataclasses.replace(keypoints, points=points))
    return dataclasses.replace(recording, view=view)


def test_keypoints_alone_that_do_not_bear_the_pose_out_are_told(sensed: Path, tmp_path: Path) -> None:
    recording = without(load(alone(sensed, tmp_path / "alone", "[320, 240]", 30.0)))

    def shifted(frames: Any, points: Array) -> None:
        points[frames >= 30, ..., 0] += 120.0

    def head_only(frames: Any, points: Array) -> None:
        points[frames >= 30, :, 1:] = np.nan

    def narrow(frames: Any, points: Array) -> None:
        points[..., 0] *= 0.6

    def nobody(frames: Any, points: Array) -> None:
        points[(frames >= 40) & (frames < 60)] = np.nan

    for change, first, words in (
        (shifted, 40, "no keypoints of the arms"),
        (head_only, 40, "no keypoints of the arms"),
        (nobody, 50, "no keypoints of the arms"),
    ):
        track = pt.track(changed_points(recording, change), pt.Partitioned(), 1)
        assert words in track.reason[first]
        assert track.valid[:28].mean() > 0.9
    (doubt,) = pt.doubts(pt.track(changed_points(recording, shifted), pt.Partitioned(), 1))
    assert "frames, first in frame 30, keypoints are of somebody else than the first pose's person" in doubt
    (doubt,) = pt.doubts(pt.track(changed_points(recording, narrow), pt.Partitioned(), 1))
    assert re.search(r"the keypoints of an arm lie \d+ cm beside the first pose, expected at most 7 cm", doubt)


def test_one_arm_that_is_elsewhere_at_first_is_told(sensed: Path) -> None:
    """Of both arms together it was not: the wrist was 15 cm off, half of it valid and wrong."""
    recording = load(sensed)
    joints = {name: places[0] for name, places in recording.skeleton.joints(recording.initial[None]).items()}
    points = np.full((len(KEYPOINTS), 3), np.nan)
    for row, name in enumerate(KEYPOINTS):
        if name in joints:
            points[row] = [*recording.view.camera.project(joints[name][None])[0], 1.0]
    assert worst_arm_off_m(recording.view.camera, joints, points) < 0.01
    for joint in ("left_elbow", "left_wrist"):
        points[KEYPOINTS.index(joint), 0] += 0.3 * float(recording.view.camera.px_per_m(joints[joint][None])[0])
    assert worst_arm_off_m(recording.view.camera, joints, points) == pytest.approx(0.3, abs=0.01)
    assert median_off_m(recording.view.camera, joints, points) < 0.01


@pytest.mark.parametrize(
    ("method", "of", "words"),
    [
        (pt.Partitioned(), slice(30, 60), "first in frame 30"),
        (pt.BodySmooth(), slice(None), "mirror"),
        *([(pt.Partitioned(), slice(None), "mirror")] if IS_ACCEPTANCE else []),
        *([(pt.BodySmooth(), slice(30, 60), "first in frame 30")] if IS_ACCEPTANCE else []),
    ],
)
def test_left_and_right_that_a_detector_exchanges_are_put_right(
    sensed: Path, tmp_path: Path, of: slice, words: str, method: pt.Partitioned
) -> None:
    """With a picture and without."""

    def exchanged(_: Any, points: Array) -> None:
        points[of] = points[of][..., OTHER_SIDE, :]

    points_alone = alone(sensed, tmp_path / "alone", "[320, 240]", 30.0)
    for folder in (sensed, points_alone) if IS_ACCEPTANCE or not isinstance(method, pt.BodySmooth) else (points_alone,):
        recording = without(load(folder))
        right, track = (pt.track(r, method, 1) for r in (recording, changed_points(recording, exchanged)))
        off_m, usual_m = (
            np.mean([pt.evaluate(of, recording.truth).joints[joint].across_m for joint in WRISTS])
            for of in (track, right)
        )
        assert off_m < usual_m + 0.01
        assert track.valid.mean() > right.valid.mean() - 0.05
        (doubt,) = pt.doubts(track)
        assert "left and right of the keypoints are exchanged" in doubt
        assert words in doubt
        assert not track.points_exchanged[:30].any() or of == slice(None)


def test_keypoints_alone_are_counted_as_their_files_are(sensed: Path, tmp_path: Path) -> None:
    folder = alone(sensed, tmp_path / "alone", "[320, 240]", 30.0)
    keypoints = load(folder).view.keypoints
    assert keypoints is not None
    (folder / "keypoints.csv").unlink()
    text = (folder / "recording.toml").read_text("utf-8").replace("keypoints.csv", "alphapose.json")
    (folder / "recording.toml").write_text(text, "utf-8")

    def write(numbers: list[int]) -> None:
        """As AlphaPose does: a list of people, of frames in which there are any."""
        people = []
        for number, points in zip(numbers, keypoints.points[:, 0], strict=False):
            coco = np.zeros((17, 3))
            coco[[0, *range(5, 13)]] = np.nan_to_num(points)
            people.append({"image_id": f"{number}.jpg", "keypoints": coco.ravel().tolist()})
        (folder / "alphapose.json").write_text(json.dumps(people), "utf-8")

    count = len(keypoints.frames)
    write(list(range(20, 20 + count)))
    recording = load(folder)
    assert any("the keypoints begin at frame 20" in words for words in recording.warnings)
    times = [observed.time_s for observed in recording.observations() if observed.is_frame]
    assert times[0] == 0.0
    assert times[-1] == pytest.approx((19 + count) / 30.0)
    write(list(range(1, 1 + count)))
    assert len([observed for observed in load(folder).observations() if observed.is_frame]) == count
    write([*range(count - 1), 9_999_999])
    with pytest.raises(pt.InputError, match="of the frames 0 to 9999999, expected most of them: a stray file"):
        load(folder)


def test_people_by_keypoints_alone(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """Real people, nothing tuned on these clips, and no picture of them."""
    wrists = []
    for number in KEPT_BACK:
        folder = shared(f"recordings/people-gesture-{number}")
        table = next(shared("data/people/gestures").glob(f"0_1_{number}_*mediapipe*"))
        with_keypoints(folder, table, tmp_path / number)
        recording = load(alone(tmp_path / number, tmp_path / f"{number}-alone", "[270, 480]", 60.0))
        joints = {name: rows.mean for name, rows in pt.track(recording, pt.Partitioned(), 1).joints.items()}
        wrists.append(errors(recording, folder, joints, WRISTS))
    off, across = np.concatenate(wrists, axis=1)
    assert np.median(off) < 0.08
    assert np.median(across) < 0.035
    assert (across > 0.20).mean() < 0.01
