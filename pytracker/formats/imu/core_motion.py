"""Apple's Core Motion in one file, by whatever app: acceleration without gravity, gravity, and rotation rate.

It counts accelerations and gravity the other way round than everybody else: at rest, face up, z reads -1 g.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.imu.clock import unit_of
from pytracker.formats.imu.names import known_as
from pytracker.formats.imu.table import header_of
from pytracker.formats.text import parse_table, without_cut_row
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog

__all__ = ["is_motion", "read_motion"]

MOTION = re.compile(r"(useracceleration|useracc|acceleration|acc|gravity|rotationrate)(x|y|z)")
"""Columns of Core Motion, by whatever app; SensorLog writes `motion` before each and its unit in brackets."""
MOTION_TIME = ("secondselapsed", "time", "times", "relativetime", "timestampsincereboot")
HEADER_LINES = 10
"""A header comes within these."""


def is_motion(lines: list[str]) -> bool:
    """Whether the columns are Core Motion's: acceleration without gravity, gravity, rotation rate."""
    return {"gravity_x", "gyr_x"} <= {_motion_name(name) for name in header_of(lines[:HEADER_LINES]).names}


def read_motion(path: Path, lines: list[str]) -> ImuLog:
    """Core Motion in one file, such as a watch's `WristMotion.csv`. Raises `InputError`.

    In g its signs are Apple's; where Sensor Logger standardises units to m/s², it turns the signs too.
    """
    header = header_of(lines)
    names = [_motion_name(name) for name in header.names]
    groups = {group: tuple(f"{group}_{axis}" for axis in "xyz") for group in ("acc", "gravity", "gyr")}
    missing = [name for group in groups.values() for name in group if name not in names]
    if double := [name for group in groups.values() for name in group if names.count(name) > 1]:
        raise InputError(
            f"{path}:{header.first}: has several columns for {double[0]}, expected one: acceleration without gravity"
        )
    if missing or "time_s" not in names:
        raise InputError(
            f"{path}:{header.first}: Core Motion's columns lack {', '.join((missing or ['time'])[:6])}, expected "
            "acceleration, gravity and rotationRate along X, Y, Z, and seconds_elapsed"
        )
    wanted = {"time_s", *(name for group in groups.values() for name in group)}
    lines, cut = without_cut_row(path, header.lines, header.first, names, header.delimiter)
    table = parse_table(path, lines, header.first, names, header.delimiter, wanted)
    time_s, *found = (table.columns(*group) for group in (("time_s",), *groups.values()))
    assert time_s is not None
    acc, gravity, gyr = found
    assert acc is not None
    assert gravity is not None
    norm = float(np.median(np.linalg.norm(gravity, axis=1)))
    if not (0.9 < norm < 1.1 or 0.9 < norm / GRAVITY < 1.1):
        raise InputError(f"{path}: gravity is {norm:.3g} long in the median, expected 1 g or {GRAVITY:.2f} m/s²")
    force = (-GRAVITY if norm < 2.0 else 1.0) * (acc + gravity)
    clock = known_as(header.names[names.index("time_s")])
    unit_s = clock.factor if clock is not None and clock.has_unit else unit_of(time_s[:, 0])[1]
    return ImuLog(path=path, lines=table.lines, time_s=time_s[:, 0] * unit_s, acc=force, gyr=gyr, warnings=cut)


def _motion_name(name: str) -> str:
    """`acc_x`, `gravity_x`, `gyr_x`, `time_s`; others as they are."""
    plain = re.sub(r"\(.*?\)|[^a-z]", "", name.lower()).removeprefix("motion")
    if match := MOTION.fullmatch(plain):
        group = {"gravity": "gravity", "rotationrate": "gyr"}.get(match[1], "acc")
        return f"{group}_{match[2]}"
    return "time_s" if plain in MOTION_TIME else name
