"""A hand's keypoint that stays where it was, trembling, while the hand goes on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import Keypoints
from pytracker.recording.keypoints.stuck import without_stuck
from pytracker.rotation import Array

RATE_HZ = 30.0
WRIST, OTHER = KEYPOINTS.index("left_wrist"), KEYPOINTS.index("right_wrist")
STUCK = slice(35, 65)


def person(seed: int, px_per_m: float = 250.0) -> Array:
    """Both wrists go to and fro by 40 cm in two seconds `(120, 1, 9, 3)`; all points tremble by 2 mm."""
    rng = np.random.default_rng(seed)
    at = {"head": (0.0, 0.0), "shoulder": (0.18, 0.25), "elbow": (0.25, 0.5), "wrist": (0.2, 0.7), "hip": (0.12, 0.75)}
    places = np.zeros((120, 9, 2))
    for k, name in enumerate(KEYPOINTS):
        x, y = at[name.rpartition("_")[2]]
        places[:, k] = (x if name.startswith("left") else -x, y)
    way = 0.2 * np.sin(np.pi * np.arange(120) / RATE_HZ)
    places[:, WRIST, 1] += way
    places[:, OTHER, 1] -= way
    places += rng.normal(0.0, 0.002, places.shape)
    pixels = 300.0 + px_per_m * places
    return np.concatenate([pixels, np.ones((120, 9, 1))], axis=-1)[:, None]


def of(points: Array) -> Keypoints:
    return Keypoints(np.arange(len(points)), points)


@pytest.mark.parametrize("noise_px", [0.02, 0.5, 1.0])
@pytest.mark.parametrize("px_per_m", [250.0, 1000.0])
def test_a_stuck_wrist_is_left_out(px_per_m: float, noise_px: float, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    points = person(0, px_per_m)
    points[STUCK, 0, WRIST, :2] = points[35, 0, WRIST, :2] + rng.normal(0.0, noise_px, (30, 2))
    kept, said = without_stuck(tmp_path / "k.csv", of(points), RATE_HZ)
    gone = np.isnan(kept.points[:, 0, :, 0])
    assert gone[39:65, WRIST].all()
    assert gone[:, WRIST].sum() <= 34
    assert not np.delete(gone, WRIST, axis=1).any()
    assert "left wrist in frames" in said[0]
    assert "stuck, not seen, and left out" in said[0]


def test_right_points_stay(tmp_path: Path) -> None:
    for seed in range(5):
        points = person(seed)
        kept, said = without_stuck(tmp_path / "k.csv", of(points), RATE_HZ)
        assert said == ()
        assert kept.points is points


def test_who_rests_and_goes_on_stays(tmp_path: Path) -> None:
    """From rest by 25 m/s² along the way, faster than people: no frame leaps."""
    points, since_s = person(0), np.maximum(np.arange(120) - 59, 0)[:, None] / RATE_HZ
    points[:, 0, WRIST, :2] = points[0, 0, WRIST, :2] + np.minimum(250.0 * 0.5 * 25.0 * since_s**2, 100.0)
    points[:, 0, WRIST, :2] += np.random.default_rng(0).normal(0.0, 0.4, (120, 2))
    assert without_stuck(tmp_path / "k.csv", of(points), RATE_HZ)[1] == ()


def test_a_stray_point_and_an_exchange_of_sides_are_no_leap(tmp_path: Path) -> None:
    points, rng = person(0), np.random.default_rng(2)
    for joint in (WRIST, OTHER):
        points[20:70, 0, joint, :2] = points[20, 0, joint, :2] + rng.normal(0.0, 0.5, (50, 2))
    strayed, exchanged, leapt = (points[:70].copy() for _ in range(3))
    strayed[50, 0, WRIST, :2] += 80.0
    exchanged[50:, 0, [WRIST, OTHER]] = points[50:70, 0, [OTHER, WRIST]]
    leapt[50:, 0, WRIST, :2] += 80.0
    assert without_stuck(tmp_path / "k.csv", of(leapt), RATE_HZ)[1] != ()
    for odd in (strayed, exchanged):
        assert without_stuck(tmp_path / "k.csv", of(odd), RATE_HZ)[1] == ()


def test_of_several_people_nothing_is_said(tmp_path: Path) -> None:
    points = person(0)
    points[STUCK, 0, WRIST, :2] = points[35, 0, WRIST, :2]
    both = np.concatenate([points, person(1)], axis=1)
    assert without_stuck(tmp_path / "k.csv", of(both), RATE_HZ)[1] == ()
