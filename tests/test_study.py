"""Studies: what the table says, that nothing is done twice or lost, and that it is the same wherever it ran."""

from __future__ import annotations

import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.study import study as study_module
from pytracker.study.execute import COLUMNS
from pytracker.study.schedule import on_dask

SCENE = pt.ArmScene(duration_s=2.0)
CIRCLE = pt.StudyRecording(name="circle", scene=SCENE, pixel_sd=4.0)
METHODS = (pt.Layered(particles=100), pt.Layered(particles=200), pt.Ekf(corrections=("colour", "arm_length")))

TOML = """
schema = 1
seeds = 10

[[recording]]
name = "circle"
simulate = "arm"
scene = { duration_s = 2.0 }
pixel_sd = 4.0

[[method]]
name = "layered"
grid = { particles = [400, 2000, 8000] }

[[method]]
name = "ekf"
set = { corrections = ["colour", "arm_length"] }
"""


def small() -> pt.Study:
    return pt.Study(recordings=(CIRCLE,), methods=METHODS, seeds=(1, 2))


def asked(study: pt.Study, out: Path) -> tuple[pt.StudyTable, int]:
    """The table, and how many runs were known before."""
    known: list[int] = []
    table = pt.run_study(study, out, progress=lambda done, total: known.append(done))
    return table, known[0]


def test_table_says_what_the_scores_say(tmp_path: Path) -> None:
    table = pt.run_study(small(), tmp_path / "out")
    simulation = pt.ArmSimulation(SCENE, 2)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(4.0))
    track = pt.track(simulation.recording(), METHODS[1], 2, sightings=sightings)
    wrist = pt.evaluate(track, simulation.truth).joints["wrist"]
    (row,) = table.where(recording="circle", method="layered", particles=200, seed=2, joint="wrist")
    assert row["rms_m"] == wrist.rms_m
    assert row["mean_y_m"] == wrist.mean_m[1]
    assert row["coverage_z"] == wrist.coverage[2]
    assert row["ess_share"] == pytest.approx(track.ess.mean() / 200)
    with (tmp_path / "out" / "table.csv").open(encoding="utf-8") as file:
        written = list(csv.DictReader(file))
    assert list(written[0]) == ["recording", "method", "particles", "corrections", "seed", "status", "error", *COLUMNS]
    assert len(written) == len(METHODS) * 2 * 3  # wrist, elbow, all
    assert float(written[0]["rms_m"]) == pytest.approx(table.values("rms_m", joint="wrist")[0], rel=1e-8)
    assert written[-1]["corrections"] == '["colour", "arm_length"]'


def test_what_is_done_is_not_done_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, known = asked(small(), tmp_path / "out")
    assert known == 0
    second, known = asked(small(), tmp_path / "out")
    assert known == 6
    assert second == first
    more = pt.Study(recordings=(CIRCLE,), methods=METHODS, seeds=(1, 2, 3))
    assert asked(more, tmp_path / "out")[1] == 6
    monkeypatch.setattr(study_module, "fingerprint", lambda: "another build")
    assert asked(small(), tmp_path / "out")[1] == 0


def test_a_folder_with_other_content_is_another_recording(simulated: Path, tmp_path: Path) -> None:
    folder = tmp_path / "trial"
    shutil.copytree(simulated, folder)
    recordings = (pt.StudyRecording(name="trial", folder=folder),)
    study = pt.Study(recordings=recordings, methods=(pt.Layered(particles=50),), seeds=(1,))
    assert asked(study, tmp_path / "out")[1] == 0
    assert asked(study, tmp_path / "out")[1] == 1
    (folder / "recording.toml").write_text((folder / "recording.toml").read_text() + "# the same, said again\n")
    assert asked(study, tmp_path / "out")[1] == 0


def test_a_run_that_fails_is_recorded_and_stops_no_other(simulated_body: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken"
    shutil.copytree(simulated_body, broken)
    (broken / "video.mp4").write_bytes(b"no video")
    recordings = (
        pt.StudyRecording(name="broken", folder=broken),
        pt.StudyRecording(name="absent", folder=tmp_path / "absent"),
        pt.StudyRecording(name="good", folder=simulated_body),
    )
    methods = (pt.BodyPlain(particles=20), pt.BodyPlain(particles=20, free=("no_such",)))
    study = pt.Study(recordings=recordings, methods=methods, seeds=(1,))
    table, _ = asked(study, tmp_path / "out")
    assert (table.count("ok"), table.count("failed")) == (1, 5)
    assert "video.mp4" in str(table.where(recording="broken")[0]["error"])
    assert "expected a folder with recording.toml" in str(table.where(recording="absent")[0]["error"])
    assert [row["status"] for row in table.where(recording="good")] == ["ok"] * 9 + ["failed"]
    assert "no_such" in str(table.where(recording="good", status="failed")[0]["error"])
    # What failed is tried again, what is done is not.
    shutil.copy(simulated_body / "video.mp4", broken / "video.mp4")
    table, known = asked(study, tmp_path / "out")
    assert (known, table.count("ok")) == (1, 2)


def test_a_lost_track_keeps_its_frames(tmp_path: Path) -> None:
    # A bias that drives the particles through the camera.
    recording = pt.StudyRecording(name="circle", scene=pt.ArmScene(duration_s=2.0, acc_bias=30.0), pixel_sd=4.0)
    study = pt.Study(recordings=(recording,), methods=(pt.Plain(particles=10),), seeds=(3,))
    table = pt.run_study(study, tmp_path / "out")
    assert table.count("lost") == 1
    row = table.where(joint="wrist")[0]
    assert "frame 10: all 10 particle weights are zero" in str(row["error"])
    assert isinstance(row["frames"], int)
    assert 0 < row["frames"] < 50


def test_parquet_holds_the_same(tmp_path: Path) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    table = pt.run_study(small(), tmp_path / "out", parquet=True)
    back = pq.read_table(tmp_path / "out" / "table.parquet")
    assert back.column_names == list(table.columns)
    assert back.to_pylist() == list(table.rows)


def test_threads_change_nothing(tmp_path: Path) -> None:
    tables = [pt.run_study(small(), tmp_path / str(n), workers=n).csv() for n in (1, 3)]
    assert tables[0] == tables[1]


def test_it_takes_no_folder_that_is_something_else(tmp_path: Path) -> None:
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "dear.txt").touch()
    with pytest.raises(pt.InputError, match="already exists and is no study"):
        pt.run_study(small(), tmp_path / "letters")


