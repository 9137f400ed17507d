"""Gaps of a truth that were filled in are no truth; what was measured stays, whatever its digits."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import pytracker as pt
from pytracker.formats.markers import Markers
from pytracker.formats.trc import read_trc
from pytracker.recording.truth.filled import without_filled
from pytracker.rotation import Array
from pytracker.simulate.arm import ArmSimulation

FILE = Path("truth.csv")


def markers(time_s: Array, points: Array) -> Markers:
    return Markers(time_s=time_s, positions_m={"wrist": points}, rate_hz=None)


def filled(time_s: Array, points: Array) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """Which rows were taken for filled in, and what is said."""
    kept, words = without_filled(FILE, markers(time_s, points), "wrist")
    return np.asarray(np.isnan(kept[:, 0]) & np.isfinite(points[:, 0])), words


def with_gap(points: Array, first: int, end: int, how: str) -> Array:
    """Rows from `first` on that were not measured."""
    points = points.copy()
    if how == "held":
        points[first:end] = points[first - 1]
    else:
        points[first - 1 : end + 1] = np.linspace(points[first - 1], points[end], end + 2 - first)
    return points


@pytest.mark.parametrize("how", ["line", "held"])
@pytest.mark.parametrize("digits", [4, 6])
@pytest.mark.parametrize("rate_hz", [30.0, 100.0])
@pytest.mark.parametrize("noise_m", [0.0, 0.0003])
@pytest.mark.parametrize("pattern", ["circle", "gesture", "reach"])
def test_what_was_filled_in_is_found(pattern: str, noise_m: float, rate_hz: float, digits: int, how: str) -> None:
    rng = np.random.default_rng(3)
    time_s = np.arange(0.0, 12.0, 1.0 / rate_hz)
    places = ArmSimulation(pt.ArmScene(pattern=pattern, duration_s=12.0), 5).wrist(time_s)
    places = places + rng.normal(0.0, 1.0, places.shape) * noise_m
    assert filled(time_s, np.round(places, digits))[1] == ()
    first, end = round(2.3 * rate_hz), round(3.9 * rate_hz)
    found, words = filled(time_s, np.round(with_gap(places, first, end, how), digits))
    assert found[first:end].mean() > 0.9
    assert not found[: first - 2].any()
    assert not found[end + 2 :].any()
    assert "filled in or held, not measured, and left out of the scores" in words[0]


def test_what_comes_to_rest_stays() -> None:
    """A simulated hand that waits, to the last digit, goes and stops as hands do; so does one that goes evenly on."""
    time_s = np.arange(0.0, 6.0, 0.01)
    share = np.clip((time_s - 2.0) / 1.5, 0.0, 1.0)
    eased = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    points = np.array([0.1, 0.2, 0.3]) + np.outer(eased, [0.3, 0.1, -0.2])
    assert filled(time_s, points)[1] == ()
    assert filled(time_s, np.outer(time_s, [0.1, 0.0, 0.0]))[1] == ()
    assert filled(time_s[:5], points[:5])[1] == ()
    assert filled(time_s, np.full((600, 3), np.nan))[1] == ()


def test_markers_of_people_stay_and_their_gaps_are_found(shared: Callable[[str], Path]) -> None:
    for file in sorted(shared("data/people/gestures").glob("0_1_*.trc")):
        found = read_trc(file)
        for name in ("RWrist", "LWrist", "Head"):
            points = found.positions_m[name]
            assert without_filled(file, found, name)[1] == ()
            moved = np.linalg.norm(points[30:-30] - points[:-60], axis=1)
            first = int(moved.argmax())
            if moved[first] > 0.1:
                held = {name: with_gap(points, first, first + 30, "held")}
                kept, _ = without_filled(file, Markers(found.time_s, held, None), name)
                assert np.isnan(kept[first : first + 30, 0]).mean() > 0.9


def test_filled_gaps_are_not_scored(tmp_path: Path) -> None:
    folder = pt.simulate_arm(tmp_path / "arm", pt.ArmScene(duration_s=6.0), 2)
    right = pt.load(folder)
    track = pt.track(right, pt.Mixture())
    text = (folder / "qualisys.tsv").read_text().splitlines()
    first = next(k for k, line in enumerate(text) if line[:1].isdigit() or line[:1] == "-")
    text[first + 200 : first + 400] = [text[first + 199]] * 200
    (folder / "qualisys.tsv").write_text("\n".join(text) + "\n")
    recording = pt.load(folder)
    assert any(
        "wrist goes straight on, or stays, to the last digit in 199 of 601 rows" in w for w in recording.warnings
    )
    was, now = (pt.evaluate(track, truth).joints["wrist"] for truth in (right.truth, recording.truth))
    assert now.rms_m < 1.2 * was.rms_m
    assert now.frames < was.frames - 45


@pytest.mark.parametrize("digits", [3, 4])
@pytest.mark.parametrize("rate_hz", [25.0, 50.0, 100.0])
def test_a_hand_that_reaches_and_rests_is_measured(rate_hz: float, digits: int) -> None:
    """In whole millimetres a rest is the same to the last digit, and a hand that is put down stops at once."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        time_s = np.arange(0.0, 20.0, 1.0 / rate_hz)
        places, at, begins = np.zeros((len(time_s), 3)), np.zeros(3), 1.0
        while begins < 19.0:
            lasts, there = rng.uniform(0.5, 1.2), rng.normal(0.0, 0.15, 3)
            share = np.clip((time_s - begins) / lasts, 0.0, 1.0)
            places += np.outer(share**2 * (3.0 - 2.0 * share), there - at)
            at, begins = there, begins + lasts + rng.uniform(0.5, 3.0)
        for noise_m in (0.0, 0.0001):
            trembling = places + noise_m * rng.standard_normal(places.shape)
            assert filled(time_s, np.round(trembling, digits))[1] == ()
