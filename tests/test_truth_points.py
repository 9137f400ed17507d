"""Truth as points: TRC, C3D and CSV, of an arm or a body, with a map of names; and the pose that is held beside it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import ezc3d
import numpy as np
import pytest

import pytracker as pt
from pytracker._core import KEY_JOINTS
from pytracker.formats.c3d import read_c3d
from pytracker.formats.markers import Markers, check_times, without_fillers
from pytracker.formats.qualisys import read_qualisys
from pytracker.formats.trc import read_trc
from pytracker.formats.truth_csv import read_truth_csv
from pytracker.recording.schema import TruthEntry
from pytracker.recording.truth.points import POINT_FORMATS, load_points
from pytracker.rotation import Array


def test_real_trc_files_load(shared: Callable[[str], Path]) -> None:
    walk = read_trc(shared("data/markers/opensim_markers_walk.trc"))
    assert len(walk.time_s) == 238
    upper = np.linalg.norm(walk.positions_m["R.Shoulder"] - walk.positions_m["R.Elbow"], axis=1)
    assert np.nanmean(upper) == pytest.approx(0.368, abs=0.01)
    people = read_trc(next(shared("data/people/gestures").glob("0_1_20*.trc")))
    assert len(people.time_s) == 232
    assert len(people.positions_m) == 27


def test_a_real_c3d_file_loads(shared: Callable[[str], Path]) -> None:
    found = read_c3d(shared("data/markers/pyomeca_markers_analogs.c3d"))
    assert found.rate_hz == pytest.approx(100)
    elbow = 0.5 * (found.positions_m["EPICl"] + found.positions_m["EPICm"])
    wrist = 0.5 * (found.positions_m["STYLr"] + found.positions_m["STYLu"])
    lengths = np.linalg.norm(elbow - wrist, axis=1)
    assert np.nanmean(lengths) == pytest.approx(0.261, abs=0.01)
    assert 0 < sum(found.gaps[name] for name in ("ACRO_tip", "EPICl", "EPICm", "STYLr", "STYLu")) < 200


HEAD = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t2\t2\tmm\n"
NAMES = "Frame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"


def test_a_trc_says_gaps_and_units(tmp_path: Path) -> None:
    path = tmp_path / "a.trc"
    path.write_text(HEAD + NAMES + "1\t0.0\t1000\t0\t0\t\t\t\n2\t0.01\t2000\t0\t0\t1\t2\t3\n", "utf-8")
    found = read_trc(path)
    assert found.positions_m["A"][:, 0].tolist() == [1.0, 2.0]
    assert found.gaps == {"A": 0, "B": 1}
    assert found.rate_hz == 100


@pytest.mark.parametrize("unit", ["M", "meters", "Metres"])
def test_a_trc_may_spell_its_unit_out(tmp_path: Path, unit: str) -> None:
    rows = "\n".join("\t".join(map(str, [k + 1, k / 100, *([0.5] * 6)])) for k in range(3))
    (tmp_path / "a.trc").write_text((HEAD + NAMES).replace("mm", unit) + rows, "utf-8")
    assert read_trc(tmp_path / "a.trc").positions_m["A"][0] == pytest.approx([0.5, 0.5, 0.5])


@pytest.mark.parametrize("suffix", ["csv", "trc", "c3d"])
def test_zeros_are_gaps_but_of_a_joint_that_is_the_origin(tmp_path: Path, suffix: str) -> None:
    """They were truth: 200 rows of 2001 made 11 cm of 1.5."""
    rng = np.random.default_rng(0)
    wrist, shoulder = np.round(rng.uniform(0.1, 0.5, (30, 3)), 3), np.zeros((30, 3))
    wrist[[4, 5, 20]] = 0.0
    path = tmp_path / f"a.{suffix}"
    if suffix == "csv":
        head = ",".join(f"{joint}_{axis}_m" for joint in ("shoulder", "wrist") for axis in "xyz")
        rows = [",".join(map(str, [k / 100, *shoulder[k], *wrist[k]])) for k in range(30)]
        path.write_text("\n".join([f"time_s,{head}", *rows]), "utf-8")
    elif suffix == "trc":
        rows = ["\t".join(map(str, [k + 1, k / 100, *shoulder[k], *wrist[k]])) for k in range(30)]
        head = (HEAD + NAMES).replace("mm", "m").replace("\tA\t", "\tshoulder\t").replace("\tB\t", "\twrist\t")
        path.write_text(head + "\n".join(rows), "utf-8")
    else:
        written = ezc3d.c3d()
        written["parameters"]["POINT"]["RATE"]["value"] = [100.0]
        written["parameters"]["POINT"]["UNITS"]["value"] = ["m"]
        written["parameters"]["POINT"]["LABELS"]["value"] = ["shoulder", "wrist"]
        points = np.ones((4, 2, 30))
        points[:3, 0], points[:3, 1] = shoulder.T, wrist.T
        written["data"]["points"] = points
        written.write(str(path))
    found = POINT_FORMATS[f".{suffix}"](path)
    assert found.gaps == {"shoulder": 0, "wrist": 3}
    assert np.isnan(found.positions_m["wrist"][[4, 5, 20]]).all()


def test_a_truth_may_stand_below_comments(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("# exported\n\ntime_s,wrist_x_m,wrist_y_m,wrist_z_m\n0,1,2,3\n0.1,1,2,3\n")
    assert read_truth_csv(path).positions_m["wrist"][1] == pytest.approx([1, 2, 3])


def test_points_that_are_called_nearly_like_joints_are_not_dropped_in_silence(tmp_path: Path) -> None:
    """Of root, head and leftWrist two were scored, as if they were the body."""
    names = ["root", "head", "leftWrist", "RElbow", "Pelvis"]
    columns = ",".join(f"{name}_{axis}_m" for name in names for axis in "xyz")
    rows = [",".join(map(str, [k / 10, *range(1, 3 * len(names) + 1)])) for k in range(3)]
    file = tmp_path / "t.csv"
    file.write_text("\n".join([f"time_s,{columns}", *rows]), "utf-8")
    truth, said = load_points(tmp_path / "r.toml", file, TruthEntry(file="t.csv"), KEY_JOINTS, kind="body")
    assert set(truth.joints_m) == {"root", "head"}
    assert any(
        "root, head are taken for truth" in words and "RElbow, leftWrist are not: truth" in words for words in said
    )
    told = TruthEntry(file="t.csv", markers={"head": "head"})
    assert not any("are not" in words for words in load_points(tmp_path, file, told, KEY_JOINTS, kind="body")[1])


@pytest.mark.parametrize(
    ("column", "expected"),
    [
        ("left_wrist_x_cm", "<joint>_x_m but time_s, left_wrist_x_cm"),
        ("left_wrist_x_m", "left_wrist_y_m, left_wrist_z_m but"),
        ("left_wrist_x_mm", "left_wrist_y_mm, left_wrist_z_mm but"),
    ],
)
def test_a_header_that_lacks_columns_is_shown(tmp_path: Path, column: str, expected: str) -> None:
    (tmp_path / "t.csv").write_text(f"time_s,{column}\n0,1\n", "utf-8")
    with pytest.raises(pt.InputError, match=re.escape(expected)):
        read_truth_csv(tmp_path / "t.csv")


def test_a_value_of_a_trc_may_be_blank(tmp_path: Path) -> None:
    head = "PathFileType\t4\t(X/Y/Z)\tt.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t\t2\t1\tm\n"
    path = tmp_path / "t.trc"
    path.write_text(head + "Frame#\tTime\twrist\n\t\tX1\tY1\tZ1\n1\t0.00\t1\t2\t3\n2\t0.01\t1\t2\t3\n")
    assert read_trc(path).positions_m["wrist"][0] == pytest.approx([1, 2, 3])


def test_rows_of_tabs_alone_are_rows(tmp_path: Path) -> None:
    """Where no marker is seen at first; the file was said to be cut short."""
    rows = ["\t" * 2, "\t" * 2, "100.0\t200.0\t300.0"]
    path = tmp_path / "q.tsv"
    path.write_text("\n".join(["NO_OF_FRAMES\t3", "FREQUENCY\t100", "MARKER_NAMES\twrist", *rows]) + "\n")
    found = read_qualisys(path)
    assert np.isnan(found.positions_m["wrist"][:2]).all()
    assert found.positions_m["wrist"][2] == pytest.approx([0.1, 0.2, 0.3])


def test_other_fillers_are_gaps_too() -> None:
    """-9999 in more than a twentieth of the rows was truth: metres of error, without a word."""
    points = np.random.default_rng(0).uniform(0.1, 0.5, (30, 3))
    points[3:9] = -9.999
    points[20] = 0.25  # once, by chance
    found = without_fillers(points)
    assert np.flatnonzero(np.isnan(found[:, 0])).tolist() == list(range(3, 9))


def test_a_joint_may_lie_in_the_origin() -> None:
    """A wrist that rests there first was a gap."""
    way = np.concatenate([np.zeros(50), np.round(np.linspace(0.0, 0.3, 60), 3)])
    points = np.stack([way, 0.5 * way, way], axis=1)
    assert np.isfinite(without_fillers(points)).all()
    assert np.isfinite(without_fillers(np.stack([way, way, way], axis=1))).all()


def of_times(times: Array, rate_hz: float | None) -> Markers:
    return Markers(times, {"wrist": np.ones((len(times), 3))}, rate_hz)


def test_times_are_held_against_the_rate() -> None:
    """Headers were not: a truth in milliseconds was scored, 21 cm for 1.5, and the held pose praised."""
    file, seconds = Path("a.trc"), np.arange(200) / 120
    assert check_times(file, of_times(seconds, 120.0)) == ()
    assert check_times(file, of_times(seconds, None)) == ()
    assert check_times(file, of_times(np.round(seconds, 3), 120.0)) == ()
    assert check_times(file, of_times(np.delete(seconds, slice(20, 160)), 120.0)) == ()
    (said,) = check_times(file, of_times(seconds, 50.0))
    assert "a.trc: says 50 Hz, and its times are at 120 Hz: the times are taken" in said
    with pytest.raises(pt.InputError, match=r"a\.trc: its frames are 8\.33\d+ s apart, .* in milliseconds\?"):
        check_times(file, of_times(1000 * seconds, 120.0))


def test_a_trc_that_is_cut_short_says_so(tmp_path: Path) -> None:
    path = tmp_path / "a.trc"
    path.write_text(
        HEAD.replace("\t2\t2\t", "\t9\t2\t") + NAMES + "1\t0.0\t1\t0\t0\t\t\t\n2\t0.01\t2\t0\t0\t1\t2\t3\n", "utf-8"
    )
    (said,) = read_trc(path).warnings
    assert "a.trc:3: NumFrames is 9, and 2 rows follow: the file is cut short" in said


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x\n" * 7, "a.trc:1: starts with 'x', expected PathFileType"),
        (HEAD.replace("mm", "ft") + NAMES + "1\t0\t1\t2\t3\t4\t5\t6\n", "a.trc:3: Units is 'ft'"),
        (HEAD + NAMES.replace("\tB", "\tA") + "1\t0\t1\t2\t3\t4\t5\t6\n", "a.trc:4: names are A, A"),
        (HEAD + NAMES, "has a header but no rows"),
        (HEAD + NAMES + "1\t0\t1\t2\t3\t4\t5\t6\t7\n", "a.trc:7: row has 9 cells, expected 8"),
        (HEAD + NAMES + "1\t0\tb\t2\t3\t4\t5\t6\n", "a.trc:7: a coordinate is 'b'"),
        (HEAD + NAMES + "1\t1\t1\t2\t3\t4\t5\t6\n2\t1\t1\t2\t3\t4\t5\t6\n", "a.trc:8: Time is 1.0"),
    ],
)
def test_what_is_no_trc_is_refused_by_line(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "a.trc"
    path.write_text(text, "utf-8")
    with pytest.raises(pt.InputError, match=expected):
        read_trc(path)


def test_a_label_that_stands_twice_names_neither(tmp_path: Path) -> None:
    """The last one was taken: a wrist 4 cm beside, unsaid."""
    written = ezc3d.c3d()
    written["parameters"]["POINT"]["UNITS"]["value"] = ["m"]
    written["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    written["parameters"]["POINT"]["LABELS"]["value"] = ["elbow", "wrist", "wrist"]
    written["data"]["points"] = np.ones((4, 3, 5))
    written.write(str(tmp_path / "a.c3d"))
    assert list(read_c3d(tmp_path / "a.c3d").positions_m) == ["elbow", "wrist (1 of 2)", "wrist (2 of 2)"]


def test_more_points_than_a_parameter_has_values_keep_their_names(tmp_path: Path) -> None:
    """Of 300 points those from the 256th on were lost, unsaid: their labels are in LABELS2."""
    file = ezc3d.c3d()
    names = [f"m{k}" for k in range(300)]
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["UNITS"]["value"] = ["m"]
    file["parameters"]["POINT"]["LABELS"]["value"] = names
    file["data"]["points"] = np.ones((4, 300, 5)) * (1.0 + np.arange(300)[:, None] / 100.0)
    file.write(str(tmp_path / "many.c3d"))
    found = read_c3d(tmp_path / "many.c3d")
    assert list(found.positions_m) == names
    assert found.positions_m["m299"] == pytest.approx(np.full((5, 3), 3.99))


def test_what_is_no_c3d_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.c3d").write_bytes(b"\x02\x50" + bytes(600))
    with pytest.raises(pt.InputError, match=r"a.c3d: (is not a C3D|has units)"):
        read_c3d(tmp_path / "a.c3d")
    with pytest.raises(pt.InputError, match="no such file"):
        read_c3d(tmp_path / "none.c3d")


MAP = 'file = "truth.trc"\nmarkers = {{ root = ["HipL", "HipR"], left_wrist = "m left_wrist" {more} }}{after}'


BOTH = ', left_shoulder = "m left_shoulder", left_elbow = "m left_elbow", right_elbow = "m right_elbow"'
RIGHT = ', right_shoulder = "m right_shoulder", right_wrist = "m right_wrist"'
