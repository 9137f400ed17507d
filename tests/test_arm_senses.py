"""An arm with more senses: patches or keypoints of shoulder and elbow, a sensor on the upper arm."""

from __future__ import annotations

import dataclasses
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import made_once

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.evidence import Landmarks
from pytracker.methods import ArmMethod
from pytracker.rotation import multiply
from pytracker.setup import check
from pytracker.simulate import ArmSimulation

UPPER, FORE = (f'segment = "right_{of}"' for of in ("upper_arm", "forearm"))
ALL = ("shoulder", "elbow", "upper_arm")
PATTERNS: tuple[dict[str, Any], ...] = ({}, {"pattern": "gesture", "period_s": 2.0}, {"pattern": "reach"})


def simulated(seed: int, senses: tuple[str, ...], **scene: Any) -> tuple[pt.ArmRecording, pt.Sightings]:
    simulation = ArmSimulation(pt.ArmScene(worn=True, senses=senses, **scene), seed)
    seen = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(), simulation.landmarks())
    return simulation.recording(), seen


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = pt.ArmScene(worn=True, duration_s=6.0, senses=ALL)
    return made_once(tmp_path_factory, "senses", lambda folder: pt.simulate_arm(folder, scene, 3))


def load(folder: Path) -> pt.ArmRecording:
    recording = pt.load(folder)
    assert isinstance(recording, pt.ArmRecording)
    return recording


def changed(folder: Path, to: Path, change: Callable[[str], str]) -> Path:
    """The same recording with another `recording.toml`."""
    to.mkdir()
    for file in folder.iterdir():
        (to / file.name).symlink_to(file)
    toml = to / "recording.toml"
    text = change(toml.read_text("utf-8"))
    toml.unlink()
    toml.write_text(text, "utf-8")
    return to


def pooled_cm(method: ArmMethod, senses: tuple[str, ...], seeds: tuple[int, ...]) -> tuple[float, np.ndarray]:
    """3-D RMS error of the wrist and coverage by axis over the three patterns."""
    errors, coverage = [], []
    for seed in seeds:
        for pattern in PATTERNS:
            recording, seen = simulated(seed, senses, duration_s=12.0, **pattern)
            score = pt.evaluate(pt.track(recording, method, seed, sightings=seen), recording.truth).joints["wrist"]
            errors.append(score.rms_m)
            coverage.append(score.coverage)
    return 100 * float(np.sqrt(np.mean(np.square(errors)))), np.mean(coverage, axis=0)


@pytest.mark.parametrize("method", [pt.Mixture(), pt.Smooth()], ids=lambda method: method.name)
def test_a_sensor_on_the_upper_arm_halves_the_error(method: ArmMethod) -> None:
    """Tuned on seeds 101 to 103; these are others."""
    alone, _ = pooled_cm(method, (), (1, 2))
    with_sensor, coverage = pooled_cm(method, ("upper_arm",), (1, 2))
    everything, _ = pooled_cm(method, ALL, (1, 2))
    assert with_sensor < 0.65 * alone
    assert with_sensor < 4.5
    assert everything < with_sensor + 0.3
    assert (coverage > 0.8).all()


def test_from_pixels_to_a_page(folder: Path, tmp_path: Path) -> None:
    recording = load(folder)
    assert recording.landmarks == ("shoulder", "elbow")
    assert [imu.segment for imu in recording.imus] == ["right_forearm", "right_upper_arm"]
    assert recording.warnings == ()
    track = pt.track(recording, pt.Smooth(), 1)
    assert all(np.isfinite(of.pixels).all(axis=1).mean() > 0.9 for of in track.sightings.landmarks)
    score = pt.evaluate(track, recording.truth).joints["wrist"]
    assert score.rms_m < 0.045
    page = (pt.write_report([track], tmp_path / "page") / "index.html").read_text("utf-8")
    assert (
        "which was used: the shoulder (seen in 100 %), the elbow (seen in 100 %) and a sensor on the upper arm." in page
    )
    paper = pt.track(recording, pt.Layered(), 1, sightings=track.sightings)
    page = (pt.write_report([paper], tmp_path / "paper") / "index.html").read_text("utf-8")
    assert "which was not used by this method: the shoulder" in page


