"""From files to a recording: conventions, clock, heading, mount and patch found; init, check and what they say."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import get_args

import cv2
import numpy as np
import pytest
from conftest import made_once
from typer.testing import CliRunner

import pytracker as pt
from pytracker.cli.entry import app
from pytracker.evidence import sight
from pytracker.evidence.lag import find_lags
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.conventions import AccUnit, Conventions, Direction, Earth, GyrUnit, Order, in_our_terms
from pytracker.inertial.gravity import GRAVITY
from pytracker.report.check_page import render_check
from pytracker.rotation import Array, conjugate, multiply, rotate, rotation_vector_to_quaternion
from pytracker.setup.check_worn import given_axis
from pytracker.setup.conventions import find_conventions
from pytracker.setup.draft import Draft
from pytracker.setup.worn import mount_of

SHARED = Path(__file__).parents[2] / "shared" / "recordings" / "arm-circle"
KNOWN = ("matrix", "rotation", "translation_m")
ACC, GYR, QUATERNION = slice(1, 4), slice(4, 7), slice(7, 11)
COLUMNS = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q_w,q_x,q_y,q_z"
EVERY = [
    Conventions(acc_unit=a, gyr_unit=g, quaternion=o, quaternion_takes=d, earth=e)
    for a, g, o, d, e in itertools.product(*(get_args(of) for of in (AccUnit, GyrUnit, Order, Direction, Earth)))
]


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A worn arm that gestures, with everything in its recording.toml."""
    scene = pt.ArmScene(worn=True, pattern="gesture", period_s=2.0)
    return made_once(tmp_path_factory, "setup", lambda folder: pt.simulate_arm(folder, scene, 8))


@pytest.fixture(scope="module")
def sightings(simulated: Path) -> pt.Sightings:
    recording = pt.load(simulated)
    assert isinstance(recording, pt.ArmRecording)
    return sight(recording)


def rows_of(folder: Path) -> Array:
    header, *lines = (folder / "imu.csv").read_text().splitlines()
    at = [header.split(",").index(name) for name in COLUMNS.split(",")]
    return np.array([[float(cell) for cell in line.split(",")] for line in lines])[:, at]


def otherwise(rows: Array, of: Conventions) -> Array:
    """The same samples, as a file of these conventions has them."""
    rows = rows.copy()
    q = rows[:, QUATERNION]
    if of.earth == "z down":
        q = multiply(np.broadcast_to([0.0, -1.0, 0.0, 0.0], q.shape), q)
    q = conjugate(q) if of.quaternion_takes == "world to sensor" else q
    rows[:, QUATERNION] = np.roll(q, -1, axis=1) if of.quaternion == "xyzw" else q
    rows[:, ACC] /= GRAVITY if of.acc_unit == "g" else 1.0
    rows[:, GYR] = np.degrees(rows[:, GYR]) if of.gyr_unit == "deg/s" else rows[:, GYR]
    return rows


def written(rows: Array, path: Path) -> Path:
    np.savetxt(path, rows, "%.7f", ",", header=COLUMNS, comments="")
    return path


@pytest.mark.parametrize("conventions", EVERY, ids=lambda c: "-".join(c.__dict__.values()).replace(" ", "_"))
def test_conventions_are_found_and_read(conventions: Conventions, simulated: Path, tmp_path: Path) -> None:
    rows = rows_of(simulated)
    log = read_imu(written(otherwise(rows, conventions), tmp_path / "imu.csv"))
    found = find_conventions(log)
    assert found.conventions == conventions
    assert found.unknown == ()
    ours = in_our_terms(log, found.conventions)
    assert ours.acc is not None
    assert ours.q_world_sensor is not None
    assert np.abs(ours.acc - rows[:, ACC]).max() < 1e-5
    same = np.abs((ours.q_world_sensor * rows[:, QUATERNION]).sum(axis=1))
    assert same == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("unit", get_args(GyrUnit))
