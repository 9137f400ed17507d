"""DeepLabCut's HDF5: the same as its CSV; what is none of it, or would run something, is refused."""

from __future__ import annotations

import os
import pickle
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import read_keypoints
from pytracker.rotation import Array

PARTS = ("nose", "left_wrist", "right_wrist", "left_elbow")
NAMES = ("scorer", "bodyparts", "coords")
COLUMNS = [("DLC_resnet50", part, axis) for part in PARTS for axis in ("x", "y", "likelihood")]


def values() -> Array:
    """Six frames; in the fourth a wrist is not seen."""
    table = np.random.default_rng(0).uniform(50.0, 400.0, (6, len(COLUMNS)))
    table[:, 2::3] = 0.9
    table[3, 3:5] = np.nan
    return table


def words(what: Any) -> np.bytes_:
    """As PyTables writes what is no number."""
    return np.bytes_(pickle.dumps(what, 0))


def written(
    path: Path, columns: Any = COLUMNS, names: Any = NAMES, key: str = "df_with_missing", kind: Any = None
) -> Path:
    """As `DataFrame.to_hdf(path, key=key, format="table")` lays it out: an index and one block of values."""
    table = values()
    rows = np.zeros(len(table), dtype=[("index", "<i8"), ("values_block_0", "<f8", (table.shape[1],))])
    rows["index"], rows["values_block_0"] = np.arange(len(table)), table
    with h5py.File(path, "w") as file:
        group = file.create_group(key)
        group.attrs["pandas_type"] = np.bytes_(b"frame_table")
        group.attrs["values_cols"] = words(["values_block_0"])
        group.attrs["info"] = words({1: {"names": list(names), "type": "MultiIndex"}, "index": {}})
        group.create_dataset("table", data=rows).attrs["values_block_0_kind"] = kind or words(columns)
    return path


def as_csv(path: Path) -> Path:
    head = [",".join([name, *(column[k] for column in COLUMNS)]) for k, name in enumerate(NAMES)]
    rows = [",".join([str(k), *map(str, row)]) for k, row in enumerate(values().tolist())]
    path.write_text("\n".join(head + rows), "utf-8")
    return path


@pytest.mark.parametrize("key", ["df_with_missing", "tracks"])
def test_the_same_as_the_csv(tmp_path: Path, key: str) -> None:
    found, csv = read_keypoints(written(tmp_path / "clip.h5", key=key)), read_keypoints(as_csv(tmp_path / "clip.csv"))
    assert np.array_equal(found.points, csv.points, equal_nan=True)
    assert np.array_equal(found.frames, csv.frames)
    assert np.isfinite(found.points[:, 0, :, 0]).sum() == 4 * 6 - 1


@pytest.mark.parametrize("kind", ["<i8", "S40"])
def test_its_index_says_which_frames(tmp_path: Path, kind: str) -> None:
    path = written(tmp_path / "clip.h5")
    with h5py.File(path, "r+") as file:
        table, shown = file["df_with_missing/table"][:], [3, 4, 5, 9, 10, 41]
        names = [f"labeled-data/clip2/img{k:03d}.png" for k in shown] if kind == "S40" else shown
        rows = np.zeros(6, dtype=[("index", kind), ("values_block_0", "<f8", (len(COLUMNS),))])
        rows["index"], rows["values_block_0"] = names, table["values_block_0"]
        del file["df_with_missing/table"]
        file["df_with_missing"].create_dataset("table", data=rows).attrs["values_block_0_kind"] = words(COLUMNS)
    assert read_keypoints(path).frames.tolist() == shown


def test_individuals_are_told_apart_and_may_change_places(tmp_path: Path) -> None:
    """Two whom DeepLabCut swaps for two frames, one who is never seen, and a corner of the table."""
    here = values()[:1] + np.random.default_rng(1).normal(0.0, 1.0, (6, 1)) * (np.arange(len(COLUMNS)) % 3 < 2)
    there = here + 400.0 * (np.arange(len(COLUMNS)) % 3 == 0)
    is_swapped = np.isin(np.arange(6), [2, 3])[:, None]
    people = [np.where(is_swapped, there, here), np.where(is_swapped, here, there), np.full_like(here, np.nan)]
    names = ("scorer", "individuals", "bodyparts", "coords")
    columns = [(scorer, who, part, axis) for who in ("a", "b", "c") for scorer, part, axis in COLUMNS]
    columns += [(COLUMNS[0][0], "single", "corner", axis) for axis in ("x", "y", "likelihood")]
    table = np.concatenate([*people, np.ones((6, 3))], axis=1)
    lines = [",".join([name, *(column[k] for column in columns)]) for k, name in enumerate(names)]
    lines += [",".join([str(k), *("" if np.isnan(x) else str(x) for x in row)]) for k, row in enumerate(table.tolist())]
    path = tmp_path / "two.csv"
    path.write_text("\n".join(lines) + "\n")
    found = read_keypoints(path).points
    wrist = KEYPOINTS.index("left_wrist")
    assert found.shape == (6, 3, 9, 3)
    assert found[:, 0, wrist] == pytest.approx(here[:, 3:6])
    assert found[:, 1, wrist] == pytest.approx(there[:, 3:6])
    assert not np.isfinite(found[:, 2]).any()


class Runs:
    """What a pickle may do."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> Any:
        return os.mkdir, (str(self.mark),)


def test_nothing_is_run(tmp_path: Path) -> None:
    path = written(tmp_path / "bad.h5", kind=words(Runs(tmp_path / "ran")))
    with pytest.raises(pt.InputError, match=r"bad\.h5: is no table .*mkdir, expected words alone"):
        read_keypoints(path)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("columns", "names", "expected"),
    [
        (COLUMNS[:-1], NAMES, "has 12 values a row, expected one of 11 columns"),
        (COLUMNS, NAMES[:2], "expected one of 12 columns"),
        ([("DLC", "tail", axis) for _, _, axis in COLUMNS], NAMES, "bodyparts name no joint of ours"),
        (COLUMNS, ("scorer", "joint", "axis"), "columns have scorer, joint, axis, expected bodyparts and coords"),
    ],
)
def test_other_tables_are_refused(tmp_path: Path, columns: Any, names: Any, expected: str) -> None:
    with pytest.raises(pt.InputError, match=expected):
        read_keypoints(written(tmp_path / "other.h5", columns, names))


def test_files_that_are_cut_or_hold_something_else(tmp_path: Path) -> None:
    whole = written(tmp_path / "clip.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(pt.InputError, match=r"cut\.h5: is no table of DeepLabCut's that can be read"):
        read_keypoints(tmp_path / "cut.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["acc"] = np.zeros((3, 2))
    with pytest.raises(pt.InputError, match=r"other\.h5: holds acc, expected df_with_missing as a table"):
        read_keypoints(tmp_path / "other.h5")
    with h5py.File(written(tmp_path / "empty.h5"), "a") as file:
        rows = file["df_with_missing/table"][:0]
        del file["df_with_missing/table"]
        file["df_with_missing/table"] = rows
    with pytest.raises(pt.InputError, match=r"empty\.h5: /df_with_missing has 0 rows, expected one a frame"):
        read_keypoints(tmp_path / "empty.h5")
