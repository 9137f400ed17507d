"""An IMU's CSV: a header, then a row a sample.

Columns are found by name, extra ones ignored: `time_s, acc_x..z` (m/s², specific force), `gyr_x..z` (rad/s),
`mag_x..z`, `q_w, q_x, q_y, q_z` (sensor to world); or by what other loggers call them (`names`), or by a map.
"""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.imu.clock import as_it_went, seconds
from pytracker.formats.imu.counter import as_counted, counter_in, steps_of
from pytracker.formats.imu.dates import as_seconds
from pytracker.formats.imu.names import (
    Column,
    devices_of_shimmer,
    known_as,
    numbered_quaternion,
    of_shimmer,
    unit_in,
)
from pytracker.formats.text import Table, cells_of, delimited, parse_table, without_cut_row
from pytracker.inertial.log import ImuLog

__all__ = ["ACC", "GYR", "QUATERNION", "Header", "header_of", "read"]

SEPARATOR = re.compile(r'"?sep=', re.IGNORECASE)

ACC = ("acc_x", "acc_y", "acc_z")
GYR = ("gyr_x", "gyr_y", "gyr_z")
MAG = ("mag_x", "mag_y", "mag_z")
ORIENTATION_LIKE = re.compile(
    r"(q|quat|quaternion|ori|orientation)[ _.]?(0|1|2|3|w|x|y|z|i|j|k|real|si) ?(\(\)|\[\])?$|(roll|pitch|yaw|euler\b)"
)
"""How others name an orientation; what is not read must not be passed over."""
TURN_LIKE = re.compile(r".*(gyr|omega|ang(ular)?_?(vel|rate)|turn_?rate|rot(ation)?_?rate)")
"""How others name a turn rate."""
MOST_COLUMNS = 1000
HEADER_WITHIN = 40
LEAST_KNOWN = 4
"""A header comes within so many lines, and names so much of a time and three axes."""
QUATERNION = ("q_w", "q_x", "q_y", "q_z")
OURS = {"time_s", *ACC, *GYR, *MAG, *QUATERNION}
TURNED = (*ACC, *GYR, *MAG)
"""Those whose sign a map may turn: `acc_x = "-ax"`."""


@dataclass(frozen=True)
class Header:
    """How a CSV names its columns.

    Attributes:
        first: number of its line, from 1: rows follow it.
        delimiter: between cells.
        names: in small letters, as they are.
        lines: the whole file's, with points for decimals.
        devices: whose columns they are, where the names say it.
    """

    first: int
    delimiter: str
    names: tuple[str, ...]
    lines: list[str]
    devices: tuple[str, ...] = ()


def header_of(lines: list[str], columns: Collection[str] = ()) -> Header:
    """Of a file's lines: the first that names a sensor's columns, else the first that is not blank or says `sep=`.

    Where names of `columns` are given, the first that has all of them.
    """
    said = [k for k, line in enumerate(lines[:HEADER_WITHIN]) if line.strip() and not SEPARATOR.match(line)]
    first = next((k for k in said if _names_columns(lines[k])), said[0] if said else len(lines) - 1)
    first = next((k for k in said if columns and _names_all(columns, _numbered(_names(lines[k])))), first)
    delimiter, lines = delimited(lines, first)
    names = _numbered(_names(lines[first]))
    below = lines[first + 1].split(delimiter) if first + 1 < len(lines) else []
    devices: tuple[str, ...] = ()
    if (
        any(name.endswith("_cal") for name in names)
        and len(below) == len(names)
        and not re.match(r'[ "]*-?\d', below[0])
    ):
        devices = devices_of_shimmer(names)
        units = [unit.strip().strip('"') for unit in below]
        names, first = of_shimmer(names, units) if len(devices) < 2 else names, first + 1
    elif with_units := _with_units(names, below):
        names, first = names if columns else with_units, first + 1
    # A comma at the end of every line begins no column.
    return Header(first + 1, delimiter, tuple(names if names[-1] else names[:-1]), lines, devices)


