"""Studies that are killed, stopped or run elsewhere: nothing is lost, and the table is the same."""

from __future__ import annotations

import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE
from study_cases import CIRCLE, METHODS, TOML, small

import pytracker as pt
from pytracker.study import Study, StudyRecording, schedule
from pytracker.study.schedule import on_dask


@pytest.mark.parametrize("left", [[], [".made-by-pytracker"], [".made-by-pytracker", "runs/"]])
def test_a_study_killed_at_once_is_gone_on_with(tmp_path: Path, left: list[str]) -> None:
    for name in ["", *left]:
        path = tmp_path / "out" / name
        path.mkdir() if not name or name.endswith("/") else path.touch()
    assert pt.run_study(small(), tmp_path / "out").count("ok") == 6


def test_what_killed_processes_left_is_swept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    pt.run_study(small(), out)
    old, new = out / "runs" / "a.json.1.partial", out / "runs" / "b.json.2.partial"
    for path in (old, new):
        path.touch()
    os.utime(old, (1, 1))
    dead = out / f".scratch-{platform.node()}-999999999"
    dead.mkdir()
    pt.run_study(small(), out)
    assert not old.exists()
    assert new.exists()  # of a process that may be writing it
    assert not dead.exists()
    assert not list(out.glob(".scratch-*"))


@pytest.mark.skipif(sys.platform == "win32", reason="signals as Unix has them")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_stopped_by_a_signal_it_keeps_what_was_in_flight(tmp_path: Path, name: str) -> None:
    file = tmp_path / "study.toml"
    file.write_text(TOML.replace("8000", "20000").replace("duration_s = 2.0", "duration_s = 20.0"))
    number = getattr(signal, name)
    process = subprocess.Popen(  # noqa: S603
        study_command(file, tmp_path / "out"), stderr=subprocess.PIPE, text=True,
        # What runs the tests may ignore some signals, and a child would too.
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # noqa: PLW1509
    )  # fmt: skip
    until = time.monotonic() + 60
    while time.monotonic() < until and not list(tmp_path.glob("out/runs/*.json")):
        time.sleep(0.01)
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 128 + number
    assert "pytracker: stopping" in said
    assert "Traceback" not in said
    assert not list(tmp_path.glob("out/runs/*.partial"))


def study_command(file: Path, out: Path) -> list[str]:
    return [sys.executable, "-m", "pytracker", "study", str(file), "--out", str(out), "--quiet"]


@pytest.mark.skipif(sys.platform == "win32", reason="kills as Unix does")
def test_killed_again_and_again_and_gone_on_with(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(TOML)
    pt.run_study(pt.read_study(file), tmp_path / "undisturbed")
    out, pick = tmp_path / "out", np.random.default_rng(4)
    seen: list[Path] = []
    for k in range(10 if IS_ACCEPTANCE else 4):
        process = subprocess.Popen(study_command(file, out))  # noqa: S603
        # Somewhere in the work, not only in the imports: from the first new result on.
        before, until = len(seen), time.monotonic() + 60
        while process.poll() is None and time.monotonic() < until and len(list(out.glob("runs/*.json"))) <= before:
            time.sleep(0.005)
        time.sleep(pick.uniform(0.0, 0.08))
        process.send_signal(signal.SIGKILL)
        process.wait()
        seen = list(out.glob("runs/*.json"))
        assert len(seen) > before or len(seen) == 40, k
    assert not (out / "table.csv").exists() or len(seen) == 40
    assert subprocess.run(study_command(file, out), check=False).returncode == 0  # noqa: S603
    assert (out / "table.csv").read_bytes() == (tmp_path / "undisturbed" / "table.csv").read_bytes()


def test_on_a_cluster_that_loses_a_worker(simulated: Path, tmp_path: Path) -> None:
    """Two worker processes; one is killed in mid-study: the same table, byte for byte. A changed folder is noticed."""
    distributed = pytest.importorskip("distributed")
    video = StudyRecording(name="person", scene=pt.BodyScene(duration_s=1.0))
    methods = (*METHODS, pt.BodyPlain(particles=50), pt.Partitioned(particles=50))
    study = Study(recordings=(CIRCLE, video), methods=methods, seeds=tuple(range(1, 5)))
    here = pt.run_study(study, tmp_path / "here")
    killed: list[int] = []
    left = set(Path(tempfile.gettempdir()).glob("pytracker-*"))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        pids = [worker.pid for worker in cluster.workers.values()]

        def kill_one(done: int, total: int) -> None:
            if done > 5 and not killed:
                assert done < total
                os.kill(pids[0], signal.SIGKILL)
                killed.append(done)

        there = pt.run_study(study, tmp_path / "there", scheduler=cluster.scheduler_address, progress=kill_one)
        trial = shutil.copytree(simulated, tmp_path / "trial")
        recording = StudyRecording(name="trial", folder=trial)
        again = Study(recordings=(recording,), methods=(pt.Layered(particles=50),), seeds=(1,))
        first = pt.run_study(again, tmp_path / "first", scheduler=cluster.scheduler_address)
        text = (trial / "recording.toml").read_text("utf-8")
        (trial / "recording.toml").write_text(text.replace("upper_arm_m = 0.3", "upper_arm_m = 0.32"), "utf-8")
        changed = pt.run_study(again, tmp_path / "changed", scheduler=cluster.scheduler_address)
    assert first.values("rms_m", joint="wrist") != changed.values("rms_m", joint="wrist")
    assert changed == pt.run_study(again, tmp_path / "changed here")
    assert killed
    assert set(Path(tempfile.gettempdir()).glob("pytracker-*")) == left
    assert there.count("ok") == 20
    assert there == here
    assert (tmp_path / "there" / "table.csv").read_bytes() == (tmp_path / "here" / "table.csv").read_bytes()


def test_no_cluster_there(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(schedule, "CONNECT_S", 2)
    with pytest.raises(pt.InputError, match="--scheduler is 'nonsense', expected the address"):
        list(on_dask([], "nonsense", lambda run, result: None))
    with pytest.raises(pt.InputError, match="expected the address of a Dask scheduler"):
        list(on_dask([], "tcp://127.0.0.1:1", lambda run, result: None))