@pytest.mark.parametrize("acc_unit", get_args(AccUnit))
def test_without_a_quaternion_gravity_tells_the_units(
    acc_unit: AccUnit, unit: GyrUnit, simulated: Path, tmp_path: Path
) -> None:
    """Only the acceleration's was written, and the file refused for its turn rate (ActiGraph: g and deg/s)."""
    rows = otherwise(rows_of(simulated), Conventions(acc_unit=acc_unit, gyr_unit=unit))
    path = tmp_path / "imu.csv"
    header = COLUMNS.split(",q_w", maxsplit=1)[0]
    np.savetxt(path, rows[:, : QUATERNION.start], "%.7f", ",", header=header, comments="")
    found = find_conventions(read_imu(path))
    assert (found.conventions.acc_unit, found.conventions.gyr_unit) == (acc_unit, unit)
    # What is as usual may be told or not: it is taken as it is.
    assert found.unknown == () or unit == "rad/s"
    rows[:, ACC], rows[:, GYR] = [0.0, 0.0, 9.8], 0.001
    np.savetxt(path, rows[:, : QUATERNION.start], "%.7f", ",", header=header, comments="")
    assert "gyr_unit" in find_conventions(read_imu(path)).unknown


def test_a_sensor_that_does_not_turn_tells_no_quaternion(tmp_path: Path) -> None:
    rows = np.zeros((500, 11))
    rows[:, 0] = np.arange(500) / 50
    rows[:, ACC] = [0.0, 0.0, 4.0]
    rows[:, 7] = 1.0
    found = find_conventions(read_imu(written(rows, tmp_path / "imu.csv")))
    assert {"acc_unit", "quaternion", "quaternion_takes"} <= set(found.unknown)
    assert found.conventions == Conventions()
    # Found by fuzzing: what was read is not checked yet.
    for time_s in (1e15, -5.0, np.nan):
        rows[-1, 0] = time_s
        with_odd_time = find_conventions(read_imu(written(rows, tmp_path / "imu.csv")))
        assert "quaternion" in with_odd_time.unknown


@pytest.mark.parametrize("offset_s", [-29.3, 0.0, 11.77])
def test_any_lag_is_found_from_the_movement_alone(offset_s: float, simulated: Path, sightings: pt.Sightings) -> None:
    recording = pt.load(simulated)
    assert isinstance(recording, pt.ArmRecording)
    imu = recording.imus[0]
    world = rotate(imu.q_world_segment, imu.acc) - np.array([0.0, 0.0, GRAVITY])
    best = find_lags(sightings.time_s, sightings.pixels[:, 0], imu.time_s - offset_s, world)[0]
    # The simulator's own clock is 20 ms off.
    assert best.offset_s == pytest.approx(offset_s, abs=0.045)
    assert best.explained > 0.7
    never = find_lags(sightings.time_s[:50], sightings.pixels[:50, 0], imu.time_s, world)
    assert never == ()
    unseen = np.full((500, 2), np.nan)
    assert find_lags(np.arange(500) / 25, unseen, imu.time_s, world) == ()


@pytest.mark.parametrize("axis", [[0, 1, 0], [0, -1, 0], [1, 0, 0], [0.6, 0, -0.8]])
def test_a_mount_takes_the_axis_to_the_forearm(axis: list[float]) -> None:
    mount = mount_of(np.array(axis, dtype=float))
    assert rotate(mount, np.array(axis, dtype=float)) == pytest.approx([0, 1, 0], abs=1e-12)
    assert given_axis(list(mount)) == pytest.approx(axis, abs=1e-12)


