"""OpenSim's storage files, `.sto` and `.mot`, of points: where markers or points of a model are, in metres.

A header down to `endheader`, a row of names, then rows; tabs or blanks between. A point is one column of `x,y,z`
(`DataType=Vec3`), or three: `NAME_tx, NAME_ty, NAME_tz` as inverse kinematics writes its model's markers, or
`NAME_X, NAME_Y, NAME_Z` as PointKinematics does. Joint angles are of a model's joints, whose lengths are in no such
file: they are refused.
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
    columns = _columns(path, header, first, names)
    table = _rows(path, lines, first + 1, names, is_vectors=_said(header, "DataType").lower() == "vec3")
    points = {}
    for name, at in columns.items():
        places = table[:, at]
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
    angles = [name for name in names if ANGLES.search(name)]
    if not found or angles:
        of = f"joint angles of a model ({', '.join(angles)[:120]})" if angles else f"{', '.join(names[1:])[:120]}"
        raise InputError(
            f"{path}:{first + 1}: holds {of}, expected points, three columns each (NAME_tx, NAME_ty, NAME_tz): where "
            "joints are depends on the model's lengths, which are not in it. Take the markers that it was computed "
            "from (.trc), or OpenSim's PointKinematics"
        )
    return found


def _rows(path: Path, lines: list[str], start: int, names: list[str], *, is_vectors: bool) -> Array:
    """Rows of numbers, time first, `(T, 1 + 3 N)` of vectors, their times increasing."""
    rows, at = [], []
    for k in range(start, len(lines)):
        cells = lines[k].split()
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
    back = np.flatnonzero(~(np.diff(table[:, 0]) > 0))
    if back.size or not np.isfinite(table[0, 0]):
        k = int(back[0]) + 1 if back.size else 0
        raise InputError(f"{path}:{at[k]}: time is {table[k, 0]}, expected increasing times")
    return table


def _vector(path: Path, line: int, cell: str) -> list[str]:
    """The three parts of a cell."""
    parts = cell.split(",")
    if len(parts) != 3:
        raise InputError(f"{path}:{line}: a point is {cell[:80]!r}, expected x,y,z")
    return parts


def _cut_short(path: Path, header: list[str], rows: int) -> tuple[str, ...]:
    """A word where fewer rows follow than the header says."""
    count = number(_said(header, "nRows"), path, 1, "nRows")
    return (f"{path}: nRows is {count:g}, and {rows} rows follow: the file is cut short",) if count > rows else ()
