"""Markers as the programs of capture systems export them to CSV."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.capture_csv import read_csv_markers

NEXUS = [
    "Devices", "1000", ",,Force", "Frame,Sub Frame,Fx", ",,N", "1,0,1.5", "",
    "Trajectories", "100", ",,Ann:RSHO,,,Ann:RWRA,,,", "Frame,Sub Frame,X,Y,Z,X,Y,Z", ",,mm,mm,mm,mm,mm,mm",
    "1,0,100,200,300,400,500,600", "2,0,101,201,301,,,", "4,0,103,203,303,403,503,603", "",
    "Model Outputs", "100", ",,Ann:RWristAngles", "Frame,Sub Frame,X,Y,Z", ",,deg,deg,deg", "1,0,1,2,3",
]  # fmt: skip
MOTIVE = [
    "Format Version,1.23,Take Name,One,Export Frame Rate,120.000000,Rotation Type,Quaternion,Length Units,Meters", "",
    ",Type," + "Rigid Body," * 8 + "Marker,Marker,Marker",
    ",Name," + "Hand," * 8 + "Ann:Wrist,Ann:Wrist,Ann:Wrist",
    ",ID," + '"1",' * 8 + '"2","2","2"',
    ",," + "Rotation," * 4 + "Position,Position,Position,Mean Marker Error,Position,Position,Position",
    "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z",
    "0,0.000000,0,0,0,1,0.1,0.2,0.3,0.001,0.4,0.5,0.6",
    "1,0.008333,0,0,0,1,0.1,0.2,0.3,0.001,,,",
]  # fmt: skip


def write(tmp_path: Path, lines: list[str]) -> Path:
    path = tmp_path / "truth.csv"
    path.write_text("\r\n".join(lines) + "\r\n", newline="")
    return path


@pytest.mark.parametrize("delimiter", [",", "\t", ";"])
def test_trajectories_of_nexus_among_other_sections(tmp_path: Path, delimiter: str) -> None:
    markers = read_csv_markers(write(tmp_path, [line.replace(",", delimiter) for line in NEXUS]))
    assert markers.rate_hz == 100.0
    assert markers.time_s == pytest.approx([0.0, 0.01, 0.03])
    assert markers.positions_m["RWRA"][2].tolist() == pytest.approx([0.403, 0.503, 0.603])
    assert markers.gaps == {"RSHO": 0, "RWRA": 1}
    assert markers.warnings == ()


def test_velocities_beside_places_are_left_out(tmp_path: Path) -> None:
    head = [
        "Trajectories",
        "100",
        ",,Ann:LELB,,,Ann:LELB,,",
        "Frame,Sub Frame,X,Y,Z,X',Y',Z'",
        ",,mm,mm,mm,mm/s,mm/s,mm/s",
    ]
    markers = read_csv_markers(write(tmp_path, [*head, "1,0,100,200,300,1,2,3", "2,0,101,202,303,1,2,3"]))
    assert list(markers.positions_m) == ["LELB"]
    assert markers.positions_m["LELB"][1].tolist() == pytest.approx([0.101, 0.202, 0.303])


def test_a_rigid_bodys_marker_is_the_one_that_was_seen(tmp_path: Path) -> None:
    """Motive writes it twice: as the body has it, and as it was measured."""
    of_body = [
        line.replace("Marker,Marker,Marker", "Rigid Body Marker," * 3 + "Marker,Marker,Marker")
        .replace("Ann:Wrist,Ann:Wrist,Ann:Wrist", "Ann:Wrist," * 5 + "Ann:Wrist")
        .replace("Mean Marker Error,Position,Position,Position", "Mean Marker Error" + ",Position" * 6)
        .replace(",,X,Y,Z", ",,X,Y,Z,X,Y,Z")
        .replace("0.001,", "0.001,0.7,0.8,0.9,")
        for line in MOTIVE
    ]
    positions = read_csv_markers(write(tmp_path, of_body)).positions_m
    assert positions["Wrist"][0].tolist() == [0.4, 0.5, 0.6]
    assert positions["Wrist (Rigid Body Marker)"][0].tolist() == [0.7, 0.8, 0.9]


def test_a_trial_of_nexus_that_was_trimmed_says_so(tmp_path: Path) -> None:
    lines = [line.replace("1,0,100", "101,0,100").replace("2,0,101", "102,0,101") for line in NEXUS]
    (said,) = read_csv_markers(write(tmp_path, lines[:-9])).warnings
    assert "its first frame is number 101 of what was recorded" in said


def test_rigid_bodies_and_markers_of_motive(tmp_path: Path) -> None:
    """Of what stands in a column each, positions alone are places."""
    markers = read_csv_markers(write(tmp_path, MOTIVE))
    assert markers.rate_hz == 120.0
    assert markers.time_s.tolist() == [0.0, 0.008333]
    assert markers.positions_m["Hand"][0].tolist() == [0.1, 0.2, 0.3]
    assert markers.positions_m["Wrist"][0].tolist() == [0.4, 0.5, 0.6]
    assert np.isnan(markers.positions_m["Wrist"][1]).all()


@pytest.mark.parametrize(
    ("lines", "old", "new", "words"),
    [
        (NEXUS, ",,mm", ",,inch", r"truth.csv:12: the unit of length is 'inch', expected one of: mm"),
        (NEXUS, "Ann:RSHO", "Ann:RWRA", r"truth.csv:10: names 'Ann:RWRA' more than once"),
        (NEXUS, "4,0,103", "2,0,103", r"truth.csv:15: its frame is 2, expected increasing numbers"),
        (NEXUS, "4,0,103", "4,0,x", r"truth.csv:15: column 3 is 'x', expected a number"),
        (NEXUS, "\n100", "\nfast", r"truth.csv:9: frames a second is 'fast', expected a number"),
        (MOTIVE, "Meters", "Feet", r"truth.csv:1: the unit of length is 'Feet'"),
        (MOTIVE, "Time (Seconds)", "Clock", r"truth.csv:7: begins with frame,clock, expected frame,time \(seconds\)"),
        (MOTIVE, "Frame,Time", "Time,Frame", r"truth.csv: has no line Frame,Time \(Seconds\),X"),
    ],
)  # fmt: skip
def test_what_is_not_as_it_should_be_is_named(tmp_path: Path, lines: list[str], old: str, new: str, words: str) -> None:
    text = "\n".join(lines)
    assert old in text
    with pytest.raises(pt.InputError, match=words):
        read_csv_markers(write(tmp_path, text.replace(old, new).split("\n")))


def test_a_row_that_was_cut_short_is_left_out(tmp_path: Path) -> None:
    markers = read_csv_markers(write(tmp_path, [*NEXUS[:14], "4,0,103,203"]))
    assert len(markers.time_s) == 2
    assert "cut short" in markers.warnings[0]
