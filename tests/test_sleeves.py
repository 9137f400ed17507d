"""Who wears long sleeves: the face must not pass for their hands."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from conftest import load_body

import pytracker as pt
from pytracker.evidence.picture.background import read_background
from pytracker.evidence.picture.silhouette import Silhouette
from pytracker.evidence.pose.borne_out import NOT_BARE, BorneOut
from pytracker.formats.truth_csv import read_truth_csv
from pytracker.formats.video import Image, frames
from pytracker.rotation import Array

SLEEVE = (195, 200, 200)
FRAMES = 120


def sleeved(image: Image, arms: list[Array]) -> Image:
    """Skin is cloth along polylines `(3, 2)`, px, from shoulder to elbow to wrist, shaded as it was."""
    luma, red, _ = cv2.split(cv2.cvtColor(image, cv2.COLOR_BGR2YCrCb))
    along = np.zeros(image.shape[:2], np.uint8)
    for arm in arms:
        cv2.polylines(along, [np.rint(arm).astype(np.int32)], False, 1, 18)
    cloth = cv2.dilate(((red > 133) & (along > 0)).astype(np.uint8), np.ones((3, 3), np.uint8)) * along > 0
    shaded = np.clip(luma[..., None] / 128.0 * np.array(SLEEVE), 0, 255)
    return np.where(cloth[..., None], shaded, image).astype(np.uint8)


@pytest.mark.parametrize("number", ["20", "33"])
def test_of_people_in_long_sleeves_no_wrist_is_lost_and_valid(
    shared: Callable[[str], Path], tmp_path: Path, number: str
) -> None:
    """Their faces were taken for their hands: half to four fifths were valid, 20 to 30 cm off, and no word of it."""
    folder, copy = shared(f"recordings/people-gesture-{number}"), tmp_path / "recording"
    bare = load_body(folder)
    shutil.copytree(folder, copy)
    truth, view = read_truth_csv(folder / "truth.csv").positions_m, bare.view
    assert view.video is not None
    arms = [
        np.stack([view.camera.project(truth[f"{side}_{joint}"]) for joint in ("shoulder", "elbow", "wrist")], axis=1)
        for side in ("left", "right")
    ]
    first = next(frames(view.video)).image
    (copy / "video.avi").unlink()
    size = (first.shape[1], first.shape[0])
    writer = cv2.VideoWriter(str(copy / "video.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 60.0, size)
    for k, frame in zip(range(FRAMES), frames(view.video), strict=False):
        writer.write(sleeved(frame.image, [arm[k] for arm in arms]))
    writer.release()
    track = pt.track(load_body(copy), pt.Partitioned(), 1)
    assert np.mean([NOT_BARE in words for words in track.reason]) > 0.4
    for wrist in ("left_wrist", "right_wrist"):
        off_m = np.linalg.norm(track.joints[wrist].mean - truth[wrist][:FRAMES], axis=1)
        assert (track.valid & (off_m > 0.2)).mean() < 0.05


@pytest.fixture(scope="module")
def watched(simulated_body: Path) -> tuple[pt.BodyRecording, Silhouette]:
    recording = load_body(simulated_body)
    assert recording.view.background is not None
    root = recording.skeleton.joints(recording.initial[None])["root"]
    background = read_background(recording.view.background)
    return recording, Silhouette(background, float(recording.camera.px_per_m(root)[0]))


@pytest.mark.parametrize("where", ["bare", "sleeved", "at the face"])
def test_an_arm_is_borne_out_by_skin_that_is_not_the_faces(
    watched: tuple[pt.BodyRecording, Silhouette], where: str
) -> None:
    recording, silhouette = watched
    assert recording.view.video is not None
    joints = {name: rows[0] for name, rows in recording.skeleton.joints(recording.initial[None]).items()}
    evidence = silhouette(next(frames(recording.view.video)).image)
    assert evidence.skin_region is not None
    if where == "sleeved":
        distance_px, points = evidence.skin_region
        v, u = np.indices(distance_px.shape)
        head = recording.camera.project(joints["head"][None])[0]
        face = np.hypot(u - head[0], v - head[1]).astype(np.float32)
        evidence = replace(evidence, skin_region=(face, points[:1]))
    elif where == "at the face":
        shoulder = joints["left_shoulder"]
        up = joints["head"] - 0.5 * (joints["left_shoulder"] + joints["right_shoulder"])
        joints |= {"left_elbow": joints["head"] - 0.6 * up, "left_wrist": joints["head"], "left_shoulder": shoulder}
    looked = BorneOut(recording.camera, joints)
    said = [looked.look(k / 30, joints, {name: np.full(3, 0.02) for name in joints}, evidence) for k in range(10)][-1]
    assert (said.get("left_wrist") == NOT_BARE) == (where != "bare")
