"""Xsens' text exports, of MT Manager and of DOT: what is said of the file, one header, whatever columns were ticked.

MT Manager says it in `//` comments, DOT in lines such as `OutputRate:,60Hz`. Delimited by tab, comma, semicolon or
space; acceleration in m/s² with gravity, or free of it in the earth frame; turn rate in rad/s (DOT: degrees per
second); orientation (sensor to a z-up earth frame) as quaternion w first, matrix written column by column, or Euler
angles in degrees; or what acceleration and turn came to from sample to sample. A sample's time is its clock, or its
packet counter, which wraps at 65535, over the rate, or the time of day; packets that were lost leave a gap.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.text import Table, parse_table, points_for_commas, without_cut_row
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.rotation import (
    conjugate,
    euler_to_quaternion,
    matrix_to_quaternion,
    quaternion_to_rotation_vector,
    rotate,
)

__all__ = ["read"]

Float = NDArray[np.float64]

COUNTER = "PacketCounter"
FINE = "SampleTimeFine"
UTC = ("UTC_Hour", "UTC_Minute", "UTC_Second", "UTC_Nano")
UTC_S, DAY_S = np.array([3600.0, 60.0, 1.0, 1e-9]), 86400
ACC = ("Acc_X", "Acc_Y", "Acc_Z")
FREE_ACC = (("FreeAcc_E", "FreeAcc_N", "FreeAcc_U"), ("FreeAcc_X", "FreeAcc_Y", "FreeAcc_Z"))
"""Free of gravity and in the earth frame, as newer and older versions name it."""
GYR = ("Gyr_X", "Gyr_Y", "Gyr_Z")
MAG = ("Mag_X", "Mag_Y", "Mag_Z")
QUATERNION = ("Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3")
QUATERNION_DOT = ("Quat_W", "Quat_X", "Quat_Y", "Quat_Z")
"""As the Xsens DOT writes it."""
VELOCITY_INCREMENTS = (("VelInc_X", "VelInc_Y", "VelInc_Z"), ("dv[1]", "dv[2]", "dv[3]"))
TURN_INCREMENTS = (("OriInc_q0", "OriInc_q1", "OriInc_q2", "OriInc_q3"), ("dq_W", "dq_X", "dq_Y", "dq_Z"))
"""What acceleration and turn rate came to since the sample before, m/s and a quaternion, of MT Manager and of DOT."""
MATRIX = tuple(f"Mat[{row}][{column}]" for column in (1, 2, 3) for row in (1, 2, 3))
EULER = ("Roll", "Pitch", "Yaw")
EULER_DOT = ("Euler_X", "Euler_Y", "Euler_Z")
KNOWN = {
    COUNTER, FINE, *UTC, *ACC, *FREE_ACC[0], *FREE_ACC[1], *GYR, *MAG, *QUATERNION, *QUATERNION_DOT, *MATRIX, *EULER,
    *EULER_DOT, *chain(*VELOCITY_INCREMENTS, *TURN_INCREMENTS),
}  # fmt: skip
MOST_COLUMNS = 1000
HEADER_WITHIN = 40
"""A header comes within so many lines."""
OF_DOT = re.compile(r"(?i)\"?(sep=|DeviceTag:|OutputRate:)")
"""What begins a line of a DOT's before its header."""

DOWN = re.compile(r"(?i)//\s*coordinate\s+system:.*\b(NED|north[- ]east[- ]down)\b")
"""A comment that says that the earth frame's z points down."""
ORIENTATION_LIKE = re.compile(r"(?i)(quat|mat\[|roll|pitch|yaw|euler)")

COUNTER_WRAP = 65536
FINE_WRAP = 2**32
FINE_TICKS_S = (1e-4, 1e-6)
RESTARTS_S = 10.0
"""A counter that goes back, and would have wrapped only if so much was lost, began anew."""
RATE_RANGE_HZ = (10.0, 3000.0)


