"""Sensors on a body's arms that are set up wrong: what keypoints say of them, all the way."""

from __future__ import annotations

import dataclasses
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE, SEGMENTS
from test_body_senses import changed, load, without

import pytracker as pt
from pytracker.doubting.body import of_body
from pytracker.doubting.body_sensors import of_sensors
from pytracker.evidence.points.late import Counted
from pytracker.recording.recording import Imu
from pytracker.rotation import Array, multiply, rotation_vector_to_quaternion
from pytracker.tracking import BodyTrack

Spoilt = Callable[[Imu], Imu]


def turned(imu: Imu, by: Array) -> Imu:
    """About the vertical, rad `(M,)`."""
    turn = rotation_vector_to_quaternion(by[:, None] * np.array([0.0, 1.0, 0.0]))
    return dataclasses.replace(imu, q_world_segment=multiply(turn, imu.q_world_segment))


def heading(by_deg: float) -> Spoilt:
    return lambda imu: turned(imu, np.full(len(imu.time_s), np.radians(by_deg)))


def clock(by_s: float) -> Spoilt:
    return lambda imu: dataclasses.replace(imu, time_s=imu.time_s + by_s)


def drifting(by_deg: float) -> Spoilt:
    return lambda imu: turned(imu, np.linspace(0.0, np.radians(by_deg), len(imu.time_s)))


def faster(by: float) -> Spoilt:
    return lambda imu: dataclasses.replace(imu, time_s=imu.time_s[0] + by * (imu.time_s - imu.time_s[0]))


def on_the_upper_arm(imu: Imu) -> Imu:
    return dataclasses.replace(imu, segment=imu.segment.replace("forearm", "upper_arm"))


def said_of(recording: pt.BodyRecording, which: int, spoilt: Spoilt) -> list[str]:
    method = pt.BodySmooth() if recording.view.keypoints is None else pt.BodyMixture()
    imus = tuple(spoilt(imu) if k == which else imu for k, imu in enumerate(recording.imus))
    sds = recording.imu_sds_rad[: len(imus)]
    track = pt.track(dataclasses.replace(recording, imus=imus, imu_sds_rad=sds), method)
    assert isinstance(track, BodyTrack)
    return [words for words in track.doubts if "imu[" in words]


@pytest.mark.parametrize(
    ("spoilt", "words"),
    [
        (heading(90.0), r"heading_deg turned by -(85|90|95)"),
        (heading(-40.0), r"heading_deg turned by \+(30|35|40|45|50)"),
        (clock(-0.3), r"offset_s greater by \+0.(25|30|35|40)"),
        (clock(1.0), r"offset_s greater by -1.00"),
        (drifting(90.0), "heading_deg"),
        (faster(1.2), "offset_s"),
        (on_the_upper_arm, r"check (these, )?segment"),
    ],
    ids=["heading", "heading back", "late", "early", "drift", "rate", "segment"],
)
def test_a_sensor_that_is_set_up_wrong_is_told_by_name(sensed: Path, spoilt: Spoilt, words: str) -> None:
    recording = pt.load(sensed)
    assert isinstance(recording, pt.BodyRecording)
    recording = dataclasses.replace(recording, imus=recording.imus[:2], imu_sds_rad=recording.imu_sds_rad[:2])
    for which in range(2):
        told = said_of(recording, which, spoilt)
        assert len(told) == 1
        assert f"imu[{which}]" in told[0]
        assert re.search(words, told[0]), told[0]


def test_exchanged_sensors_are_told_so(tmp_path: Path) -> None:
    """They were told as headings and clocks that are off."""
    scene = pt.BodyScene(
        movement="crossing", duration_s=6.0, keypoint_sd_px=3.0, imus=("left_forearm", "right_forearm")
    )
    recording = pt.load(pt.simulate_body(tmp_path / "crossing", scene, 5))
    assert isinstance(recording, pt.BodyRecording)
    left, right = recording.imus
    imus = (dataclasses.replace(right, segment=left.segment), dataclasses.replace(left, segment=right.segment))
    told = said_of(dataclasses.replace(recording, imus=imus), -1, heading(0.0))
    assert len(told) == 2
    assert all(re.search(r"are imu\[[01]\] and imu\[[01]\] exchanged\?", words) for words in told)


