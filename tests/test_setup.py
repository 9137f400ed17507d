"""What init and check say of what is missing, wrong and right."""

from __future__ import annotations

import importlib
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from hidden_imu import KNOWN, rows_of, written
from typer.testing import CliRunner

import pytracker as pt
from pytracker.cli.entry import app
from pytracker.report.check_page import render_check
from pytracker.setup.checks.findings import Finding
from pytracker.setup.draft import Draft


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


def test_what_is_missing_is_said_and_stops_only_what_needs_it(gesturing: Path, tmp_path: Path) -> None:
    folder, run = tmp_path / "recording", CliRunner()
    files = ["--video", str(gesturing / "video.mp4"), "--imu", str(gesturing / "imu.csv")]
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
    for source in (folder, gesturing / "video.mp4"):
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
    key: str, what: str, words: str, gesturing: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "recording"
    pt.setup.init(folder, video=gesturing / "video.mp4", imu=gesturing / "imu.csv", camera=None)
    draft = Draft(folder)
    for name in (*KNOWN, "patch_box"):
        draft.set(f"camera.{name}", Draft(gesturing).get(f"camera.{name}"))
    for name in ("shoulder_m", "upper_arm_m", "forearm_m"):
        draft.set(f"arm.{name}", Draft(gesturing).get(f"arm.{name}"))
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


def test_a_right_recording_is_right(gesturing: Path) -> None:
    found = pt.setup.check(gesturing)
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


def test_times_in_whole_seconds_are_looked_at_as_they_are_tracked(gesturing: Path, tmp_path: Path) -> None:
    """Sixty rows a second with one time: its rate was infinite, and nothing was looked at."""
    rows = rows_of(gesturing)
    rows[:, 0] = np.floor(rows[:, 0])
    written(rows, tmp_path / "imu.csv")
    (tmp_path / "recording.toml").write_text('schema = 1\nkind = "arm"\n[[imu]]\nfile = "imu.csv"\n')
    found = {one.what: one for one in pt.setup.check(tmp_path).findings}
    assert "at 60 Hz, 0 missing" in found["rate and gaps"].evidence
    assert found["order of the quaternion"].verdict == "right"


def test_what_a_recording_would_be_refused_with_is_not_written(
    simulated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a heading that jumped a mount was found that the arm could not have: a folder that had loaded did not."""
    folder = shutil.copytree(simulated, tmp_path / "arm")
    before = (folder / "recording.toml").read_text("utf-8")
    turned = Finding("mount", "wrong", "points the other way", {"imu.mount": [0.0, 1.0, 0.0, 0.0]})
    examine = importlib.import_module("pytracker.setup.check").EXAMINE
    monkeypatch.setitem(examine, "arm", lambda _: ([turned], None, None))
    found = {finding.what: finding for finding in pt.setup.check(folder, write=True).findings}
    assert (folder / "recording.toml").read_text("utf-8") == before
    assert found["mount"].verdict == "cannot be told"
    assert "it is not written: with what was found the recording is refused" in found["mount"].evidence
    assert found["the track"].verdict == "right"


def test_a_sensors_file_that_does_not_say_all_of_itself_is_begun_with(simulated: Path, tmp_path: Path) -> None:
    """There was no recording.toml to write into what was asked for."""
    times, *rows = (row.split(",") for row in (simulated / "imu.csv").read_text("utf-8").splitlines())
    header = ",".join(["Zeit", *times[1:]])
    (tmp_path / "imu.csv").write_text("\n".join([header, *(",".join(row) for row in rows)]), "utf-8")
    folder = tmp_path / "begun"
    path = pt.setup.init(folder, video=simulated / "video.mp4", imu=tmp_path / "imu.csv")
    text = path.read_text("utf-8")
    assert "# missing here: " in text
    assert "columns = { time_s = " in text
    found = {finding.what: finding for finding in pt.setup.check(folder).findings}
    assert found["IMU"].verdict == "wrong"
    names = ", ".join(f'{name} = "{name}"' for name in times[1:])
    path.write_text(text.replace("[[imu]]\n", f'[[imu]]\ncolumns = {{ time_s = "Zeit", {names} }}\n'), "utf-8")
    found = {finding.what: finding for finding in pt.setup.check(folder).findings}
    assert found["rate and gaps"].verdict == "right"
    (tmp_path / "imu.csv").write_text("", "utf-8")
    with pytest.raises(pt.InputError):
        pt.setup.init(tmp_path / "other", video=simulated / "video.mp4", imu=tmp_path / "imu.csv")
