"""Qualisys Track Manager `.tsv` exports of 3-D markers, old and new.

The header has a variable a line (name, tab, value), then marker names, then possibly `TRAJECTORY_TYPES` and a line
of column names; rows are millimetres with or without leading Frame and Time columns. A marker that was not seen is
blank, `NULL` or (0, 0, 0).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.markers import Markers
from pytracker.formats.text import number, points_for_commas, read_lines

__all__ = ["read_qualisys"]

Float = NDArray[np.float64]

KEYS = {
    "FILE_VERSION", "NO_OF_FRAMES", "NO_OF_CAMERAS", "NO_OF_MARKERS", "NO_OF_BODIES", "FREQUENCY", "NO_OF_ANALOG",
    "ANALOG_FREQUENCY", "DESCRIPTION", "TIME_STAMP", "DATA_INCLUDED", "EVENT", "MARKER_NAMES", "BODY_NAMES",
    "TRAJECTORY_TYPES",
}  # fmt: skip


MOST_DIGITS = 12
"""No count has more."""


def read_qualisys(path: Path | str) -> Markers:
    """Read a 3-D export. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    lines = read_lines(path)
    header, first = _header(path, lines)
    kind = header.get("DATA_INCLUDED", ["3D"])[0].strip()
    if kind != "3D":
        raise InputError(f"{path}: DATA_INCLUDED is {kind!r}, expected 3D (marker positions)")
    names = [name.strip() for name in header.get("MARKER_NAMES", [])]
    while names and not names[-1]:
        names.pop()
    if not names:
        raise InputError(f"{path}: has no MARKER_NAMES line, expected a QTM export with its header")
    if len(set(names)) != len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{path}: marker {twice!r} is named twice, expected each once")
    count = _whole(path, header, "NO_OF_MARKERS")
    if count is not None and count != len(names):
        raise InputError(f"{path}: NO_OF_MARKERS is {count}, but {len(names)} names follow: {', '.join(names)}")
    rows, leading = _rows(path, lines, first, len(names))
    promised = _whole(path, header, "NO_OF_FRAMES")
    if promised is not None and promised != len(rows):
        raise InputError(f"{path}: NO_OF_FRAMES is {promised}, but {len(rows)} rows follow: the file is cut short")
    rate = _rate(path, header)
    if leading == 2:
        time_s = rows[:, 1]
        if not (np.diff(time_s) > 0).all() or not np.isfinite(time_s).all():
            raise InputError(f"{path}: the Time column does not increase, expected seconds from row to row")
    elif rate is None:
        raise InputError(
            f"{path}: FREQUENCY is {header.get('FREQUENCY', ['missing'])[0]!r} and there is no Time column"
        )
    else:
        time_s = np.arange(len(rows)) / rate
    points = rows[:, leading:].reshape(len(rows), len(names), 3) / 1000.0
    points[(points == 0).all(axis=2)] = np.nan
    points[np.isnan(points).any(axis=2)] = np.nan
    return Markers(
        time_s=np.ascontiguousarray(time_s),
        positions_m={name: np.ascontiguousarray(points[:, k]) for k, name in enumerate(names)},
        rate_hz=rate,
    )


def _header(path: Path, lines: list[str]) -> tuple[dict[str, list[str]], int]:
    """Variables of the header and the index of the first row."""
    header: dict[str, list[str]] = {}
    for index, line in enumerate(lines):
        key, *values = line.split("\t")
        if key.strip() in KEYS:
            header[key.strip()] = values or [""]
        elif (line.strip() or ("\t" in line and "MARKER_NAMES" in header)) and _is_row(line):
            if not header:
                raise InputError(f"{path}:1: begins with numbers, expected a QTM header (switch it on in the export)")
            return header, index
        elif line.strip() and not header:
            raise InputError(f"{path}:1: {line[:40]!r} is no QTM variable, expected NO_OF_FRAMES, FREQUENCY ...")
    raise InputError(f"{path}: has a header but no rows, expected marker positions")


def _is_row(line: str) -> bool:
    """Whether a line is data: its first filled cell is a number (a column header's is not)."""
    for cell in line.split("\t"):
        if cell.strip() and cell.strip().upper() != "NULL":
            try:
                float(cell.replace(",", "."))
            except ValueError:
                return False
            return True
    return True


def _rows(path: Path, lines: list[str], first: int, markers: int) -> tuple[Float, int]:
    """Numbers of all rows, and how many columns (Frame, Time) lead the markers."""
    width = 3 * markers
    lines = points_for_commas(lines, first)
    split = [(k + 1, lines[k].split("\t")) for k in range(first, len(lines)) if lines[k]]
    # What is blank in every row is tabs at the lines' ends, or the last markers, which the columns' names tell.
    is_named = first > 0 and lines[first - 1].partition("\t")[0].strip().lower() == "frame"
    longer = any(len(cells) >= width + 2 and "".join(cells[width:]).strip() for _, cells in split)
    leading = 2 if is_named or longer else 0
    rows: list[list[float]] = []
    for line, cells in split:
        kept = cells if "".join(cells[leading + width :]).strip() else cells[: leading + width]
        if len(kept) != leading + width:
            raise InputError(
                f"{path}:{line}: row has {len(kept)} columns, expected {width} (3 for each of {markers} markers)"
                + (" after Frame and Time" if leading else " or two more with Frame and Time")
            )
        rows.append([number(cell, path, line, f"column {k + 1}") for k, cell in enumerate(kept)])
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1), leading


def _whole(path: Path, header: dict[str, list[str]], key: str) -> int | None:
    if key not in header:
        return None
    text = header[key][0].strip()
    if not text.isdecimal() or len(text) > MOST_DIGITS:
        raise InputError(f"{path}: {key} is {text[:80]!r}, expected a whole number")
    return int(text)


def _rate(path: Path, header: dict[str, list[str]]) -> float | None:
    text = header.get("FREQUENCY", [""])[0].strip()
    if text.upper() in {"", "EXT"}:
        return None
    try:
        rate = float(text.replace(",", "."))
    except ValueError:
        rate = math.nan
    if not 0 < rate < math.inf:
        raise InputError(f"{path}: FREQUENCY is {text!r}, expected a positive number of Hz or EXT")
    return rate
