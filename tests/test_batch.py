"""Several recordings at once: each has its own folder, one that fails stops no other, and a page leads to all."""

from __future__ import annotations

import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import pytracker as pt
from pytracker import batch
from pytracker.cli.entry import app
from pytracker.methods.method import Method


def test_one_that_fails_stops_no_other(tmp_path: Path) -> None:
    first = pt.simulate_arm(tmp_path / "trial", pt.ArmScene(duration_s=3.0), 1)
    alike = tmp_path / "other" / "trial"
    shutil.copytree(first, alike)
    broken = tmp_path / "=broken"
    shutil.copytree(first, broken)
    (broken / "imu.csv").write_text("time_s,acc_x\n")
    out = tmp_path / "out"
    files = [str(folder) for folder in (first, broken, alike)]
    done = CliRunner().invoke(app, ["track", *files, "--out", str(out), "--no-report", "--jobs", "2"])
    assert done.exit_code == 1, done.output
    rows = list(csv.DictReader((out / "index.csv").read_text().splitlines()))
    assert [(row["recording"], row["result"], row["failed"]) for row in rows] == [
        ("trial", "trial", "False"),
        ("'=broken", "", "True"),
        ("trial", "trial-2", "False"),
    ]
    assert "acc_y" in rows[1]["said"]
    assert (out / "trial" / "track.csv").read_bytes() == (out / "trial-2" / "track.csv").read_bytes()
    page = (out / "index.html").read_text()
    assert 'href="trial-2/index.html"' in page
    assert "2 of 3" in page
    alone = CliRunner().invoke(app, ["track", str(first), "--out", str(tmp_path / "alone"), "--no-report", "--quiet"])
    assert alone.exit_code == 0, alone.output
    assert (tmp_path / "alone" / "track.csv").read_bytes() == (out / "trial" / "track.csv").read_bytes()


