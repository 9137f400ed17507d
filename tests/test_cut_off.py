"""Hands that are hidden by what hides the body below the hips."""

from __future__ import annotations

import numpy as np
import pytest

import pytracker as pt
from pytracker.evidence.pose.cut_off import HIDDEN, CutOff
from pytracker.formats.video import Image
from pytracker.rotation import Array


def seen(body: pt.BodyRecording, body_to_m: float, left_to_m: float) -> tuple[dict[str, Array], Image]:
    """Joints and a foreground: the body seen so far below the hips, the left wrist's arm too, the right one raised."""
    camera = body.view.camera
    joints = {name: rows[0] for name, rows in body.skeleton.joints(body.initial[None]).items()}
    root = joints["root"]
    joints |= {"left_wrist": root + np.array([0.3, 0.05, 0.0]), "right_wrist": root + np.array([-0.3, 0.5, 0.0])}
    px_per_m = float(camera.px_per_m(root[None])[0])
    mask = np.zeros((240, 320), dtype=np.uint8)

    def fill(at: Array, half_m: float, from_m: float, to_m: float) -> None:
        u, v = camera.project(at[None])[0]
        rows = slice(max(0, round(v + from_m * px_per_m)), round(v + to_m * px_per_m))
        mask[rows, round(u - half_m * px_per_m) : round(u + half_m * px_per_m)] = 255

    fill(root, 0.12, -0.7, body_to_m)
    fill(root + np.array([0.3, 0.0, 0.0]), 0.04, -0.3, left_to_m)
    fill(joints["right_wrist"], 0.04, -0.3, 0.1)
    return joints, mask


def hidden(body: pt.BodyRecording, body_to_m: float, left_to_m: float) -> dict[str, str]:
    """What is said in the last of some frames."""
    cut_off = CutOff(body.view.camera)
    said = [cut_off.look(frame / 30.0, *seen(body, body_to_m, left_to_m)) for frame in range(10)]
    return said[-1]


def test_a_hand_that_ends_where_the_body_does_may_be_hidden(body: pt.BodyRecording) -> None:
    """Behind a table wrists were 20 to 29 cm off, at its edge, valid, and nothing was said."""
    assert hidden(body, 0.1, 0.1) == {"left_wrist": HIDDEN}


@pytest.mark.parametrize(("body_to_m", "left_to_m"), [(0.8, 0.1), (0.1, 0.3), (0.1, -0.1)])
def test_a_hand_that_is_seen_is_not(body: pt.BodyRecording, body_to_m: float, left_to_m: float) -> None:
    """Who stands free has legs; a hand on a table is seen before it; one above it ends above it."""
    assert hidden(body, body_to_m, left_to_m) == {}