def _with_units(names: list[str], below: list[str]) -> list[str]:
    """The names with the units that stand in a row of their own below them; none where that is a row of numbers."""
    units = [unit.strip(' "()[]') for unit in below]
    if len(units) != len(names) or any(re.match(r"[-+.]?\d", unit) for unit in units):
        return []
    said = [f"{name} ({unit})" if unit else name for name, unit in zip(names, units, strict=True)]
    is_known = [bool(unit) and known_as(one) is not None for one, unit in zip(said, units, strict=True)]
    is_odd = [bool(unit) and not known and (name in OURS or known_as(name) is not None)
              for name, unit, known in zip(names, units, is_known, strict=True)]  # fmt: skip
    if sum(is_known) < LEAST_KNOWN or any(is_odd):
        return []
    return [one if known else name for one, known, name in zip(said, is_known, names, strict=True)]


def _names_all(columns: Collection[str], names: list[str]) -> bool:
    return all(_without_sign(name, names) in names for name in columns)


def _names(line: str) -> list[str]:
    """In small letters, by whichever of comma, semicolon and tab parts them."""
    delimiter, _ = delimited([line])
    return [name.strip().strip('"').lower() for name in cells_of(line, delimiter)]


def _numbered(names: list[str]) -> list[str]:
    """The same, those that stand again as `name.1`, `name.2`, unless they are a sensor's: Delsys repeats its clock."""
    before: Counter[str] = Counter()
    numbered = []
    for name in names:
        is_again = before[name] > 0 and name not in OURS and known_as(name) is None
        numbered.append(f"{name}.{before[name]}" if is_again else name)
        before[name] += 1
    return numbered


def _names_columns(line: str) -> bool:
    """Whether it is the header, below a logger's own words on the recording."""
    names = [name.strip().strip('"').lower() for name in re.split("[,;\t]", line)]
    return sum(name in OURS or known_as(name) is not None for name in names) >= LEAST_KNOWN


def read(
    path: Path, lines: list[str], columns: Mapping[str, str] | None = None, rate_hz: float | None = None
) -> ImuLog:
    """From the file's lines. Raises `InputError`.

    `columns` says what ours are called in the file, `rate_hz` how fast rows without a time follow each other.
    """
    header = header_of(lines, (columns or {}).values())
    names, known = _ours(path, list(header.names), columns or {})
    numbered = [] if set(QUATERNION[1:]) & set(names) else numbered_quaternion(names)
    names = [QUATERNION[numbered.index(name)] if name in numbered else name for name in names]
    if len(header.devices) > 1 and not columns:
        raise InputError(
            f"{path}:{header.first}: holds the sensors {', '.join(header.devices)[:200]}, expected one a file, or "
            'columns = { time_s = "...", acc_x = "...", ... } that names one\'s'
        )
    _check_names(path, header.first, names, has_rate=rate_hz is not None)
    lines, cut = without_cut_row(path, header.lines, header.first, names, header.delimiter)
    clock = known.get("time_s")
    at = names.index("time_s") if "time_s" in names else None
    dated = None if at is None else as_seconds(path, lines, header.first, header.delimiter, at)
    if dated is not None:
        lines, clock = dated, None  # dates say their unit
    table = _without_tail(parse_table(path, lines, header.first, names, header.delimiter, OURS))

    def scaled(*group: str) -> NDArray[np.float64] | None:
        values = table.columns(*group)
        return None if values is None else values * [known[name].factor if name in known else 1.0 for name in group]

    time_s, odd = seconds(table, clock, rate_hz)
    if dated is not None:
        time_s, changed = as_it_went(table, time_s)
        odd = (*odd, *changed)
    counting = counter_in(names)
    steps = None if counting is None else steps_of(lines, table.lines, header.delimiter, counting)
    if steps is not None:
        time_s, skips = as_counted(steps, time_s, scaled(*GYR), table.lines)
        odd = (*odd, f"{path}: {skips}") if skips else odd
    if numbered:
        words = f"{path}: columns {', '.join(numbered)} are taken as a quaternion's w, x, y, z"
        odd = (*odd, f'{words}: quaternion = "xyzw" says otherwise')
    strange = [name for name in names if name not in OURS and TURN_LIKE.match(name)]
    if strange and GYR[0] not in names:
        words = f"{path}: columns {', '.join(strange)[:200]} look like a turn rate and are not read"
        odd = (*odd, f"{words}: columns = {{ gyr_x = ... }} names them")
    return ImuLog(
        path=path,
        lines=table.lines,
        time_s=time_s,
        acc=scaled(*ACC),
        gyr=scaled(*GYR),
        mag=scaled(*MAG),
        q_world_sensor=table.columns(*QUATERNION),
        warnings=(*cut, *odd),
        unread=tuple(name for name in names if name not in OURS),
    )


