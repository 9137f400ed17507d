"""CSV of markers with header lines above, as Vicon's Nexus and OptiTrack's Motive export them.

Nexus: sections; `Trajectories`, frames a second, a line of markers, one for every three columns, then
`Frame,Sub Frame,X,Y,Z,...`, a line of units, and rows to the first blank line. Motive: a line of keys and values,
then lines of types, names, numbers and quantities, a column each, above `Frame,Time (Seconds),X,Y,Z,...`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.markers import UNITS_M, Markers, without_fillers
from pytracker.formats.text import cells_of, delimited, number, parse_table, read_lines, without_cut_row
from pytracker.formats.truth_csv import read_truth_csv
from pytracker.rotation import Array

__all__ = ["read_csv_markers"]

NEXUS, MOTIVE = "trajectories", "format version"
"""What a line of it begins with, in small letters."""
BLANK = ' ,;"\t'
"""What lines hold that hold nothing."""
POSITION, MARKER = "position", "marker"
"""What of Motive's quantities is a place, and of its types a marker as it was seen."""


@dataclass(frozen=True)
class _Columns:
    """What the rows below a header of axes hold: the column of x by marker, y and z behind it, and metres a unit."""

    header: int
    of: dict[str, int]
    unit_m: float
    rate_hz: float


def read_csv_markers(path: Path | str) -> Markers:
    """Read it, or a plain CSV (`read_truth_csv`). Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    lines = read_lines(path)
    if lines[0].lower().startswith(MOTIVE):
        return _motive(path, lines)
    section = next((k for k, line in enumerate(lines) if line.strip(BLANK).lower() == NEXUS), None)
    return read_truth_csv(path) if section is None else _nexus(path, lines, section)


def _nexus(path: Path, lines: list[str], section: int) -> Markers:
    if len(lines) < section + 6:
        raise InputError(f"{path}:{section + 1}: Trajectories are cut short, expected five lines of header and rows")
    header = section + 3
    end = next((k for k in range(header + 2, len(lines)) if not lines[k].strip(BLANK)), len(lines))
    delimiter, lines = delimited(lines[:end], header)
    rate_hz = number(cells_of(lines[section + 1], delimiter)[0], path, section + 2, "frames a second")
    if not rate_hz > 0:
        raise InputError(f"{path}:{section + 2}: frames a second are {rate_hz}, expected a positive number")
    names, axes, units = (cells_of(lines[k], delimiter) for k in (section + 2, header, header + 1))
    _require_axes(path, header, axes, ("frame", "sub frame"))
    # Velocities and accelerations, where they were exported, have the markers' names again above X' and X''.
    places = {
        k: name for k, (name, axis) in enumerate(zip(names, axes, strict=False)) if name.strip() and axis.strip() == "X"
    }
    of = _by_name(path, section + 2, places)
    unit_m = _unit_m(path, header + 1, next((unit for unit in units if unit.strip()), ""))
    table, cut = _table(path, [*lines[: header + 1], "", *lines[header + 2 :]], header, axes, delimiter)
    time_s = (table[:, 0] - table[0, 0]) / rate_hz
    began = f"{path}: its first frame is number {table[0, 0]:g} of what was recorded: times are counted from it on"
    said = (*cut, *([began] if table[0, 0] > 1 else []))
    return _markers(path, table, _Columns(header, of, unit_m, rate_hz), time_s, said)


def _motive(path: Path, lines: list[str]) -> Markers:
    header = next((k for k, line in enumerate(lines) if line.lower().startswith("frame")), None)
    above = [k for k in range(1, header or 0) if lines[k].strip(BLANK)]
    if header is None or len(above) < 3:
        raise InputError(f"{path}: has no line Frame,Time (Seconds),X,... below types, names and quantities")
    delimiter, lines = delimited(lines, header)
    head, axes, quantities, types, names = (
        cells_of(lines[k], delimiter) for k in (0, header, above[-1], above[0], above[1])
    )
    _require_axes(path, header, axes, ("frame", "time (seconds)"))
    said = {key.strip().lower(): value.strip() for key, value in zip(head[::2], head[1::2], strict=False)}
    of_columns = enumerate(zip(axes, quantities, types, names, strict=False))
    found = [
        (k, kind.strip(), name)
        for k, (axis, quantity, kind, name) in of_columns
        if (axis.strip().upper(), quantity.strip().lower()) == ("X", POSITION)
    ]
    # A rigid body's marker stands there twice, as it was measured and as the body has it.
    once = Counter(name for _, _, name in found)
    places = {k: name if kind.lower() == MARKER or once[name] == 1 else f"{name} ({kind})" for k, kind, name in found}
    unit_m = _unit_m(path, 0, said.get("length units", ""))
    rate_hz = number(said.get("export frame rate", ""), path, 1, "Export Frame Rate")
    table, cut = _table(path, lines, header, axes, delimiter)
    columns = _Columns(header, _by_name(path, above[1], places), unit_m, rate_hz)
    return _markers(path, table, columns, table[:, 1], cut)


def _require_axes(path: Path, line: int, axes: Sequence[str], first: Sequence[str]) -> None:
    said = [axis.strip().lower() for axis in axes[: len(first)]]
    if said != [*first]:
        raise InputError(f"{path}:{line + 1}: begins with {','.join(said)}, expected {','.join(first)}, then X, Y, Z")


def _by_name(path: Path, line: int, named: Mapping[int, str]) -> dict[str, int]:
    """Columns by marker, without the subject's name before a colon where that leaves them apart."""
    short = [name.rpartition(":")[2].strip() for name in named.values()]
    names = short if len(set(short)) == len(short) else [name.strip() for name in named.values()]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None or not names:
        found = "names no marker" if twice is None else f"names {twice!r} more than once"
        raise InputError(f"{path}:{line + 1}: {found}, expected another one for every three columns")
    return dict(zip(names, named, strict=True))