def test_quiet_or_not_what_failed_and_whose_warning_it_is_is_said(tmp_path: Path) -> None:
    """On the error stream: a folder that failed was passed over in silence, warnings came without their folder."""
    right = pt.simulate_arm(tmp_path / "right", pt.ArmScene(duration_s=3.0), 1)
    short, broken = (Path(shutil.copytree(right, tmp_path / name)) for name in ("short", "broken"))
    rows = (short / "imu.csv").read_text().splitlines()
    (short / "imu.csv").write_text("\n".join(rows[: len(rows) // 2]) + "\n")
    (broken / "imu.csv").write_text("time_s,acc_x\n")
    folders = [str(folder) for folder in (right, short, broken)]
    done = CliRunner().invoke(app, ["track", *folders, "--out", str(tmp_path / "out"), "--no-report", "--quiet"])
    assert done.exit_code == 1
    assert done.stdout == ""
    said = done.stderr.splitlines()
    assert any(line.startswith(f"pytracker: {broken}: failed: ") and "acc_y" in line for line in said)
    assert any(line.startswith(f"pytracker: warning: {short}: ") and "the IMU ends" in line for line in said)
    assert not any(f"{right}: " in line for line in said)


def rows_of(out: Path) -> list[tuple[str, str, str, bool]]:
    """Recording, result, failed, and whether it is of an earlier run."""
    rows = csv.DictReader((out / "index.csv").read_text().splitlines())
    return [(row["recording"], row["result"], row["failed"], "of an earlier run" in row["said"]) for row in rows]


def test_what_an_earlier_run_left_stays_in_the_table(tmp_path: Path) -> None:
    """A second run, after one was mended, called all others failed; of a part of them the others were gone."""
    one = pt.simulate_arm(tmp_path / "one", pt.ArmScene(duration_s=2.0), 1)
    two = Path(shutil.copytree(one, tmp_path / "two"))
    alike = Path(shutil.copytree(one, tmp_path / "other" / "one"))
    good = (two / "imu.csv").read_text()
    (two / "imu.csv").write_text("time_s,acc_x\n")
    out = tmp_path / "out"

    def run(*folders: Path, force: bool = False) -> int:
        arguments = ["track", *map(str, folders), "--out", str(out), "--no-report", "--quiet"]
        return CliRunner().invoke(app, [*arguments, *(["--force"] if force else [])]).exit_code

    assert run(one, two, alike) == 1
    first = rows_of(out)
    assert first == [("one", "one", "False", False), ("two", "", "True", False), ("one", "one-2", "False", False)]
    (two / "imu.csv").write_text(good)
    was = (out / "one" / "track.csv").stat().st_mtime_ns
    shown = CliRunner().invoke(app, ["track", str(one), str(two), str(alike), "--out", str(out), "--no-report"])
    assert shown.exit_code == 0
    assert f"{one}: 100% of 50 frames valid" in shown.output
    assert shown.output.count("(of an earlier run; --force does it again)") == 2
    assert rows_of(out) == [
        ("one", "one", "False", True),
        ("two", "two", "False", False),
        ("one", "one-2", "False", True),
    ]
    assert (out / "one" / "track.csv").stat().st_mtime_ns == was
    # The other of one name is not taken for it, whatever place it has among them.
    assert run(alike, two) == 0
    assert rows_of(out) == [
        ("one", "one-2", "False", True),
        ("two", "two", "False", True),
        ("one", "one", "False", True),
    ]
    (two / "imu.csv").write_text("time_s,acc_x\n")
    assert run(one, two, force=True) == 1
    text = (out / "index.csv").read_text()
    assert "two holds what an earlier run found" in text
    assert rows_of(out)[-1][:2] == ("one", "one-2")


def test_what_is_there_and_not_its_own_stays(tmp_path: Path) -> None:
    """An index.html of somebody's site, and the report of a single recording, were written over."""
    one = pt.simulate_arm(tmp_path / "one", pt.ArmScene(duration_s=2.0), 1)
    two = Path(shutil.copytree(one, tmp_path / "two"))
    site, alone = tmp_path / "site", tmp_path / "alone"
    site.mkdir()
    (site / "index.html").write_text("mine")

    def run(out: Path, *folders: Path, force: bool = False) -> Result:
        arguments = ["track", *map(str, folders), "--out", str(out), "--no-report", "--quiet"]
        return CliRunner().invoke(app, [*arguments, *(["--force"] if force else [])])

    done = run(site, one, two)
    assert "index.html: was not written by pytracker" in str(done.exception)
    assert [path.name for path in site.iterdir()] == ["index.html"]
    assert (site / "index.html").read_text() == "mine"
    assert run(alone, one).exit_code == 0
    done = run(alone, one, two, force=True)
    assert "holds the result of one recording" in str(done.exception)
    assert run(site, one, two, force=True).exit_code == 0


def test_a_result_of_other_files_or_another_method_is_told_and_stays(tmp_path: Path) -> None:
    """Old numbers stood in the table as those of the run, which had been of another method and another arm."""
    one = pt.simulate_arm(tmp_path / "one", pt.ArmScene(duration_s=2.0), 1)
    two = Path(shutil.copytree(one, tmp_path / "two"))
    out = tmp_path / "out"

    def run(*more: str) -> list[str]:
        CliRunner().invoke(app, ["track", str(one), str(two), "--out", str(out), "--no-report", "--quiet", *more])
        return [row["said"] for row in csv.DictReader((out / "index.csv").read_text().splitlines())]

    assert run() == ["", ""]
    assert run() == ["of an earlier run; --force does it again"] * 2
    text = (two / "recording.toml").read_text()
    (two / "recording.toml").write_text(text + "\n# touched\n")
    track = (out / "two" / "track.csv").read_bytes()
    first, second = run()
    assert first == "of an earlier run; --force does it again"
    assert "recording.toml was another file in that run" in second
    (two / "recording.toml").write_text(text)
    assert all("by another method, other settings or another seed" in words for words in run("--method", "layered"))
    assert (out / "two" / "track.csv").read_bytes() == track
    # As it was asked for at first it is as right as then.
    assert run() == ["of an earlier run; --force does it again"] * 2
    assert [row[2] for row in rows_of(out)] == ["False", "False"]
    gone = one.rename(tmp_path / "gone")
    first, second = run()
    assert "one holds what an earlier run found" in first
    assert rows_of(out)[0][:3] == ("one", "one", "True")
    gone.rename(one)
    assert run() == ["of an earlier run; --force does it again"] * 2
    assert run("--method", "layered", "--force") == ["", ""]
    assert (out / "two" / "track.csv").read_bytes() != track


def test_another_recording_of_the_same_name_takes_nothing_from_an_earlier_one(tmp_path: Path) -> None:
    """It was refused, and with --force, as it asked for, the other's result was replaced and its row was gone."""
    one = pt.simulate_arm(tmp_path / "one", pt.ArmScene(duration_s=2.0), 1)
    alike, two = (Path(shutil.copytree(one, tmp_path / name)) for name in ("sub/one", "two"))
    out = tmp_path / "out"
    for folders in ((one, two), (alike, two)):
        files = [str(folder) for folder in folders]
        done = CliRunner().invoke(app, ["track", *files, "--out", str(out), "--no-report", "--quiet", "--force"])
        assert done.exit_code == 0, done.output
    assert [row[:2] for row in rows_of(out)] == [("one", "one-2"), ("two", "two"), ("one", "one")]
    twice = [str(one), f"{one}/../one", str(two)]
    done = CliRunner().invoke(app, ["track", *twice, "--out", str(tmp_path / "b"), "--no-report", "--quiet"])
    assert done.exit_code == 0, done.output
    assert [row[:2] for row in rows_of(tmp_path / "b")] == [("one", "one"), ("two", "two")]


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_process_that_is_killed_stops_no_other(tmp_path: Path) -> None:
    """One that ran out of memory ended all, with an internal error, and no index."""
    folders = [pt.simulate_arm(tmp_path / name, pt.ArmScene(duration_s=2.0), 1) for name in ("one", "two", "three")]
    found = batch.track_all(folders, tmp_path / "out", killed_by_two, page=False)
    assert [(one.recording.name, one.failed) for one in found] == [("one", False), ("two", True), ("three", False)]
    assert found[1].said == ("its process was killed, or did not start: is there too little memory for it?",)


def killed_by_two(recording: pt.Recording) -> Method:
    assert recording.folder is not None
    if recording.folder.name == "two":
        os.kill(os.getpid(), signal.SIGKILL)
    return pt.Layered(particles=50)


def test_one_of_no_use_has_failed_too(tmp_path: Path) -> None:
    """As of one recording alone; of several the exit status was 0."""
    hidden = pt.simulate_arm(tmp_path / "hidden", pt.ArmScene(duration_s=3.0, occlusions=((0.8, 3.0),)), 3)
    seen = pt.simulate_arm(tmp_path / "seen", pt.ArmScene(duration_s=3.0), 3)
    arguments = ["track", str(hidden), str(seen), "--out", str(tmp_path / "out"), "--no-report"]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 1
    rows = list(csv.DictReader((tmp_path / "out" / "index.csv").read_text().splitlines()))
    assert [(row["result"], row["failed"]) for row in rows] == [("hidden", "True"), ("seen", "False")]
    assert "hidden: failed: 5" in done.output
    assert "are not valid, do not use them: patch not found again" in done.output


def is_running(pid: str) -> bool:
    """Not there, or a zombie that nobody has waited for, is not."""
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and stat.read_text().rsplit(")", 1)[1].split()[0] != "Z"


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_whoever_stops_it_does_not_wait_for_the_recordings_in_flight(tmp_path: Path) -> None:
    first = pt.simulate_arm(tmp_path / "trial1", pt.ArmScene(duration_s=12.0), 1)
    folders = [str(first), str(shutil.copytree(first, tmp_path / "trial2"))]
    command = [sys.executable, "-m", "pytracker", "track", *folders, "--out", str(tmp_path / "out"), "--jobs", "2"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stderr=pipe, stdout=pipe, start_new_session=True) as run:  # noqa: S603 - our own
        children = Path(f"/proc/{run.pid}/task/{run.pid}/children")
        ours: list[str] = []
        for _ in range(200):
            time.sleep(0.05)
            ours = children.read_text().split() if children.exists() else []
            if len(ours) >= 2:
                break
        time.sleep(2.0)
        began = time.monotonic()
        os.kill(run.pid, signal.SIGTERM)
        run.communicate(timeout=20)
        assert time.monotonic() - began < 4.0
        assert run.returncode == 128 + signal.SIGTERM
    time.sleep(0.5)
    assert not [pid for pid in ours if is_running(pid)]
    assert not (tmp_path / "out" / "trial1").exists()