def test_online_it_is_the_same_to_the_bit(folder: Path) -> None:
    recording = load(folder)
    track = pt.track(recording, pt.Mixture(), 1)
    tracker = pt.Tracker(recording, track.method, 1, delay_s=0.2)
    observations = list(recording.observations(track.sightings))
    # What is of the past comes late.
    late = sorted(observations, key=lambda o: o.time_s + (0.1 if o.what in ("landmark", "orientation") else 0.0))
    estimates = [found for observation in late if (found := tracker.observe(observation)) is not None]
    means = [estimate.places["wrist"].mean for estimate in (*estimates, *tracker.finish())]
    whole = track.joints["wrist"].mean
    assert np.array_equal(np.array(means), whole[np.isfinite(whole[:, 0])])


@pytest.mark.parametrize(
    ("late_s", "heading", "expected"),
    [
        (0.4, "", "before are tracked without"),
        (0.4, "heading_deg = 0.0", "before are tracked without"),
        (2.0, "heading_deg = 0.0", "before are tracked without"),
        (2.0, "", "to 0.5 s later, to tell its heading, or heading_deg"),
    ],
)
def test_a_second_sensor_may_begin_late(
    folder: Path, tmp_path: Path, late_s: float, heading: str, expected: str
) -> None:
    """It was refused, with the advice to check a clock that was right."""
    other = changed(folder, tmp_path / "late", lambda text: text.replace("heading_deg = 0.0", heading))
    (other / "upper_arm.csv").unlink()
    header, *rows = (folder / "upper_arm.csv").read_text("utf-8").splitlines()
    kept = [row for row in rows if float(row.split(",")[0]) > late_s]
    (other / "upper_arm.csv").write_text("\n".join([header, *kept, ""]), "utf-8")
    if "to tell" in expected:
        with pytest.raises(pt.InputError, match=re.escape(expected)):
            pt.load(other)
        return
    recording = load(other)
    assert any(expected in words for words in recording.warnings)
    track = pt.track(recording, pt.Smooth(), 1)
    assert pt.evaluate(track, recording.truth).joints["wrist"].rms_m < 0.08


def test_a_copy_of_the_first_sensors_file_is_refused(folder: Path, tmp_path: Path) -> None:
    other = changed(folder, tmp_path / "copy", lambda text: text)
    (other / "upper_arm.csv").unlink()
    shutil.copyfile(folder / "imu.csv", other / "upper_arm.csv")
    with pytest.raises(pt.InputError, match=r"imu\[1\].file, upper_arm.csv, is a copy of imu.csv"):
        pt.load(other)


