"""What other loggers call the columns of an IMU's CSV, and in which units: phyphox, Sensor Logger, x-io and the like.

A name is its quantity, its axis and, in brackets, its unit: `Gyroscope x (rad/s)`, `Accelerometer X (g)`, `acc_x[mg]`.
Orientations by other names are not guessed: the order of their numbers has to be said.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from pytracker.formats.imu_gravity import GRAVITY

__all__ = ["Column", "known_as", "of_shimmer"]

SHIMMER = re.compile(r".*?(accel_ln|accel_wr|gyro|mag|timestamp(?:sync)?(?:_unix)?)(?:_([xyz]))?_cal")
"""Shimmer's: the device, the sensor, the axis; of two accelerometers the one of low noise and the one of wide range."""
UNIT = re.compile(r"[\(\[]([^\)\]]*)[\)\]]")
TIME = {"time", "times", "t", "timestamp", "timestamps", "secondselapsed", "elapsed", "elapsedtime"}
SENSORS = {
    "acc": re.compile(r"(acc|accel|acceleration|accelerometer)(x|y|z)"),
    "gyr": re.compile(r"(gyr|gyro|gyroscope|angularvelocity|angularrate)(x|y|z)"),
    "mag": re.compile(r"(mag|magn|magnetometer|magneticfield)(x|y|z)"),
}
DEGREES = 0.017453292519943295
UNITS: dict[str, dict[str, float]] = {
    "time": {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9},
    "acc": {"": 1.0, "m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0, "ms-2": 1.0, "g": GRAVITY, "mg": 1e-3 * GRAVITY},
    "gyr": {
        "": 1.0, "rad/s": 1.0, "rads-1": 1.0, "deg/s": DEGREES, "°/s": DEGREES, "dps": DEGREES, "mdps": 1e-3 * DEGREES,
    },
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A column in our terms.

    Attributes:
        name: `time_s`, `acc_x` and so on.
        factor: of its numbers, to our units.
    """

    name: str
    factor: float


def of_shimmer(names: Sequence[str], units: Sequence[str]) -> list[str]:
    """Columns of Shimmer's and the units in the row below them, as names that are known; others as they are.

    Of two accelerometers it is the one of wide range: a wrist that moves is beyond the other.
    """
    found = [SHIMMER.fullmatch(name) for name in names]
    has_wide = any(match and match[1] == "accel_wr" for match in found)
    known = {"accel_wr": "acc", "accel_ln": "low noise" if has_wide else "acc", "gyro": "gyr", "mag": "mag"}
    plain = [re.sub(r"[()]", "", unit.lower()).replace("secs", "s").replace("sec", "s") for unit in units]
    return [
        name if match is None else f"{known.get(match[1], 'timestamp')} {match[2] or ''} ({unit})"
        for name, unit, match in zip(names, plain, found, strict=True)
    ]


def known_as(header: str) -> Column | None:
    """What a column of this name is; None where it is not known, or its unit is not."""
    found = UNIT.search(header)
    unit = "" if found is None else found[1].strip().lower().replace(" ", "")
    base = re.sub(r"[\s_.\-]+", "", UNIT.sub("", header).lower())
    if base in TIME:
        return _in_unit("time", "time_s", unit)
    for sensor, pattern in SENSORS.items():
        if match := pattern.fullmatch(base):
            return _in_unit(sensor, f"{sensor}_{match[2]}", unit)
    return None


def _in_unit(quantity: str, name: str, unit: str) -> Column | None:
    units = UNITS.get(quantity)
    # A magnetic field may be in any unit.
    if units is None:
        return Column(name, 1.0)
    return Column(name, units[unit]) if unit in units else None
