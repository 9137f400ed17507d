"""OpenSim's storage files, `.sto` and `.mot`, of points: where markers or points of a model are.

A header down to `endheader`, a row of names, then rows; tabs or blanks between. A point is one column of `x,y,z`
(`DataType=Vec3`), or three: `NAME_tx, NAME_ty, NAME_tz` as inverse kinematics writes its model's markers, or
`NAME_X, NAME_Y, NAME_Z` as PointKinematics does; in metres, unless the header names another unit.
Joint angles are of a model's joints, whose lengths are in no such file: they are refused.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.markers import Markers, without_fillers
from pytracker.formats.text import number, read_lines
from pytracker.rotation import Array

__all__ = ["read_storage"]

AXES = (("_tx", "_ty", "_tz"), ("_X", "_Y", "_Z"), ("_x", "_y", "_z"))
"""How the three columns of a point end."""
ANGLES = re.compile(r"(flex|_add_|rotation|_rot|tilt|list|bending|obliquity|elv|pro_sup)")
"""What coordinates of models' joints are called."""
UNITS_M = {"": 1.0, "m": 1.0, "meters": 1.0, "cm": 0.01, "mm": 0.001}
BODIES = re.compile(r"centers? of mass of the body segments")
"""What BodyKinematics says above its rows: no joint is there."""


def read_storage(path: Path | str) -> Markers:
    """Every point by name. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    lines = read_lines(path)
    ends = [k for k, line in enumerate(lines) if line.strip().lower() == "endheader"]
    if not ends or ends[0] + 1 >= len(lines):
        raise InputError(f"{path}: has no line endheader with a table below it, expected a storage file of OpenSim")
    header, first = lines[: ends[0]], ends[0] + 1
    while first + 1 < len(lines) and not lines[first].strip():
        first += 1
    names = lines[first].split()
    if not names or names[0].lower() != "time" or len(set(names)) < len(names):
        raise InputError(f"{path}:{first + 1}: names are {', '.join(names)[:200]}, expected time, then each name once")
    if any(BODIES.search(line.lower()) for line in header):
        raise InputError(
            f"{path}: holds the centres of mass of a model's bodies, which are no joints, expected points: "
            "PointKinematics, or the marker locations of inverse kinematics"
        )
    unit = (_said(header, "Units") or _said(header, "units")).lower()
    if unit not in UNITS_M:
        raise InputError(f"{path}: units are {unit}, expected m, cm or mm")
    columns = _columns(path, header, first, names)
    table = _rows(path, lines, first + 1, names, is_vectors=_said(header, "DataType").lower() == "vec3")
    points = {}
    for name, at in columns.items():
        places = UNITS_M[unit] * table[:, at]
        places[np.isnan(places).any(axis=1)] = np.nan
        points[name] = without_fillers(places)
    rate = number(_said(header, "DataRate"), path, 1, "DataRate")
    return Markers(table[:, 0], points, rate if rate > 0 else None, _cut_short(path, header, len(table)))


def _said(header: list[str], key: str) -> str:
    """What the header says of a key; empty where it does not."""
    return next((line.partition("=")[2].strip() for line in header if line.partition("=")[0].strip() == key), "")


def _columns(path: Path, header: list[str], first: int, names: list[str]) -> dict[str, list[int]]:
    """Points to their three columns, the time being column 0."""
    kind = _said(header, "DataType").lower()
    if kind == "vec3":
        return {name: [3 * k + 1, 3 * k + 2, 3 * k + 3] for k, name in enumerate(names[1:])}
    if kind not in ("", "double"):
        raise InputError(f"{path}: DataType is {_said(header, 'DataType')}, expected points: Vec3, or double")
    found = {}
    for ends in AXES:
        for name in (name.removesuffix(ends[0]) for name in names if name.endswith(ends[0])):
            if all(name + end in names for end in ends):
                found[name] = [names.index(name + end) for end in ends]
    of_points = {0, *(k for at in found.values() for k in at)}
    angles = [name for k, name in enumerate(names) if k not in of_points and ANGLES.search(name)]
    expected = "expected points, three columns each (NAME_tx, NAME_ty, NAME_tz)"
    if angles:
        raise InputError(
            f"{path}:{first + 1}: holds joint angles of a model ({', '.join(angles)[:120]}), {expected}: where "
            "joints are depends on the model's lengths, which are not in it. Take the markers that it was computed "
            "from (.trc), or OpenSim's PointKinematics"
        )
    if not found:
        raise InputError(f"{path}:{first + 1}: holds {', '.join(names[1:])[:120]}, {expected}")
    return found


def _rows(path: Path, lines: list[str], start: int, names: list[str], *, is_vectors: bool) -> Array:
    """Rows of numbers, time first, `(T, 1 + 3 N)` of vectors, their times increasing."""
    rows, at = [], []
    for k in range(start, len(lines)):
        cells = _cells(lines[k], len(names))
        if not cells:
            continue
        if len(cells) != len(names):
            raise InputError(f"{path}:{k + 1}: row has {len(cells)} cells, expected {len(names)}")
        if is_vectors:
            cells = [cells[0], *(part for cell in cells[1:] for part in _vector(path, k + 1, cell))]
        rows.append([number(cell, path, k + 1, "a coordinate") for cell in cells])
        at.append(k + 1)
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected at least one frame")
    table = np.array(rows)
    wrong = ~np.isfinite(table[:, 0])
    wrong[1:] |= np.diff(table[:, 0]) <= 0
    if wrong.any():
        k = int(np.argmax(wrong))
        raise InputError(f"{path}:{at[k]}: time is {table[k, 0]}, expected increasing times")
    return table


def _cells(line: str, count: int) -> list[str]:
    """A row's cells; one that is empty between two tabs is not known."""
    cells = line.split()
    if not cells or len(cells) == count or "\t" not in line:
        return cells
    between = [cell.strip() for cell in line.split("\t")]
    rest = between[count:]
    return [cell or "nan" for cell in between[:count]] if len(between) >= count and not any(rest) else cells


def _vector(path: Path, line: int, cell: str) -> list[str]:
    """The three parts of a cell."""
    parts = [cell] * 3 if cell == "nan" else cell.split(",")
    if len(parts) != 3:
        raise InputError(f"{path}:{line}: a point is {cell[:80]!r}, expected x,y,z")
    return parts


def _cut_short(path: Path, header: list[str], rows: int) -> tuple[str, ...]:
    """A word where fewer rows follow than the header says."""
    count = number(_said(header, "nRows"), path, 1, "nRows")
    return (f"{path}: nRows is {count:g}, and {rows} rows follow: the file is cut short",) if count > rows else ()
