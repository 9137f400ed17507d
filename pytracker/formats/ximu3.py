"""x-io's x-IMU3: a folder with a CSV a kind of message: `Inertial.csv`, and `Quaternion.csv`, `Magnetometer.csv`.

Messages come at rates of their own, by one clock: orientation and magnetic field are taken at the inertial ones' times.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats import imu_csv
from pytracker.formats.imu_csv import header_of
from pytracker.formats.imu_log import ImuLog
from pytracker.formats.imu_names import known_as
from pytracker.formats.text import parse_table, read_lines

__all__ = ["files_of_ximu3", "is_ximu3", "read_ximu3"]

Float = NDArray[np.float64]

INERTIAL, QUATERNION, MAGNETOMETER = "inertial", "quaternion", "magnetometer"
OTHERS = {
    QUATERNION: dict(zip("wxyz", ("q_w", "q_x", "q_y", "q_z"), strict=True)),
    MAGNETOMETER: {f"magnetometer{axis}": f"mag_{axis}" for axis in "xyz"},
}
"""What columns are called in ours, by file."""
TURNED_OTHERWISE = ("eulerangles", "rotationmatrix")
"""Orientations that are not read."""
MOST_OF_IT = 0.9
"""Of less there is no magnetic field: the heading is arbitrary."""
LONG_GAP = 10.0
"""Messages that stay away for so many of their usual intervals are lost, and nothing is between."""


def files_of_ximu3(folder: Path) -> dict[str, Path]:
    """What is read of a folder, by name in small letters; without `inertial` it is none of x-io's."""
    known = {INERTIAL, *OTHERS}
    return {path.stem.lower(): path for path in sorted(folder.glob("*.[cC][sS][vV]")) if path.stem.lower() in known}


def is_ximu3(folder: Path) -> bool:
    """Whether a folder is one of x-io's."""
    return folder.is_dir() and INERTIAL in files_of_ximu3(folder)


def read_ximu3(folder: Path) -> ImuLog:
    """The inertial messages, with the orientation and field between theirs. Raises `InputError`."""
    files = files_of_ximu3(folder)
    log = imu_csv.read(files[INERTIAL], read_lines(files[INERTIAL]))
    for name, columns in OTHERS.items():
        if name in files:
            log = _beside(log, files[name], columns)
    idle = [path.name for path in sorted(folder.glob("*.[cC][sS][vV]")) if path.stem.lower() in TURNED_OTHERWISE]
    if QUATERNION in files or not idle:
        return log
    words = f"{folder.name}: {idle[0]} is not read, only Quaternion.csv: the orientation is computed in its place"
    return dataclasses.replace(log, warnings=(*log.warnings, words))


def _beside(log: ImuLog, path: Path, columns: dict[str, str]) -> ImuLog:
    time_s, values, lines = _message(path, columns)
    kept = (log.time_s >= time_s[0]) & (log.time_s <= time_s[-1])
    after = np.clip(np.searchsorted(time_s, log.time_s), 1, len(time_s) - 1)
    wait = np.diff(time_s)
    kept &= wait[after - 1] <= LONG_GAP * np.median(wait)
    if "mag_x" in columns.values() and kept.mean() < MOST_OF_IT:
        words = f"{path.name} has nothing at {int((~kept).sum())} of {len(kept)} inertial samples: it is left out"
        return dataclasses.replace(log, warnings=(*log.warnings, words))
    if kept.sum() < 2:
        raise InputError(
            f"{path}: goes from {time_s[0]:.3f} to {time_s[-1]:.3f} s and {log.path.name} from {log.time_s[0]:.3f} to "
            f"{log.time_s[-1]:.3f} s, expected one recording"
        )
    if "q_w" in columns.values():
        values = _turning_on(path, values, lines)
    at = np.stack([np.interp(log.time_s, time_s, column) for column in values.T], axis=1)
    said = log.warnings
    if lost := int((~kept).sum()):
        said = (*said, f"{path.name}: has nothing at {lost} of {len(kept)} inertial samples, which are left out")
    log = log.kept(kept)
    if "q_w" not in columns.values():
        return dataclasses.replace(log, mag=at[kept], warnings=said)
    q = at[kept] / np.linalg.norm(at[kept], axis=1, keepdims=True)
    return dataclasses.replace(log, q_world_sensor=np.ascontiguousarray(q), warnings=said)


def _message(path: Path, columns: dict[str, str]) -> tuple[Float, Float, NDArray[np.int64]]:
    """Times, s `(M,)`, the columns `(M, K)` and their lines."""
    header = header_of(read_lines(path))
    names, factor = [], 1.0
    for name in header.names:
        column = known_as(name)
        plain = "".join(letter for letter in name.lower().split("(")[0] if letter.isalpha())
        if column is not None and column.name == "time_s":
            factor = column.factor
        names.append("time_s" if column is not None and column.name == "time_s" else columns.get(plain, name))
    if missing := [name for name in ("time_s", *columns.values()) if name not in names]:
        raise InputError(
            f"{path}:{header.first}: header has no column {', '.join(missing)} (it has {', '.join(header.names)[:99]}),"
            " expected x-io's"
        )
    table = parse_table(path, header.lines, header.first, names, header.delimiter, {"time_s", *columns.values()})
    time_s, values = table.columns("time_s"), table.columns(*columns.values())
    assert time_s is not None
    assert values is not None
    if (back := np.flatnonzero(~(np.diff(time_s[:, 0]) > 0))).size or len(time_s) < 2:
        line = int(table.lines[back[0] + 1]) if back.size else int(table.lines[0])
        raise InputError(f"{path}:{line}: time does not go on, expected two rows at least, of increasing times")
    return factor * time_s[:, 0], values, table.lines


def _turning_on(path: Path, q: Float, lines: NDArray[np.int64]) -> Float:
    """Without leaps to the other sign. Raises `InputError` for one that has no length of 1."""
    odd = np.flatnonzero(~(np.abs(np.linalg.norm(q, axis=1) - 1.0) < 0.1))
    if odd.size:
        k = int(odd[0])
        raise InputError(f"{path}:{lines[k]}: quaternion {np.round(q[k], 3).tolist()}, expected one of length 1")
    leaps = np.cumprod(np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
    return np.asarray(q * np.concatenate([[1.0], leaps])[:, None])