def test_a_heading_that_is_not_given_is_found_from_the_first_frame(folder: Path, tmp_path: Path) -> None:
    def without(text: str) -> str:
        return text.replace("heading_deg = 0.0\n", "")

    given, found = load(folder), load(changed(folder, tmp_path / "found", without))
    between = multiply(found.imus[1].q_world_segment[:1], given.imus[1].q_world_segment[:1] * [1, -1, -1, -1])
    assert 2 * np.degrees(np.arccos(abs(between[0, 0]))) < 12.0


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (UPPER, 'segment = "left_upper_arm"', "imu[1].segment is 'left_upper_arm', expected 'right_upper_arm'"),
        (UPPER, FORE, "imu[1].segment is 'right_forearm'"),
        (FORE, UPPER, "imu[0] is worn by the upper arm, expected the forearm's first"),
        ("heading_deg = 0.0", "heading_deg = 120.0", "the upper arm points"),
        ("heading_deg = 0.0", "offset_s = 60.0", "expected it to cover the first frame"),
        ("elbow = [", "hand = [", "hand"),
        (re.compile(r"elbow = \[\d+"), "elbow = [900", "patches.elbow is [900"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(
    folder: Path, tmp_path: Path, old: str | re.Pattern[str], new: str, expected: str
) -> None:
    def other(text: str) -> str:
        made = re.sub(old, new, text) if isinstance(old, re.Pattern) else text.replace(old, new)
        assert made != text
        return made

    with pytest.raises(pt.InputError, match=re.escape(expected)):
        pt.load(changed(folder, tmp_path / "other", other))


def test_a_shoulder_that_is_seen_elsewhere_is_refused(folder: Path, tmp_path: Path) -> None:
    """The box lies on the elbow's patch."""

    def other(text: str) -> str:
        (elbow,) = re.findall(r"elbow = (\[[^]]*\])", text)
        return re.sub(r"shoulder = \[[^]]*\]", f"shoulder = {elbow}", text)

    recording = load(changed(folder, tmp_path / "elsewhere", other))
    with pytest.raises(
        pt.InputError, match=r"camera\[0\]: what is seen of the shoulder is \d+ px from where shoulder_m is"
    ):
        pt.track(recording, pt.Mixture(), 1)


def keypoint_table(recording: pt.ArmRecording, side: str) -> str:
    """A detector's table of this arm, two pixels off, the wrong one's points 150 px beside."""
    assert recording.truth is not None
    time_s = np.arange(150) / 25.0
    rng = np.random.default_rng(4)
    columns = {}
    for joint in ("shoulder", "elbow", "wrist"):
        at = recording.truth.at(joint, time_s)
        pixels = recording.views[0].camera.project(at) + 2.0 * rng.standard_normal((len(time_s), 2))
        other = "left" if side == "right" else "right"
        columns[f"{side}_{joint}"], columns[f"{other}_{joint}"] = (
            pixels,
            np.clip(pixels + np.array([150.0, 10.0]), 0, 470),
        )
    header = ",".join(f"{name}_{axis}" for name in columns for axis in "xy")
    rows = "\n".join(",".join(f"{v:.2f}" for v in row) for row in np.hstack(list(columns.values())))
    return f"{header}\n{rows}\n"


def with_keypoints(text: str) -> str:
    text = re.sub(r"patches = .*\n", 'keypoints = "points.csv"\n', text)
    return text[: text.index('[[imu]]\nfile = "upper_arm.csv"')] + text[text.index("[arm]") :]


def test_keypoints_say_where_shoulder_and_elbow_are(folder: Path, tmp_path: Path) -> None:
    there = changed(folder, tmp_path / "points", with_keypoints)
    (there / "points.csv").write_text(keypoint_table(load(folder), "right"), "utf-8")
    recording = load(there)
    assert recording.landmarks == ("shoulder", "elbow")
    assert there / "points.csv" in recording.files
    track = pt.track(recording, pt.Smooth(), 1)
    shoulder, elbow = track.sightings.landmarks
    assert recording.truth is not None
    expected = recording.views[0].camera.project(recording.truth.at("elbow", track.time_s))
    # The camera is not quite as it was calibrated: worn.
    assert np.nanmedian(np.linalg.norm(elbow.pixels - expected, axis=1)) < 8.0
    assert 1.0 < np.nanmedian(shoulder.sd_px) < 4.0
    assert pt.evaluate(track, recording.truth).joints["wrist"].rms_m < 0.08


def without_patch(text: str) -> str:
    return re.sub(r"patch_box = .*\n", "", with_keypoints(text))


def test_without_a_patch_the_wrist_is_among_the_keypoints(folder: Path, tmp_path: Path) -> None:
    there = changed(folder, tmp_path / "no patch", without_patch)
    (there / "points.csv").write_text(keypoint_table(load(folder), "right"), "utf-8")
    recording = load(there)
    assert 3.0 < recording.spreads["pixel_sd"] < 6.0  # 12 mm
    track = pt.track(recording, pt.Smooth(), 1)
    assert track.valid.mean() > 0.95
    score = pt.evaluate(track, recording.truth).joints["wrist"]
    assert score.rms_m < 0.08
    assert min(score.coverage) > 0.8
    page = (pt.write_report([track], tmp_path / "page") / "index.html").read_text("utf-8")
    assert "The wrist (a detector&#39;s keypoint) was seen in 100.0 %" in page
    verdicts = {finding.what: finding.verdict for finding in check(there).findings}
    assert verdicts["patch"] == verdicts["patch, followed"] == "right"
    assert "clock" in verdicts or "clock, heading and mount" in verdicts


def test_a_detector_that_looks_at_every_third_frame(folder: Path, tmp_path: Path) -> None:
    """Two of three frames were not valid, and 0.9 cm off."""
    there = changed(folder, tmp_path / "every third", without_patch)
    head, *rows = keypoint_table(load(folder), "right").splitlines()
    head, rows = f"frame,{head}", [f"{k},{row}" for k, row in enumerate(rows)]
    (there / "points.csv").write_text("\n".join([head, *rows[::3]]) + "\n", "utf-8")
    track = pt.track(load(there), pt.Smooth(), 1)
    assert track.valid.mean() > 0.95
    (there / "points.csv").write_text("\n".join([head, *rows[:30], *rows[60:]]) + "\n", "utf-8")
    assert (~pt.track(load(there), pt.Smooth(), 1).valid).sum() >= 30


@pytest.mark.parametrize(
    ("change", "points", "expected"),
    [
        (lambda text: re.sub(r"patch_box = .*\n", "", text), None, r"camera\[0\].patch_box is missing"),
        (
            without_patch,
            lambda table: re.sub(r"right_wrist", "right_hip", table),
            "has no right wrist in the first 5 frames",
        ),
    ],
)
def test_neither_patch_nor_wrist(
    folder: Path,
    tmp_path: Path,
    change: Callable[[str], str],
    points: Callable[[str], str] | None,
    expected: str,
) -> None:
    there = changed(folder, tmp_path / "neither", change)
    if points is not None:
        (there / "points.csv").write_text(points(keypoint_table(load(folder), "right")), "utf-8")
    with pytest.raises(pt.InputError, match=expected):
        pt.load(there)


def test_the_other_arms_keypoints_are_refused(folder: Path, tmp_path: Path) -> None:
    there = changed(folder, tmp_path / "mirrored", with_keypoints)
    (there / "points.csv").write_text(keypoint_table(load(folder), "left"), "utf-8")
    with pytest.raises(pt.InputError, match=r"check arm\.side, or whether the video is mirrored"):
        pt.track(load(there), pt.Mixture(), 1)


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: pt.Observation.landmark(0.1, "hand", (1.0, 2.0), 3.0), "hand"),
        (lambda: pt.Observation.landmark(0.1, "elbow", (1.0, 2.0), 0.0), "sd_px of a landmark is 0"),
        (lambda: pt.Observation.landmark(0.1, "elbow", (np.nan, 2.0), 3.0), "pixel of a landmark"),
        (lambda: pt.Observation.landmark(0.1, "elbow", (1.0, 2.0), 3.0, camera=1), "camera of a landmark is 1"),
        (lambda: pt.Observation.orientation(0.1, "right_forearm", (1.0, 0, 0, 0), 0.05), "orientation of a forearm"),
        (lambda: pt.Observation.orientation(0.1, "left_upper_arm", (1.0, 0, 0, 0), 0.05), "of the other arm"),
    ],
)
def test_no_such_observation(make: Callable[[], pt.Observation], expected: str) -> None:
    recording, _ = simulated(1, ALL, duration_s=1.0)
    with pytest.raises(pt.InputError, match=expected):
        pt.Tracker(recording, pt.Mixture()).observe(make())


