"""What a frame's skin leaves open of a wrist: little where a forearm is seen alone, much where arms are folded."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pytracker.evidence.picture.silhouette import Region
from pytracker.evidence.pose.ambiguity import Forearm, Line, wrists_may_be_off
from pytracker.rotation import Array

PX_PER_M = 150.0
FOREARM_M = 0.25
HEAD = np.array([200.0, 60.0]), np.array([200.0, 30.0])
OTHER = np.array([260.0, 160.0]), np.array([262.0, 197.0])


def skin(*limbs: tuple[Array, Array, float]) -> Region:
    """Lines `(2,)`, `(2,)` px that are so wide, m; and some points of theirs."""
    mask = np.zeros((400, 400), np.uint8)
    for start, end, width_m in limbs:
        a, b = (tuple(int(x) for x in np.rint(at)) for at in (start, end))
        cv2.line(mask, a, b, 255, round(width_m * PX_PER_M))
    distance = cv2.distanceTransform(cv2.bitwise_not(mask), cv2.DIST_L2, 3).astype(np.float32)
    points = np.argwhere(mask)[:, ::-1].astype(float)
    return distance, points[np.linspace(0, len(points) - 1, 64).astype(int)]


def forearm(line: Line, px_per_m: float = PX_PER_M, is_known: bool = False) -> Forearm:
    return Forearm(*line, whole_px=FOREARM_M * px_per_m, is_known=is_known)


def off_m(region: Region, elbow: Array, wrist: Array, other: Line = OTHER, is_known: bool = False) -> float:
    """As it is asked of one wrist, m."""
    arms = forearm((elbow, wrist)), forearm(other, is_known=is_known)
    return wrists_may_be_off(region, PX_PER_M, arms, HEAD)[0] / PX_PER_M


def body(arm: tuple[Array, Array]) -> Region:
    hands = [(elbow, elbow + 1.35 * (wrist - elbow), 0.08) for elbow, wrist in (arm, OTHER)]
    return skin((*HEAD, 0.15), *hands)


ELBOW = np.array([140.0, 160.0])
HANGING = ELBOW + np.array([0.0, FOREARM_M * PX_PER_M])
ACROSS = ELBOW + np.array([0.9 * FOREARM_M * PX_PER_M, 0.0])


@pytest.mark.parametrize("wrist", [HANGING, ACROSS])
def test_a_forearm_that_is_seen_alone_is_known(wrist: Array) -> None:
    region = body((ELBOW, wrist))
    assert off_m(region, ELBOW, wrist) < 0.06
    elsewhere = ELBOW + np.array([-0.9 * FOREARM_M * PX_PER_M, 0.0])
    assert off_m(region, ELBOW, elsewhere) > 0.2


def test_of_folded_arms_it_is_not() -> None:
    """Two forearms, one over the other: the one that is seen explains the skin of both."""
    left = np.array([220.0, 160.0]), np.array([150.0, 158.0])
    region = skin((*HEAD, 0.15), (ELBOW, left[0], 0.12))
    assert off_m(region, ELBOW, ELBOW + np.array([3.0, 3.0]), left) > 0.125


def test_where_there_is_no_skin_to_tell_anything_goes() -> None:
    """A sleeve over arm and hand."""
    assert off_m(skin((*HEAD, 0.15)), ELBOW, HANGING) > 0.2


def test_it_does_not_depend_on_the_size_of_the_picture() -> None:
    region = body((ELBOW, HANGING))
    distance, points = region
    large = cv2.resize(2.0 * distance, None, fx=2.0, fy=2.0, interpolation=cv2.INTER_LINEAR)
    twice = np.asarray(large, dtype=np.float32), 2.0 * points
    head = 2.0 * HEAD[0], 2.0 * HEAD[1]
    px = 2.0 * PX_PER_M
    arms = forearm((2.0 * ELBOW, 2.0 * HANGING), px), forearm((2.0 * OTHER[0], 2.0 * OTHER[1]), px)
    assert wrists_may_be_off(twice, px, arms, head)[0] / px == pytest.approx(off_m(region, ELBOW, HANGING), abs=0.005)


def test_what_the_other_arm_may_explain_is_open() -> None:
    """A bar of skin between the elbows is this forearm if the other one is known to point elsewhere, or else either."""
    right = np.array([215.0, 160.0])
    region = skin((*HEAD, 0.15), (ELBOW, right, 0.10))
    to_camera = right, right - np.array([6.0, 0.0])
    sure = off_m(region, ELBOW, ACROSS, to_camera, is_known=True)
    assert sure < 0.05
    assert off_m(region, ELBOW, ACROSS, to_camera) > 1.5 * sure


def test_a_forearm_that_a_sensor_points_is_where_it_is() -> None:
    left = np.array([220.0, 160.0]), np.array([150.0, 158.0])
    region = skin((*HEAD, 0.15), (ELBOW, left[0], 0.12))
    arms = forearm((ELBOW, ACROSS), is_known=True), forearm(left)
    assert wrists_may_be_off(region, PX_PER_M, arms, HEAD)[0] == 0.0


def test_places_that_are_no_numbers_tell_nothing() -> None:
    assert np.isnan(off_m(body((ELBOW, HANGING)), ELBOW, np.array([np.nan, 3.0])))