def read(path: Path, lines: list[str], rate_hz: float | None = None) -> ImuLog:
    """From the file's lines; `rate_hz` where the file does not say it. Raises `InputError`."""
    first, delimiter, names = _header(path, lines)
    if twice := [name for name in names if name in KNOWN and names.count(name) > 1]:
        raise InputError(f"{path}:{first + 1}: column {twice[0]!r} stands more than once, expected one sensor a file")
    if delimiter != ",":
        lines = points_for_commas(lines, first + 1)
    lines, cut = without_cut_row(path, lines, first + 1, names, delimiter)
    table = parse_table(path, lines, first + 1, names, delimiter, KNOWN)
    stated = _stated_rate(path, lines[:first])
    if stated is not None and rate_hz is not None and stated != rate_hz:
        raise InputError(
            f"{path}: its Update Rate is {stated:g} Hz, and rate_hz is {rate_hz:g}, expected the same, or no rate_hz"
        )
    rate = stated if rate_hz is None else rate_hz
    # Times come before the lost samples go: without a counter it is the rows that count.
    time_s = _times(table, rate)
    kept, warnings = _lost_samples(table)
    table = table.without(~kept)
    q, gyr = _orientation(table), table.columns(*GYR)
    step_s = float(np.median(np.diff(time_s))) if rate is None and len(time_s) > 1 else 1.0 / (rate or np.nan)
    is_dot = any(OF_DOT.match(line) for line in lines[:first])
    is_down = any(DOWN.match(line) for line in lines[:first])
    acc, put_back = _acceleration(table, q, -GRAVITY if is_down else GRAVITY)
    gyr = np.deg2rad(gyr) if is_dot and gyr is not None else gyr
    summed, turned = (_first_of(table, of) for of in (VELOCITY_INCREMENTS, TURN_INCREMENTS))
    if summed is not None and (acc is None or put_back):
        acc, put_back = summed / step_s, ()
    if turned is not None and gyr is None:
        gyr = quaternion_to_rotation_vector(turned) / step_s
    return ImuLog(
        path=path,
        lines=table.lines,
        time_s=time_s[kept],
        acc=acc,
        gyr=gyr,
        mag=table.columns(*MAG),
        q_world_sensor=q,
        rate_hz=rate,
        warnings=(*cut, *warnings, *put_back),
    )


def _first_of(table: Table, groups: Sequence[tuple[str, ...]]) -> Float | None:
    """The columns of the first group that is there."""
    return next((found for names in groups if (found := table.columns(*names)) is not None), None)


def _header(path: Path, lines: list[str]) -> tuple[int, str, list[str]]:
    """Where the header is, what parts its cells, and their names. Raises `InputError`."""
    said = [k for k, line in enumerate(lines) if line.strip() and not line.startswith("//")]
    if not said:
        raise InputError(f"{path}: has comments but no header, expected a line that names the columns")
    for k in said[:HEADER_WITHIN]:
        header = lines[k].rstrip()
        delimiter = max("\t,; ", key=header.count)
        names = [name.strip().strip('"') for name in header.split(delimiter)]
        if len(names) > MOST_COLUMNS:
            raise InputError(
                f"{path}:{k + 1}: header has {len(names)} columns, expected a few: are its line ends lost?"
            )
        if KNOWN & set(names):
            return k, delimiter, names if names[-1] else names[:-1]
    raise InputError(
        f"{path}:{said[0] + 1}: header {lines[said[0]].rstrip()[:80]!r} names no known column, expected Acc_X, "
        "Quat_q0 ..."
    )


def _acceleration(table: Table, q_world_sensor: Float | None, up: float) -> tuple[Float | None, tuple[str, ...]]:
    """Specific force `(M, 3)`; where gravity was taken off it is put back by the orientation, and that is said.

    `up` is what a sensor at rest feels along the earth frame's z, m/s².
    """
    acc = table.columns(*ACC)
    free = _first_of(table, FREE_ACC)
    if acc is not None or free is None or q_world_sensor is None:
        return acc, ()
    words = (
        f"{table.path}: its acceleration is free of gravity, which is put back by its orientation: nothing checks one "
        "by the other. Export Acc beside it where you can"
    )
    return rotate(conjugate(q_world_sensor), free + np.array([0.0, 0.0, up])), (words,)


