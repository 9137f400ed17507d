"""A camera's place that was written where its translation belongs is told by where the feet are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.doubting.camera_place import of_camera_place
from pytracker.rotation import triple
from pytracker.tracking import BodyTrack


@pytest.fixture(scope="module")
def track(shared: Callable[[str], Path]) -> BodyTrack:
    found = pt.track(pt.load(shared("recordings/people-gesture-21")), pt.Partitioned(particles=20), 1)
    assert isinstance(found, BodyTrack)
    return found


def with_translation(track: BodyTrack, translation_m: np.ndarray) -> BodyTrack:
    """The same picture, and a first pose that fits it."""
    recording, camera = track.recording, track.recording.view.camera
    assert isinstance(camera, pt.Camera)
    moved = np.array(camera.rotation).T @ (np.array(camera.translation_m) - translation_m)
    initial = recording.initial.copy()
    initial[recording.skeleton.columns(("root_tx", "root_ty", "root_tz"))] += moved
    view = replace(recording.view, camera=replace(camera, translation_m=triple(translation_m)))
    other = replace(recording, view=view, initial=initial)
    before, after = (of.view.camera.project(of.skeleton.joints(of.initial[None])["head"]) for of in (recording, other))
    assert np.allclose(before, after, atol=1e-6)
    return replace(track, recording=other)


def test_where_a_camera_stands_is_no_translation(track: BodyTrack) -> None:
    camera = track.recording.view.camera
    assert isinstance(camera, pt.Camera)
    assert of_camera_place(track) == ()
    (said,) = of_camera_place(with_translation(track, camera.position_m))
    assert "if camera.translation_m were where the camera stands: is it?" in said
    # A world that begins at the camera, or on a table, tells no floor.
    assert of_camera_place(with_translation(track, np.zeros(3))) == ()
    table = np.array(camera.translation_m) + np.array(camera.rotation) @ [0.0, 0.75, 0.0]
    assert of_camera_place(with_translation(track, table)) == ()
    (said,) = of_camera_place(with_translation(track, 10.0 * np.array(camera.translation_m)))
    assert "expected within 10 m of where the world begins: is the camera's translation_m in metres?" in said
