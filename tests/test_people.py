"""Real people with truth: the default must beat the first pose, held, and say where it does not know."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE

import pytracker as pt
from pytracker.evidence.picture.background import read_background
from pytracker.evidence.picture.silhouette import Silhouette
from pytracker.evidence.pose.borne_out import BorneOut
from pytracker.formats.truth_csv import read_truth_csv
from pytracker.formats.video import frames
from pytracker.report.body.overlay import UNSURE, draw_body
from pytracker.rotation import Array
from pytracker.setup import Checkup, check, init
from pytracker.tracking import BodyTrack

KEPT_BACK = ("21", "24", "31")
PREPARED = KEPT_BACK if IS_ACCEPTANCE else KEPT_BACK[1:2]
"""Those that are made ready from their files: the worst, and another."""
WRISTS = ("left_wrist", "right_wrist")


def errors(recording: pt.BodyRecording, folder: Path, joints: dict[str, Array], names: tuple[str, ...]) -> Array:
    """3-D error and error across the picture of each joint and frame, m `(2, J * T)`."""
    truth = read_truth_csv(folder / "truth.csv").positions_m
    camera = recording.view.camera
    assert isinstance(camera, pt.Camera)
    found = []
    for name in names:
        off = joints[name] - truth[name][: len(joints[name])]
        ray = truth[name][: len(off)] - camera.position_m
        ray /= np.linalg.norm(ray, axis=1, keepdims=True)
        across = off - (off * ray).sum(axis=1, keepdims=True) * ray
        found.append(np.stack([np.linalg.norm(off, axis=1), np.linalg.norm(across, axis=1)]))
    return np.concatenate(found, axis=1)


@pytest.fixture(scope="module")
def tracked(shared_people: list[Path]) -> list[tuple[Path, BodyTrack]]:
    tracks = []
    for folder in shared_people:
        recording = pt.load(folder)
        assert isinstance(recording, pt.BodyRecording)
        tracks.append((folder, pt.track(recording, pt.Partitioned(), 1)))
    return tracks


@pytest.fixture(scope="module")
def shared_people(shared: Callable[[str], Path]) -> list[Path]:
    """The clips on which nothing was tuned; 20, 22, 29 and 33 were used for that."""
    return [shared(f"recordings/people-gesture-{number}") for number in KEPT_BACK]


def test_wrists_are_followed_where_the_held_pose_loses_them(tracked: list[tuple[Path, BodyTrack]]) -> None:
    """Before, with blobs alone: 19 cm, 16 % lost; the first pose held 14 cm, 26 % lost."""
    ours, held = [], []
    for folder, track in tracked:
        recording = track.recording
        ours.append(errors(recording, folder, {n: track.joints[n].mean for n in WRISTS}, WRISTS))
        first = recording.skeleton.joints(recording.initial[None])
        still = {name: np.repeat(first[name], len(track.time_s), axis=0) for name in WRISTS}
        held.append(errors(recording, folder, still, WRISTS))
    (off, across), (still_off, still_across) = np.concatenate(ours, axis=1), np.concatenate(held, axis=1)
    assert np.median(off) < 0.125
    assert np.median(across) < 0.06
    assert (across > 0.20).mean() < 0.05
    assert np.median(off) < np.median(still_off)
    assert (across > 0.20).mean() < 0.3 * (still_across > 0.20).mean()


def test_bands_hold_real_wrists_and_elbows(tracked: list[tuple[Path, BodyTrack]]) -> None:
    inside = []
    for folder, track in tracked:
        truth = read_truth_csv(folder / "truth.csv").positions_m
        for name in (*WRISTS, "left_elbow", "right_elbow"):
            joint = track.joints[name]
            at = truth[name][: len(joint.mean)]
            inside.append(((joint.lo <= at) & (at <= joint.hi)).mean(axis=0))
    assert np.mean(inside, axis=0).min() > 0.7


def test_frames_are_valid_while_the_track_is_right(tracked: list[tuple[Path, BodyTrack]]) -> None:
    assert np.mean([track.valid.mean() for _, track in tracked]) > 0.6


def test_a_pose_beside_the_person_is_told(body: pt.BodyRecording) -> None:
    """Joints a quarter of a metre beside where they are."""
    assert body.view.background is not None
    assert body.view.video is not None
    root = body.skeleton.joints(body.initial[None])["root"]
    silhouette = Silhouette(read_background(body.view.background), float(body.view.camera.px_per_m(root)[0]))
    joints = {name: rows[0] for name, rows in body.skeleton.joints(body.initial[None]).items()}
    sure = {name: np.full(3, 0.02) for name in joints}
    evidence = silhouette(next(frames(body.view.video)).image)
    for shift, told in ((0.0, False), (0.35, True)):
        looked = BorneOut(body.view.camera, joints)
        moved = {name: at + np.array([shift, 0.0, 0.0]) for name, at in joints.items()}
        said = [looked.look(k / 30, moved, sure, evidence) for k in range(10)]
        assert bool(said[-1]) == told
    unsure = {name: np.full(3, 0.2) for name in joints}
    looked = BorneOut(body.view.camera, joints)
    said_unsure = looked.look(0.0, joints, unsure, replace(evidence, skin_region=None))
    assert said_unsure == dict.fromkeys(WRISTS, "not known across the picture")


def test_a_wrist_that_is_lost_is_mostly_said_so(shared: Callable[[str], Path]) -> None:
    """Folded arms, the worst of the clips: one hand is taken for the other. It was used for tuning."""
    folder = shared("recordings/people-gesture-33")
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    lost, valid = [], []
    for seed in (1, 2, 3):
        track = pt.track(recording, pt.Partitioned(), seed)
        for name in WRISTS:
            (_, across) = errors(recording, folder, {name: track.joints[name].mean}, (name,))
            lost.append(across > 0.20)
            valid.append(track.joints[name].valid)
        frame_valid = track.joints["left_wrist"].valid & track.joints["right_wrist"].valid
        assert not track.valid[~frame_valid].any()
    is_lost, is_valid = np.concatenate(lost), np.concatenate(valid)
    # 31 % were, and 35 % of the others were doubted, until it was known how people hold their arms.
    assert is_lost.mean() < 0.15
    assert (~is_valid)[is_lost].mean() > 0.9
    assert (~is_valid)[~is_lost].mean() < 0.6


def test_a_forearm_whose_wrist_is_not_known_is_drawn_so(tracked: list[tuple[Path, BodyTrack]]) -> None:
    _, track = tracked[0]
    unsure = replace(track.joints["left_wrist"], reason=("not known across the picture",) * len(track.time_s))
    known = replace(track.joints["left_wrist"], reason=())
    video = track.recording.view.video
    assert video is not None
    image = next(frames(video)).image
    orange = []
    for wrist in (known, unsure):
        joints = dict(track.joints) | {
            "left_wrist": wrist,
            "right_wrist": replace(track.joints["right_wrist"], reason=()),
        }
        drawn = draw_body(image.copy(), replace(track, joints=joints), 0)
        orange.append(int((drawn == UNSURE).all(axis=2).sum()))
    assert orange[0] == 0
    assert orange[1] > 20


@pytest.mark.parametrize("scale", [1.1, 1.2])
def test_points_that_are_too_large_are_told(simulated_body: Path, tmp_path: Path, scale: float) -> None:
    """The camera that is fitted to them sees a person who is too small, and elsewhere; by a fifth it was not told."""
    folder = shutil.copytree(simulated_body, tmp_path / "large")
    right = pt.track(pt.load(folder), pt.Partitioned(particles=50))
    assert pt.doubts(right) == ()
    path = folder / "points.csv"
    header, *lines = path.read_text().splitlines()
    rows = [line.split(",") for line in lines]
    scaled = [",".join([*(f"{scale * float(x):.5f}" for x in row[:3]), *row[3:]]) for row in rows]
    path.write_text("\n".join([header, *scaled]) + "\n")
    (words,) = pt.doubts(pt.track(pt.load(folder), pt.Partitioned(particles=50)))
    assert re.search(r"at the first frame .*the person's head is \d", words)


def test_of_people_that_are_described_rightly_nothing_is_said(tracked: list[tuple[Path, BodyTrack]]) -> None:
    for _, track in tracked:
        assert pt.doubts(track) == ()


def tracked_by(checkup: Checkup) -> tuple[pt.BodyRecording, BodyTrack]:
    """What was written, loaded, and its track by the default method."""
    assert isinstance(checkup.track, BodyTrack)
    assert isinstance(checkup.track.method, pt.BodySmooth)
    return checkup.track.recording, checkup.track


def test_people_before_a_camera_that_nobody_calibrated(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """Video, keypoints and height alone; it looks down by 20 degrees. Wrists and elbows from between the shoulders.

    Measured on all seven: wrists 4.7 to 9.9 cm, elbows 3.2 to 9.6, the first pose held 8 to 42; with a camera that is
    taken to be level 25 and 24 on clip 24.
    """
    clips, off, still = shared("data/people/gestures"), [], []
    for number in PREPARED:
        prepared = pt.load(shared(f"recordings/people-gesture-{number}"))
        assert isinstance(prepared, pt.BodyRecording)
        folder, keypoints = tmp_path / number, next(clips.glob(f"0_1_{number}_*mediapipe*"))
        path = init(folder, video=next(clips.glob(f"0_1_{number}_*.avi")), keypoints=keypoints)
        path.write_text(path.read_text().replace("# height_m = 1.70", "height_m = 1.57"))
        checkup = check(folder, write=True)
        (pitch,) = (one for one in checkup.findings if one.what == "camera's pitch")
        assert "looks down by about 2" in pitch.evidence
        recording, track = tracked_by(checkup)
        truth = read_truth_csv(shared(f"recordings/people-gesture-{number}") / "truth.csv").positions_m
        count = min(len(track.time_s), len(truth["root"]))
        ours = from_shoulders({name: joint.mean[:count] for name, joint in track.joints.items()}, recording)
        theirs = from_shoulders({name: at[:count] for name, at in truth.items()}, prepared)
        for joint in (*WRISTS, "left_elbow", "right_elbow"):
            off.append(np.linalg.norm(ours[joint] - theirs[joint], axis=1))
            still.append(np.linalg.norm(ours[joint][0] - theirs[joint], axis=1))
    assert np.nanmedian(np.concatenate(off)) < min(0.09, 0.75 * np.nanmedian(np.concatenate(still)))
    assert max(np.nanmedian(one) for one in off) < 0.2


def test_people_before_their_own_calibrated_camera(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """A calibration whose x axis is up, a camera that looks along another: places in the room, as the camera has them.

    Measured on all seven: wrists 4.9 to 7.0 cm, elbows 4.8 to 8.2, bands 97 %; wrists 8 to 30 while the root was free
    along the world's axes.
    """
    clips, off, held = shared("data/people/gestures"), [], []
    for number in PREPARED:
        prepared = pt.load(shared(f"recordings/people-gesture-{number}"))
        assert isinstance(prepared, pt.BodyRecording)
        video, keypoints = (next(clips.glob(f"0_1_{number}_*{ending}")) for ending in (".avi", "mediapipe*"))
        path = init(
            tmp_path / number, video=video, keypoints=keypoints, camera=clips / "Calib_board.toml", camera_name="cam2"
        )
        path.write_text(path.read_text().replace("# height_m = 1.70", "height_m = 1.57"))
        recording, track = tracked_by(check(path.parent, write=True))
        assert track.valid.mean() > 0.9
        truth = read_truth_csv(shared(f"recordings/people-gesture-{number}") / "truth.csv").positions_m
        for joint in (*WRISTS, "left_elbow", "right_elbow"):
            theirs = as_seen(truth[joint][: len(track.time_s)], prepared)
            ours = as_seen(track.joints[joint].mean[: len(theirs)], recording)
            off.append(np.linalg.norm(ours - theirs, axis=1))
            held.append(np.linalg.norm(ours[0] - theirs, axis=1))
    assert np.nanmedian(np.concatenate(off)) < min(0.08, 0.75 * np.nanmedian(np.concatenate(held)))
    assert max(np.nanmedian(one) for one in off) < 0.2


def as_seen(places: Array, recording: pt.BodyRecording) -> Array:
    """World to camera, m."""
    camera = recording.view.camera
    assert isinstance(camera, pt.Camera)
    return np.asarray(places @ np.array(camera.rotation).T + np.array(camera.translation_m))


def from_shoulders(joints: dict[str, Array], recording: pt.BodyRecording) -> dict[str, Array]:
    """Joints seen from the camera, from the middle of the shoulders."""
    camera = recording.view.camera
    assert isinstance(camera, pt.Camera)
    middle = 0.5 * (joints["left_shoulder"] + joints["right_shoulder"])
    return {name: (at - middle) @ np.array(camera.rotation).T for name, at in joints.items()}
