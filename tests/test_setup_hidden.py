"""Clock, heading, mount and patch found from a video and an IMU file by init and check, or nothing written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE
from hidden_imu import EVERY, hidden, known_file, otherwise, rows_of, written
from typer.testing import CliRunner

import pytracker as pt
from pytracker.cli.entry import app
from pytracker.setup.checks.worn import given_axis
from pytracker.setup.draft import Draft

SHARED = Path(__file__).parents[2] / "shared" / "recordings" / "arm-circle"


def test_everything_hidden_is_found_by_init_and_check(gesturing: Path, tmp_path: Path) -> None:
    """Clock, heading, mount, units and quaternion; afterwards the wrist is as right as with the true ones, nearly."""
    mount, other = np.array([0.5, 0.5, 0.5, 0.5]), EVERY[-1]
    rows = otherwise(hidden(rows_of(gesturing), 12.4, 131.0, mount), other)
    known, run = known_file(gesturing, tmp_path / "known.toml"), CliRunner()
    folder = tmp_path / "recording"
    files = ["--video", str(gesturing / "video.mp4"), "--imu", str(written(rows, tmp_path / "imu.csv"))]
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
    recording, right = pt.load(folder), pt.load(gesturing)
    as_found = pt.evaluate(pt.track(recording, pt.Smooth()), right.truth).joints["wrist"].rms_m
    as_true = pt.evaluate(pt.track(right, pt.Smooth()), right.truth).joints["wrist"].rms_m
    assert as_found < max(1.6 * as_true, 0.06)


def test_of_a_video_of_another_rate_no_heading_is_written(gesturing: Path, tmp_path: Path) -> None:
    """Frames that were lost, and written at the rate that was wished for: a heading of -144 ± 1° explained most."""
    rows = hidden(rows_of(gesturing), 12.4, 131.0, np.array([1.0, 0.0, 0.0, 0.0]))
    rows[:, 0] *= 1.1
    known = known_file(gesturing, tmp_path / "known.toml")
    imu = written(rows, tmp_path / "imu.csv")
    pt.setup.init(tmp_path / "recording", video=gesturing / "video.mp4", imu=imu, camera=known)
    found = pt.setup.check(tmp_path / "recording", write=True).findings
    (rates,) = (finding for finding in found if finding.what == "video and IMU")
    assert rates.verdict == "wrong"
    assert "the IMU's clock goes 9.0% faster than the video's" in rates.evidence
    draft = Draft(tmp_path / "recording")
    assert draft.get("imu.heading_deg") is None
    assert draft.get("imu.mount") is None


def test_of_a_sensor_of_another_take_nothing_is_written(gesturing: Path, tmp_path: Path) -> None:
    """A clock and a heading that explained the least badly were."""
    other = pt.simulate_arm(tmp_path / "other", pt.ArmScene(worn=True, pattern="gesture", duration_s=12.0), 5)
    imu = written(hidden(rows_of(other), 3.0, 131.0, np.array([1.0, 0.0, 0.0, 0.0])), tmp_path / "imu.csv")
    known = known_file(gesturing, tmp_path / "known.toml")
    pt.setup.init(tmp_path / "recording", video=gesturing / "video.mp4", imu=imu, camera=known)
    found = pt.setup.check(tmp_path / "recording", write=True).findings
    (together,) = (finding for finding in found if finding.what == "video and IMU")
    assert together.verdict == "wrong"
    assert "are video and IMU of one take" in together.evidence
    draft = Draft(tmp_path / "recording")
    assert [draft.get(f"imu.{key}") for key in ("offset_s", "heading_deg", "mount")] == [None, None, None]


@pytest.mark.skipif(not IS_ACCEPTANCE, reason="takes a minute; test_worn asks a shorter circle in every run")
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


@pytest.mark.skipif(not IS_ACCEPTANCE, reason="takes a minute; test_worn asks a shorter circle in every run")
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
    assert wrist.rms_m < 0.031
    assert min(wrist.coverage) > 0.9