def test_a_draft_keeps_what_was_written(tmp_path: Path) -> None:
    (tmp_path / "recording.toml").write_text('kind = "arm"  # mine\n[[imu]]\nfile = "a.csv"  # the left one\n')
    draft = Draft(tmp_path)
    assert draft.lacks("imu.file", "imu.offset_s", "arm.shoulder_m") == ["imu.offset_s", "arm.shoulder_m"]
    draft.set("imu.offset_s", 1.5)
    draft.set("arm.forearm_m", 0.25)
    draft.set("camera.patch_box", [1, 2, 3, 4])
    draft.save()
    again = Draft(tmp_path)
    assert "# the left one" in again.path.read_text()
    assert (again.get("imu.offset_s"), again.get("arm.forearm_m")) == (1.5, 0.25)
    assert again.get("camera.patch_box") == [1, 2, 3, 4]
    (tmp_path / "recording.toml").write_text("kind = [")
    with pytest.raises(pt.InputError, match="is not TOML"):
        Draft(tmp_path)
    with pytest.raises(pt.InputError, match="pytracker init writes it"):
        Draft(tmp_path / "nowhere")


def known_file(folder: Path, path: Path) -> Path:
    """What a person has measured: camera and arm."""
    draft = Draft(folder)
    lines = [f"{key} = {draft.get(f'camera.{key}')}" for key in KNOWN]
    lines += [f"{key} = {draft.get(f'arm.{key}')}" for key in ("shoulder_m", "upper_arm_m", "forearm_m")]
    path.write_text("\n".join(lines) + "\n")
    return path


def hidden(rows: Array, offset_s: float, heading_deg: float, mount: Array) -> Array:
    """The samples by another clock, in another earth frame, of a sensor that is worn otherwise."""
    rows, back = rows.copy(), conjugate(mount)
    rows[:, 0] -= offset_s
    rows[:, ACC], rows[:, GYR] = rotate(back, rows[:, ACC]), rotate(back, rows[:, GYR])
    turn = rotation_vector_to_quaternion(np.array([0.0, 0.0, -np.radians(heading_deg)]))
    q = rows[:, QUATERNION]
    rows[:, QUATERNION] = multiply(multiply(np.broadcast_to(turn, q.shape), q), np.broadcast_to(mount, q.shape))
    return rows


def test_tables_may_stand_in_a_line(tmp_path: Path) -> None:
    path = tmp_path / "recording.toml"
    path.write_text('schema = 1\nkind = "body"\ncamera = [{ video = "a.mp4" }]\n')
    draft = Draft(tmp_path)
    assert (draft.count("camera"), draft.count("imu"), draft.get("camera.video")) == (1, 0, "a.mp4")
    draft.set("camera[0].keypoints", "k.csv")
    draft.save()
    assert Draft(tmp_path).table("camera") == {"video": "a.mp4", "keypoints": "k.csv"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('schema = 1\nkind = "body"\n', "there is no \\[\\[camera\\]\\], expected one with a video"),
        ('schema = 1\nkind = "body"\n[[camera]]\nvideos = "a.mp4"\n', "videos is not a known key"),
        ('schema = 7\nkind = "body"\n[[camera]]\nvideo = "a.mp4"\n', "schema"),
    ],
)
def test_keypoints_are_looked_for_in_a_recording(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "recording.toml").write_text(text)
    with pytest.raises(pt.InputError, match=expected):
        pt.setup.detect(tmp_path)


def test_everything_hidden_is_found_by_init_and_check(simulated: Path, tmp_path: Path) -> None:
    """Clock, heading, mount, units and quaternion; afterwards the wrist is as right as with the true ones, nearly."""
    mount, other = np.array([0.5, 0.5, 0.5, 0.5]), EVERY[-1]
    rows = otherwise(hidden(rows_of(simulated), 12.4, 131.0, mount), other)
    known, run = known_file(simulated, tmp_path / "known.toml"), CliRunner()
    folder = tmp_path / "recording"
    files = ["--video", str(simulated / "video.mp4"), "--imu", str(written(rows, tmp_path / "imu.csv"))]
    done = run.invoke(app, ["init", str(folder), *files, "--known", str(known)])
    assert done.exit_code == 0, done.output
    done = run.invoke(app, ["check", str(folder), "--write"])
    assert done.exit_code == 0, done.output
    draft = Draft(folder)
    assert draft.get("imu.offset_s") == pytest.approx(12.4, abs=0.06)
    assert draft.get("imu.heading_deg") == pytest.approx(131.0, abs=8.0)
    found, true = given_axis(draft.get("imu.mount")), given_axis(list(mount))
    assert np.degrees(np.arccos(found @ true)) < 20.0
    assert [draft.get(f"imu.{name}") for name in ("quaternion", "earth")] == [other.quaternion, other.earth]
    recording, right = pt.load(folder), pt.load(simulated)
    as_found = pt.evaluate(pt.track(recording, pt.Smooth()), right.truth).joints["wrist"].rms_m
    as_true = pt.evaluate(pt.track(right, pt.Smooth()), right.truth).joints["wrist"].rms_m
    assert as_found < max(1.6 * as_true, 0.06)


