"""Pictures made smaller: the same person, filmed by more pixels, is the same evidence and the same track."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pytracker as pt
from pytracker.evidence import senses_of
from pytracker.evidence.picture.background import read_background
from pytracker.evidence.picture.smaller import place_in_frame, place_in_smaller, smaller, times_smaller
from pytracker.formats.video import frames, probe
from pytracker.recording import WeakPerspective

CAMERA = pt.Camera(
    matrix=((812.0, 0.5, 530.0), (0.0, 790.0, 941.0), (0.0, 0.0, 1.0)),
    translation_m=(0.1, -0.2, 2.9),
    distortion=(-0.21, 0.2, 0.002, -0.01, 0.01),
)
FAR = WeakPerspective(affine=((211.0, 3.0, -20.0, 530.0), (1.0, -214.0, 8.0, 941.0)))
places = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3)


@given(place=places, times=st.integers(1, 9))
def test_the_camera_of_smaller_pictures_sees_a_point_where_it_lies_in_them(place: list[float], times: int) -> None:
    at = np.array([place])
    for camera in (CAMERA, FAR):
        seen = camera.of_smaller(times)
        assert seen.project(at) == pytest.approx(place_in_smaller(camera.project(at), times), abs=1e-9)
        assert camera.project(at) == pytest.approx(place_in_frame(seen.project(at), times), abs=1e-9)
        assert seen.px_per_m(at) == pytest.approx(camera.px_per_m(at) / times)


def test_a_pixel_is_the_mean_of_those_it_was_made_of() -> None:
    image = np.arange(7 * 10 * 3, dtype=np.uint8).reshape(7, 10, 3)
    made = smaller(image, 3)
    assert made.shape == (2, 3, 3)
    assert made[1, 2, 0] == image[3:6, 6:9, 0].mean()
    assert smaller(image, 1) is image


def test_as_many_pixels_are_left_as_tell_something() -> None:
    filmed = np.zeros((1920, 1080, 3), np.uint8)
    assert [times_smaller(px_per_m, filmed) for px_per_m in (30.0, 118.0, 199.0, 200.0, 470.0)] == [1, 1, 1, 2, 4]


def test_a_picture_is_left_of_whatever_is_set_up() -> None:
    """Who stands before the lens by mistake, or behind it."""
    filmed = np.zeros((240, 320, 3), np.uint8)
    assert [times_smaller(px_per_m, filmed) for px_per_m in (1e7, np.inf, np.nan, -50.0)] == [7, 1, 1, 1]
    assert times_smaller(1e7, np.zeros((20, 20, 3), np.uint8)) == 1
    assert times_smaller(1e7, np.zeros((4320, 7680, 3), np.uint8)) == 16


def larger(recording: pt.BodyRecording, folder: Path) -> pt.BodyRecording:
    """The same by a camera of twice as many pixels a side."""
    view = recording.view
    assert view.video is not None
    assert view.background is not None
    assert isinstance(view.camera, WeakPerspective)
    video, background = folder / "larger.avi", folder / "larger.png"
    info = probe(view.video)
    codec = cv2.VideoWriter_fourcc(*"FFV1")  # type: ignore[attr-defined]
    writer = cv2.VideoWriter(str(video), codec, info.rate_hz or 30.0, (2 * info.width, 2 * info.height))
    for frame in frames(view.video):
        writer.write(frame.image.repeat(2, axis=0).repeat(2, axis=1))
    writer.release()
    cv2.imwrite(str(background), read_background(view.background).repeat(2, axis=0).repeat(2, axis=1))
    u, v = ((2 * x, 2 * y, 2 * z, 2 * at + 0.5) for x, y, z, at in view.camera.affine)
    camera = WeakPerspective(affine=(u, v))
    return replace(recording, view=replace(view, video=video, background=background, camera=camera))


def test_who_is_filmed_by_more_pixels_is_tracked_as_well(body: pt.BodyRecording, tmp_path: Path) -> None:
    """The evidence is the same, pixel for pixel but for the codec; the filter takes its places to be the frame's."""
    twice = larger(body, tmp_path)
    assert body.view.video is not None
    assert twice.view.video is not None
    senses, of_twice = senses_of(body), senses_of(twice)
    assert (senses.shrunk, of_twice.shrunk) == (1, 2)
    for one, other in zip(frames(body.view.video), frames(twice.view.video), strict=True):
        as_it_is, made_smaller = senses(one), of_twice(other)
        assert made_smaller.image is other.image
        for name in ("foreground", "edges", "skin"):
            assert np.mean(getattr(as_it_is, name) != getattr(made_smaller, name)) < 0.002, name
    track, of_more = (pt.track(each, pt.Partitioned(), seed=3) for each in (body, twice))
    assert np.mean(track.valid == of_more.valid) > 0.9
    for joint, of in track.joints.items():
        apart = np.linalg.norm(of.mean - of_more.joints[joint].mean, axis=1)
        assert np.median(apart) < 0.03, joint
    assert of_more.head_off_m == pytest.approx(track.head_off_m, abs=0.02)
    assert of_more.on_person == pytest.approx(track.on_person, abs=0.15, nan_ok=True)
    assert of_more.shown is not None
    assert of_more.shown.image.shape[0] == 2 * of_more.shown.foreground.shape[0]


def test_keypoints_and_blobs_beside_smaller_pictures_are_the_frames(body: pt.BodyRecording, tmp_path: Path) -> None:
    """The same for the filter, so the same estimates: evidence as it is, and told to be of a smaller picture."""
    twice = replace(body, view=replace(body.view, camera=larger(body, tmp_path).view.camera))
    points = np.full((1, 9, 3), np.nan)
    points[0, :2] = [[150.0, 60.0, 3.0], [170.0, 75.0, 3.0]]
    trackers = pt.Tracker(body, pt.Partitioned(), seed=3), pt.Tracker(twice, pt.Partitioned(), seed=3)
    for observation in islice(body.observations(), 12):
        given = replace(observation.evidence, keypoints=points)
        as_larger = points * 2 + np.array([0.5, 0.5, 0.0])
        of_smaller = replace(given, keypoints=as_larger, shrunk=2)
        seen = (pt.Observation.picture(observation.time_s, of) for of in (given, of_smaller))
        one, other = (tracker.observe(each) for tracker, each in zip(trackers, seen, strict=True))
        assert one is not None
        assert other is not None
        for joint, place in one.places.items():
            assert other.places[joint].mean == pytest.approx(place.mean, abs=1e-6), joint
        assert other.log_evidence == pytest.approx(one.log_evidence, abs=1e-6)
