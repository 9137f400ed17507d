"""TRC files of 3-D markers, as OpenSim, Pose2Sim and Sports2D write them.

Five header lines: file type; keys; values (rate, units); marker names, three tabs apart; axes. Then rows of
`frame time x y z ...`, tabs between; an empty cell is a gap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.markers import UNITS_M, Markers, without_fillers
from pytracker.formats.text import number, read_lines
from pytracker.rotation import Array

__all__ = ["read_trc", "read_trc_pixels"]


@dataclass(frozen=True)
class _Trajectories:
    """What a file holds.

    That is its unit, frames a second, how many frames it says there are (NaN where it does not), times `(T,)` and
    coordinates by name `(T, 3)`, NaN where empty.
    """

    unit: str
    rate_hz: float
    frame_count: float
    time_s: Array
    points: dict[str, Array]


def read_trc(path: Path | str) -> Markers:
    """Read it. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    found = _trajectories(path)
    unit = found.unit.lower()
    if unit not in UNITS_M:
        raise InputError(f"{path}:3: Units is {found.unit!r}, expected one of: {', '.join(UNITS_M)}")
    positions = {name: without_fillers(points * UNITS_M[unit]) for name, points in found.points.items()}
    rate_hz = found.rate_hz if found.rate_hz > 0 else None
    return Markers(found.time_s, positions, rate_hz, _cut_short(Path(path), found))


def read_trc_pixels(path: Path | str) -> tuple[Array, dict[str, Array], tuple[str, ...]]:
    """Times `(T,)`, s, u, v of every point `(T, 2)`, px, of a file in pixels, whatever its unit says, and what is odd.

    Raises `InputError` naming line, value and expectation.
    """
    found = _trajectories(Path(path))
    return found.time_s, {name: points[:, :2] for name, points in found.points.items()}, _cut_short(Path(path), found)


def _cut_short(path: Path, found: _Trajectories) -> tuple[str, ...]:
    """A word where fewer rows follow than the header says."""
    count, rows = found.frame_count, len(found.time_s)
    short = f"{path}:3: NumFrames is {count:g}, and {rows} rows follow: the file is cut short"
    return (short,) if count > rows else ()


def _trajectories(path: Path) -> _Trajectories:
    lines = read_lines(path)
    if len(lines) < 5 or not lines[0].startswith("PathFileType"):
        raise InputError(
            f"{path}:1: starts with {lines[0][:40]!r}, expected PathFileType and five header lines of a TRC"
        )
    keys, values = lines[1].split(), lines[2].split()
    if len(values) < len(keys):  # one is blank, between its tabs
        keys, values = ([cell.strip() for cell in line.split("\t")] for line in lines[1:3])
    header = dict(zip(keys, values, strict=False))
    rate_hz = number(header.get("DataRate", ""), path, 3, "DataRate")
    frame_count = number(header.get("NumFrames", ""), path, 3, "NumFrames")
    names = _names(path, lines[3])
    table = _table(path, lines, 2 + 3 * len(names))
    points = {}
    for k, name in enumerate(names):
        points[name] = table[:, 2 + 3 * k : 5 + 3 * k]
        points[name][np.isnan(points[name]).any(axis=1)] = np.nan
    return _Trajectories(header.get("Units", ""), rate_hz, frame_count, table[:, 1], points)


def _table(path: Path, lines: list[str], width: int) -> Array:
    """Rows of numbers `(T, width)`, their times increasing."""
    rows, at = [], []
    for k in range(5, len(lines)):
        cells = lines[k].rstrip("\t").split("\t") if lines[k].strip() else []
        if not cells:
            continue
        if len(cells) > width:
            raise InputError(f"{path}:{k + 1}: row has {len(cells)} cells, expected {width}")
        cells += [""] * (width - len(cells))
        rows.append([number(cell, path, k + 1, "a coordinate") for cell in cells])
        at.append(k + 1)
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected at least one frame")
    table = np.array(rows)
    back = np.flatnonzero(~(np.diff(table[:, 1]) > 0))
    if back.size or not math.isfinite(table[0, 1]):
        k = int(back[0]) + 1 if back.size else 0
        raise InputError(f"{path}:{at[k]}: Time is {table[k, 1]}, expected increasing times")
    return table


def _names(path: Path, line: str) -> list[str]:
    names = [name.strip() for name in line.split("\t")[2::3]]
    while names and not names[-1]:
        names.pop()
    if not names or len(set(names)) < len(names) or not all(names):
        raise InputError(
            f"{path}:4: names are {', '.join(names)[:80] or 'none'}, expected another one for every three columns"
        )
    return names