def test_sensors_that_are_right_are_not_doubted(sensed: Path, tmp_path: Path) -> None:
    """Nor where they are 5° off, worn on all four segments, and the detector is half as good."""
    for seed in (16, 17):
        scene = pt.BodyScene(duration_s=5.0, keypoint_sd_px=4.0, imus=SEGMENTS, imu_sd_deg=5.0)
        recording = pt.load(pt.simulate_body(tmp_path / str(seed), scene, seed))
        assert isinstance(recording, pt.BodyRecording)
        assert said_of(recording, -1, heading(0.0)) == []
    recording = pt.load(sensed)
    assert isinstance(recording, pt.BodyRecording)
    assert said_of(recording, -1, heading(0.0)) == []


def test_pictures_tell_of_sensors_where_there_are_no_keypoints(sensed: Path) -> None:
    """Less well: a heading 90° off, a clock a second off; and nothing of right ones."""
    recording = pt.load(sensed)
    assert isinstance(recording, pt.BodyRecording)
    recording = dataclasses.replace(
        recording,
        view=dataclasses.replace(recording.view, keypoints=None),
        imus=recording.imus[:2],
        imu_sds_rad=recording.imu_sds_rad[:2],
    )
    for which, spoilt, words in (
        (0, heading(90.0), r"heading_deg turned by -(70|75|80|85|90|95|100|105|110)"),
        *([(1, clock(1.0), r"offset_s greater by -1.00")] if IS_ACCEPTANCE else []),
    ):
        (told,) = said_of(recording, which, spoilt)
        assert f"imu[{which}]" in told
        assert "beside where the pictures alone have it" in told
        assert re.search(words, told), told
    assert said_of(recording, -1, heading(0.0)) == []


def test_keypoints_of_other_frames_are_not_laid_on_the_sensors_clocks(sensed: Path) -> None:
    recording = pt.load(sensed)
    assert isinstance(recording, pt.BodyRecording)
    imus = tuple(clock(-0.3)(imu) for imu in recording.imus)
    track = pt.track(dataclasses.replace(recording, imus=imus), pt.BodyMixture())
    assert isinstance(track, BodyTrack)
    assert any("imu[" in words for words in of_body(track))
    late = of_body(dataclasses.replace(track, points_late=(Counted(9), 0.05)))
    assert any("frames before it" in words for words in late)
    assert not any("imu[" in words for words in late)


def test_where_no_keypoint_or_no_place_before_the_camera_is_nothing_is_told(sensed: Path) -> None:
    recording = pt.load(sensed)
    assert isinstance(recording, pt.BodyRecording)
    track = pt.track(recording, pt.BodyMixture())
    assert isinstance(track, BodyTrack)
    unseen = dataclasses.replace(track, points=np.full_like(track.points, np.nan))
    behind = {
        name: dataclasses.replace(
            joint, mean=joint.mean + recording.view.camera.viewing_directions(joint.mean) * -100.0
        )
        for name, joint in track.joints.items()
    }
    for one in (
        unseen,
        dataclasses.replace(track, joints=behind),
        dataclasses.replace(track, points=np.zeros((0, 9, 3))),
    ):
        assert of_sensors(one) == ()


def test_a_sensor_that_ends_before_the_frames_is_told(sensed: Path, tmp_path: Path) -> None:
    """Of a third of a second in eight nothing was said, and `check` called it right."""
    folder = shutil.copytree(sensed, tmp_path / "ends")
    file = folder / "left_forearm.csv"
    lines = file.read_text("utf-8").splitlines(keepends=True)
    file.write_text("".join(lines[: len(lines) // 3]), "utf-8")
    (said,) = (words for words in pt.load(folder).warnings if "is tracked without it" in words)
    assert re.search(r"imu\[\d\] ends at \d", said)
    assert not any("is tracked without it" in words for words in pt.load(sensed).warnings)


def test_a_sensor_that_begins_a_little_late_is_used_from_then_on(sensed: Path, tmp_path: Path) -> None:
    """Everyday life: it was refused."""
    late = load(changed(sensed, tmp_path / "late", ("heading_deg = 0.0", "heading_deg = 0.0\noffset_s = 0.3")))
    assert any("begins 0.300 s after the first frame" in words for words in late.warnings)
    assert late.imus[0].time_s[0] == pytest.approx(0.3)
    for method in (pt.Partitioned(particles=20), pt.BodySmooth(particles=20)):
        assert np.isfinite(pt.track(without(late, imus=1), method, 1).joints["left_wrist"].mean).all()
