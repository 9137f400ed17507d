"""Stretches of frames that are not valid, of a page."""

from __future__ import annotations

import dataclasses

import numpy as np

import pytracker as pt
from pytracker.report.page import not_believed
from pytracker.report.stretches import Stretch, stretches_of
from pytracker.tracking.body import BodyTrack


def judged(body: pt.BodyRecording, of_joint: dict[str, list[str]]) -> BodyTrack:
    """A track whose frames have these reasons by joint, in every frame where they are not listed none."""
    track = pt.track(body, pt.BodyPlain(particles=20), 1)
    count = len(track.time_s)
    reasons = {joint: tuple(of_joint.get(joint, []) + [""] * count)[:count] for joint in track.joints}
    joints = {joint: dataclasses.replace(of, reason=reasons[joint]) for joint, of in track.joints.items()}
    reason = tuple("; ".join(sorted(set(filter(None, words)))) for words in zip(*reasons.values(), strict=True))
    valid = np.array([not words for words in reason])
    return dataclasses.replace(track, joints=joints, reason=reason, valid=valid)


def test_joints_and_whole_frames_have_lines_of_their_own(body: pt.BodyRecording) -> None:
    names = [*pt.track(body, pt.BodyPlain(particles=20), 1).joints]
    all_of = {joint: ["dark"] * 3 for joint in names}
    wrist = ["dark"] * 3 + [""] * 10 + ["no skin"] * 2 + ["far off"] * 3 + [""] + ["far off"]
    track = judged(body, {**all_of, "left_wrist": wrist})
    at = track.time_s
    assert stretches_of(track) == [
        Stretch("", float(at[0]), float(at[2]), "dark"),
        Stretch("left wrist", float(at[13]), float(at[19]), "far off"),
    ]


def test_a_page_says_where_most_is_not_believed(body: pt.BodyRecording) -> None:
    names = [*pt.track(body, pt.BodyPlain(particles=20), 1).joints]
    assert not_believed(judged(body, {})) == ""
    assert "not to be believed" in not_believed(judged(body, {joint: ["dark"] * 500 for joint in names}))