def test_of_a_video_of_another_rate_no_heading_is_written(simulated: Path, tmp_path: Path) -> None:
    """Frames that were lost, and written at the rate that was wished for: a heading of -144 ± 1° explained most."""
    rows = hidden(rows_of(simulated), 12.4, 131.0, np.array([1.0, 0.0, 0.0, 0.0]))
    rows[:, 0] *= 1.1
    known = known_file(simulated, tmp_path / "known.toml")
    imu = written(rows, tmp_path / "imu.csv")
    pt.setup.init(tmp_path / "recording", video=simulated / "video.mp4", imu=imu, camera=known)
    found = pt.setup.check(tmp_path / "recording", write=True).findings
    (rates,) = (finding for finding in found if finding.what == "video and IMU")
    assert rates.verdict == "wrong"
    assert "the IMU's clock goes 9.0% faster than the video's" in rates.evidence
    draft = Draft(tmp_path / "recording")
    assert draft.get("imu.heading_deg") is None
    assert draft.get("imu.mount") is None


def test_of_a_sensor_of_another_take_nothing_is_written(simulated: Path, tmp_path: Path) -> None:
    """A clock and a heading that explained the least badly were."""
    other = pt.simulate_arm(tmp_path / "other", pt.ArmScene(worn=True, pattern="gesture", duration_s=12.0), 5)
    imu = written(hidden(rows_of(other), 3.0, 131.0, np.array([1.0, 0.0, 0.0, 0.0])), tmp_path / "imu.csv")
    known = known_file(simulated, tmp_path / "known.toml")
    pt.setup.init(tmp_path / "recording", video=simulated / "video.mp4", imu=imu, camera=known)
    found = pt.setup.check(tmp_path / "recording", write=True).findings
    (together,) = (finding for finding in found if finding.what == "video and IMU")
    assert together.verdict == "wrong"
    assert "are video and IMU of one take" in together.evidence
    draft = Draft(tmp_path / "recording")
    assert [draft.get(f"imu.{key}") for key in ("offset_s", "heading_deg", "mount")] == [None, None, None]


def test_where_a_circle_fits_two_mounts_the_elbow_tells(tmp_path: Path) -> None:
    """A mount that is 80° off explains this circle better; its elbow is above the line from shoulder to wrist."""
    true = pt.simulate_arm(tmp_path / "true", pt.ArmScene(worn=True, pattern="circle"), 102)
    mount = np.array([0.0, 0.0, -np.sqrt(0.5), np.sqrt(0.5)])
    rows = written(hidden(rows_of(true), 5.5, -60.0, mount), tmp_path / "imu.csv")
    measured = known_file(true, tmp_path / "known.toml")
    text = measured.read_text().splitlines()
    for k, line in enumerate(text):
        key, _, value = line.partition(" = ")
        if key in ("upper_arm_m", "forearm_m"):
            text[k] = f"{key} = {0.945 * float(value):.4f}"
    measured.write_text("\n".join(text) + "\n")
    run, folder = CliRunner(), tmp_path / "recording"
    files = ["--video", str(true / "video.mp4"), "--imu", str(rows)]
    assert run.invoke(app, ["init", str(folder), *files, "--known", str(measured)]).exit_code == 0
    done = run.invoke(app, ["check", str(folder), "--write"])
    assert done.exit_code == 0, done.output
    found = given_axis(Draft(folder).get("imu.mount"))
    assert found @ given_axis(list(mount)) > np.cos(np.radians(25.0))
    assert Draft(folder).get("imu.offset_s") == pytest.approx(5.5, abs=0.25)


