"""A camera that is bumped or held by hand is told; people who move before one that stands are not."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.video import frames
from pytracker.formats.video_steady import CameraMoves, camera_moves
from pytracker.tracking.camera_moved import MOVED


def filmed_anew(video: Path, to: Path, beside_px: Callable[[int], tuple[float, float]]) -> Path:
    """The same video by a camera that shows everything so far beside, frame by frame."""
    images = [frame.image for frame in frames(video)]
    height, width = images[0].shape[:2]
    writer = cv2.VideoWriter(str(to), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (width, height))
    for k, image in enumerate(images):
        u, v = beside_px(k)
        turn = np.array([[1.0, 0.0, u], [0.0, 1.0, v]])
        writer.write(cv2.warpAffine(image, turn, (width, height), borderMode=cv2.BORDER_REPLICATE))
    writer.release()
    return to


@pytest.mark.parametrize(
    "beside_px",
    [
        lambda k: (0.0 if k < 40 else 30.0, 0.0),
        lambda k: (8 * np.sin(k / 10), 5 * np.cos(k / 13)),
        lambda k: (0.0, 0.1 * k),
        lambda k: (0.0 if k < 40 else 150.0, 20.0 if k < 40 else 0.0),
    ],
    ids=["bumped", "by hand", "sinks", "bumped far"],
)
def test_a_camera_that_moves_is_told(
    simulated: Path, tmp_path: Path, beside_px: Callable[[int], tuple[float, float]]
) -> None:
    """40 px halfway: wrists were 9 cm off with bands that held half of it, and nothing said so."""
    folder = shutil.copytree(simulated, tmp_path / "moves")
    filmed_anew(simulated / "video.mp4", folder / "moves.avi", beside_px)
    path = folder / "recording.toml"
    path.write_text(path.read_text("utf-8").replace("video.mp4", "moves.avi"), "utf-8")
    said = [words for words in pt.load(folder).warnings if "the camera moves: at" in words]
    assert len(said) == 1
    assert "px beside where it was at first" in said[0]


def test_a_camera_that_stands_still_is_not(simulated: Path, simulated_body: Path, tmp_path: Path) -> None:
    for folder in (simulated, simulated_body):
        assert camera_moves(folder / "video.mp4").words == ""
    again = filmed_anew(simulated / "video.mp4", tmp_path / "again.avi", lambda k: (0.0, 0.0))
    assert camera_moves(again).words == ""


def test_of_people_before_cameras_on_stands_nothing_is_said(shared: Callable[[str], Path]) -> None:
    videos = [*shared("data/people/gestures").glob("*.avi"), *shared("data/video/asl").glob("*.mkv")]
    assert len(videos) > 20
    assert [video.name for video in videos if camera_moves(video).words] == []


def test_where_nothing_tells_it_is_as_it_was_told_last(simulated: Path, tmp_path: Path) -> None:
    """A camera that drifted on until nothing could be compared was taken to have come back."""
    images = [frame.image for frame in frames(filmed_anew(simulated / "video.mp4", tmp_path / "a.avi", bumped))]
    writer = cv2.VideoWriter(str(tmp_path / "b.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, images[0].shape[1::-1])
    for k, image in enumerate(images):
        writer.write(image if k < 0.7 * len(images) else np.full_like(image, 90))
    writer.release()
    moves = camera_moves(tmp_path / "b.avi")
    assert min(moves.moved_px[-2:]) > 25.0


def bumped(k: int) -> tuple[float, float]:
    return (0.0 if k < 20 else 30.0, 0.0)


def test_frames_of_a_camera_that_was_bumped_are_not_valid(simulated: Path, tmp_path: Path) -> None:
    """They were all valid, as far off as the camera moved, and more."""
    folder = shutil.copytree(simulated, tmp_path / "moves")
    filmed_anew(simulated / "video.mp4", folder / "moves.avi", lambda k: (0.0 if k < 40 else 30.0, 0.0))
    path = folder / "recording.toml"
    path.write_text(path.read_text("utf-8").replace("video.mp4", "moves.avi"), "utf-8")
    track = pt.track(pt.load(folder), pt.Smooth(), 1)
    assert all(MOVED in words for words in track.reason[40:])
    assert not any(MOVED in words for words in track.reason[:35])


def test_nor_are_a_bodys(body: pt.BodyRecording) -> None:
    """There and back: between two looks it may be as at either."""
    moves = CameraMoves(time_s=(0.0, 0.5, 1.0, 1.5), moved_px=(0.0, 2.0, 20.0, 2.0), longer_px=320)
    moved = dataclasses.replace(body, view=dataclasses.replace(body.view, moves=moves))
    track = pt.track(moved, pt.Partitioned(particles=100), 1)
    said = np.array([MOVED in words for words in track.reason])
    assert (said == ((track.time_s > 0.5) & (track.time_s < 1.5))).all()
    assert not track.valid[said].any()


def test_what_is_not_told_in_words_makes_no_frame_invalid() -> None:
    """A person who is small in a large picture: 3 cm are less than what is told at all."""
    moves = CameraMoves(time_s=(0.0, 1.0, 2.0), moved_px=(0.0, 5.0, 12.0), longer_px=1920)
    assert moves.are_beside(np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0]), 2.0).tolist() == [
        False,
        False,
        False,
        True,
        True,
        True,
    ]
    assert "at 2.0 s" in moves.words
