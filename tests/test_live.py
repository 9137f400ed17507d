"""Live: lines and frames as they come, by the clock on the wall, against what was simulated."""

from __future__ import annotations

import contextlib
import dataclasses
import heapq
import itertools
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.video import Frame, frames
from pytracker.live import Estimated, Live, live, sensor_samples
from pytracker.live.camera import camera_frames
from pytracker.live.following import Following
from pytracker.live.sensor import SensorClock
from pytracker.live.subject import live_subject
from pytracker.methods.method import Method
from pytracker.recording.recording import Worn
from pytracker.rotation import rotation_vector_to_quaternion

HEADER = "time_s,acc_x,acc_y,acc_z,q_w,q_x,q_y,q_z"
NOT_TURNED = Worn(np.array([1.0, 0.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0, 0.0]))


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> pt.ArmRecording:
    scene = pt.ArmScene(duration_s=6.0, pattern="gesture", worn=True)
    recording = pt.load(pt.simulate_arm(tmp_path_factory.mktemp("live") / "arm", scene, 4))
    assert isinstance(recording, pt.ArmRecording)
    return recording


def at_hand(recording: pt.Recording, name: str) -> Path:
    assert recording.folder is not None
    return recording.folder / name


def followed(recording: pt.Recording, method: Method, lines: Iterator[str], counts: Live) -> list[Estimated]:
    """By the clocks of sensor and video alone, as if both arrived when they were measured."""
    subject = live_subject(recording, method)
    tracker = pt.Tracker(subject.recording, method.known_by(subject.recording.spreads), 0, delay_s=0.1)
    following, now_s = Following(subject, tracker, counts, print), [0.0]

    def arriving() -> Iterator[str]:
        for number, line in enumerate(lines):
            now_s[0] = float(line.split(",")[0]) if number else 0.0
            yield line

    samples: Iterator[pt.Observation] = iter(())
    if subject.worn is not None:
        samples = sensor_samples(arriving(), subject.worn, lambda: now_s[0], print)
    arrived: list[Iterator[Frame | pt.Observation]] = [samples, frames(at_hand(recording, "video.mp4"))]
    both = heapq.merge(*arrived, key=lambda one: one.time_s)
    found = [estimated for one in both for estimated in following.take(one)]
    return found + list(following.finish())


def test_an_arm_is_followed_live(arm: pt.ArmRecording) -> None:
    """The second in which the sensor's clock is found is left out; what follows is as well known as it says."""
    counts = Live()
    found = followed(arm, pt.Mixture(), iter(at_hand(arm, "imu.csv").read_text("utf-8").splitlines()), counts)
    time_s = np.array([one.estimate.time_s for one in found])
    wrist = np.array([one.estimate.places["wrist"].mean for one in found])
    assert arm.truth is not None
    off_m = np.linalg.norm(wrist - arm.truth.at("wrist", time_s), axis=1)
    assert 0.9 < time_s[0] < 1.2
    assert time_s[-1] > 5.8
    assert [one.frame for one in found] == list(range(found[0].frame, found[-1].frame + 1))
    assert counts.frames == len(found)
    assert np.nanmedian(off_m) < 0.1  # 4 to 7 cm
    assert counts.invalid < 0.2 * counts.frames


def test_a_body_is_followed_live(tmp_path: Path) -> None:
    """The same as offline, to the bit, and what is said of it too."""
    recording = pt.load(pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=2.0), 3))
    assert isinstance(recording, pt.BodyRecording)
    found = followed(recording, pt.Partitioned(), iter(()), Live())
    track = pt.track(recording, pt.Partitioned(), 0)
    elbow = np.array([one.estimate.places["left_elbow"].mean for one in found])
    assert np.array_equal(elbow, track.joints["left_elbow"].mean)
    assert [one.reason for one in found] == list(track.reason)


def test_frames_that_come_too_fast_are_left_out_and_counted(tmp_path: Path) -> None:
    recording, counts = pt.load(pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=2.0), 3)), Live()
    source = live(recording, pt.Partitioned(particles=20), str(at_hand(recording, "video.mp4")), progress=counts)
    numbers = []
    for found in source:
        numbers.append(found.frame)
        time.sleep(0.2)
    assert 3 <= len(numbers) == counts.frames
    assert counts.skipped > 5
    assert counts.frames + counts.skipped == 60
    assert numbers == sorted(set(numbers))


def test_a_camera_of_another_size_is_refused(arm: pt.ArmRecording) -> None:
    subject = live_subject(arm, pt.Mixture())
    with pytest.raises(pt.InputError, match="frame 7 is 320 x 240 px, expected 640 x 480"):
        subject.see(Frame(7, 0.2, np.zeros((240, 320, 3), dtype=np.uint8)))


def silent() -> Iterator[str]:
    """A sensor that is there and says nothing: one whose lines end is told before what the camera says, or after."""
    yield HEADER
    time.sleep(5.0)


