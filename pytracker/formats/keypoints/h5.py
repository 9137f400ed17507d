"""DeepLabCut's HDF5, by h5py (the extra `deeplabcut`): a pandas table, without pandas.

One group (`df_with_missing`) holds `table`: an index and blocks of values. Which column a value is of, pandas writes as
pickled lists of words; only such are read, no file can run anything.
"""

from __future__ import annotations

import io
import pickle
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError
from pytracker.formats.hdf5 import opened
from pytracker.formats.keypoints.deeplabcut import of_deeplabcut
from pytracker.formats.keypoints.log import Keypoints
from pytracker.rotation import Array

__all__ = ["read_h5"]

USUAL = "df_with_missing"
"""What DeepLabCut calls the table."""
MOST_ROWS = 10_000_000
"""Days of frames; more is a broken file."""


class _Words(pickle.Unpickler):
    """Lists, tuples, words and numbers, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(f"it asks for {module}.{name}, expected words alone")


def read_h5(path: Path) -> Keypoints:
    """The keypoints of everybody. Raises `InputError`."""
    with opened(path, "table of DeepLabCut's") as file:
        levels, table, index = _table(path, file)
    return of_deeplabcut(path, levels, table, index)


def _table(path: Path, file: Any) -> tuple[dict[str, list[str]], Array, list[str]]:
    """Words of every column by level, the values `(T, C)`, and what the index says of each row."""
    tables = [name for name in file if f"{name}/table" in file]
    name = USUAL if USUAL in tables else tables[0] if len(tables) == 1 else None
    if name is None:
        raise InputError(
            f"{path}: holds {', '.join(file)[:200] or 'nothing'}, expected {USUAL} as a table, as DeepLabCut writes it"
        )
    group = file[name]
    rows = group["table"]
    if not 0 < len(rows) <= MOST_ROWS:
        raise InputError(f"{path}: /{name} has {len(rows)} rows, expected one a frame, at most {MOST_ROWS}")
    blocks = _words(group.attrs["values_cols"])
    columns = [column for block in blocks for column in _words(rows.attrs[f"{block}_kind"])]
    table = np.concatenate(
        [np.asarray(rows[block], dtype=np.float64).reshape(len(rows), -1) for block in blocks], axis=1
    )
    names = _words(group.attrs["info"])[1]["names"]
    if table.shape[1] != len(columns) or any(len(column) != len(names) for column in columns):
        raise InputError(f"{path}: /{name} has {table.shape[1]} values a row, expected one of {len(columns)} columns")
    index = [cell.decode() if isinstance(cell, bytes) else str(cell) for cell in np.asarray(rows["index"]).tolist()]
    levels = {str(level): [str(column[k]) for column in columns] for k, level in enumerate(names)}
    return levels, table, index


def _words(pickled: Any) -> Any:
    return _Words(io.BytesIO(bytes(pickled))).load()
