"""What a detector's confidences are worth: spreads that the data show, and points that are guesses."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pytracker.formats.keypoints.read import Keypoints
from pytracker.recording.keypoints.filled import as_seen
from pytracker.recording.keypoints.spreads import with_spreads
from pytracker.rotation import Array


def jittered(sd_px: Array, rng: np.random.Generator) -> Keypoints:
    """A person who moves slowly, seen with so much noise at the confidences 0.95, 0.8 and 0.2."""
    count = 600
    slow = 3.0 * np.sin(0.02 * np.arange(count))[:, None, None, None] + rng.uniform(50, 400, (1, 1, 9, 2))
    which = rng.integers(0, 3, (count, 1, 9))
    uv = slow + sd_px[which][..., None] * rng.standard_normal((count, 1, 9, 2))
    confidence = np.array([0.95, 0.8, 0.2])[which]
    return Keypoints(np.arange(count), np.concatenate([uv, confidence[..., None]], axis=-1))


def test_a_confidence_is_worth_what_the_points_jump() -> None:
    sd_px = np.array([2.0, 4.0, 9.0])
    keypoints = jittered(sd_px, np.random.default_rng(1))
    found = with_spreads(keypoints)[..., 2]
    # Neighbours in time are of any confidence: what is sure looks worse than it is, and the order is right.
    of_each = [float(np.median(found[np.isclose(keypoints.points[..., 2], c)])) for c in (0.95, 0.8, 0.2)]
    assert of_each == sorted(of_each)
    assert 1.5 < of_each[0] < 6.0
    assert 5.0 < of_each[2] < 12.0


def test_faith_in_a_confidence_is_not_asked_for() -> None:
    """A detector that is sure of everything and wrong by 5 px is taken to be wrong by 5 px."""
    keypoints = jittered(np.array([5.0, 5.0, 5.0]), np.random.default_rng(2))
    sure = Keypoints(keypoints.frames, np.concatenate([keypoints.points[..., :2], np.ones((600, 1, 9, 1))], axis=-1))
    assert np.allclose(with_spreads(sure)[..., 2], 5.0, rtol=0.15)


def test_places_of_what_was_not_seen_are_left_out(tmp_path: Path) -> None:
    """As DeepLabCut writes them: a right track was valid in 6 % of the frames, its points called somebody else's."""
    rng = np.random.default_rng(3)
    keypoints = jittered(np.array([1.0, 1.0, 1.0]), rng)
    is_guess = rng.random((600, 1, 9)) < 0.3
    points = np.where(is_guess[..., None], rng.uniform(0, 400, (600, 1, 9, 3)), keypoints.points)
    points[..., 2] = np.where(is_guess, 0.02, 0.95)
    kept, (said,) = as_seen(tmp_path / "k.csv", Keypoints(keypoints.frames, points))
    assert (np.isnan(kept.points[..., 0]) == is_guess).all()
    assert re.search(rf"k\.csv: {is_guess.sum()} points of a confidence of at most 0\.3 lie anywhere", said)
    kept, said_of_unsure = as_seen(tmp_path / "k.csv", jittered(np.array([1.0, 2.0, 6.0]), rng))
    assert np.isfinite(kept.points).all()
    assert said_of_unsure == ()


@pytest.mark.parametrize("joints", [1, 2, 9])
def test_points_of_an_arm_or_of_a_fast_hand_are_seen(joints: int, tmp_path: Path) -> None:
    """Of an elbow alone two thirds were called guesses, of a hand that circles at 10 Hz all."""
    rng, count = np.random.default_rng(6), 600
    points = np.full((count, 1, 9, 3), np.nan)
    points[:, 0, :joints, :2] = np.arange(joints)[:, None] * [5.0, 40.0] + rng.normal(0, 2.0, (count, joints, 2))
    points[:, 0, :joints, 2] = rng.choice([0.6, 0.95], (count, joints))
    turn = 2 * np.pi * np.arange(count) / 10
    points[:, 0, 0, :2] += 100.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    points[:, 0, 0, 2] = 0.4
    kept, said = as_seen(tmp_path / "k.csv", Keypoints(np.arange(count), points))
    assert np.isfinite(kept.points[:, 0, :joints, 0]).all()
    assert said == ()


@given(
    hnp.arrays(np.float64, (6, 2, 9, 3), elements=st.floats(-1e4, 1e4) | st.just(float("nan"))),
    st.lists(st.integers(0, 50), min_size=6, max_size=6, unique=True),
)
def test_spreads_are_positive_and_only_of_what_was_seen(points: Array, frames: list[int]) -> None:
    points[np.isnan(points).any(axis=-1)] = np.nan
    found = with_spreads(Keypoints(np.sort(np.array(frames)), points))
    seen = np.isfinite(points[..., 0])
    assert (found[seen][:, 2] > 0).all()
    assert np.isnan(found[~seen]).all()