def test_what_cannot_be_followed_live_is_refused(arm: pt.ArmRecording) -> None:
    lines = iter([HEADER])
    with pytest.raises(pt.InputError, match="needs the whole recording"):
        next(live(arm, pt.Smooth(), "0", lines))
    with pytest.raises(pt.InputError, match="by its sensor too"):
        next(live(arm, pt.Mixture(), "0"))
    with pytest.raises(pt.InputError, match="2 cameras"):
        next(live(dataclasses.replace(arm, views=arm.views * 2), pt.Mixture(), "0", lines))
    with pytest.raises(pt.InputError, match="no such file, expected a camera's number"):
        next(live(arm, pt.Mixture(), "nothing.mp4", silent()))
    with pytest.raises(pt.InputError, match="no column acc_x, acc_y"):
        next(live(arm, pt.Mixture(), str(at_hand(arm, "video.mp4")), iter(["time_s,acc_z,q_w,q_x,q_y,q_z"])))
    with pytest.raises(pt.InputError, match="ended before 1 s had passed"):
        next(live(arm, pt.Mixture(), str(at_hand(arm, "video.mp4")), iter([HEADER, "0,0,0,9.81,1,0,0,0"])))


def test_a_sensor_that_says_nothing_is_told(tmp_path: Path) -> None:
    """Where the camera ends before it is waited for no longer."""
    folder = pt.simulate_arm(tmp_path / "arm", pt.ArmScene(duration_s=1.0), 1)

    with pytest.raises(pt.InputError, match="camera ended before a sample"):
        next(live(pt.load(folder), pt.Mixture(), str(folder / "video.mp4"), silent()))


def test_bursts_are_told_apart_by_the_sensors_own_clock() -> None:
    """A radio sends ten samples at a time; whatever the delay, times are as far apart as they were measured."""
    clock = SensorClock()
    own_s = 250.0 + 0.01 * np.arange(3000)
    rng = np.random.default_rng(1)
    bursts = np.repeat(own_s[9::10] - 250.0 + 0.02 + rng.gamma(1.0, 0.01, 300), 10)
    time_s = np.array([clock(own, arrived) for own, arrived in zip(own_s, bursts, strict=True)])
    known = np.isfinite(time_s)
    assert 80 < np.argmax(known) < 130
    assert known[130:].all()
    off_s = time_s[known] - (own_s[known] - 250.0)
    assert np.ptp(off_s) < 0.02
    assert np.diff(time_s[known]).min() > 0.009


def test_a_sensors_clock_that_drifts_is_followed() -> None:
    """By 200 ppm for ten minutes, 120 ms."""
    clock = SensorClock()
    ours_s = 0.05 * np.arange(12000)
    rng = np.random.default_rng(2)
    late_s = rng.gamma(1.0, 0.01, len(ours_s))
    time_s = np.array([clock(1.0002 * now, now + late) for now, late in zip(ours_s, late_s, strict=True)])
    assert np.abs(time_s[400:] - ours_s[400:]).max() < 0.015
    assert np.diff(time_s[400:]).min() > 0.0


@pytest.mark.parametrize("leap_s", [-40.0, -5.0, -0.5, 0.5, 5.0, 40.0])
def test_a_sensors_clock_that_is_set_anew_is_found_anew(leap_s: float) -> None:
    """A reconnected sensor counts from elsewhere on: no sample was used any more, or all frames came too late."""
    clock = SensorClock()
    ours_s = 0.01 * np.arange(4000)
    own_s = np.where(ours_s < 10.0, ours_s, ours_s + leap_s)
    rng = np.random.default_rng(3)
    late_s = rng.gamma(1.0, 0.01, len(ours_s))
    time_s = np.array([clock(own, now + late) for own, now, late in zip(own_s, ours_s, late_s, strict=True)])
    known = np.isfinite(time_s)
    assert known[ours_s > 12.0].all()
    assert np.nanmax(time_s - ours_s - late_s) < 0.15  # never measured after it arrived
    assert np.abs(time_s - ours_s)[ours_s > 21.0].max() < 0.03


def test_one_time_that_is_wrong_is_left_out() -> None:
    said: list[str] = []
    now = itertools.count()
    lines = [HEADER, *(f"{k / 100 + (30.0 if k == 250 else 0.0)},0,0,9.81,1,0,0,0" for k in range(400))]
    found = list(sensor_samples(lines, NOT_TURNED, lambda: next(now) / 100.0, said.append))
    assert len(said) == 1
    assert "line 252 has time 32.5, not after" in said[0]
    assert len(found) == pytest.approx(300, abs=3)
    assert np.ptp(np.diff([sample.time_s for sample in found])) < 0.011


@pytest.mark.parametrize("times", [1000.0, 60.0, 1.0 / 60.0])
def test_times_that_are_not_in_seconds_are_told(times: float) -> None:
    now = itertools.count()
    lines = [HEADER, *(f"{times * k / 50},0,0,9.81,1,0,0,0" for k in range(100))]
    with pytest.raises(pt.InputError, match=r"expected time_s in seconds"):
        list(sensor_samples(lines, NOT_TURNED, lambda: next(now) / 50.0, print))


