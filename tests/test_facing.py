"""A skeleton that is seen from behind and has a face."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_body_senses import with_keypoints

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.doubting.doubts import doubts
from pytracker.evidence.pose.facing import FaceSeen
from pytracker.recording import WeakPerspective
from pytracker.setup.poses.keypoints import first_pose

OTHERS = {"left": "right", "right": "left"}
EXCHANGED = [KEYPOINTS.index("_".join(OTHERS.get(word, word) for word in name.split("_"))) for name in KEYPOINTS]
CAMERA = WeakPerspective(affine=((100.0, 0.0, 0.0, 160.0), (0.0, -100.0, 0.0, 240.0)))


UPSIDE_DOWN = WeakPerspective(affine=((-100.0, 0.0, 0.0, 160.0), (0.0, 100.0, 0.0, -60.0)))


def seen(left_x: float, face: bool, camera: WeakPerspective = CAMERA) -> float:
    """Of a head at (160, 90) px between shoulders, the left one at `left_x` m."""
    joints = {
        "left_shoulder": [left_x, 1.3, 0],
        "right_shoulder": [-left_x, 1.3, 0],
        "head": [0, 1.5, 0],
    }
    skin = np.zeros((480, 320), np.uint8)
    skin[80:101, 150:171] = 255 * face
    facing = FaceSeen(camera)
    evidence: Any = SimpleNamespace(skin=skin)
    for _ in range(3):
        facing.look({name: np.array(at, float) for name, at in joints.items()}, evidence)
    return facing.on_back


def test_a_face_on_a_back() -> None:
    assert seen(-0.17, face=True) == 1.0
    assert seen(-0.17, face=False) == 0.0
    assert seen(0.17, face=True) == 0.0
    assert seen(0.17, face=True, camera=UPSIDE_DOWN) == 0.0
    assert seen(-0.17, face=True, camera=UPSIDE_DOWN) == 1.0


def test_from_the_side_either_shoulder_may_be_the_left_one() -> None:
    turned = {"left_shoulder": [-0.03, 1.3, 0.16], "right_shoulder": [0.03, 1.3, -0.16], "head": [0, 1.5, 0]}
    facing = FaceSeen(CAMERA)
    evidence: Any = SimpleNamespace(skin=np.full((480, 320), 255, np.uint8))
    facing.look({name: np.array(at, float) for name, at in turned.items()}, evidence)
    assert facing.on_back == 0.0


def test_exchanged_sides_of_a_person_are_told(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """From keypoints of somebody who sees left and right as the camera does, the first pose has the back to it."""
    table = next(shared("data/people/gestures").glob("0_1_20_*mediapipe*"))
    recording = with_keypoints(shared("recordings/people-gesture-20"), table, tmp_path / "20")
    keypoints = recording.view.keypoints
    assert keypoints is not None
    exchanged = dataclasses.replace(keypoints, points=keypoints.points[:, :, EXCHANGED])
    found = first_pose(recording.skeleton, recording.view.camera, exchanged.points[0, 0])
    assert found.is_from_behind
    back = dataclasses.replace(
        recording,
        view=dataclasses.replace(recording.view, keypoints=exchanged),
        initial=found.channels(recording.skeleton),
    )
    (said,) = doubts(pt.track(back, pt.BodyMixture()))
    assert "the skeleton is seen from behind" in said
    assert "left and right are exchanged" in said
    assert doubts(pt.track(recording, pt.BodyMixture())) == ()


def test_a_back_that_keypoints_alone_show_is_asked_about(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """No picture shows a face: 40 cm off, all valid, and nothing was said."""
    table = next(shared("data/people/gestures").glob("0_1_20_*mediapipe*"))
    recording = with_keypoints(shared("recordings/people-gesture-20"), table, tmp_path / "20")
    alone = dataclasses.replace(recording.view, video=None, background=None, rate_hz=60.0)
    assert alone.keypoints is not None
    assert doubts(pt.track(dataclasses.replace(recording, view=alone), pt.BodyMixture())) == ()
    exchanged = dataclasses.replace(alone.keypoints, points=alone.keypoints.points[:, :, EXCHANGED])
    found = first_pose(recording.skeleton, alone.camera, exchanged.points[0, 0])
    view, initial = dataclasses.replace(alone, keypoints=exchanged), found.channels(recording.skeleton)
    (said,) = doubts(pt.track(dataclasses.replace(recording, view=view, initial=initial), pt.BodyMixture()))
    assert "show the person from behind most of the time" in said


@pytest.mark.parametrize("roll_deg", [-10.0, 10.0])
def test_a_camera_that_was_rolled_is_asked_about(
    roll_deg: float, shared: Callable[[str], Path], tmp_path: Path
) -> None:
    """Wrists were 10 cm off across the picture, all valid, and nothing was said."""
    table = next(shared("data/people/gestures").glob("0_1_24_*mediapipe*"))
    recording = with_keypoints(shared("recordings/people-gesture-24"), table, tmp_path / "24")
    keypoints, camera = recording.view.keypoints, recording.view.camera
    assert keypoints is not None
    c, s = np.cos(np.radians(roll_deg)), np.sin(np.radians(roll_deg))
    points, middle = keypoints.points.copy(), np.array([134.5, 239.5])
    points[..., :2] = (points[..., :2] - middle) @ np.array([[c, s], [-s, c]]) + middle
    rolled = dataclasses.replace(keypoints, points=points)
    found = first_pose(recording.skeleton, camera, points[0, 0])
    view = dataclasses.replace(recording.view, video=None, background=None, rate_hz=60.0, keypoints=rolled)
    turned = dataclasses.replace(recording, view=view, initial=found.channels(recording.skeleton))
    (said,) = doubts(pt.track(turned, pt.BodyMixture()))
    side = "right" if roll_deg > 0 else "left"
    assert f"to the {side} of the picture most of the time: was the camera rolled" in said
