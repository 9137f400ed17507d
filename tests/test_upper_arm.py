"""A second sensor, on the upper arm: set up, and told where its clock or heading is another."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from test_arm_senses import load, simulated

import pytracker as pt
from pytracker.doubting import doubts
from pytracker.doubting.upper_arm import of_upper_arm
from pytracker.rotation import multiply, rotation_vector_to_quaternion
from pytracker.setup import check
from pytracker.tracking import ArmTrack


def test_a_sensor_that_points_elsewhere_is_told_and_does_little_harm() -> None:
    recording, seen = simulated(102, ("upper_arm",), pattern="gesture", period_s=2.0)
    right = pt.track(recording, pt.Smooth(), 1, sightings=seen)
    assert doubts(right) == ()
    turn = rotation_vector_to_quaternion(np.array([0.0, 0.0, np.radians(30.0)]))
    fore, upper = recording.imus
    upper = dataclasses.replace(upper, q_world_segment=multiply(turn[None], upper.q_world_segment))
    wrong = dataclasses.replace(recording, imus=(fore, upper))
    track = pt.track(wrong, pt.Smooth(), 1, sightings=seen)
    assert any("the upper arm's sensor points" in words and "heading_deg" in words for words in doubts(track))
    assert pt.evaluate(track, recording.truth).joints["wrist"].rms_m < 0.08


@pytest.mark.parametrize("seed", [11, 21])
def test_the_clock_of_a_second_sensor_is_told(seed: int) -> None:
    """It took slow arms 5 to 15 cm off, valid, beside their bands in up to 30 % of the frames, and nothing was said."""
    recording, seen = simulated(seed, ("upper_arm",), pattern="reach", period_s=5.0, duration_s=16.0)
    assert doubts(pt.track(recording, pt.Smooth(), 1, sightings=seen)) == ()
    fore, upper = recording.imus
    early = dataclasses.replace(recording, imus=(fore, dataclasses.replace(upper, time_s=upper.time_s - 1.0)))
    said = doubts(pt.track(early, pt.Smooth(), 1, sightings=seen))
    assert len(said) == 1
    assert re.search(r"offset_s of imu\[1\] changed by \+(0.9|1.0|1.1) s", said[0])


def test_clocks_of_a_second_sensor_are_compared_on_the_same_frames() -> None:
    """Of one that ends early another clock leaves out frames in which the arm is tracked worse: that is no better."""
    recording, seen = simulated(12, ("upper_arm",), pattern="reach", period_s=5.0, duration_s=8.0)
    track = pt.track(recording, pt.Smooth(), 1, sightings=seen)
    assert isinstance(track, ArmTrack)
    elbow = track.joints["elbow"]
    rests = np.repeat(elbow.mean[100:101], len(elbow.mean), axis=0)
    rests[:50, 2] += 0.15
    track = dataclasses.replace(track, joints={**track.joints, "elbow": dataclasses.replace(elbow, mean=rests)})
    fore, upper = recording.imus
    at = int(np.searchsorted(upper.time_s, track.time_s[100]))
    until, still = upper.time_s < 5.0, np.repeat(upper.q_world_segment[at : at + 1], len(upper.time_s), axis=0)
    parts = {name: getattr(upper, name)[until] for name in ("time_s", "acc", "gyr")}
    early = dataclasses.replace(upper, **parts, q_world_segment=still[until])
    recording = dataclasses.replace(recording, imus=(fore, early))
    assert not any(
        "changed by" in words for words in of_upper_arm(dataclasses.replace(track, recording=recording), track)
    )


def test_a_sensor_that_ends_early_does_not_move_the_clock() -> None:
    recording, seen = simulated(2, ("upper_arm",), duration_s=6.0)
    fore, upper = recording.imus
    assert upper.gyr is not None
    until = upper.time_s < 4.0
    parts = {name: getattr(upper, name)[until] for name in ("time_s", "acc", "q_world_segment", "gyr")}
    early = dataclasses.replace(recording, imus=(fore, dataclasses.replace(upper, **parts)))
    whole, ended = (pt.track(of, pt.Smooth(), 1, sightings=seen) for of in (recording, early))
    delays = [np.nanmean(track.state_mean[:, -1]) for track in (whole, ended)]
    assert abs(delays[0] - delays[1]) < 0.04
    assert not any("upper arm's sensor points" in words for words in doubts(ended))


def test_a_second_sensor_is_set_up_with_the_first(tmp_path: Path) -> None:
    """Both files by a clock 17.3 s ahead, in an earth frame turned by 70°, in g: checked, written, tracked."""
    scene = pt.ArmScene(worn=True, duration_s=15.0, pattern="gesture", period_s=2.0, senses=("upper_arm",))
    folder = pt.simulate_arm(tmp_path / "arm", scene, 5)
    turn = rotation_vector_to_quaternion(np.array([0.0, 0.0, np.radians(70.0)]))
    for name in ("imu.csv", "upper_arm.csv"):
        header, rows = (folder / name).read_text("utf-8").split("\n", 1)
        values = np.array([row.split(",") for row in rows.split()], dtype=float)
        values[:, 0] += 17.3
        values[:, 1:4] /= 9.80665
        values[:, 7:11] = multiply(turn[None], values[:, 7:11])
        np.savetxt(folder / name, values, fmt="%.7f", delimiter=",", header=header, comments="")
    checkup = check(folder, write=True)
    assert all(finding.verdict != "wrong" for finding in checkup.findings if "whole" in finding.what)
    text = (folder / "recording.toml").read_text("utf-8")
    assert text.count('acc_unit = "g"') == 2
    assert text.count("offset_s = -17.") == 2
    recording = load(folder)
    score = pt.evaluate(pt.track(recording, pt.Smooth(), 1), recording.truth).joints["wrist"]
    assert score.rms_m < 0.05