def test_a_header_as_others_write_it() -> None:
    """Quotes, other orders and other columns; rows of more or fewer cells are none of it."""
    said: list[str] = []
    now = itertools.count()
    header = '"q_w","q_x","q_y","q_z","battery","time_s","acc_z","acc_y","acc_x"\r'
    lines = [header, *(f'1,0,0,0,"87",{k},9.81,0,0\r' for k in range(4)), "1,0,0,0,87,4,5,9,81,0,0,0,0", "1,0"]
    assert len(list(sensor_samples(lines, NOT_TURNED, lambda: float(next(now)), said.append))) == 3
    assert len(said) == 2


def test_samples_are_turned_as_the_recording_says() -> None:
    """Of a sensor that is worn a quarter turn about its z, in a world a quarter turn about the vertical."""
    quarter = rotation_vector_to_quaternion(np.array([0.0, 0.0, 0.5 * np.pi]))
    worn = Worn(quarter, rotation_vector_to_quaternion(np.array([0.0, 0.0, np.pi])))
    assert worn.of_segment(np.array([1.0, 0.0, 9.81])) == pytest.approx([0.0, 1.0, 9.81])
    assert worn.q_world_segment(np.array([[1.0, 0.0, 0.0, 0.0]]))[0] == pytest.approx(quarter)
    now = itertools.count()
    lines = [HEADER, *(f"{k},1,0,9.81,1,0,0,0" for k in range(5))]
    found = list(sensor_samples(lines, worn, lambda: float(next(now)), print))
    assert [sample.time_s for sample in found] == [1.0, 2.0, 3.0, 4.0]
    assert {sample.what for sample in found} == {"IMU sample"}


def test_lines_that_cannot_be_read_are_said_and_left_out() -> None:
    said: list[str] = []
    now = itertools.count()
    rows = [f"{k},0,0,9.81,1,0,0,0" for k in range(6)]
    lines = [HEADER, *rows[:3], "3,0,0", "", "nan,0,0,9.81,1,0,0,0", *rows[4:]]
    found = list(sensor_samples(lines, NOT_TURNED, lambda: float(next(now)), said.append))
    assert len(found) == 4
    assert [words.split(",")[0] for words in said] == ["the sensor's line 5 is '3", "the sensor's line 7 is 'nan"]


def test_a_file_is_played_at_its_own_pace(arm: pt.ArmRecording) -> None:
    began_s = time.monotonic()
    played = camera_frames(str(at_hand(arm, "video.mp4")), lambda: time.monotonic() - began_s, late_s=0.03)
    last = next(itertools.islice(played, 25, None))
    assert time.monotonic() - began_s > 0.9
    assert last.index == 25
    assert last.time_s >= 0.97


def test_the_command_writes_rows_and_leaves_in_peace(arm: pt.ArmRecording, tmp_path: Path) -> None:
    """Where it refuses, what was there is kept; a camera that is still open does not abort the program."""
    assert arm.folder is not None
    video, out = str(at_hand(arm, "video.mp4")), tmp_path / "live.csv"
    command = [sys.executable, "-m", "pytracker", "live", str(arm.folder), "--camera", video, "--out", str(out)]
    header, *rows = at_hand(arm, "imu.csv").read_text("utf-8").splitlines()
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as fed:  # noqa: S603
        assert fed.stdin is not None
        assert fed.stderr is not None
        with contextlib.suppress(BrokenPipeError):
            print(header, file=fed.stdin, flush=True)
            # For as long as it takes to begin and to play the video.
            for k, row in enumerate(itertools.cycle(rows)):
                if fed.poll() is not None:
                    break
                print(",".join([f"{k / 60:.6f}", *row.split(",")[1:]]), file=fed.stdin, flush=True)
                time.sleep(1 / 60)
        with contextlib.suppress(BrokenPipeError):
            fed.stdin.close()
        said = fed.stderr.read()
    counted = re.search(r"(\d+) frames, (\d+) of them valid", said)
    assert counted is not None, said
    # On a machine that is busy samples come late, and most frames may have none.
    assert fed.returncode == (2 * int(counted[2]) < int(counted[1])), said
    written = out.read_text("utf-8").splitlines()
    assert written[0].startswith("time_s,frame,wrist_x_m,")
    assert written[0].endswith("valid,reason")
    assert len(written) > 1
    for lines, words in (("a,b\n", "no column time_s"), ("\n".join([header, *rows]), "ended before 1 s had passed")):
        refused = subprocess.run(  # noqa: S603
            [*command, "--force"], input=lines, capture_output=True, text=True, timeout=60, check=False
        )
        assert refused.returncode == 2, refused.stderr
        assert words in refused.stderr
        assert out.read_text("utf-8").splitlines() == written
