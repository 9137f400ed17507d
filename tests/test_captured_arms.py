"""Real arms' movement with worn sensors: errors, and bands that hold where the depth is not known."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import pytest
from captured_arm import KEPT, CapturedArm, captured, pooled, scored

import pytracker as pt
from pytracker.methods import ArmMethod
from pytracker.rotation import triple


@pytest.mark.parametrize(
    ("method", "most_m", "least"), [(pt.Smooth(), 0.08, 0.92), (pt.Mixture(), 0.11, 0.87)], ids=["smooth", "mixture"]
)
def test_arms_of_people_are_followed(
    shared: Callable[[str], Path], method: ArmMethod, most_m: float, least: float
) -> None:
    """On clips that nothing was tuned on."""
    error, inside, still = pooled(shared("data").parent, KEPT, method, (1, 2))
    assert error < most_m
    assert error < 0.35 * still
    assert inside.min() > least


def test_where_two_depths_are_as_likely_the_band_holds_both(shared: Callable[[str], Path]) -> None:
    """An arm held out to the side, across the picture: started at one depth, a smoother is 20 cm off and sure."""
    for seed in (3, 5):
        score, _ = scored(shared("data").parent, "49_18 R", pt.Smooth(), seed)
        assert min(score.coverage) > 0.9


def test_a_shoulder_that_went_elsewhere_is_among_what_is_named(shared: Callable[[str], Path]) -> None:
    """Cut so that it starts elsewhere: a mirrored picture was named, as that, headings and clocks were tried alone."""
    arm = CapturedArm(*captured(shared("data").parent, "49_18 L"), 3)
    recording, time_s, pixels = arm.recording(), arm.frame_time_s, arm.sightings(2.0)
    first = len(time_s) // 10
    assert recording.truth is not None
    start = triple(recording.truth.at("wrist", time_s[first : first + 1])[0])
    view = dataclasses.replace(recording.views[0], start_s=float(time_s[first]))
    described = dataclasses.replace(recording.arm, wrist_start_m=start)
    cut = dataclasses.replace(recording, views=(view,), arm=described)
    track = pt.track(cut, pt.Smooth(), 1, sightings=pt.Sightings.of(time_s[first:], pixels[first:]))
    (said,) = pt.doubts(track)
    assert "shoulder_m" in said
    assert "mirrored" not in said


def test_a_right_arm_of_few_seconds_is_not_refused(shared: Callable[[str], Path]) -> None:
    """All its windows are nearly one, which is as far off as one of a right arm may be: every frame was invalid."""
    for name, seed in (("20 R", 2), ("29 L", 3)):
        arm = CapturedArm(*captured(shared("data").parent, name), seed)
        seen = pt.Sightings.of(arm.frame_time_s, arm.sightings(2.0))
        assert pt.track(arm.recording(), pt.Smooth(), 1, sightings=seen).valid.mean() > 0.9