def study_command(file: Path, out: Path) -> list[str]:
    return [sys.executable, "-m", "pytracker", "study", str(file), "--out", str(out), "--quiet"]


@pytest.mark.skipif(sys.platform == "win32", reason="kills as Unix does")
def test_killed_ten_times_and_gone_on_with(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(TOML)
    pt.run_study(pt.read_study(file), tmp_path / "undisturbed")
    out, pick = tmp_path / "out", np.random.default_rng(4)
    seen: list[Path] = []
    for k in range(10):
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


def test_on_a_cluster_that_loses_a_worker(tmp_path: Path) -> None:
    """Two worker processes; one is killed in mid-study: the same table, byte for byte."""
    distributed = pytest.importorskip("distributed")
    video = pt.StudyRecording(name="person", scene=pt.BodyScene(duration_s=1.0))
    methods = (*METHODS, pt.BodyPlain(particles=50), pt.Partitioned(particles=50))
    study = pt.Study(recordings=(CIRCLE, video), methods=methods, seeds=tuple(range(1, 7)))
    here = pt.run_study(study, tmp_path / "here")
    killed: list[int] = []
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
    assert killed
    assert there.count("ok") == 30
    assert there == here
    assert (tmp_path / "there" / "table.csv").read_bytes() == (tmp_path / "here" / "table.csv").read_bytes()


def test_no_cluster_there() -> None:
    pytest.importorskip("distributed")
    with pytest.raises(pt.InputError, match="expected the address of a Dask scheduler"):
        list(on_dask([], "tcp://127.0.0.1:1", study_module.fingerprint))


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        ("schema = 1", "schema = 2", "schema is 2, this version reads 1"),
        ("seeds = 10", "seeds = 0", "seeds"),
        ("seeds = 10", "seeds = [1, 1]", "the seed 1 twice, expected all to differ"),
        ("seeds = 10", "seeds = [-1]", "the seed -1, expected 0 to"),
        ("seeds = 10", "seed = 10", "seed is not a known key, did you mean 'seeds'?"),
        ('simulate = "arm"', 'simulate = "leg"', "recording[0].simulate is 'leg', expected: input should be 'arm'"),
        ('simulate = "arm"', "", "recording[0] has neither of folder and simulate, expected one of them"),
        ('simulate = "arm"', 'folder = "x"', "recording[0].scene goes with simulate, not with folder"),
        ("duration_s = 2.0", "duration = 2.0", "recording[0].scene.duration is not a known key, did you mean"),
        ("duration_s = 2.0", "duration_s = -2.0", "duration_s is -2.0, expected a positive number"),
        ("pixel_sd = 4.0", "pixel_sd = -4.0", "recording[0].pixel_sd is -4.0"),
        ('name = "layered"', 'name = "layred"', "method[0].name is 'layred', did you mean 'layered'?"),
        ("grid = { particles", "grid = { particle", "method[0]: particle: Layered has no such parameter, did you mean"),
        (
            "grid = { particles",
            'set = { particles = "few" }\ngrid = { pixel_sd',
            "Layered.particles is 'few', expected",
        ),
        ("grid = {", "set = { particles = 3 }\ngrid = {", "method[0] has particles in both set and grid"),
        ('name = "ekf"', 'name = "partitioned"', "method[1].name is 'partitioned', expected one of: inertial"),
        ("grid = { particles = [400, 2000, 8000] }", "grid = { particles = [4, 4] }", "twice, expected all to differ"),
    ],
)
def test_faults_of_a_study_file(tmp_path: Path, line: str, instead: str, message: str) -> None:
    file = tmp_path / "study.toml"
    assert line in TOML
    file.write_text(TOML.replace(line, instead, 1))
    with pytest.raises(pt.InputError) as caught:
        pt.read_study(file)
    assert str(file) in str(caught.value)
    assert message in str(caught.value)


def test_a_study_file_is_what_it_says(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(TOML)
    study = pt.read_study(file)
    assert study.recordings == (CIRCLE,)
    assert study.seeds == tuple(range(1, 11))
    assert [getattr(method, "particles", 0) for method in study.methods] == [400, 2000, 8000, 0]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pt.StudyRecording(name="x"), "has neither folder nor scene"),
        (lambda: pt.StudyRecording(name="x", folder=Path(), seed=1), "seed and pixel_sd go with a scene"),
        (lambda: pt.StudyRecording(name="x", scene=pt.BodyScene(), pixel_sd=1.0), "expected an arm's"),
        (lambda: pt.Study(recordings=(), methods=METHODS, seeds=(1,)), "has no recording, expected at least one"),
        (lambda: pt.Study(recordings=(CIRCLE,), methods=(pt.BodyPlain(),), seeds=(1,)), "the study has none"),
        (lambda: pt.Study(recordings=(CIRCLE, CIRCLE), methods=METHODS, seeds=(1,)), "twice"),
    ],
)
def test_faults_of_a_study(make: Callable[[], object], message: str) -> None:
    with pytest.raises(pt.InputError, match=message):
        make()
