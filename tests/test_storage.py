"""OpenSim's storage files as truth: points in every manner, and what is none."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import load_arm

import pytracker as pt
from pytracker.formats.storage import read_storage

VECTORS = ["DataRate=50.0", "DataType=Vec3", "version=3", "OpenSimVersion=4.5", "units=m", "endheader"]
MARKERS = ["model marker locations", "version=1", "nRows=3", "nColumns=7", "inDegrees=yes", "", "endheader"]
PLACES = np.arange(18.0).reshape(3, 2, 3) / 100.0 + 0.2


def write(path: Path, lines: list[str]) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


def flat(ends: tuple[str, str, str] = ("_tx", "_ty", "_tz")) -> list[str]:
    names = "\t".join(["time", *(f"{name}{end}" for name in ("R.Elbow", "R.Wrist") for end in ends)])
    return [*MARKERS, names, *("\t".join(map(str, [0.02 * k, *PLACES[k].ravel()])) for k in range(3))]


def test_points_in_every_manner(tmp_path: Path) -> None:
    cells = [",".join(map(str, place)) for place in PLACES.reshape(-1, 3)]
    vectors = [
        *VECTORS,
        "time\tR.Elbow\tR.Wrist",
        *(f"{0.02 * k}\t{cells[2 * k]}\t{cells[2 * k + 1]}" for k in range(3)),
    ]
    for k, lines in enumerate((vectors, flat(), flat(("_X", "_Y", "_Z")))):
        found = read_storage(write(tmp_path / f"{k}.sto", lines))
        assert np.array_equal(found.time_s, [0.0, 0.02, 0.04])
        assert not found.warnings
        assert list(found.positions_m) == ["R.Elbow", "R.Wrist"]
        assert np.allclose(np.stack(list(found.positions_m.values()), axis=1), PLACES)


def test_what_is_no_point_is_refused_with_what_to_take(tmp_path: Path) -> None:
    head = ["Coordinates", "version=1", "nRows=1", "inDegrees=yes", "endheader"]
    angles = [*head, "time\tpelvis_tx\tpelvis_ty\tpelvis_tz\tarm_flex_r\telbow_flex_r", "0\t0\t1\t0\t30\t90"]
    with pytest.raises(
        pt.InputError, match=r"a.mot:6: holds joint angles .*arm_flex_r, elbow_flex_r.* Take the markers"
    ):
        read_storage(write(tmp_path / "a.mot", angles))
    bodies = ["Positions", "of the centers of mass of the body segments in model m.", *flat()[4:]]
    with pytest.raises(pt.InputError, match=r"centres of mass .* PointKinematics"):
        read_storage(write(tmp_path / "b.sto", bodies))
    turns = [line.replace("Vec3", "Quaternion") for line in VECTORS]
    with pytest.raises(pt.InputError, match=r"DataType is Quaternion, expected points"):
        read_storage(write(tmp_path / "c.sto", [*turns, "time\tradius_r_imu", "0\t1,0,0,0"]))
    with pytest.raises(pt.InputError, match=r"d.sto:8: a point is '1,2', expected x,y,z"):
        read_storage(write(tmp_path / "d.sto", [*VECTORS, "time\twrist", "0\t1,2"]))
    with pytest.raises(pt.InputError, match=r"e.sto:10: row has 6 cells, expected 7"):
        read_storage(write(tmp_path / "e.sto", [*flat()[:9], flat()[9].rpartition("\t")[0]]))
    with pytest.raises(pt.InputError, match=r"f.sto:10: time is 0.0, expected increasing"):
        read_storage(write(tmp_path / "f.sto", [*flat()[:9], flat()[8]]))
    with pytest.raises(pt.InputError, match="no line endheader"):
        read_storage(write(tmp_path / "g.sto", flat()[7:]))


def test_units_markers_names_and_empty_cells(tmp_path: Path) -> None:
    in_mm = [line.replace("version=1", "units=mm").replace("R.Elbow", "R_flexor") for line in flat()]
    in_mm[-1] = in_mm[-1].replace(str(PLACES[2, 0, 1]), "")
    found = read_storage(write(tmp_path / "mm.sto", in_mm))
    expected = PLACES / 1000
    expected[2, 0] = np.nan
    assert np.allclose(np.stack(list(found.positions_m.values()), axis=1), expected, equal_nan=True)
    assert list(found.positions_m) == ["R_flexor", "R.Wrist"]
    found = read_storage(write(tmp_path / "gap.sto", [*VECTORS, "time\twrist", "0\t", "0.02\t1,2,3"]))
    assert np.allclose(found.positions_m["wrist"], [[np.nan] * 3, [1.0, 2.0, 3.0]], equal_nan=True)
    with pytest.raises(pt.InputError, match="units are inches, expected m, cm or mm"):
        read_storage(write(tmp_path / "in.sto", [line.replace("version=1", "units=inches") for line in flat()]))
    forces = ["version=1", "endheader", "time\tground_force_vx\tground_force_vy", "0\t1\t700"]
    with pytest.raises(pt.InputError, match=r"holds ground_force_vx, ground_force_vy, expected points.*_tz\)$"):
        read_storage(write(tmp_path / "forces.mot", forces))
    with pytest.raises(pt.InputError, match=r"t.sto:8: time is nan, expected increasing"):
        read_storage(write(tmp_path / "t.sto", [*VECTORS, "time\twrist", "nan\t1,2,3"]))


def test_cut_short_is_told(tmp_path: Path) -> None:
    (said,) = read_storage(write(tmp_path / "cut.sto", flat()[:-1])).warnings
    assert said.endswith("nRows is 3, and 2 rows follow: the file is cut short")


def test_as_an_arms_truth(tmp_path: Path, simulated: Path) -> None:
    folder = tmp_path / "circle"
    shutil.copytree(simulated, folder)
    truth = load_arm(folder).truth
    assert truth is not None
    names = "\t".join(["time", *(f"{joint}_{axis}" for joint in truth.joints_m for axis in ("tx", "ty", "tz"))])
    rows = np.concatenate([truth.time_s[:, None], *truth.joints_m.values()], axis=1)
    write(folder / "truth.sto", ["endheader", names, *("\t".join(map(str, row)) for row in rows)])
    description, _, after = (folder / "recording.toml").read_text().partition("[truth]")
    rest = after[after.index("\n[") :] if "\n[" in after else ""
    (folder / "recording.toml").write_text(f'{description}[truth]\nfile = "truth.sto"\n{rest}')
    again = load_arm(folder).truth
    assert again is not None
    assert all(np.allclose(again.joints_m[joint], places) for joint, places in truth.joints_m.items())
