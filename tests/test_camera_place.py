"""A camera's place or rotation that is another's is told by where the feet are."""

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


def raised(track: BodyTrack, by_m: float, rotation: np.ndarray) -> BodyTrack:
    """A first pose that is so much higher, seen by a camera that is turned so."""
    recording, camera = track.recording, track.recording.view.camera
    assert isinstance(camera, pt.Camera)
    initial = recording.initial.copy()
    initial[recording.skeleton.columns(("root_ty",))] += by_m
    rows = triple(rotation[0]), triple(rotation[1]), triple(rotation[2])
    view = replace(recording.view, camera=replace(camera, rotation=rows))
    return replace(track, recording=replace(recording, view=view, initial=initial))


def test_a_rotation_that_is_transposed_is_told(track: BodyTrack) -> None:
    """The camera looked up from the ground, not down: 60 to 96 cm off, all valid, without a word."""
    camera = track.recording.view.camera
    assert isinstance(camera, pt.Camera)
    turned = np.array(camera.rotation).T
    (said,) = of_camera_place(raised(track, -0.25, turned))
    assert "does camera.rotation take the camera to the world?" in said
    assert "0.21 m below where the world begins" in said
    # Who films from the ground on which the world begins, or below a table on which it does, is right.
    for by_m in (-0.05, -0.5, -0.8):
        assert of_camera_place(raised(track, by_m, turned)) == ()


def test_a_picture_that_was_cut_has_people_in_the_air(track: BodyTrack) -> None:
    """60 rows of 480 cut off above, the matrix as it was: 41 to 55 cm off, all valid, without a word."""
    camera = track.recording.view.camera
    assert isinstance(camera, pt.Camera)
    (said,) = of_camera_place(raised(track, 0.48, np.array(camera.rotation)))
    assert "was the picture cut" in said
    assert of_camera_place(raised(track, 0.2, np.array(camera.rotation))) == ()