def _orientation(table: Table) -> Float | None:
    """Quaternion, else matrix, else Euler angles: the order of trust that OpenSim uses."""
    for names in (QUATERNION, QUATERNION_DOT):
        quaternion = table.columns(*names)
        if quaternion is not None:
            return quaternion
    matrix = table.columns(*MATRIX)
    if matrix is not None:
        m = matrix.reshape(-1, 3, 3).transpose(0, 2, 1)
        skew = np.abs(m @ m.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        bad = np.flatnonzero(~(skew < 0.02))
        if bad.size:
            raise InputError(
                f"{table.path}:{table.lines[bad[0]]}: orientation matrix differs from a rotation by "
                f"{skew[bad[0]]:.3f}, expected at most 0.02"
            )
        return matrix_to_quaternion(m)
    for angles in (EULER, EULER_DOT):
        euler = table.columns(*angles)
        if euler is not None:
            roll, pitch, yaw = np.deg2rad(euler).T
            return euler_to_quaternion(roll, pitch, yaw)
    strange = [name for name in table.header if ORIENTATION_LIKE.match(name)]
    if strange:
        raise InputError(
            f"{table.path}: columns {', '.join(strange)[:200]} look like an orientation, expected it whole, as "
            f"{', '.join(QUATERNION)}, {', '.join(QUATERNION_DOT)}, nine of Mat[1][1], or {', '.join(EULER)}"
        )
    return None


def _lost_samples(table: Table) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """Rows to keep: MT Manager writes NaN or nothing where a packet held no reading."""
    free = () if ACC[0] in table.names else (*FREE_ACC[0], *FREE_ACC[1])
    readings = (
        *ACC,
        *free,
        *chain(*VELOCITY_INCREMENTS, *TURN_INCREMENTS),
        *GYR,
        *QUATERNION,
        *QUATERNION_DOT,
        *MATRIX,
        *EULER,
        *EULER_DOT,
    )
    columns = [name for name in readings if name in table.names]
    values = table.columns(*columns)
    if values is None or not columns:
        return np.ones(len(table.lines), dtype=np.bool_), ()
    lost = np.asarray(~np.isfinite(values.sum(axis=1)), dtype=np.bool_)
    if lost.all():
        raise InputError(f"{table.path}: no row has all of {', '.join(columns)[:120]}, expected numbers")
    if not lost.any():
        return ~lost, ()
    first = int(np.flatnonzero(lost)[0])
    cell = columns[int(np.flatnonzero(~np.isfinite(values[first]))[0])]
    warning = (
        f"{table.path}:{table.lines[first]}: {cell} has no value; {int(lost.sum())} of {len(lost)} rows lack a "
        "reading and are left out"
    )
    return ~lost, (warning,)


def _stated_rate(path: Path, comments: list[str]) -> float | None:
    """`// Update Rate: 100.0Hz`, which only old versions write; `OutputRate:,60Hz` of a DOT."""
    for number, line in enumerate(comments, start=1):
        found = re.match(r"(?://\s*Update Rate:|OutputRate:[,;]?)\s*(.*?)\s*(Hz)?[\s,;]*$", line, re.IGNORECASE)
        if found:
            try:
                rate = float(found[1])
            except ValueError:
                rate = 0.0
            if not 0 < rate < np.inf:
                raise InputError(f"{path}:{number}: Update Rate is {found[1]!r}, expected a positive number of Hz")
            return rate
    return None


def _times(table: Table, rate: float | None) -> Float:
    """From the sample clock where it was exported, else from counter and rate; the first sample is at 0."""
    fine = table.columns(FINE)
    if fine is not None and np.isfinite(fine).all() and len(fine) > 1:
        return _fine_times(table, _unwrap(fine[:, 0], FINE_WRAP))
    if rate is None and (utc := table.columns(*UTC)) is not None and np.isfinite(utc).all():
        return _unwrap(utc @ UTC_S, DAY_S)
    if rate is None:
        raise InputError(
            f"{table.path}: states neither an Update Rate nor sample times (newer MT Manager versions leave the rate "
            "out), expected rate_hz in [[imu]] of recording.toml"
        )
    counter = table.columns(COUNTER)
    if counter is None or not np.isfinite(counter).all():
        return np.arange(len(table.lines)) / rate
    packets = _unwrap(counter[:, 0], COUNTER_WRAP)
    lost = np.diff(packets) - 1
    back = np.flatnonzero((np.diff(counter[:, 0]) < 0) & (lost > RESTARTS_S * rate))
    if back.size:
        k = int(back[0])
        raise InputError(
            f"{table.path}:{table.lines[k + 1]}: {COUNTER} is {counter[k + 1, 0]:.0f} after {counter[k, 0]:.0f}, "
            f"expected that it goes on, or wraps at {COUNTER_WRAP - 1}: did the device start anew? Write one file each"
        )
    return np.asarray(packets / rate)


def _fine_times(table: Table, ticks: Float) -> Float:
    """Ticks are 0.1 ms on MTi and 1 µs on DOT; only one of them gives a rate that an IMU has."""
    interval = float(np.median(np.diff(ticks)))
    for tick_s in FINE_TICKS_S:
        if interval > 0 and RATE_RANGE_HZ[0] <= 1 / (interval * tick_s) <= RATE_RANGE_HZ[1]:
            return ticks * tick_s
    raise InputError(
        f"{table.path}: {FINE} advances by {interval:g} ticks a sample, expected a rate of 10 to 3000 Hz at 0.1 ms or "
        "1 µs a tick"
    )


def _unwrap(counter: Float, wrap: int) -> Float:
    """A counter that starts anywhere and wraps, as samples since the first."""
    steps = np.diff(counter)
    steps[steps < -wrap / 2] += wrap
    return np.concatenate([[0.0], np.cumsum(steps)])