def _unit_m(path: Path, line: int, unit: str) -> float:
    if unit.strip().lower() not in UNITS_M:
        raise InputError(f"{path}:{line + 1}: the unit of length is {unit!r}, expected one of: {', '.join(UNITS_M)}")
    return UNITS_M[unit.strip().lower()]


def _table(
    path: Path, lines: list[str], header: int, axes: Sequence[str], delimiter: str
) -> tuple[Array, tuple[str, ...]]:
    """Rows of numbers `(T, C)` below a header, their frames and times increasing; a word where the last was cut."""
    names = [f"column {k + 1}" for k in range(len(axes))]
    lines, cut = without_cut_row(path, lines, header + 1, names, delimiter)
    table = parse_table(path, lines, header + 1, names, delimiter, set(names))
    back = np.flatnonzero(~(np.diff(table.values[:, 0]) > 0))
    if back.size or not np.isfinite(table.values[0, 0]):
        k = int(back[0]) + 1 if back.size else 0
        raise InputError(f"{path}:{table.lines[k]}: its frame is {table.values[k, 0]:g}, expected increasing numbers")
    return table.values, cut


def _markers(path: Path, table: Array, columns: _Columns, time_s: Array, said: tuple[str, ...]) -> Markers:
    if max(columns.of.values()) + 3 > table.shape[1]:
        raise InputError(f"{path}:{columns.header + 1}: has {table.shape[1]} columns, expected three a marker")
    back = np.flatnonzero(~(np.diff(time_s) > 0))
    if back.size:
        raise InputError(
            f"{path}: time {time_s[back[0] + 1]:g} s follows {time_s[back[0]]:g}, expected increasing times"
        )
    positions = {}
    for name, k in columns.of.items():
        points = columns.unit_m * table[:, k : k + 3]
        points[np.isnan(points).any(axis=1)] = np.nan
        positions[name] = without_fillers(points)
    return Markers(time_s, positions, columns.rate_hz if columns.rate_hz > 0 else None, said)
