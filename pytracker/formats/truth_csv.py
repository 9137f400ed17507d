"""Truth as plain CSV: `time_s`, then `<joint>_x_m, <joint>_y_m, <joint>_z_m`, or in `_mm`.

Comments (`#`) may stand above the header. A gap is an empty cell, or (0, 0, 0) where no row before or after leads
there.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.markers import UNITS_M, Markers, without_fillers
from pytracker.formats.text import cells_of, delimited, first_line, parse_table, read_lines, without_cut_row

__all__ = ["read_truth_csv"]


def read_truth_csv(path: Path | str) -> Markers:
    """Read it. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    lines = read_lines(path)
    first = first_line(lines)
    delimiter, lines = delimited(lines, first)
    names = [name.strip().strip('"').strip() for name in cells_of(lines[first], delimiter)]
    joints = {name.rsplit("_x_", 1)[0]: name.rsplit("_", 1)[1] for name in names if name.endswith(("_x_m", "_x_mm"))}
    wanted = {"time_s", *(f"{joint}_{axis}_{unit}" for joint, unit in joints.items() for axis in "xyz")}
    missing = sorted(wanted - set(names))
    if missing or not joints:
        column = ", ".join(missing) or "<joint>_x_m"
        raise InputError(
            f"{path}:{first + 1}: header has no column {column} but {', '.join(names)[:200]}, expected time_s and "
            "<joint>_x_m, <joint>_y_m, <joint>_z_m, seconds and metres (or _mm, millimetres)"
        )
    if twice := [name for name in names if name in wanted and names.count(name) > 1]:
        raise InputError(f"{path}:{first + 1}: column {twice[0]!r} stands more than once, expected each name once")
    lines, cut = without_cut_row(path, lines, first + 1, names, delimiter)
    table = parse_table(path, lines, first + 1, names, delimiter, wanted)
    time_s = table.columns("time_s")
    assert time_s is not None
    back = np.flatnonzero(~(np.diff(time_s[:, 0]) > 0))
    if back.size or not np.isfinite(time_s).all():
        k = int(back[0]) + 1 if back.size else 0
        raise InputError(f"{path}:{table.lines[k]}: time_s is {time_s[k, 0]}, expected increasing times")
    positions = {}
    for joint, unit in joints.items():
        points = table.columns(*(f"{joint}_{axis}_{unit}" for axis in "xyz"))
        assert points is not None
        points *= UNITS_M[unit]
        points[np.isnan(points).any(axis=1)] = np.nan
        positions[joint] = without_fillers(points)
    return Markers(time_s=time_s[:, 0], positions_m=positions, rate_hz=None, warnings=cut)
