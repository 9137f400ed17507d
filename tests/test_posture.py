"""How people hold their arms: what was learned, what it is worth, and simulated people who do what they are asked."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import learn_posture
import numpy as np
import pytest
from conftest import IS_ACCEPTANCE

import pytracker as pt
from pytracker.rotation import Array
from pytracker.simulate.arm_script import MOVEMENTS, arm_script
from pytracker.skeleton.average import average_skeleton

WRISTS = ("left_wrist", "right_wrist")


def moved(movement: str, turned_deg: float = 0.0, seed: int = 1) -> dict[str, Array]:
    """Joints of somebody of 1.75 m, by name `(T, 3)`, m."""
    skeleton, time_s = average_skeleton(1.75), np.arange(0.0, 12.0, 0.05)
    poses = arm_script(skeleton, time_s, 0.93, 1.1, np.random.default_rng(seed), movement, turned_deg)
    return skeleton.joints(poses)


@pytest.mark.parametrize("movement", ["any", *MOVEMENTS])
def test_forearms_are_held_before_the_body_by_either_arm(movement: str) -> None:
    """The right arm mirrors the left: half of its poses had the elbow behind the back."""
    forward = np.split(learn_posture.directions(moved(movement))[:, 5], 2)
    assert all((side > -0.25).mean() > 0.97 for side in forward)


def test_people_do_what_they_are_asked() -> None:
    waving, reaching, bending, meeting = (moved(name) for name in ("waving", "reaching", "bending", "meeting"))
    assert (waving["right_wrist"][:, 1] > waving["right_elbow"][:, 1] + 0.1).mean() > 0.9
    assert (waving["left_wrist"][:, 1] < waving["left_elbow"][:, 1]).all()
    assert np.ptp(reaching["left_wrist"][:, 2]) > 0.4
    assert np.ptp(bending["head"][:, 1]) > 0.15
    assert np.ptp(bending["head"][:, 2]) > 0.3
    hands = np.linalg.norm(meeting["left_wrist"] - meeting["right_wrist"], axis=1)
    # Wrists that are as far apart as one hand is long: the hands lie on each other.
    assert hands.min() < 0.2
    assert (hands < 0.35).mean() > 0.4
    turned = moved("waving", 40.0)
    across = (turned["left_shoulder"] - turned["right_shoulder"]).mean(axis=0)
    assert np.degrees(np.arctan2(-across[2], across[0])) == pytest.approx(40.0, abs=6.0)


@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("movement", {"movement": "swimming"}),
        ("turned_deg", {"turned_deg": 120.0}),
        ("movement", {"movement": "waving", "skeleton": "a.asf", "motion": "a.amc"}),
        ("turned_deg", {"turned_deg": 10.0, "skeleton": "a.asf", "motion": "a.amc"}),
    ],
)
def test_what_nobody_does_is_refused(name: str, more: dict[str, Any]) -> None:
    with pytest.raises(pt.InputError, match=name):
        pt.BodyScene(**more)


@pytest.fixture(scope="module")
def captured(shared: Callable[[str], Path]) -> dict[str, Array]:
    shared("data/cmu")
    return learn_posture.captured()


def test_the_numbers_are_those_that_are_learned(captured: dict[str, Array]) -> None:
    def numbers(text: str) -> Array:
        return np.array([float(x) for x in re.findall(r"-?\d+\.\d{3}", text)])

    shipped = numbers(learn_posture.TABLE.read_text("utf-8"))
    np.testing.assert_allclose(numbers(learn_posture.table(learn_posture.learned(captured))), shipped, atol=0.01)


def test_it_tells_of_people_whom_it_was_not_learned_from(captured: dict[str, Array]) -> None:
    """Whoever is left out is likelier than any pose, and than with forearms behind the body in place of before it."""
    for subject, rows in captured.items():
        of_others = learn_posture.learned({name: x for name, x in captured.items() if name != subject})
        behind = rows * [1, 1, 1, 1, 1, -1]
        found, mirrored = of_others.log_density(rows).mean(), of_others.log_density(behind).mean()
        assert found > 0.8
        assert found > mirrored + 0.5


def test_reaching_arms_are_tracked_the_better_by_it(tmp_path: Path) -> None:
    """Particles by the picture alone: the depth of wrists that reach and meet, pooled over seeds that chose nothing."""
    squares: dict[float, list[Array]] = {0.0: [], pt.Partitioned().posture_weight: []}
    for movement in ("reaching", "meeting"):
        for seed in (21, 22, 23) if IS_ACCEPTANCE else (21,):
            folder = pt.simulate_body(
                tmp_path / f"{movement}-{seed}", pt.BodyScene(movement=movement, duration_s=5.0), seed
            )
            recording = pt.load(folder)
            assert isinstance(recording, pt.BodyRecording)
            assert recording.truth is not None
            for weight, found in squares.items():
                track = pt.track(recording, pt.Partitioned(posture_weight=weight), 1)
                off = [track.joints[joint].mean - recording.truth.at(joint, track.time_s) for joint in WRISTS]
                found.append((np.concatenate(off) ** 2).sum(axis=1))
    without, by_posture = (np.sqrt(np.concatenate(found).mean()) for found in squares.values())
    assert by_posture < 0.9 * without, f"{by_posture:.3f} and {without:.3f} m"


def test_who_came_down_may_have_bent(tmp_path: Path) -> None:
    """One camera takes who bends for one who crouches: bands that did not know of it missed heads half of the time."""
    held: dict[float, list[float]] = {0.0: [], pt.Partitioned().unseen_bend: []}
    for seed in (21, 22):
        recording = pt.load(
            pt.simulate_body(tmp_path / str(seed), pt.BodyScene(movement="bending", duration_s=5.0), seed)
        )
        assert isinstance(recording, pt.BodyRecording)
        assert recording.truth is not None
        for share, found in held.items():
            track = pt.track(recording, pt.Partitioned(unseen_bend=share), 1)
            for joint in ("head", "left_shoulder", "right_shoulder"):
                band, depth = track.joints[joint], recording.truth.at(joint, track.time_s)[:, 2]
                found.append(float(((band.lo[:, 2] <= depth) & (depth <= band.hi[:, 2])).mean()))
    without, with_bends = (np.mean(found) for found in held.values())
    assert with_bends > 0.7
    assert with_bends > without + 0.1
