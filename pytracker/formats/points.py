"""Point pairs `x_m, y_m, z_m, u, v`: world points and where an image shows them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.text import parse_table, read_lines
from pytracker.rotation import Array

__all__ = ["read_points"]

NAMES = ("x_m", "y_m", "z_m", "u", "v")


def read_points(path: Path | str) -> tuple[Array, Array]:
    """World points `(n, 3)`, m, and pixels `(n, 2)`. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    lines = read_lines(path)
    names = [name.strip() for name in lines[0].split(",")]
    missing = [name for name in NAMES if name not in names]
    if missing:
        raise InputError(f"{path}:1: header has no column {', '.join(missing)}, expected {', '.join(NAMES)}")
    table = parse_table(path, lines, 1, names, ",", set(NAMES))
    values = table.columns(*NAMES)
    assert values is not None
    empty = np.flatnonzero(np.isnan(values).any(axis=1))
    if empty.size:
        raise InputError(f"{path}:{table.lines[empty[0]]}: has an empty cell, expected five numbers")
    return values[:, :3], values[:, 3:]
