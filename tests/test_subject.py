"""Of several people the subject is followed, and nobody else is taken for the subject."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.evidence.points.followed import EXCHANGED
from pytracker.evidence.points.subject import subject_of
from pytracker.rotation import Array

PX_PER_M, RATE_HZ = 120.0, 30.0
COUNT = len(KEYPOINTS)


def walking(frames: int, from_m: float, speed_m_s: float, rng: np.random.Generator) -> Array:
    """Somebody who goes along the picture, waves the arms, and trembles `(T, 9, 3)`."""
    at = from_m + speed_m_s * np.arange(frames) / RATE_HZ
    body = np.random.default_rng(0).uniform(-0.3, 0.3, (COUNT, 2))
    points = np.ones((frames, COUNT, 3))
    points[..., :2] = body
    points[..., 0] += at[:, None]
    phase = rng.uniform(0.0, 6.0, 4)
    for k, name in enumerate(("left_elbow", "right_elbow", "left_wrist", "right_wrist")):
        points[:, KEYPOINTS.index(name), 1] += 0.25 * np.sin(4.0 * np.arange(frames) / RATE_HZ + phase[k])
    points[..., :2] = PX_PER_M * points[..., :2] + rng.normal(0.0, 1.5, points[..., :2].shape)
    return points


def of(people: list[Array], rng: np.random.Generator, frames: NDArray[np.int64] | None = None) -> Array:
    """The subject of people who are listed in any order; the first of them has the first pose."""
    count = len(people[0])
    listed = np.stack([np.stack(row)[rng.permutation(len(row))] for row in zip(*people, strict=True)])
    first_px = people[0][np.argmax(np.isfinite(people[0][:, 0, 0])), :, :2] + rng.normal(0.0, 8.0, (COUNT, 2))
    return subject_of(listed, np.arange(count) if frames is None else frames, first_px, PX_PER_M, RATE_HZ)


@pytest.mark.parametrize("seed", range(40))
def test_who_passes_by_is_somebody_else(seed: int) -> None:
    """Of the same build, who may hold the arms alike as they pass: of 1500 such two were taken for each other."""
    rng = np.random.default_rng(seed)
    me, other = walking(120, 0.0, 0.1, rng), walking(120, 1.5, -0.8, rng)
    np.testing.assert_array_equal(of([me, other], rng), me)


@given(st.integers(0, 10_000), st.floats(0.4, 2.0))
def test_who_stands_beside_does_not_become_the_subject_while_that_one_is_not_seen(seed: int, beside_m: float) -> None:
    rng = np.random.default_rng(seed)
    me, other = walking(150, 0.0, 0.0, rng), walking(150, beside_m, 0.0, rng)
    me[40:100] = np.nan
    np.testing.assert_array_equal(of([me, other], rng), me)
    # Nor where the other comes as the subject goes, for good.
    me[40:], other[:40] = np.nan, np.nan
    np.testing.assert_array_equal(of([me, other], rng), me)


def test_one_person_alone_is_the_subject_whatever_a_detector_does(rng: np.random.Generator) -> None:
    me = walking(90, 0.0, 1.5, rng)
    me[20:26], me[50] = np.nan, np.nan
    me[30:40] = me[30:40][:, EXCHANGED]
    me[60:70, 3:5] = np.nan
    me[72, 5, :2] += 400.0
    np.testing.assert_array_equal(of([me], rng), me)


def test_a_leap_to_somewhere_else_and_back_is_nobody(rng: np.random.Generator) -> None:
    me = walking(60, 0.0, 0.0, rng)
    seen = me.copy()
    seen[30:33, :, :2] += [150.0, 20.0]
    found = of([seen], rng)
    assert np.isnan(found[30:33]).all()
    np.testing.assert_array_equal(np.delete(found, [30, 31, 32], 0), np.delete(me, [30, 31, 32], 0))


@pytest.mark.parametrize("every", [3, 10])
def test_of_every_third_frame_people_may_have_gone_farther(every: int, rng: np.random.Generator) -> None:
    me, other = (walking(300, from_m, speed, rng)[::every] for from_m, speed in ((0.0, 1.0), (-1.0, -0.3)))
    np.testing.assert_array_equal(of([me, other], rng, np.arange(0, 300, every)), me)


def test_nobody_is_nobody() -> None:
    nobody = np.full((5, 2, COUNT, 3), np.nan)
    assert np.isnan(subject_of(nobody, np.arange(5), np.zeros((COUNT, 2)), PX_PER_M, RATE_HZ)).all()
    late = nobody.copy()
    late[3:, 1] = 7.0
    found = subject_of(late, np.arange(5), np.full((COUNT, 2), np.nan), PX_PER_M, RATE_HZ)
    np.testing.assert_array_equal(found, late[:, 1])


@pytest.mark.parametrize("missed", [1, 15])
def test_who_is_missed_at_first_is_waited_for(missed: int) -> None:
    """The first pose decides, not who is there first."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        me, other = walking(90, 0.0, 0.0, rng), walking(90, 0.8, 0.0, rng)
        first_px = me[0, :, :2].copy()
        me[:missed] = np.nan
        listed = np.stack([me, other], axis=1)
        found = subject_of(listed, np.arange(90), first_px, PX_PER_M, RATE_HZ)
        np.testing.assert_array_equal(found, me)


def test_of_a_first_pose_that_is_rough_whoever_is_nearest_is_the_subject(rng: np.random.Generator) -> None:
    me, other = walking(90, 0.0, 0.0, rng), walking(90, -2.0, 0.0, rng)
    first_px = me[0, :, :2] + [1.0 * PX_PER_M, 0.0]
    found = subject_of(np.stack([other, me], axis=1), np.arange(90), first_px, PX_PER_M, RATE_HZ)
    np.testing.assert_array_equal(found, me)


@given(st.integers(0, 10_000), st.floats(0.15, 1.5), st.integers(1, 3))
def test_a_stray_frame_loses_nothing_else(seed: int, aside_m: float, count: int) -> None:
    rng = np.random.default_rng(seed)
    me = walking(60, 0.0, 0.0, rng)
    seen = me.copy()
    seen[30 : 30 + count, :, 0] += aside_m * PX_PER_M
    found = of([seen], rng)
    left = [k for k in range(60) if not 30 <= k < 30 + count]
    np.testing.assert_array_equal(found[left], me[left])


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
def test_joints_that_are_not_seen_make_nobody_new(share: float) -> None:
    for seed in range(5):
        rng = np.random.default_rng(seed)
        me = walking(120, 0.0, 0.3, rng)
        first_px = me[0, :, :2].copy()
        me[rng.random(me.shape[:2]) < share] = np.nan
        found = subject_of(me[:, None], np.arange(120), first_px, PX_PER_M, RATE_HZ)
        lost = np.isfinite(me[..., 0]) & np.isnan(found[..., 0])
        assert lost.any(axis=1).mean() < 0.05