def test_landmarks_of_another_length_are_refused() -> None:
    wrong = Landmarks("elbow", 0, np.zeros((4, 2)), np.ones(4))
    with pytest.raises(pt.InputError, match="pixels of the elbow have shape"):
        pt.Sightings.of(np.arange(3.0), np.zeros((3, 2)), (wrong,))
    assert "right_elbow" in KEYPOINTS


def test_landmarks_that_the_recording_does_not_have_are_refused() -> None:
    recording, seen = simulated(1, ("elbow",), duration_s=2.0)
    undeclared = dataclasses.replace(recording, landmarks=())
    with pytest.raises(
        pt.InputError, match="sightings hold the elbow of camera 0, expected of the recording's landmarks"
    ):
        pt.track(undeclared, pt.Mixture(), 1, sightings=seen)


def test_what_is_no_elbow_is_refused(folder: Path, tmp_path: Path) -> None:
    """The box lies on the wrist's patch."""

    def other(text: str) -> str:
        (wrist,) = re.findall(r"patch_box = (.*)", text)
        return re.sub(r"elbow = \[[^]]*\]", f"elbow = {wrist}", text)

    with pytest.raises(pt.InputError, match=r"what is seen of the elbow is \d cm from the wrist"):
        pt.track(load(changed(folder, tmp_path / "elbow", other)), pt.Mixture(), 1)


def test_a_landmark_is_live_only_with_its_frame() -> None:
    """One of the past is refused, one of the future waits, and the same one twice is one."""
    recording, seen = simulated(1, ("shoulder",), duration_s=2.0)
    observations = list(recording.observations(seen))

    def wrist(made: list[pt.Observation]) -> np.ndarray:
        return np.array([e.places["wrist"].mean for o in made if (e := pt_tracker.observe(o)) is not None])

    pt_tracker = pt.Tracker(recording, pt.Mixture(), 1)
    once = wrist(observations)
    pt_tracker = pt.Tracker(recording, pt.Mixture(), 1)
    twice = wrist([o for o in observations for _ in range(2 if o.what == "landmark" else 1)])
    assert np.array_equal(once, twice)
    pt_tracker = pt.Tracker(recording, pt.Mixture(), 1)
    ahead = sorted(observations, key=lambda o: o.time_s - (0.05 if o.what == "landmark" else 0.0))
    assert [o.time_s for o in ahead] != [o.time_s for o in observations]
    assert np.array_equal(once, wrist(ahead))
    with pytest.raises(pt.InputError, match=r"landmark at 0\.5"):
        pt_tracker.observe(pt.Observation.landmark(0.5, "shoulder", (300.0, 100.0), 4.0))
