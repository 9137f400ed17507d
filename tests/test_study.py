"""Studies: what the table says, that nothing is done twice or lost, and that it is the same wherever it ran."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest
from study_cases import CIRCLE, METHODS, SCENE, asked, small

import pytracker as pt
from pytracker.scores.evaluate import held
from pytracker.simulate import ArmSimulation
from pytracker.study import Study, StudyRecording
from pytracker.study import study as study_module
from pytracker.study.execute import COLUMNS

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


def test_table_says_what_the_scores_say(tmp_path: Path) -> None:
    table = pt.run_study(small(), tmp_path / "out")
    simulation = ArmSimulation(SCENE, 2)
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
        "said",
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
    more = Study(recordings=(CIRCLE,), methods=METHODS, seeds=(1, 2, 3))
    assert asked(more, tmp_path / "out")[1] == 6
    monkeypatch.setattr(study_module, "fingerprint", lambda: "another build")
    assert asked(small(), tmp_path / "out")[1] == 0


def test_a_folder_with_other_content_is_another_recording(simulated: Path, tmp_path: Path) -> None:
    folder = tmp_path / "trial"
    shutil.copytree(simulated, folder)
    recordings = (StudyRecording(name="trial", folder=folder),)
    study = Study(recordings=recordings, methods=(pt.Layered(particles=50),), seeds=(1,))
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
        StudyRecording(name="broken", folder=broken),
        StudyRecording(name="absent", folder=tmp_path / "absent"),
        StudyRecording(name="good", folder=simulated_body),
    )
    methods = (pt.BodyPlain(particles=20), pt.BodyPlain(particles=20, free=("no_such",)))
    study = Study(recordings=recordings, methods=methods, seeds=(1,))
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
    recording = StudyRecording(name="own", scene=scene)
    before = recording.digest()
    skeleton.write_text(ASF + "# another\n")
    assert len({before, recording.digest(), ""}) == 3


def test_messages_do_not_depend_on_where_it_ran(tmp_path: Path) -> None:
    """A simulated recording lies somewhere else each time."""
    scene = pt.ArmScene(duration_s=1.0, dropped_imu=0.99)
    study = Study(
        recordings=(StudyRecording(name="gaps", scene=scene),), methods=(pt.Layered(particles=10),), seeds=(0,)
    )
    tables = [pt.run_study(study, tmp_path / str(k)).csv() for k in range(2)]
    assert tables[0] == tables[1]
    assert "gaps/imu.csv" in tables[0]
    assert "pytracker-" not in tables[0]


def test_where_takes_a_method_with_all_its_parameters(simulated_body: Path, tmp_path: Path) -> None:
    recordings = (CIRCLE, StudyRecording(name="person", folder=simulated_body))
    methods = (pt.Plain(particles=50), pt.BodyPlain(particles=50))
    table = pt.run_study(Study(recordings=recordings, methods=methods, seeds=range(2)), tmp_path / "out")
    assert {row["recording"] for row in table.where(method=methods[0])} == {"circle"}
    assert {row["recording"] for row in table.where(method=methods[1])} == {"person"}
    assert table.where(method=pt.Plain(particles=50, accel_density=9.0)) == []
    assert len(table.where(method="plain", joint="all")) == 4


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"status": "ok", "error": "", "said": "", "rows": []}',
             '{"status": "ok", "error": "", "said": "", "rows": [{}]}', '{"status": "ok", "error": "", "rows": []}',
             '{"status": "ok", "error": "", "said": "", "rows": [1]}',
             '{"status": "failed", "error": "x", "said": "", "rows": []}'],
)  # fmt: skip
def test_a_result_that_cannot_be_read_is_done_again(tmp_path: Path, text: str) -> None:
    table, _ = asked(small(), tmp_path / "out")
    next((tmp_path / "out" / "runs").glob("*.json")).write_text(text)
    assert asked(small(), tmp_path / "out") == (table, 5)


def test_a_lost_track_keeps_its_frames(tmp_path: Path) -> None:
    # A bias that drives the particles through the camera.
    recording = StudyRecording(name="circle", scene=pt.ArmScene(duration_s=2.0, acc_bias=30.0), pixel_sd=4.0)
    study = Study(recordings=(recording,), methods=(pt.Plain(particles=10),), seeds=(3,))
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


def test_a_name_that_a_spreadsheet_would_run_is_written_as_a_word(tmp_path: Path) -> None:
    recording = StudyRecording(name="=1+1", scene=pt.ArmScene(duration_s=1.0), pixel_sd=4.0)
    study = Study(recordings=(recording,), methods=(pt.Layered(particles=5),), seeds=(1,))
    pt.run_study(study, tmp_path / "out")
    table = (tmp_path / "out" / "table.csv").read_text().splitlines()
    assert table[1].startswith("'=1+1,")


def test_what_is_odd_is_in_the_table_and_on_the_page(tmp_path: Path) -> None:
    """A heading that is off by 25° was `ok`, and nothing was said; the first pose held stands beside every error."""
    right = pt.simulate_arm(tmp_path / "right", pt.ArmScene(duration_s=6.0, pattern="rectangle"), 4)
    turned = Path(shutil.copytree(right, tmp_path / "turned"))
    text = (turned / "recording.toml").read_text()
    assert "[[imu]]\n" in text
    (turned / "recording.toml").write_text(text.replace("[[imu]]\n", "[[imu]]\nheading_deg = 25.0\n", 1))
    recordings = (
        *(StudyRecording(name=name, folder=tmp_path / name) for name in ("right", "turned")),
        StudyRecording(name="simulated", scene=pt.ArmScene(duration_s=2.0), pixel_sd=2.0),
    )
    methods = (pt.Ekf(corrections=("colour", "arm_length")), pt.Ekf(corrections=("colour", "arm_length"), bias=True))
    study = Study(recordings=recordings, methods=methods, seeds=(1, 2))
    table, _ = asked(study, tmp_path / "out")
    assert list(table.said()) == ["turned"]
    assert "heading_deg" in table.said()["turned"]
    assert str(tmp_path) not in table.csv()
    still = table.values("held_m", joint="wrist", recording="right", method=methods[0])
    (truth,) = {pt.evaluate(held(pt.track(pt.load(right), methods[0])), pt.load(right).truth).joints["wrist"].rms_m}
    assert still == pytest.approx([truth, truth])
    page = (tmp_path / "out" / "index.html").read_text()
    for words in ("first pose held", "EKF with constraint, bias", "12 runs kept the track", "check heading_deg"):
        assert words in page
    assert str(tmp_path) not in page
