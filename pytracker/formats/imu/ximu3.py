"""x-io's x-IMU3 and NGIMU: a folder with a CSV a kind of message: `Inertial.csv`, an orientation, `Magnetometer.csv`.

An NGIMU's inertial messages are `sensors.csv`, which holds the magnetic field too.
An orientation is `Quaternion.csv`, else `RotationMatrix.csv`, else `EulerAngles.csv` (degrees, yaw about z first).

Messages come at rates of their own, by one clock: orientation and magnetic field are taken at the inertial ones' times.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.imu import table
from pytracker.formats.imu.names import known_as
from pytracker.formats.imu.stream import Stream
from pytracker.formats.imu.table import header_of
from pytracker.formats.text import parse_table, read_lines
from pytracker.inertial.log import ImuLog
from pytracker.rotation import euler_to_quaternion, matrix_to_quaternion, without_leaps

__all__ = ["files_of_ximu3", "is_ximu3", "read_ximu3"]

Float = NDArray[np.float64]

INERTIAL, SENSORS, MAGNETOMETER = "inertial", "sensors", "magnetometer"
OF_QUATERNION = {"w": "q_w", "x": "q_x", "y": "q_y", "z": "q_z"}
OF_MATRIX = {row + column: f"r_{row}{column}" for row in "xyz" for column in "xyz"}
OF_ANGLES = {name: name for name in ("roll", "pitch", "yaw")}
OF_MAGNETOMETER = {f"magnetometer{axis}": f"mag_{axis}" for axis in "xyz"}
"""What their columns are called in ours."""
ORIENTATIONS: Mapping[str, tuple[Mapping[str, str], Callable[[Float], Float]]] = {
    "quaternion": (OF_QUATERNION, lambda values: values),
    "rotationmatrix": (OF_MATRIX, lambda values: matrix_to_quaternion(values.reshape(-1, 3, 3))),
    "eulerangles": (OF_ANGLES, lambda values: euler_to_quaternion(*np.deg2rad(values).T)),
}
"""By the file's name, the most trusted first: its columns, and its rows as quaternions."""
MOST_OF_IT = 0.9
"""A magnetic field that is there for less of the time is left out: the heading is arbitrary."""


def files_of_ximu3(folder: Path) -> dict[str, Path]:
    """What is read of a folder, by name in small letters; without `inertial` it is none of x-io's."""
    there = {path.stem.lower(): path for path in sorted(folder.glob("[!.]*.[cC][sS][vV]"))}
    orientation = next((name for name in ORIENTATIONS if name in there), "")
    if SENSORS in there and orientation:
        there.setdefault(INERTIAL, there[SENSORS])
    return {name: there[name] for name in (INERTIAL, orientation, MAGNETOMETER) if name in there}


def is_ximu3(folder: Path) -> bool:
    """Whether a folder is one of x-io's."""
    return folder.is_dir() and INERTIAL in files_of_ximu3(folder)


def read_ximu3(folder: Path) -> ImuLog:
    """The inertial messages, with the orientation and field between theirs. Raises `InputError`."""
    files = files_of_ximu3(folder)
    log = table.read(files[INERTIAL], read_lines(files[INERTIAL]))
    for name, (columns, as_quaternions) in ORIENTATIONS.items():
        if name in files:
            turned = _message(files[name], columns)
            log = _oriented(log, dataclasses.replace(turned, values=as_quaternions(turned.values)))
    if MAGNETOMETER in files:
        log = _magnetic(log, _message(files[MAGNETOMETER], OF_MAGNETOMETER))
    return log


def _oriented(log: ImuLog, turned: Stream) -> ImuLog:
    """Where there is an orientation. Raises `InputError` where there is none, or one that is no quaternion."""
    kept = turned.covers(log.time_s)
    if kept.sum() < 2:
        raise InputError(
            f"{turned.path}: goes from {turned.time_s[0]:.3f} to {turned.time_s[-1]:.3f} s and {log.path.name} from "
            f"{log.time_s[0]:.3f} to {log.time_s[-1]:.3f} s, expected one recording"
        )
    said = log.warnings
    if lost := int((~kept).sum()):
        said = (*said, f"{turned.path.name}: has nothing at {lost} of {len(kept)} inertial samples, which are left out")
    log = log.kept(kept)
    steady = dataclasses.replace(turned, values=_turning_on(turned.path, turned.values, turned.lines))
    q = steady.at(log.time_s)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return dataclasses.replace(log, q_world_sensor=np.ascontiguousarray(q), warnings=said)


def _magnetic(log: ImuLog, field: Stream) -> ImuLog:
    """With the magnetic field, where it is there most of the time."""
    lost = ~field.covers(log.time_s)
    if lost.mean() <= 1.0 - MOST_OF_IT:
        return dataclasses.replace(log, mag=field.at(log.time_s))
    words = f"{field.path.name} has nothing at {int(lost.sum())} of {len(lost)} inertial samples: it is left out"
    return dataclasses.replace(log, warnings=(*log.warnings, words))


def _message(path: Path, columns: Mapping[str, str]) -> Stream:
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
    return Stream(path, table.lines, factor * time_s[:, 0], values)


def _turning_on(path: Path, q: Float, lines: NDArray[np.int64]) -> Float:
    """Without leaps to the other sign. Raises `InputError` for one that has no length of 1."""
    odd = np.flatnonzero(~(np.abs(np.linalg.norm(q, axis=1) - 1.0) < 0.1))
    if odd.size:
        k = int(odd[0])
        raise InputError(f"{path}:{lines[k]}: quaternion {np.round(q[k], 3).tolist()}, expected one of length 1")
    return without_leaps(q)