def _without_tail(table: Table) -> Table:
    """The same without rows below the last that holds anything of the sensor: others beside it are faster."""
    holds = np.flatnonzero(np.isfinite(table.values).any(axis=1))
    last = int(holds[-1]) if len(holds) else len(table.values)
    return table.without(np.arange(len(table.values)) > last)


def _check_names(path: Path, line: int, names: list[str], *, has_rate: bool) -> None:
    """Whether all that is needed is there, once. Raises `InputError`."""
    if len(names) > MOST_COLUMNS:
        raise InputError(f"{path}:{line}: header has {len(names)} columns, expected a few: are its line ends lost?")
    repeated = sorted(name for name, count in Counter(names).items() if count > 1)
    if repeated:
        raise InputError(f"{path}:{line}: column {repeated[0]!r} stands more than once, expected each name once")
    missing = [name for name in ("time_s", *ACC) if name not in names and not (name == "time_s" and has_rate)]
    if missing:
        raise InputError(
            f"{path}:{line}: header has no column {', '.join(missing)} (it has {', '.join(names)[:200]}), "
            'expected time_s, acc_x, acc_y, acc_z and any of gyr_*, mag_*, q_*, or columns = { time_s = "...", ... }'
            + (", or rate_hz for rows without a time" if missing == ["time_s"] else "")
        )
    for group in (GYR, MAG, QUATERNION):
        there = [name for name in group if name in names]
        if there and len(there) < len(group):
            missing = [name for name in group if name not in names]
            raise InputError(f"{path}:{line}: header has {', '.join(there)} but not {', '.join(missing)}")
    strange = [name for name in names if name not in QUATERNION and ORIENTATION_LIKE.match(name)]
    if strange and not set(QUATERNION) <= set(names):
        raise InputError(
            f"{path}:{line}: columns {', '.join(strange)[:200]} look like an orientation, expected it as "
            'q_w, q_x, q_y, q_z (sensor to world, w first): name them by columns = { q_w = "...", ... }, or drop them '
            "to have one computed from the gyroscope"
        )


def _without_sign(name: str, theirs: Collection[str]) -> str:
    """Of a mapped column, in small letters, without a minus that is none of its name's."""
    name = name.lower()
    return name[1:].strip() if name not in theirs and name.startswith("-") else name


def _ours(path: Path, theirs: list[str], columns: Mapping[str, str]) -> tuple[list[str], dict[str, Column]]:
    """The columns' names with ours where they are known, and what those of others say."""
    names, found = list(theirs), {}
    for ours, name in columns.items():
        plain = _without_sign(name, theirs)
        if plain not in theirs:
            raise InputError(
                f"{path}: columns.{ours} is {name!r}, but the header has no such column: {', '.join(theirs)[:200]}"
            )
        if plain != name.lower() and ours not in TURNED:
            raise InputError(f"{path}: columns.{ours} is {name!r}, expected a sign before {', '.join(TURNED)} only")
        names[theirs.index(plain)] = ours
        column = unit_in(plain, ours)
        found[ours] = column if plain == name.lower() else dataclasses.replace(column, factor=-column.factor)
    # A clock that counts from the start says more than one of the day.
    for k in sorted(range(len(theirs)), key=lambda k: "elapsed" not in theirs[k]):
        known = known_as(theirs[k]) if names[k] == theirs[k] and names[k] not in OURS else None
        if known is not None and known.name not in names:
            names[k], found[known.name] = known.name, known
    return names, found
