"""Keypoints of wrists that lie beside all skin, as detectors guess hands that they do not see."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from test_body_senses import with_keypoints

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.evidence.points.on_skin import LEAST_FRAMES, WristsOnSkin

PX_PER_M = 100.0
LEFT, RIGHT, HIP = (KEYPOINTS.index(name) for name in ("left_wrist", "right_wrist", "left_hip"))


def region(*hands: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Distances from skin, px `(120, 160)`, and places on it, of hands at these pixels."""
    mask = np.full((120, 160), 255, np.uint8)
    for hand in hands:
        cv2.circle(mask, hand, 4, 0, -1)
    return cv2.distanceTransform(mask, cv2.DIST_L2, 5), np.argwhere(mask == 0)[:, ::-1].astype(float)


def points(left: tuple[float, float], right: tuple[float, float]) -> np.ndarray:
    found = np.tile([50.0, 50.0, 1.0], (9, 1))
    found[LEFT, :2], found[RIGHT, :2] = left, right
    return found


@pytest.mark.parametrize("sleeve_m", [0.0, 0.07])
def test_a_wrist_beside_all_skin_is_left_out_where_wrists_are_bare(sleeve_m: float) -> None:
    """Of who wears long sleeves every wrist is beside skin, and none is a guess."""
    hands, wrists = ((40, 60), (110, 60)), WristsOnSkin(PX_PER_M)
    away = 4 + sleeve_m * PX_PER_M
    right = points((40, 60 - away), (110, 60 - away))
    guessed = points((60, 90), (110, 60 - away))
    for _ in range(LEAST_FRAMES):
        assert wrists.beside(right, region(*hands)) == []
    is_bare = sleeve_m == 0.0
    assert wrists.beside(guessed, region(*hands)) == ([LEFT] if is_bare else [])
    assert wrists.left_out == is_bare
    # Where the light goes out, nothing is known of skin, or a detector is as far off, nothing is told.
    assert wrists.beside(guessed, region((5, 5))) == []
    assert wrists.beside(guessed, None) == []
    assert wrists.beside(guessed * [1.0, 1.0, 12.0], region(*hands)) == []


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
    view = dataclasses.replace(recording.view, keypoints=dataclasses.replace(keypoints, points=moved))
    track = pt.track(dataclasses.replace(recording, view=view), pt.Partitioned(particles=100), 1)
    assert any("keypoints of wrists lie beside all skin" in words for words in pt.doubts(track)) == is_guessed
    truth = np.genfromtxt(shared("recordings/people-gesture-24") / "truth.csv", delimiter=",", names=True)
    wrist = track.joints["left_wrist"]
    place = np.stack(
        [np.interp(track.time_s, truth["time_s"], truth[f"left_wrist_{axis}_m"]) for axis in "xyz"], axis=1
    )
    off = np.linalg.norm(wrist.mean - place, axis=1)
    beside = ((place < wrist.lo) | (place > wrist.hi)).any(axis=1)
    assert (wrist.valid & (off > 0.2) & beside).mean() < 0.03
