"""The plain IMU CSV: a header, then a row a sample.

Columns are found by name, extra ones ignored: `time_s, acc_x..z` (m/s², specific force), `gyr_x..z` (rad/s),
`mag_x..z`, `q_w, q_x, q_y, q_z` (sensor to world).
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from pytracker._core import InputError
from pytracker.formats.imu_log import ImuLog
from pytracker.formats.text import parse_table

__all__ = ["read"]

ACC = ("acc_x", "acc_y", "acc_z")
GYR = ("gyr_x", "gyr_y", "gyr_z")
MAG = ("mag_x", "mag_y", "mag_z")
ORIENTATION_LIKE = re.compile(
    r"(q|quat|quaternion|ori|orientation)[ _.]?(0|1|2|3|w|x|y|z|i|j|k|real|si)$|(roll|pitch|yaw|euler\b)"
)
"""How others name an orientation; what is not read must not be passed over."""
MOST_COLUMNS = 1000
QUATERNION = ("q_w", "q_x", "q_y", "q_z")


def read(path: Path, lines: list[str]) -> ImuLog:
    """From the file's lines. Raises `InputError`."""
    first = next(k for k, line in enumerate(lines) if line.strip())
    header = lines[first]
    delimiter = max(",;\t", key=header.count)
    names = [name.strip().strip('"').lower() for name in header.split(delimiter)]
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
            "expected time_s, acc_x, acc_y, acc_z and any of gyr_*, mag_*, q_*"
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
            "q_z (sensor to world, w first): rename them, or drop them to have one computed from the gyroscope"
        )
    table = parse_table(path, lines, first + 1, names, delimiter, {"time_s", *ACC, *GYR, *MAG, *QUATERNION})
    time_s = table.columns("time_s")
    assert time_s is not None
    return ImuLog(
        path=path,
        lines=table.lines,
        time_s=time_s[:, 0],
        acc=table.columns(*ACC),
        gyr=table.columns(*GYR),
        mag=table.columns(*MAG),
        q_world_sensor=table.columns(*QUATERNION),
    )
