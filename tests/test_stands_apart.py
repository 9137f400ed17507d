"""A thing of skin's colour that comes, stands still and is apart from the person is no hand."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
from test_borne_out import CAMERA, PX_PER_M, SKIN, WALL, hanging, person

from pytracker.evidence.picture.silhouette import Silhouette
from pytracker.evidence.pose.stands_apart import STANDS_APART, StandsApart

Place = tuple[int, int]
BESIDE = (368, 310)
"""Where the left hand is taken to hang, while it is raised."""


def said_of(thing: Callable[[int], Place | None], frames: int = 60) -> list[dict[str, str]]:
    """Of who is taken to let their arms hang, and of a ball at `thing` of a frame; 30 Hz."""
    background = np.full((480, 640, 3), WALL, np.uint8)
    silhouette, joints, looked = Silhouette(background, PX_PER_M), hanging(), StandsApart(CAMERA)
    said = []
    for k in range(frames):
        image = background.copy()
        person(image, 320, (11, -64))
        if (at := thing(k)) is not None:
            cv2.circle(image, at, 10, SKIN, -1)
        said.append(looked.look(k / 30, joints, silhouette(image)))
    return said


def test_an_arm_beside_a_thing_that_came_is_not_believed() -> None:
    """It was drawn there: 33 cm off, 87 % of the frames valid, not a word."""
    said = said_of(lambda k: None if k < 10 else BESIDE)
    assert not any(said[:30])
    assert all(words == {"left_elbow": STANDS_APART, "left_wrist": STANDS_APART} for words in said[36:])


@pytest.mark.parametrize(
    "thing",
    [
        lambda k: BESIDE,
        lambda k: None if k < 10 else (BESIDE[0], BESIDE[1] - 3 * ((k - 10) % 16)),
        lambda k: None if k < 10 else (460, 150),
        lambda k: None if k < 10 else (348, 300),
    ],
    ids=["always there", "moving", "far away", "touching the person"],
)
def test_what_may_be_the_persons_or_draws_no_arm_is_nothing(thing: Callable[[int], Place | None]) -> None:
    assert not any(said_of(thing))
