"""Skin that nobody wears: this person's or another's."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pytracker._core import KEYPOINTS
from pytracker.evidence.picture.silhouette import BodyEvidence, Silhouette
from pytracker.evidence.pose.borne_out import BorneOut, head_off
from pytracker.recording.camera import WeakPerspective
from pytracker.rotation import Array
from pytracker.skeleton import average_skeleton

PX_PER_M = 120.0
CAMERA = WeakPerspective(affine=((PX_PER_M, 0.0, 0.0, 320.0), (0.0, -PX_PER_M, 0.0, 300.0)))
SKELETON = average_skeleton(1.7)
SKIN, SHIRT, WALL = (87, 103, 150), (140, 90, 40), (170, 170, 170)


def person(image: np.ndarray, at: int, arm: tuple[int, int]) -> None:
    """Trunk, head and a bare arm that ends at `arm`, px from the shoulder."""
    cv2.rectangle(image, (at - 20, 228), (at + 20, 310), SHIRT, -1)
    cv2.circle(image, (at, 212), 11, SKIN, -1)
    cv2.line(image, (at + 20, 242), (at + 20 + arm[0], 242 + arm[1]), SKIN, 9)


def seen(*people: tuple[int, tuple[int, int]]) -> BodyEvidence:
    background = np.full((480, 640, 3), WALL, np.uint8)
    image = background.copy()
    for at, arm in people:
        person(image, at, arm)
    return Silhouette(background, PX_PER_M)(image)


def hanging() -> dict[str, Array]:
    """Joints of who lets their arms hang, world, m."""
    pose = np.zeros((1, len(SKELETON.channels)))
    for channel, degrees in (("lhumerus_ry", -80.0), ("rhumerus_ry", 80.0)):
        pose[0, SKELETON.channels.index(channel)] = np.radians(degrees)
    return {name: rows[0] for name, rows in SKELETON.joints(pose).items()}


@pytest.mark.parametrize(
    ("people", "told"),
    [
        (((320, (11, 64)),), False),  # as it is tracked, hanging
        (((320, (11, -64)),), True),  # raised: no arm of the track is there
        (((320, (11, 64)), (400, (11, -64)), (240, (-11, -64))), False),  # others, within arm's reach, raise theirs
    ],
)
def test_skin_that_another_person_wears_is_not_missed(
    people: tuple[tuple[int, tuple[int, int]], ...], told: bool
) -> None:
    joints = hanging()
    looked = BorneOut(CAMERA, joints)
    sure = {name: np.full(3, 0.02) for name in joints}
    evidence = seen(*people)
    said = [looked.look(k / 30, joints, sure, evidence) for k in range(10)]
    assert ("skin that no arm explains" in said[-1].get("", "")) == told


@pytest.mark.parametrize(
    ("points_m", "track_m", "told"),
    [
        (0.0, 0.0, False),
        (1.0, 1.0, True),  # a track that follows them is where they are, and there is nobody there
        (1.0, 0.0, True),  # they bear nothing out, and still speak against a track that is elsewhere
    ],
)
def test_points_beside_the_person_bear_nothing_out(points_m: float, track_m: float, told: bool) -> None:
    joints, at_points = (
        {name: at + np.array([beside_m, 0.0, 0.0]) for name, at in hanging().items()}
        for beside_m in (track_m, points_m)
    )
    # A sensor tells where the forearm points: without points nothing speaks against a wrist that is on skin.
    looked, sure = BorneOut(CAMERA, joints, ("left_forearm",)), {name: np.full(3, 0.02) for name in joints}
    points = np.full((len(KEYPOINTS), 3), 2.0)
    for row, name in zip(points, KEYPOINTS, strict=True):
        row[:2] = CAMERA.project(at_points[name][None])[0] if name in at_points else np.nan
    said = [looked.look(k / 30, joints, sure, seen((320, (11, 64))), points) for k in range(10)]
    assert ("left_wrist" in said[-1]) == told


def test_a_head_that_is_above_the_picture_is_nowhere() -> None:
    """Cut off below the chin, what was at the picture's edge was the head: 31 cm below the skeleton's, "check it"."""
    joints, above = hanging(), np.array([0.0, 0.55, 0.0])
    evidence = seen((320, (11, 64)))
    assert np.abs(head_off(CAMERA, joints, evidence)).max() < 0.3
    lower = WeakPerspective(affine=((PX_PER_M, 0.0, 0.0, 320.0), (0.0, -PX_PER_M, 0.0, 40.0)))
    image = np.full((480, 640, 3), WALL, np.uint8)
    cv2.rectangle(image, (300, 0), (340, 120), SHIRT, -1)
    cut = Silhouette(np.full((480, 640, 3), WALL, np.uint8), PX_PER_M)(image)
    raised = {name: at + above for name, at in joints.items()}
    assert np.isnan(head_off(lower, raised, cut)).all()
