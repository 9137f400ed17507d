"""Qualisys TSV and CSV truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pytracker as pt
from pytracker.formats.qualisys import read_qualisys
from pytracker.formats.truth_csv import read_truth_csv

HEADER = ["NO_OF_FRAMES\t3", "NO_OF_MARKERS\t2", "FREQUENCY\t50", "DATA_INCLUDED\t3D", "MARKER_NAMES\tleft one\twrist"]
ROWS = ["1\t2\t3\t10\t20\t30", "4\t5\t6\t40\t50\t60", "7\t8\t9\t70\t80\t90"]


def write(tmp_path: Path, lines: list[str], end: str = "\n") -> Path:
    path = tmp_path / "truth.tsv"
    path.write_text(end.join(lines) + end, newline="")
    return path


def test_old_export_without_frame_and_time(tmp_path: Path) -> None:
    markers = read_qualisys(write(tmp_path, HEADER + ROWS, "\r\n"))
    assert markers.time_s == pytest.approx([0, 0.02, 0.04])
    assert markers.positions_m["wrist"][1].tolist() == [0.04, 0.05, 0.06]
    assert markers.gaps == {"left one": 0, "wrist": 0}


def test_tabs_at_the_lines_ends_are_no_columns(tmp_path: Path) -> None:
    markers = read_qualisys(write(tmp_path, HEADER + [f"{row}\t\t" for row in ROWS]))
    assert markers.time_s == pytest.approx([0, 0.02, 0.04])
    assert markers.positions_m["wrist"][1].tolist() == [0.04, 0.05, 0.06]


def test_decimal_commas(tmp_path: Path) -> None:
    header = [line.replace("\t50", "\t50,0") for line in HEADER]
    markers = read_qualisys(write(tmp_path, header + [row.replace("0", "0,5") for row in ROWS]))
    assert markers.time_s == pytest.approx([0, 0.02, 0.04])
    assert markers.positions_m["wrist"][0].tolist() == pytest.approx([0.0105, 0.0205, 0.0305])


def test_a_count_without_end_is_named(tmp_path: Path) -> None:
    header = [line.replace("NO_OF_FRAMES\t3", "NO_OF_FRAMES\t" + "9" * 5000) for line in HEADER]
    with pytest.raises(pt.InputError, match=r"NO_OF_FRAMES is '9+', expected a whole number"):
        read_qualisys(write(tmp_path, header + ROWS))


def test_new_export_with_frame_time_types_and_column_header(tmp_path: Path) -> None:
    columns = "Frame\tTime\tleft one X\tleft one Y\tleft one Z\twrist X\twrist Y\twrist Z"
    rows = [f"{k + 1}\t{0.5 + 0.02 * k:.5f}\t{row}\t" for k, row in enumerate(ROWS)]
    head = ["FILE_VERSION\t2.0.0", *HEADER, "TRAJECTORY_TYPES\tMeasured\tMixed", columns]
    markers = read_qualisys(write(tmp_path, head + rows))
    assert markers.time_s == pytest.approx([0.5, 0.52, 0.54])
    assert markers.positions_m["left one"][2].tolist() == [0.007, 0.008, 0.009]


def test_gaps_are_blank_null_or_zero(tmp_path: Path) -> None:
    rows = ["1\t2\t3\t0.000\t0.000\t0.000", "\t\t\t40\t50\t60", "7\t8\t9\tNULL\tNULL\tNULL"]
    markers = read_qualisys(write(tmp_path, HEADER + rows))
    assert markers.gaps == {"left one": 1, "wrist": 2}
    assert np.isnan(markers.positions_m["wrist"][0]).all()
    assert np.isfinite(markers.positions_m["wrist"][1]).all()


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ([*HEADER, *ROWS[:2]], "NO_OF_FRAMES is 3, but 2 rows follow: the file is cut short"),
        ([*HEADER, ROWS[0], "4\t5\tx\t40\t50\t60", ROWS[2]], "truth.tsv:7: column 3 is 'x', expected a number"),
        ([*HEADER, ROWS[0], "4\t5", ROWS[2]], "truth.tsv:7: row has 2 columns, expected 6 (3 for each of 2 markers)"),
        ([*HEADER[:1], "NO_OF_MARKERS\t5", *HEADER[2:], *ROWS], "NO_OF_MARKERS is 5, but 2 names follow"),
        ([*HEADER[:2], "FREQUENCY\tfast", *HEADER[3:], *ROWS], "FREQUENCY is 'fast', expected a positive number of Hz"),
        ([*HEADER[:2], "FREQUENCY\tEXT", *HEADER[3:], *ROWS], "FREQUENCY is 'EXT' and there is no Time column"),
        ([*HEADER[:3], "DATA_INCLUDED\t6D", HEADER[4], *ROWS], "DATA_INCLUDED is '6D', expected 3D"),
        ([*HEADER[:4], *ROWS], "has no MARKER_NAMES line"),
        ([*HEADER[:4], "MARKER_NAMES\twrist\twrist", *ROWS], "marker 'wrist' is named twice"),
        (HEADER, "has a header but no rows"),
        (ROWS, "truth.tsv:1: begins with numbers, expected a QTM header"),
        (["hello"], "truth.tsv:1: 'hello' is no QTM variable"),
    ],
)
def test_faults_are_explained(tmp_path: Path, lines: list[str], expected: str) -> None:
    with pytest.raises(pt.InputError) as error:
        read_qualisys(write(tmp_path, lines))
    assert expected in str(error.value)


def test_shared_qualisys_exports(shared: Callable[[str], Path]) -> None:
    markers = read_qualisys(shared("data/qualisys/imusim/stand_3D.tsv"))
    assert len(markers.time_s) == 513
    assert markers.rate_hz == 256
    assert markers.positions_m["Knee Hinge"].shape == (513, 3)
    # The person stands: thigh to knee is a leg's length and still.
    thigh = np.linalg.norm(markers.positions_m["Hip"] - markers.positions_m["Knee Hinge"], axis=1)
    assert 0.2 < thigh.mean() < 0.6
    assert thigh.std() < 0.002
    with pytest.raises(pt.InputError, match="DATA_INCLUDED is '6D', expected 3D"):
        read_qualisys(shared("data/qualisys/imusim/stand_6D.tsv"))


def test_csv_truth(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text("time_s,wrist_x_m,wrist_y_m,wrist_z_m\n0,1,2,3\n0.1,,,\n0.2,4,5,6\n")
    markers = read_truth_csv(path)
    assert markers.gaps == {"wrist": 1}
    path.write_text("time_s,wrist_x_m,wrist_y_m\n0,1,2\n")
    with pytest.raises(pt.InputError, match=r"truth\.csv:1: header has no column wrist_z_m"):
        read_truth_csv(path)
    path.write_text("time_s,wrist_x_m,wrist_y_m,wrist_z_m\n0,1,2,3\n0,1,2,3\n")
    with pytest.raises(pt.InputError, match=r"truth\.csv:3: time_s is 0\.0, expected increasing times"):
        read_truth_csv(path)


def test_csv_truth_as_others_write_it(tmp_path: Path) -> None:
    """R puts names in quotes; a half of Europe writes semicolons and decimal commas."""
    path = tmp_path / "truth.csv"
    path.write_text('"time_s","wrist_x_m","wrist_y_m","wrist_z_m"\n0,1,2.5,3\n0.1,NA,NA,NA\n')
    assert read_truth_csv(path).positions_m["wrist"][0].tolist() == [1.0, 2.5, 3.0]
    path.write_text('time_s,"note, free",wrist_x_m,wrist_y_m,wrist_z_m\n0,"a, b",1,2.5,3\n')
    assert read_truth_csv(path).positions_m["wrist"][0].tolist() == [1.0, 2.5, 3.0]
    path.write_text("time_s;wrist_x_m;wrist_y_m;wrist_z_m\n0;1;2,5;3\n0,1;4;5;6\n")
    assert read_truth_csv(path).positions_m["wrist"][0].tolist() == [1.0, 2.5, 3.0]
    path.write_text('time_s,wrist_x_m,wrist_y_m,wrist_z_m\n0,"1,0","2,5",3\n"0,125","4,125",5,6\n')
    assert read_truth_csv(path).positions_m["wrist"].tolist() == [[1.0, 2.5, 3.0], [4.125, 5.0, 6.0]]
    path.write_text('time_s,wrist_x_mm,wrist_y_mm,wrist_z_mm\n0,"1,500",2500,3000\n')
    with pytest.raises(pt.InputError, match=r"truth\.csv:2: wrist_x_mm is '1,500', expected a number"):
        read_truth_csv(path)  # thousands, or decimals
    path.write_text("time_s,wrist_x_mm,wrist_y_mm,wrist_z_mm\n0,1000,2500,3000\n")
    assert read_truth_csv(path).positions_m["wrist"][0].tolist() == [1.0, 2.5, 3.0]
    path.write_text("time_s,a_x_mm,a_y_mm,a_z_mm,b_x_m,b_y_m,b_z_m\n0,1000,2500,3000,1,2,3\n")
    assert {name: at[0, 0] for name, at in read_truth_csv(path).positions_m.items()} == {"a": 1.0, "b": 1.0}
    path.write_text("time_s,wrist_x_m,wrist_y_m,wrist_z_m,wrist_x_m\n0,1,2,3,4\n")
    with pytest.raises(pt.InputError, match=r"truth\.csv:1: column 'wrist_x_m' stands more than once"):
        read_truth_csv(path)


LINES = st.sampled_from(
    [*HEADER, *ROWS, "FREQUENCY\tEXT", "FREQUENCY\t0", "MARKER_NAMES", "MARKER_NAMES\ta", "NO_OF_FRAMES\tx", "\t\t",
     "1\t0.1\t1\t2\t3\t4\t5\t6", "nan", "NULL\tNULL\tNULL", "DATA_INCLUDED", "EVENT\tgo\t1\t0.1", "", "Frame\tTime"]
)  # fmt: skip


@settings(max_examples=400, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(st.lists(LINES, max_size=12).map("\n".join), st.text(max_size=80)))
def test_reader_raises_only_input_error(tmp_path: Path, content: str) -> None:
    path = tmp_path / "fuzz.tsv"
    path.write_bytes(content.encode("utf-8", "surrogatepass"))
    for reader in (read_qualisys, read_truth_csv):
        try:
            markers = reader(path)
        except pt.InputError as error:
            said = str(error)
            if "fuzz.tsv" not in said:
                pytest.fail(f"the message names no file: {said}")
        else:
            assert len(markers.time_s) > 0
