"""The scene without the person, where nobody filmed it: what the video's median holds of them is filled in."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from test_people import WRISTS, errors

import pytracker as pt
from pytracker.evidence.picture.background import median_of, read_background, sampled, without_person
from pytracker.evidence.picture.left_behind import draw, left_behind
from pytracker.formats.video import Image, frames
from pytracker.rotation import Array

NO_SHADOW = 70
"""Of 255: shadows of simulated people differ by less from what they lie on, people mostly by more."""


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> pt.BodyRecording:
    folder = tmp_path_factory.mktemp("background") / "body"
    recording = pt.load(pt.simulate_body(folder, pt.BodyScene(duration_s=2.0), seed=3))
    assert isinstance(recording, pt.BodyRecording)
    return recording


def first_of(recording: pt.BodyRecording) -> tuple[Image, Array, NDArray[np.bool_]]:
    """The first frame, the ends of all bones in it, and which are of either forearm and hand."""
    assert recording.view.video is not None
    starts, ends, _ = recording.skeleton.core.pose(recording.initial[None])
    hands = np.stack([recording.skeleton.below(forearm) for forearm in ("lradius", "rradius")])
    return next(frames(recording.view.video)).image, np.stack([starts[0], ends[0]], axis=1), hands


def apart(image: Image, other: Image) -> Array:
    return np.asarray(cv2.absdiff(image, other).max(axis=2), dtype=float)


def test_who_stands_still_is_taken_out_of_the_median(filmed: pt.BodyRecording) -> None:
    view = filmed.view
    assert view.video is not None
    assert view.background is not None
    scene, samples = read_background(view.background), sampled(frames(view.video))
    first, bones, hands = first_of(filmed)
    filled = without_person(samples, first, view.camera, bones, hands)
    # Their shadow stays: it is none of them, and nothing shows what it lies on.
    held, left = (apart(image, scene) >= NO_SHADOW for image in (median_of(samples), filled))
    assert held.mean() > 0.05
    assert left.mean() < 0.05 * held.mean()
    np.testing.assert_array_equal(filled, without_person(samples, first, view.camera, bones, hands))


def test_what_is_of_their_colours_far_beside_them_takes_nothing_of_them(filmed: pt.BodyRecording) -> None:
    """Wooden doors, and who else is in the room: the person was taken for background, and no frame was valid."""
    view = filmed.view
    assert view.video is not None
    assert view.background is not None
    first, bones, hands = first_of(filmed)
    scene, height, width = read_background(view.background), *first.shape[:2]
    theirs = first[apart(first, scene) >= NO_SHADOW]
    # As many pixels of every colour of theirs, beyond the wall beside them.
    door = theirs[np.arange(height * width) % len(theirs)].reshape(first.shape)
    wide = [np.hstack([image, scene[:, ::-1], door]) for image in (first, *sampled(frames(view.video)))]
    filled = without_person(wide[1:], wide[0], view.camera, bones, hands)[:, :width]
    held, left = (apart(image, scene) >= NO_SHADOW for image in (median_of(wide)[:, :width], filled))
    assert left.mean() < 0.05 * held.mean()


def test_a_median_without_the_person_stays(filmed: pt.BodyRecording) -> None:
    """They walked away from where they stood at first."""
    view = filmed.view
    assert view.background is not None
    scene = read_background(view.background)
    first, bones, hands = first_of(filmed)
    filled = without_person([first] * 3 + [scene] * 6, first, view.camera, bones, hands)
    assert (apart(filled, scene) >= 26).mean() < 0.01


def test_who_is_not_in_the_picture_takes_nothing_out(filmed: pt.BodyRecording) -> None:
    first, bones, hands = first_of(filmed)
    beside = bones + np.array([50.0, 0.0, 0.0])
    np.testing.assert_array_equal(without_person([first], first, filmed.view.camera, beside, hands), first)


@pytest.mark.parametrize("leaves", [True, False])
def test_what_stays_where_a_hand_was_is_background(leaves: bool, filmed: pt.BodyRecording) -> None:
    """A box of skin's colour beside a hand that is raised was foreground, and drew it: 18 to 39 cm off, all valid."""
    view = filmed.view
    assert view.background is not None
    scene, (first, bones, hands) = read_background(view.background), first_of(filmed)
    (u, v), px = view.camera.project(bones[hands[1]][-1:, 1])[0], float(view.camera.px_per_m(bones[:1, 0])[0])
    skin = first[round(v), round(u)]
    outward = np.sign(u - view.camera.project(bones[:1, 0])[0, 0])
    box = sorted(round(u + outward * m * px) for m in (0.08, 0.28))
    where = (slice(round(v - 0.15 * px), round(v + 0.15 * px)), slice(*box))
    is_there = np.zeros(first.shape[:2], dtype=bool)
    is_there[where] = True
    person = cv2.dilate((apart(first, scene) >= 26).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0

    def with_box(image: Image, hidden: NDArray[np.bool_]) -> Image:
        return np.where((is_there & ~hidden)[..., None], skin, image)

    about = np.zeros(first.shape[:2], dtype=np.uint8)
    for hand in hands:
        draw(about, view.camera, bones[hand], 0.3, 1)
    without_hands = np.where((about > 0)[..., None], scene, first)
    raised = with_box(without_hands, np.zeros_like(is_there)) if leaves else with_box(first, person)
    samples = [with_box(first, person)] * 5 + [raised] * 4
    near = is_there & ~person & (about > 0)
    stays = left_behind(samples, with_box(first, person), person | is_there, view.camera, bones, hands)
    # A hand that never moves is there as the box is: nothing tells the two apart.
    assert near.any()
    assert stays[near].mean() > 0.5 if leaves else not stays[near].any()
    if leaves:
        filled = without_person(samples, with_box(first, person), view.camera, bones, hands)
        kept = apart(filled, with_box(scene, np.zeros_like(is_there))) < 26
        assert kept[is_there & ~person].mean() > 0.95


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
