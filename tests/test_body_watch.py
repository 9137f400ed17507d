"""A body's stream says of every frame what a recording says of it."""

from __future__ import annotations

import itertools
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import load_body

import pytracker as pt
from pytracker._core import KEY_JOINTS
from pytracker.evidence.picture.frozen import HANGS
from pytracker.evidence.senses import senses_of
from pytracker.formats.video import frames
from pytracker.methods import BodyMethod
from pytracker.tracking import BodyTrack, BodyWatch


def streamed(recording: pt.BodyRecording, method: BodyMethod, delay_s: float = 0.0) -> list[dict[str, str]]:
    """What is said of every frame as it comes."""
    tracker, watch = pt.Tracker(recording, method, seed=1, delay_s=delay_s), BodyWatch(recording, method)
    estimates = []
    said = []
    for observation in recording.observations():
        watch.take(observation)
        estimate = tracker.observe(observation)
        if estimate is not None:
            estimates.append(estimate)
            said.append(watch.reasons(estimate))
    return said + [watch.reasons(estimate) for estimate in tracker.finish()]


def is_said_alike(track: BodyTrack, said: list[dict[str, str]]) -> bool:
    """Whether every joint of every frame has the reason that the track has."""
    of_joints = {name: [words.get(name) or words.get("", "") for words in said] for name in KEY_JOINTS}
    return all(list(track.joints[name].reason) == of_joints[name] for name in KEY_JOINTS) and np.array_equal(
        track.valid, [not words for words in said]
    )


@pytest.fixture(scope="module", params=["picture", "picture and keypoints", "keypoints"])
def recording(request: pytest.FixtureRequest, sensed: Path) -> pt.BodyRecording:
    """A body, by what sees it."""
    whole = load_body(sensed)
    view = whole.view
    if request.param == "picture":
        view = replace(view, keypoints=None)
    elif request.param == "keypoints":
        view = replace(view, video=None, background=None, size_px=(320, 240), rate_hz=30.0)
    return replace(whole, view=view, imus=(), imu_sds_rad=())


@pytest.mark.parametrize("delay_s", [0.0, 0.1])
def test_a_stream_says_what_a_recording_says(recording: pt.BodyRecording, delay_s: float) -> None:
    method = pt.Partitioned(particles=100)
    said = streamed(recording, method, delay_s)
    assert is_said_alike(pt.track(recording, method, 1), said)
    assert np.mean([not words for words in said]) > 0.8


def test_a_stream_says_that_a_pose_is_beside_the_person(recording: pt.BodyRecording) -> None:
    """It said nothing of a body. Where the person is found after all, no longer."""
    initial = recording.initial.copy()
    initial[recording.skeleton.columns(("root_tx",))] += 0.4
    beside, method = replace(recording, initial=initial), pt.Partitioned(particles=100)
    said = streamed(beside, method)
    assert is_said_alike(pt.track(beside, method, 1), said)
    assert all(said[:10])


def test_a_picture_that_hangs_is_told_after_a_second(sensed: Path) -> None:
    """A live camera that gives its last picture again and again: 97 % of its frames were valid."""
    whole = load_body(sensed)
    recording = replace(whole, view=replace(whole.view, keypoints=None), imus=(), imu_sds_rad=())
    method, senses = pt.Partitioned(particles=100), senses_of(recording)
    assert recording.video is not None
    shown = list(itertools.islice(frames(recording.video), 20))
    shown += [replace(shown[-1], index=k, time_s=k / 30.0) for k in range(20, 70)]
    tracker, watch = pt.Tracker(recording, method, seed=1), BodyWatch(recording, method)
    said = []
    for frame in shown:
        observation = pt.Observation.picture(frame.time_s, senses(frame), frame.index)
        watch.take(observation)
        estimate = tracker.observe(observation)
        assert estimate is not None
        said.append(watch.reasons(estimate))
    assert not any(HANGS in words.get("", "") for words in said[:49])
    assert all(HANGS in words[""] for words in said[51:])


def test_a_papers_filter_without_blobs_is_said_to_be_blind(sensed: Path) -> None:
    whole = load_body(sensed)
    recording, method = (
        replace(whole, view=replace(whole.view, keypoints=None), imus=(), imu_sds_rad=()),
        pt.BodyPlain(particles=50),
    )
    assert is_said_alike(pt.track(recording, method, 1), streamed(recording, method))


def test_a_frame_is_asked_about_once(body: pt.BodyRecording) -> None:
    method = pt.Partitioned(particles=20)
    tracker, watch = pt.Tracker(body, method, seed=1), BodyWatch(body, method)
    frame = next(body.observations())
    watch.take(frame)
    estimate = tracker.observe(frame)
    assert estimate is not None
    watch.reasons(estimate)
    with pytest.raises(pt.InputError, match="was not taken, or was asked about"):
        watch.reasons(estimate)
    with pytest.raises(pt.InputError, match="Layered tracks a recording of kind 'arm'"):
        BodyWatch(body, pt.Layered())  # type: ignore[arg-type]


def test_frames_that_nobody_asks_about_are_not_kept(body: pt.BodyRecording) -> None:
    """A viewer that asked about every tenth kept all pictures."""
    method = pt.Partitioned(particles=20)
    tracker, watch = pt.Tracker(body, method, seed=1), BodyWatch(body, method)
    frames = []
    for k, frame in enumerate(body.observations()):
        frames.append(weakref.ref(frame.evidence))
        watch.take(frame)
        estimate = tracker.observe(frame)
        if estimate is not None and k % 10 == 9:
            watch.reasons(estimate)
            del frame
            assert sum(kept() is not None for kept in frames) <= 3
