"""Whether a person stands out from the background, and the rest of the picture does not."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

import pytracker as pt
from pytracker.evidence.picture.largest import largest_person
from pytracker.evidence.pose.stands_out import EVERYWHERE, HARDLY
from pytracker.formats.video import frames
from pytracker.formats.video_write import VideoWriter


def changed(folder: Path, true: Path, light: float, contrast: float, from_frame: int = 0) -> pt.BodyRecording:
    """A recording whose pictures differ from the background by so much of it, in such a light, from a frame on."""
    shutil.copytree(true, folder)
    background = np.asarray(cv2.imread(str(true / "background.png")), dtype=np.float64)
    with VideoWriter(folder / "video.avi", "MJPG", 25.0, (background.shape[1], background.shape[0])) as writer:
        for frame in frames(next(true.glob("video.*"))):
            seen = background + contrast * (frame.image - background) if frame.index >= from_frame else frame.image
            lit = light if frame.index >= from_frame else 1.0
            writer.write(np.clip(np.rint(lit * seen), 0, 255).astype(np.uint8))
    file = folder / "recording.toml"
    file.write_text(file.read_text("utf-8").replace("video.mp4", "video.avi"), "utf-8")
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    return recording


def test_a_person_who_hardly_differs_from_the_wall_is_told(simulated_body: Path, tmp_path: Path) -> None:
    """Of people half as different from the wall wrists were 9 to 58 cm off, valid, and nothing was said."""
    track = pt.track(changed(tmp_path / "like", simulated_body, 1.0, 0.12), pt.Partitioned(particles=50))
    assert "lie on the foreground, expected 65% at least" in pt.doubts(track)[0]
    assert track.valid.mean() < 0.2
    assert any(HARDLY in why for why in track.reason)


@pytest.mark.parametrize(("number", "contrast", "is_told"), [("22", 0.5, True), ("31", 0.5, True), ("31", 1.0, False)])
def test_real_people_half_as_different_from_the_wall_are_told(
    shared: Callable[[str], Path], tmp_path: Path, number: str, contrast: float, is_told: bool
) -> None:
    """Their wrists were 56 and 25 cm off, the latter valid in 95 % of the frames."""
    clip = shared(f"recordings/people-gesture-{number}")
    said = pt.doubts(pt.track(changed(tmp_path / number, clip, 1.0, contrast), pt.Partitioned(particles=50)))
    assert any("lie on the foreground, expected 65% at least" in words for words in said) == is_told


@pytest.mark.parametrize("from_frame", [0, 5])
def test_a_picture_that_differs_everywhere_is_told(simulated_body: Path, tmp_path: Path, from_frame: int) -> None:
    """The first pose's head was said to be a metre off, or nothing at all."""
    recording = changed(tmp_path / "lit", simulated_body, 1.5, 1.0, from_frame)
    track = pt.track(recording, pt.Partitioned(particles=50))
    (words,) = (words for words in pt.doubts(track) if "a person: did the light change" in words)
    assert f"first in frame {from_frame}, " in words
    assert not any(EVERYWHERE in why for why in track.reason[:from_frame])
    assert all(EVERYWHERE in why for why in track.reason[from_frame:])


def test_who_comes_in_later_is_told(simulated_body: Path, tmp_path: Path) -> None:
    recording = changed(tmp_path / "late", simulated_body, 1.0, 1.0, 0)
    background = np.asarray(cv2.imread(str(simulated_body / "background.png")), dtype=np.uint8)
    assert recording.view.video is not None
    seen = [frame.image for frame in frames(recording.view.video)]
    with VideoWriter(tmp_path / "late" / "video.avi", "MJPG", 25.0, background.shape[1::-1]) as writer:
        for number, image in enumerate(seen):
            writer.write(background if number < 10 else image)
    loaded = pt.load(tmp_path / "late")
    (words,) = pt.doubts(pt.track(loaded, pt.Partitioned(particles=50)))
    assert "at the first frame 0% of the pose's trunk and arms lie on the foreground" in words
    assert "somebody is there: does the person come in later?" in words


def test_a_dark_first_frame_is_no_person() -> None:
    background = np.full((120, 90, 3), 150, np.uint8)
    with pytest.raises(
        pt.InputError, match=r"100% of the first frame differs from the background, .* is that frame dark"
    ):
        largest_person(np.zeros_like(background), background, 1.7)
