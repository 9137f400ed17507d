"""What body tracking must reach, end to end: ten seeds or six people, unless said. Tuned on simulations of other seeds.

Where a claim holds by far, some of the seeds are run by `make acceptance` alone.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE, load_body, made_once
from scipy import stats

import pytracker as pt
from pytracker.methods.body import BodyMethod
from pytracker.scores.evaluate import average_error, frames_to_recover
from pytracker.skeleton import KEY_JOINTS, UPPER_BODY
from pytracker.tracking import BodyTrack

BACK = ("lowerback_rx", "thorax_rx", "lowerneck_rx", "upperneck_rx")
PEOPLE = 10 if IS_ACCEPTANCE else 6


@cache
def tracked(recording: pt.BodyRecording, method: BodyMethod, seed: int) -> BodyTrack:
    """Tracked once for all claims."""
    return pt.track(recording, method, seed)


def average_m(recording: pt.BodyRecording, method: BodyMethod, seeds: range) -> float:
    """Overall average error over the eight key joints, m; two seeds at a time."""

    def of_seed(seed: int) -> float:
        return pt.evaluate(tracked(recording, method, seed), recording.truth).average_m

    with ThreadPoolExecutor(2) as pool:
        return float(np.mean(list(pool.map(of_seed, seeds))))


@cache
@pytest.mark.parametrize(
    ("name", "plain_m", "best_m"), [("body-arm-circles", 0.10, 0.09), ("body-balance", 0.13, 0.115)]
)
def test_recordings_by_another_renderer(
    shared: Callable[[str], Path], name: str, plain_m: float, best_m: float
) -> None:
    """With the wrist where it is, at the end of the whole forearm: 7.5 cm farther out than the end of `radius`."""
    recording = load_body(shared(f"recordings/{name}"))
    seeds = range(1, 11 if IS_ACCEPTANCE else 4)
    assert average_m(recording, pt.BodyPlain(), seeds) <= plain_m
    assert average_m(recording, pt.Partitioned(), seeds) <= best_m


def test_bands_in_depth_are_wide_where_the_depth_is_wrong(shared: Callable[[str], Path]) -> None:
    """Rank correlation of a wrist's standard deviation in depth with its error there, each wrist and seed by itself."""
    recording = load_body(shared("recordings/body-arm-circles"))
    assert recording.truth is not None
    found = []
    for seed in range(1, 11 if IS_ACCEPTANCE else 6):
        track = tracked(recording, pt.Partitioned(), seed)
        for joint in ("left_wrist", "right_wrist"):
            error = np.abs(track.joints[joint].mean - recording.truth.at(joint, track.time_s))[:, 2]
            known = np.isfinite(error)
            found.append(stats.spearmanr(error[known], track.joints[joint].sd[known, 2])[0])
    assert np.mean(found) >= 0.4


def test_bands_in_depth_hold_what_one_camera_does_not_see(clips: list[pt.BodyRecording]) -> None:
    """The trunk's depth is no state of the 11: only what is known beforehand says how far off it may be."""

    def held(method: BodyMethod) -> dict[str, float]:
        found: dict[str, list[float]] = {joint: [] for joint in KEY_JOINTS}
        for clip in clips:
            track = tracked(clip, method, 1)
            assert clip.truth is not None
            for joint, places in track.joints.items():
                truth = clip.truth.at(joint, track.time_s)[1:, 2]
                found[joint].append(float(np.mean((places.lo[1:, 2] <= truth) & (truth <= places.hi[1:, 2]))))
        return {joint: float(np.mean(shares)) for joint, shares in found.items()}

    assert all(share >= 0.85 for share in held(pt.Partitioned()).values())
    assert held(pt.BodyPlain())["head"] == 0.0


def test_islands_say_more_of_the_depth_than_one(clips: list[pt.BodyRecording]) -> None:
    def correlation(method: BodyMethod) -> float:
        found = []
        for clip in clips:
            track = tracked(clip, method, 1)
            assert clip.truth is not None
            for joint in ("left_wrist", "right_wrist"):
                error = np.abs(track.joints[joint].mean - clip.truth.at(joint, track.time_s))[:, 2]
                found.append(stats.spearmanr(error, track.joints[joint].sd[:, 2])[0])
        return float(np.mean(found))

    assert correlation(pt.Partitioned()) > correlation(pt.Partitioned(islands=1)) + 0.05


def test_a_freed_back_helps_where_the_back_bends(shared: Callable[[str], Path]) -> None:
    recording = load_body(shared("recordings/body-balance"))
    freed, seeds = pt.Partitioned(free=(*UPPER_BODY, *BACK)), range(1, 11 if IS_ACCEPTANCE else 3)
    assert average_m(recording, freed, seeds) < average_m(recording, pt.Partitioned(), seeds)


def people(factory: pytest.TempPathFactory, name: str, scene: pt.BodyScene) -> list[pt.BodyRecording]:
    """Simulated ones."""

    def make(folder: Path) -> None:
        folder.mkdir()
        for seed in range(1, PEOPLE + 1):
            pt.simulate_body(folder / str(seed), scene, seed)

    folder = made_once(factory, name, make)
    return [load_body(folder / str(seed)) for seed in range(1, PEOPLE + 1)]


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> list[pt.BodyRecording]:
    return people(tmp_path_factory, "clips", pt.BodyScene(duration_s=4.0))


def test_more_particles_help_most_up_to_300(clips: list[pt.BodyRecording]) -> None:
    """Fig. 5: the gain from 300 to 3000, over ten people, is small beside that to 300 (17.3, 14.7, 14.2 cm)."""

    def error_m(particles: int, seeds: range) -> float:
        return float(np.mean([average_m(clip, pt.BodyPlain(particles=particles), seeds) for clip in clips]))

    seeds = range(1, 3 if IS_ACCEPTANCE else 2)
    few, usual = error_m(10, seeds), error_m(300, seeds)
    assert few > usual + 0.01
    if IS_ACCEPTANCE:
        assert usual - error_m(3000, range(1, 4)) < 0.5 * (few - usual)


def test_the_default_is_better_than_the_paper(clips: list[pt.BodyRecording]) -> None:
    plain = np.mean([average_m(clip, pt.BodyPlain(), range(1, 3)) for clip in clips])
    assert np.mean([average_m(clip, pt.Partitioned(), range(1, 3)) for clip in clips]) < plain


@pytest.fixture(scope="module")
def hidden(tmp_path_factory: pytest.TempPathFactory) -> list[pt.BodyRecording]:
    """People, both of whose forearms are hidden for ten frames."""
    return people(tmp_path_factory, "hidden", pt.BodyScene(duration_s=5.0, hidden=((2.0, 2.334),)))


@pytest.mark.parametrize("method", [pt.BodyPlain(), pt.Partitioned()], ids=lambda m: m.name)
def test_a_loss_is_survived(hidden: list[pt.BodyRecording], method: BodyMethod) -> None:
    """Back within 1.2 times the usual error in 30 frames, in eight of ten."""
    recovered = 0
    for seed, recording in enumerate(hidden, 1):
        assert recording.truth is not None
        error = average_error(pt.track(recording, method, seed), recording.truth)
        usual = float(np.nanmean(np.concatenate([error[:60], error[100:]])))
        frames = frames_to_recover(error, 70, usual)
        recovered += frames is not None and frames <= 30
    assert recovered >= 0.8 * len(hidden)