def test_where_reaching_fits_two_mounts_neither_is_written(tmp_path: Path) -> None:
    """A hand behind the back explained it better, was written, and was 44 cm off, all valid; the clock is the same."""
    true = pt.simulate_arm(tmp_path / "true", pt.ArmScene(worn=True, pattern="reach"), 126)
    mount = np.array([-0.4536, 0.4924, -0.4767, 0.5697])
    imu = written(hidden(rows_of(true), -19.756, 214.2, mount), tmp_path / "imu.csv")
    measured = known_file(true, tmp_path / "known.toml")
    lengths = "upper_arm_m = 0.289\nforearm_m = 0.249"
    measured.write_text(measured.read_text().split("upper_arm_m")[0] + lengths + "\n")
    pt.setup.init(tmp_path / "recording", video=true / "video.mp4", imu=imu, camera=measured)
    found = {finding.what: finding for finding in pt.setup.check(tmp_path / "recording", write=True).findings}
    assert found["heading and mount"].verdict == "cannot be told"
    draft = Draft(tmp_path / "recording")
    assert (draft.get("imu.heading_deg"), draft.get("imu.mount")) == (None, None)
    assert draft.get("imu.offset_s") == pytest.approx(-19.756, abs=0.15)


def test_files_that_were_started_by_hand_are_laid_over_each_other(tmp_path: Path) -> None:
    """A recording by others: its clock moved by 17.3 s, its heading turned by 131°; camera and lengths are given."""
    if not SHARED.exists():
        pytest.skip(f"{SHARED} is not there")
    rows = hidden(rows_of(SHARED), 17.3, -131.0, np.array([1.0, 0.0, 0.0, 0.0]))
    known, imu = known_file(SHARED, tmp_path / "known.toml"), written(rows, tmp_path / "imu.csv")
    pt.setup.init(tmp_path / "recording", video=SHARED / "video.mp4", imu=imu, camera=known)
    pt.setup.check(tmp_path / "recording", write=True)
    track = pt.track(pt.load(tmp_path / "recording"), pt.Smooth())
    wrist = pt.evaluate(track, pt.load(SHARED).truth).joints["wrist"]
    assert wrist.rms_m < 0.03
    assert min(wrist.coverage) > 0.9


def test_what_is_missing_is_said_and_stops_only_what_needs_it(simulated: Path, tmp_path: Path) -> None:
    folder, run = tmp_path / "recording", CliRunner()
    files = ["--video", str(simulated / "video.mp4"), "--imu", str(simulated / "imu.csv")]
    assert run.invoke(app, ["init", str(folder), *files]).exit_code == 0
    done = run.invoke(app, ["init", str(folder), *files])
    assert isinstance(done.exception, pt.InputError)
    assert "already exists" in str(done.exception)
    text = (folder / "recording.toml").read_text()
    assert "# guessed" in text
    assert "missing: the shoulder joint" in text
    done = run.invoke(app, ["check", str(folder), "--html", str(tmp_path / "check.html")])
    assert done.exit_code == 1
    assert "pytracker calibrate" in done.output
    assert "camera.patch_box = [" in done.output
    # Even so the clocks are laid over each other.
    assert "imu.offset_s = " in done.output or "right  clock" in done.output
    assert "nothing was written" in done.output
    assert "data:image" in (tmp_path / "check.html").read_text()
    assert (folder / "recording.toml").read_text() == text
    for source in (folder, simulated / "video.mp4"):
        out = tmp_path / f"{source.name}.png"
        assert run.invoke(app, ["frame", str(source), "--out", str(out)]).exit_code == 0
        assert cv2.imread(str(out)) is not None


