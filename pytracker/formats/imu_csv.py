"""An IMU's CSV: a header, then a row a sample.

Columns are found by name, extra ones ignored: `time_s, acc_x..z` (m/s², specific force), `gyr_x..z` (rad/s),
`mag_x..z`, `q_w, q_x, q_y, q_z` (sensor to world); or by what other loggers call them (`imu_names`), or by a map.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.imu_log import ImuLog
from pytracker.formats.imu_names import known_as, of_shimmer
from pytracker.formats.text import parse_table

__all__ = ["Header", "header_of", "read"]

SEPARATOR = re.compile(r'"?sep=', re.IGNORECASE)

ACC = ("acc_x", "acc_y", "acc_z")
GYR = ("gyr_x", "gyr_y", "gyr_z")
MAG = ("mag_x", "mag_y", "mag_z")
ORIENTATION_LIKE = re.compile(
    r"(q|quat|quaternion|ori|orientation)[ _.]?(0|1|2|3|w|x|y|z|i|j|k|real|si)$|(roll|pitch|yaw|euler\b)"
)
"""How others name an orientation; what is not read must not be passed over."""
MOST_COLUMNS = 1000
QUATERNION = ("q_w", "q_x", "q_y", "q_z")
OURS = {"time_s", *ACC, *GYR, *MAG, *QUATERNION}


@dataclass(frozen=True)
class Header:
    """How a CSV names its columns.

    Attributes:
        first: number of its line, from 1: rows follow it.
        delimiter: between cells.
        names: in small letters, as they are.
        lines: the whole file's, with points for decimals.
    """

    first: int
    delimiter: str
    names: tuple[str, ...]
    lines: list[str]


def header_of(lines: list[str]) -> Header:
    """Of a file's lines; what says `sep=` and blank lines are passed over."""
    named = (k for k, line in enumerate(lines) if line.strip() and not SEPARATOR.match(line))
    first = next(named, len(lines) - 1)
    delimiter = max(",;\t", key=lines[first].count)
    if delimiter == ";":
        # Where semicolons part the cells, a comma is that of a decimal.
        lines = [*lines[: first + 1], *(line.replace(",", ".") for line in lines[first + 1 :])]
    names = [name.strip().strip('"').lower() for name in lines[first].split(delimiter)]
    below = lines[first + 1].split(delimiter) if first + 1 < len(lines) else []
    if any(name.endswith("_cal") for name in names) and len(below) == len(names) and below[0].strip(' "').isalpha():
        names, first = of_shimmer(names, [unit.strip().strip('"') for unit in below]), first + 1
    # A comma at the end of every line begins no column.
    return Header(first + 1, delimiter, tuple(names if names[-1] else names[:-1]), lines)


def read(path: Path, lines: list[str], columns: Mapping[str, str] | None = None) -> ImuLog:
    """From the file's lines; `columns` says what ours are called in the file. Raises `InputError`."""
    header = header_of(lines)
    lines, delimiter, first = header.lines, header.delimiter, header.first - 1
    names, factors = _ours(path, list(header.names), columns or {})
    if len(names) > MOST_COLUMNS:
        raise InputError(
            f"{path}:{first + 1}: header has {len(names)} columns, expected a few: are its line ends lost?"
        )
    repeated = sorted(name for name, count in Counter(names).items() if count > 1)
    if repeated:
        raise InputError(f"{path}:{first + 1}: column {repeated[0]!r} stands more than once, expected each name once")
    missing = [name for name in ("time_s", *ACC) if name not in names]
    if missing:
        raise InputError(
            f"{path}:{first + 1}: header has no column {', '.join(missing)} (it has {', '.join(names)[:200]}), "
            'expected time_s, acc_x, acc_y, acc_z and any of gyr_*, mag_*, q_*, or columns = { time_s = "...", ... }'
        )
    for group in (GYR, MAG, QUATERNION):
        there = [name for name in group if name in names]
        if there and len(there) < len(group):
            missing = [name for name in group if name not in names]
            raise InputError(f"{path}:{first + 1}: header has {', '.join(there)} but not {', '.join(missing)}")
    strange = [name for name in names if name not in QUATERNION and ORIENTATION_LIKE.match(name)]
    if strange and not set(QUATERNION) <= set(names):
        raise InputError(
            f"{path}:{first + 1}: columns {', '.join(strange)[:200]} look like an orientation, expected it as "
            "q_w, q_x, q_y, "
            'q_z (sensor to world, w first): name them by columns = { q_w = "...", ... }, or drop them to have one '
            "computed from the gyroscope"
        )
    table = parse_table(path, lines, first + 1, names, delimiter, OURS)
    time_s = table.columns("time_s")
    assert time_s is not None

    def scaled(*group: str) -> NDArray[np.float64] | None:
        values = table.columns(*group)
        return None if values is None else values * np.array([factors.get(name, 1.0) for name in group])

    return ImuLog(
        path=path,
        lines=table.lines,
        time_s=time_s[:, 0] * factors.get("time_s", 1.0),
        acc=scaled(*ACC),
        gyr=scaled(*GYR),
        mag=scaled(*MAG),
        q_world_sensor=table.columns(*QUATERNION),
    )


def _ours(path: Path, theirs: list[str], columns: Mapping[str, str]) -> tuple[list[str], dict[str, float]]:
    """The columns' names with ours where they are known, and the factors of those that are in other units."""
    names, factors = list(theirs), {}
    for ours, name in columns.items():
        if name.lower() not in theirs:
            raise InputError(
                f"{path}: columns.{ours} is {name!r}, but the header has no such column: {', '.join(theirs)[:200]}"
            )
        names[theirs.index(name.lower())] = ours
    # A clock that counts from the start says more than one of the day.
    for k in sorted(range(len(theirs)), key=lambda k: "elapsed" not in theirs[k]):
        known = known_as(theirs[k]) if names[k] == theirs[k] and names[k] not in OURS else None
        if known is not None and known.name not in names:
            names[k], factors[known.name] = known.name, known.factor
    return names, factors
