"""TRC files of 3-D markers, as OpenSim, Pose2Sim and Sports2D write them.

Five header lines: file type; keys; values (rate, units); marker names, three tabs apart; axes. Then rows of
`frame time x y z ...`, tabs between; an empty cell is a gap.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.qualisys import Markers
from pytracker.formats.text import number, read_lines

__all__ = ["read_trc"]

UNITS_M = {"mm": 0.001, "cm": 0.01, "m": 1.0}


def read_trc(path: Path | str) -> Markers:
    """Read it. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    lines = read_lines(path)
    if len(lines) < 5 or not lines[0].startswith("PathFileType"):
        raise InputError(
            f"{path}:1: starts with {lines[0][:40]!r}, expected PathFileType and five header lines of a TRC"
        )
    header = dict(zip(lines[1].split(), lines[2].split(), strict=False))
    unit = header.get("Units", "")
    if unit not in UNITS_M:
        raise InputError(f"{path}:3: Units is {unit!r}, expected one of: {', '.join(UNITS_M)}")
    rate_hz = number(header.get("DataRate", ""), path, 3, "DataRate")
    names = _names(path, lines[3])
    expected = 2 + 3 * len(names)
    rows, at = [], []
    for k in range(5, len(lines)):
        cells = lines[k].rstrip("\t").split("\t") if lines[k].strip() else []
        if not cells:
            continue
        if len(cells) > expected:
            raise InputError(f"{path}:{k + 1}: row has {len(cells)} cells, expected {expected}")
        cells += [""] * (expected - len(cells))
        rows.append([number(cell, path, k + 1, "a coordinate") for cell in cells])
        at.append(k + 1)
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected at least one frame")
    table = np.array(rows)
    time_s = table[:, 1]
    back = np.flatnonzero(~(np.diff(time_s) > 0))
    if back.size or not math.isfinite(time_s[0]):
        k = int(back[0]) + 1 if back.size else 0
        raise InputError(f"{path}:{at[k]}: Time is {time_s[k]}, expected increasing times")
    positions, gaps = {}, {}
    for k, name in enumerate(names):
        points = table[:, 2 + 3 * k : 5 + 3 * k] * UNITS_M[unit]
        points[np.isnan(points).any(axis=1)] = np.nan
        positions[name], gaps[name] = points, int(np.isnan(points[:, 0]).sum())
    return Markers(time_s, positions, gaps, rate_hz if rate_hz > 0 else None)


def _names(path: Path, line: str) -> list[str]:
    names = [name.strip() for name in line.split("\t")[2::3]]
    while names and not names[-1]:
        names.pop()
    if not names or len(set(names)) < len(names) or not all(names):
        raise InputError(
            f"{path}:4: names are {', '.join(names)[:80] or 'none'}, expected another one for every three columns"
        )
    return names
