"""Studies: what the table says, that nothing is done twice or lost, and that it is the same wherever it ran."""

from __future__ import annotations

import csv
import os
import platform
import re
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
from pytracker.study import schedule
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


ASF = """:version 1.10
:name own
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
:hierarchy
  begin
  end
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
    assert list(written[0]) == [
        "recording",
        "kind",
        "method",
        "particles",
        "corrections",
        "seed",
        "status",
        "error",
        *COLUMNS,
    ]
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
    (folder / "result").mkdir()
    (folder / "result" / "notes.txt").write_text("of no recording")
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
    assert table.where(recording="absent")[0]["error"] == (
        "InputError: absent: is no folder, expected a folder with recording.toml"
    )
    assert [row["status"] for row in table.where(recording="good")] == ["ok"] * 9 + ["failed"]
    assert "no_such" in str(table.where(recording="good", status="failed")[0]["error"])
    # One value a run, so that runs of several methods are paired by their seeds.
    assert np.isnan(table.values("average_m", recording="good", method=methods[1])).all()
    assert len(table.values("average_m", method=methods[0])) == 3
    # What failed is tried again, what is done is not.
    shutil.copy(simulated_body / "video.mp4", broken / "video.mp4")
    table, known = asked(study, tmp_path / "out")
    assert (known, table.count("ok")) == (1, 2)


def test_a_scene_with_another_motion_is_another_recording(simulated_body: Path, tmp_path: Path) -> None:
    skeleton = tmp_path / "a.asf"
    skeleton.write_text(ASF)
    scene = pt.BodyScene(duration_s=0.5, skeleton=str(skeleton), motion=str(simulated_body / "motion.amc"))
    recording = pt.StudyRecording(name="own", scene=scene)
    before = recording.digest()
    skeleton.write_text(ASF + "# another\n")
    assert len({before, recording.digest(), ""}) == 3


def test_messages_do_not_depend_on_where_it_ran(tmp_path: Path) -> None:
    """A simulated recording lies somewhere else each time."""
    scene = pt.ArmScene(duration_s=1.0, dropped_imu=0.99)
    study = pt.Study(
        recordings=(pt.StudyRecording(name="gaps", scene=scene),), methods=(pt.Layered(particles=10),), seeds=(0,)
    )
    tables = [pt.run_study(study, tmp_path / str(k)).csv() for k in range(2)]
    assert tables[0] == tables[1]
    assert "gaps/imu.csv" in tables[0]
    assert "pytracker-" not in tables[0]


def test_where_takes_a_method_with_all_its_parameters(simulated_body: Path, tmp_path: Path) -> None:
    recordings = (CIRCLE, pt.StudyRecording(name="person", folder=simulated_body))
    methods = (pt.Plain(particles=50), pt.BodyPlain(particles=50))
    table = pt.run_study(pt.Study(recordings=recordings, methods=methods, seeds=range(2)), tmp_path / "out")
    assert {row["recording"] for row in table.where(method=methods[0])} == {"circle"}
    assert {row["recording"] for row in table.where(method=methods[1])} == {"person"}
    assert table.where(method=pt.Plain(particles=50, accel_density=9.0)) == []
    assert len(table.where(method="plain", joint="all")) == 4


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


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"status": "ok", "error": "", "rows": []}', '{"status": "ok", "error": "", "rows": [{}]}',
             '{"status": "ok", "error": "", "rows": [1]}', '{"status": "failed", "error": "x", "rows": []}'],
)  # fmt: skip
def test_a_result_that_cannot_be_read_is_done_again(tmp_path: Path, text: str) -> None:
    table, _ = asked(small(), tmp_path / "out")
    next((tmp_path / "out" / "runs").glob("*.json")).write_text(text)
    assert asked(small(), tmp_path / "out") == (table, 5)


@pytest.mark.skipif(sys.platform == "win32", reason="signals as Unix has them")
def test_stopped_by_a_signal_it_keeps_what_was_in_flight(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(TOML.replace("8000", "20000").replace("duration_s = 2.0", "duration_s = 20.0"))
    process = subprocess.Popen(study_command(file, tmp_path / "out"), stderr=subprocess.PIPE, text=True)  # noqa: S603
    until = time.monotonic() + 60
    while time.monotonic() < until and not list(tmp_path.glob("out/runs/*.json")):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert "pytracker: stopping" in said
    assert "Traceback" not in said
    assert not list(tmp_path.glob("out/runs/*.partial"))


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
    (tmp_path / "letters" / "runs").mkdir()
    with pytest.raises(pt.InputError, match="already exists and is no study"):
        pt.run_study(small(), tmp_path / "letters")
    with pytest.raises(pt.InputError, match="workers is 0, expected 1 or more"):
        pt.run_study(small(), tmp_path / "out", workers=0)


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


def test_on_a_cluster_that_loses_a_worker(simulated: Path, tmp_path: Path) -> None:
    """Two worker processes; one is killed in mid-study: the same table, byte for byte. A changed folder is noticed."""
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
        trial = shutil.copytree(simulated, tmp_path / "trial")
        recording = pt.StudyRecording(name="trial", folder=trial)
        again = pt.Study(recordings=(recording,), methods=(pt.Layered(particles=50),), seeds=(1,))
        first = pt.run_study(again, tmp_path / "first", scheduler=cluster.scheduler_address)
        text = (trial / "recording.toml").read_text("utf-8")
        (trial / "recording.toml").write_text(text.replace("upper_arm_m = 0.3", "upper_arm_m = 0.32"), "utf-8")
        changed = pt.run_study(again, tmp_path / "changed", scheduler=cluster.scheduler_address)
    assert first.values("rms_m", joint="wrist") != changed.values("rms_m", joint="wrist")
    assert changed == pt.run_study(again, tmp_path / "changed here")
    assert killed
    assert there.count("ok") == 30
    assert there == here
    assert (tmp_path / "there" / "table.csv").read_bytes() == (tmp_path / "here" / "table.csv").read_bytes()


def test_no_cluster_there(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(schedule, "CONNECT_S", 2)
    with pytest.raises(pt.InputError, match="--scheduler is 'nonsense', expected the address"):
        list(on_dask([], "nonsense", lambda run, result: None))
    with pytest.raises(pt.InputError, match="expected the address of a Dask scheduler"):
        list(on_dask([], "tcp://127.0.0.1:1", lambda run, result: None))


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        ("schema = 1", "schema = 2", "schema is 2, this version reads 1"),
        ("seeds = 10", "seeds = 0", "seeds is 0, expected a whole number from 1 to 100000, or a list of them"),
        ("seeds = 10", "seeds = 1000000000000", "seeds is 1000000000000, expected a whole number from 1 to 100000"),
        ("seeds = 10", "seeds = true", "seeds is True, expected a whole number"),
        ("seeds = 10", "seeds = [1, 1]", "the seed 1 twice, expected all to differ"),
        ("seeds = 10", "seeds = [-1]", "the seed is -1, expected a whole number from 0 to 2^63 - 1"),
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
        (lambda: pt.StudyRecording(name="a\rb", folder=Path()), "expected printable characters"),
        (lambda: pt.StudyRecording(name="x", scene=SCENE, pixel_sd=float("inf")), "expected an arm's, 0 px or more"),
        (lambda: pt.StudyRecording(name="x", scene=SCENE, seed=-5), "the seed is -5, expected a whole number"),
        (lambda: pt.Study(recordings=(CIRCLE,), methods=METHODS, seeds=(1.5,)), "the seed is 1.5"),  # type: ignore[arg-type]
        (lambda: pt.Study(recordings=(CIRCLE,), methods=METHODS, seeds=range(10**6)), "3000000 runs, expected at most"),
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


def test_the_readmes_study_is_one(tmp_path: Path) -> None:
    text = (Path(__file__).parents[1] / "README.md").read_text("utf-8")
    (block,) = [b for b in re.findall(r"```toml\n(.*?)```", text, re.DOTALL) if "[[method]]" in b]
    (tmp_path / "study.toml").write_text(block, "utf-8")
    study = pt.read_study(tmp_path / "study.toml")
    assert [recording.name for recording in study.recordings] == ["trial03", "circle"]
    assert [getattr(method, "particles", 0) for method in study.methods] == [100, 500, 2000]
    assert len(study.seeds) == 10
