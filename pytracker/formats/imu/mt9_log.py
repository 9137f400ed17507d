"""Logs of the MT9's own software: no header, tab-separated, time in seconds in column 1, one file a kind.

| columns | kind |
|---|---|
| 11 | `cal`: acceleration (m/s²), turn rate (rad/s), magnetic field, temperature |
| 5 | `quat`: orientation, w first, sensor to an earth frame with z up |
| 4 | `euler`: roll, pitch, yaw in degrees |
| 10 | `matrix`: orientation, column by column |

Acceleration and orientation come in two files with the same time column.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.text import Table, parse_table, read_lines, without_cut_row
from pytracker.inertial.log import ImuLog
from pytracker.rotation import euler_to_quaternion, matrix_to_quaternion

__all__ = ["read"]

Float = NDArray[np.float64]

SAME_TIME = 0.25
"""Times that are no farther apart than so much of the usual interval are those of one sample."""
CALIBRATED = 11
ORIENTATION = {5: "quaternion", 4: "Euler", 10: "matrix"}


def read(path: Path, lines: list[str], orientation_file: Path | None) -> ImuLog:
    """From the lines of the `cal` log and, where given, an orientation log. Raises `InputError`."""
    table, warnings = _parse(path, lines)
    if table.values.shape[1] != CALIBRATED:
        raise InputError(
            f"{path}:{table.lines[0]}: row has {table.values.shape[1]} columns, expected {CALIBRATED}: the MT9 log of "
            "calibrated data (time, acc xyz, gyr xyz, mag xyz, temperature); an orientation log goes into "
            "orientation_file"
        )
    values, numbers = table.values, table.lines
    q = None
    if orientation_file is not None:
        orientation, cut = _parse(orientation_file, read_lines(orientation_file))
        warnings += cut
        here, there = _same_times(table, orientation)
        q = _quaternions(orientation)[there]
        lost = len(values) + len(orientation.values) - 2 * len(here)
        if lost:
            words = f"{path} and {orientation_file}: {lost} rows have no partner of the same time and are left out"
            warnings += (words,)
        values, numbers = values[here], numbers[here]
    return ImuLog(
        path=path,
        lines=numbers,
        time_s=np.ascontiguousarray(values[:, 0]),
        acc=np.ascontiguousarray(values[:, 1:4]),
        gyr=np.ascontiguousarray(values[:, 4:7]),
        mag=np.ascontiguousarray(values[:, 7:10]),
        q_world_sensor=q,
        warnings=warnings,
    )


def _parse(path: Path, lines: list[str]) -> tuple[Table, tuple[str, ...]]:
    """The table, and a word on a last row that was cut short."""
    first = next((k for k, line in enumerate(lines) if line.strip()), 0)
    names = [f"column {k + 1}" for k in range(len(lines[first].rstrip("\t").split("\t")))]
    lines, cut = without_cut_row(path, lines, first, names, "\t")
    return parse_table(path, lines, first, names, "\t", set(names)), cut


def _quaternions(table: Table) -> Float:
    columns = table.values.shape[1]
    if columns not in ORIENTATION:
        raise InputError(
            f"{table.path}:{table.lines[0]}: row has {columns} columns, expected 5 (time, q0..q3), 4 (time, roll, "
            "pitch, yaw) or 10 (time, matrix)"
        )
    if not np.isfinite(table.values).all():
        row = int(np.flatnonzero(~np.isfinite(table.values).all(axis=1))[0])
        raise InputError(f"{table.path}:{table.lines[row]}: a cell has no value, expected {columns} numbers")
    if columns == 5:
        return np.ascontiguousarray(table.values[:, 1:5])
    if columns == 4:
        roll, pitch, yaw = np.deg2rad(table.values[:, 1:4]).T
        return euler_to_quaternion(roll, pitch, yaw)
    return matrix_to_quaternion(table.values[:, 1:10].reshape(-1, 3, 3).transpose(0, 2, 1))


def _same_times(a: Table, b: Table) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of `a` and `b` that have the same time."""
    for table in (a, b):
        back = np.flatnonzero(~(np.diff(table.values[:, 0]) > 0))
        if back.size:
            k = back[0] + 1
            raise InputError(
                f"{table.path}:{table.lines[k]}: time {table.values[k, 0]} s after {table.values[k - 1, 0]} s, "
                "expected increasing times"
            )
    apart_s = SAME_TIME * min(
        float(np.median(np.diff(table.values[:, 0]))) for table in (a, b) if len(table.values) > 1
    )
    at = np.clip(np.searchsorted(b.values[:, 0], a.values[:, 0] - apart_s), 0, len(b.values) - 1)
    same = np.abs(b.values[at, 0] - a.values[:, 0]) <= apart_s
    if not same.any():
        raise InputError(
            f"{a.path} covers {a.values[0, 0]:.3f} to {a.values[-1, 0]:.3f} s and {b.path} {b.values[0, 0]:.3f} to "
            f"{b.values[-1, 0]:.3f} s without a common time, expected two logs of the same session"
        )
    return np.flatnonzero(same), at[same]
