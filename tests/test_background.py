"""The scene without the person, where nobody filmed it: what the video's median holds of them is filled in."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from test_people import WRISTS, errors

import pytracker as pt
from pytracker.evidence.background import median_background, read_background, without_person
from pytracker.formats.video import Frame, Image, frames
from pytracker.rotation import Array

NO_SHADOW = 70
"""Of 255: shadows of simulated people differ by less from what they lie on, people mostly by more."""


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> pt.BodyRecording:
    folder = tmp_path_factory.mktemp("background") / "body"
    recording = pt.load(pt.simulate_body(folder, pt.BodyScene(duration_s=2.0), seed=3))
    assert isinstance(recording, pt.BodyRecording)
    return recording


def first_of(recording: pt.BodyRecording) -> tuple[Image, Array]:
    """The first frame, and the ends of all bones in it."""
    assert recording.view.video is not None
    starts, ends, _ = recording.skeleton.core.pose(recording.initial[None])
    return next(frames(recording.view.video)).image, np.stack([starts[0], ends[0]], axis=1)


def apart(image: Image, other: Image) -> Array:
    return np.asarray(cv2.absdiff(image, other).max(axis=2), dtype=float)


def test_who_stands_still_is_taken_out_of_the_median(filmed: pt.BodyRecording) -> None:
    view = filmed.view
    assert view.video is not None
    assert view.background is not None
    scene, median = read_background(view.background), median_background(frames(view.video))
    first, bones = first_of(filmed)
    filled = without_person(median, first, view.camera, bones)
    # Their shadow stays: it is none of them, and nothing shows what it lies on.
    held, left = (apart(image, scene) >= NO_SHADOW for image in (median, filled))
    assert held.mean() > 0.05
    assert left.mean() < 0.05 * held.mean()
    np.testing.assert_array_equal(filled, without_person(median, first, view.camera, bones))


def test_a_median_without_the_person_stays(filmed: pt.BodyRecording) -> None:
    """They walked away from where they stood at first."""
    view = filmed.view
    assert view.background is not None
    scene = read_background(view.background)
    first, bones = first_of(filmed)

    def mostly_away() -> Iterator[Frame]:
        for k in range(9):
            yield Frame(k, k / 30, first if k < 3 else scene)

    filled = without_person(median_background(mostly_away()), first, view.camera, bones)
    assert (apart(filled, scene) >= 26).mean() < 0.01


def test_who_is_not_in_the_picture_takes_nothing_out(filmed: pt.BodyRecording) -> None:
    first, bones = first_of(filmed)
    beside = bones + np.array([50.0, 0.0, 0.0])
    np.testing.assert_array_equal(without_person(first, first, filmed.view.camera, beside), first)


@pytest.mark.parametrize("number", ["24", "31"])
def test_real_people_are_tracked_without_a_background(
    number: str, tmp_path: Path, shared: Callable[[str], Path]
) -> None:
    """With the person in the median wrists were valid in 58 % of the frames, and the first pose was doubted."""
    source, folder = shared(f"recordings/people-gesture-{number}"), tmp_path / number
    shutil.copytree(source, folder, copy_function=shutil.copy)
    lines = (folder / "recording.toml").read_text("utf-8").splitlines()
    (folder / "recording.toml").write_text("\n".join(x for x in lines if not x.startswith("background")), "utf-8")
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    track = pt.track(recording, pt.BodySmooth(), 1)
    off = errors(recording, source, {name: track.joints[name].mean for name in WRISTS}, WRISTS)
    assert np.median(off[0]) < 0.10
    assert np.mean([track.joints[name].valid.mean() for name in WRISTS]) > 0.7
    assert not any("foreground" in doubt for doubt in pt.doubts(track))