@pytest.mark.parametrize(
    ("key", "what", "words"),
    [
        ("upper_arm_m", "recording.toml", "arm.upper_arm_m is 'long', expected"),
        ("mount", "mount", "has norm 0.0000"),
        ("translation_m", "camera", "camera.translation_m not given"),
    ],
)
def test_what_is_wrong_in_the_file_is_a_line_and_no_traceback(
    key: str, what: str, words: str, simulated: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "recording"
    pt.setup.init(folder, video=simulated / "video.mp4", imu=simulated / "imu.csv", camera=None)
    draft = Draft(folder)
    for name in (*KNOWN, "patch_box"):
        draft.set(f"camera.{name}", Draft(simulated).get(f"camera.{name}"))
    for name in ("shoulder_m", "upper_arm_m", "forearm_m"):
        draft.set(f"arm.{name}", Draft(simulated).get(f"arm.{name}"))
    if key == "upper_arm_m":
        draft.set("arm.upper_arm_m", "long")
    elif key == "mount":
        draft.set("imu.mount", [0.0, 0.0, 0.0, 0.0])
    draft.save()
    if key == "translation_m":
        text = draft.path.read_text().splitlines()
        draft.path.write_text("\n".join(row for row in text if not row.startswith("translation_m")) + "\n")
    said = {finding.what: finding for finding in pt.setup.check(folder).findings}
    assert said[what].verdict in ("wrong", "missing")
    assert words in said[what].evidence


def test_a_right_recording_is_right(simulated: Path) -> None:
    found = pt.setup.check(simulated)
    assert found.is_ready
    verdicts = {finding.what: finding.verdict for finding in found.findings}
    assert verdicts["mount"] == verdicts["video"] == verdicts["the track"] == "right"
    assert verdicts["clock"] == verdicts["heading"] == "right"
    assert [finding for finding in found.findings if finding.writes] == []
    assert "Nothing is missing or wrong." in render_check(found)


def test_what_cannot_be_tracked_is_not_ready(tmp_path: Path) -> None:
    """A track of which most frames are not to be used was doubtful, and the check had no complaint."""
    folder = pt.simulate_arm(tmp_path / "hidden", pt.ArmScene(duration_s=5.0, occlusions=((1.5, 5.0),)), 3)
    draft = Draft(folder)
    draft.set("imu.offset_s", 0.0)
    draft.set("imu.heading_deg", 0.0)
    draft.save()
    found = pt.setup.check(folder)
    (said,) = (finding for finding in found.findings if finding.what == "the track")
    assert said.verdict == "wrong"
    assert "frames (70%) are not valid, do not use them: patch not found again" in said.evidence
    assert not found.is_ready


def test_a_clock_is_not_told_of_a_patch_that_is_hardly_seen(tmp_path: Path) -> None:
    """Two seconds of it were laid 1.5 s beside where they belong, to 0.01 s."""
    folder = pt.simulate_arm(tmp_path / "hidden", pt.ArmScene(duration_s=8.0, occlusions=((1.5, 7.5),)), 3)
    (said,) = (finding for finding in pt.setup.check(folder).findings if finding.what == "clock")
    assert said.verdict == "cannot be told"
    assert not said.writes


def test_times_in_whole_seconds_are_looked_at_as_they_are_tracked(simulated: Path, tmp_path: Path) -> None:
    """Sixty rows a second with one time: its rate was infinite, and nothing was looked at."""
    rows = rows_of(simulated)
    rows[:, 0] = np.floor(rows[:, 0])
    written(rows, tmp_path / "imu.csv")
    (tmp_path / "recording.toml").write_text('schema = 1\nkind = "arm"\n[[imu]]\nfile = "imu.csv"\n')
    found = {one.what: one for one in pt.setup.check(tmp_path).findings}
    assert "at 60 Hz, 0 missing" in found["rate and gaps"].evidence
    assert found["order of the quaternion"].verdict == "right"
