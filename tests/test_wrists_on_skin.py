"""Keypoints of wrists that lie beside all skin, as detectors guess hands that they do not see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest
from test_body_senses import load, with_keypoints, with_points, without

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.evidence.picture.silhouette import Silhouette
from pytracker.evidence.points.on_skin import LEAST_FRAMES, WristsOnSkin
from pytracker.evidence.senses import Senses, senses_of
from pytracker.formats.video import frames

PX_PER_M = 100.0
LEFT, RIGHT, HIP = (KEYPOINTS.index(name) for name in ("left_wrist", "right_wrist", "left_hip"))


def region(*hands: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Distances from skin, px `(120, 160)`, and places on it, of hands at these pixels."""
    mask = np.full((120, 160), 255, np.uint8)
    for hand in hands:
        cv2.circle(mask, hand, 4, 0, -1)
    return cv2.distanceTransform(mask, cv2.DIST_L2, 5), np.argwhere(mask == 0)[:, ::-1].astype(float)


def points(left: tuple[float, float], right: tuple[float, float]) -> np.ndarray:
    """Of a person before the camera, elbows 25 px beside the middle."""
    places = [(75, 5), (60, 20), (90, 20), (55, 45), (95, 45), left, right, (65, 100), (85, 100)]
    return np.column_stack([places, np.ones(9)]).astype(float)


RIGHT_ONES = points((40, 60), (110, 60))
GUESSED = points((60, 100), (110, 60))


def test_a_wrist_beside_all_skin_is_left_out_where_its_hand_is_seen() -> None:
    """Beside the other hand too, where there is as much skin as there was; in a shadow there is less."""
    wrists, apart = WristsOnSkin(PX_PER_M), region((40, 60), (110, 60))
    for _ in range(LEAST_FRAMES):
        assert wrists.beside(RIGHT_ONES, apart) == []
    joined = region((119, 60), (110, 60))
    assert wrists.beside(GUESSED, joined) == [LEFT]
    assert wrists.left_out == 1
    assert wrists.beside(GUESSED, region((110, 60))) == []
    # Where nothing is known of skin, or a detector is as far off, nothing is told.
    assert wrists.beside(GUESSED, None) == []
    assert wrists.beside(GUESSED * [1.0, 1.0, 30.0], joined) == []


def test_a_wrist_that_never_was_on_skin_is_left_out_where_a_hand_is_elsewhere() -> None:
    """One long sleeve: all of its points were left out, 13 cm off where it is 8. A hand at the hip from the first."""
    for at_left, expected in (((32, 68), []), ((30, 70), [LEFT])):
        wrists, skin = WristsOnSkin(PX_PER_M), region(at_left, (110, 60))
        sleeved = RIGHT_ONES if not expected else GUESSED
        assert [wrists.beside(sleeved, skin) for _ in range(3)][-1] == expected


@pytest.mark.parametrize("is_guessed", [True, False])
def test_a_hand_that_a_detector_puts_at_the_hip_is_found_by_its_skin(
    shared: Callable[[str], Path], tmp_path: Path, is_guessed: bool
) -> None:
    """It was 20 cm off, valid and beside its band in 13 % of the frames, silently."""
    table = next(shared("data/people/gestures").glob("0_1_24_*mediapipe*"))
    recording = with_keypoints(shared("recordings/people-gesture-24"), table, tmp_path / "clip")
    keypoints = recording.view.keypoints
    assert keypoints is not None
    moved = keypoints.points.copy()
    if is_guessed:
        guess = moved[100:200, 0, HIP, :2] + np.random.default_rng(1).normal(0.0, 2.0, (100, 2))
        moved[100:200, 0, LEFT, :2] = guess
    track = pt.track(with_points(recording, moved), pt.Partitioned(particles=100), 1)
    assert any("keypoints of wrists lie beside all skin" in words for words in pt.doubts(track)) == is_guessed
    truth = np.genfromtxt(shared("recordings/people-gesture-24") / "truth.csv", delimiter=",", names=True)
    wrist = track.joints["left_wrist"]
    place = np.stack(
        [np.interp(track.time_s, truth["time_s"], truth[f"left_wrist_{axis}_m"]) for axis in "xyz"], axis=1
    )
    off = np.linalg.norm(wrist.mean - place, axis=1)
    beside = ((place < wrist.lo) | (place > wrist.hi)).any(axis=1)
    assert (wrist.valid & (off > 0.2) & beside).mean() < 0.03


def test_in_odd_light_skin_says_nothing_of_points(sensed: Path) -> None:
    """54 right points of a video half as bright were left out: 32 cm off, valid, where they have it to 16."""
    recording = without(load(sensed))
    keypoints, usual = recording.view.keypoints, senses_of(recording)
    assert keypoints is not None
    assert usual.silhouette is not None
    points = keypoints.points.copy()
    points[LEAST_FRAMES:, 0, LEFT, 1] += 60.0
    guessed = with_points(recording, points)
    assert guessed.view.video is not None
    for gains, is_left_out in (((1.0, 1.0, 1.0), True), ((1.02, 1.0, 1.0), False)):
        parameters = replace(usual.silhouette.parameters, gains=gains)
        px_per_m = usual.silhouette.px2_per_m2**0.5
        senses = Senses(guessed, Silhouette(usual.silhouette.background, px_per_m, parameters))
        for frame in islice(frames(guessed.view.video), 30):
            senses(frame)
        assert (senses.wrists.left_out > 0) == is_left_out
