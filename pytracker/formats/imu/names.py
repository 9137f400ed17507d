"""What other loggers call the columns of an IMU's CSV, and in which units: phyphox, x-io, Sensor Logger, ROS, EuRoC.

A name is its quantity, its axis and, in brackets or behind the name, its unit: `Gyroscope x (rad/s)`, `acc_x[mg]`,
`time_ms`. A quaternion's numbers are known by their letters (`Quat_W`, `qx`, `orientation.z`); where they are numbered
(`q0` to `q3`) the first is taken for w, and that is said.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from pytracker.inertial.gravity import GRAVITY

__all__ = ["Column", "devices_of_shimmer", "known_as", "numbered_quaternion", "of_shimmer", "unit_in"]

SHIMMER = re.compile(
    r"(.*?)_?(accel_ln|accel_wr|gyro|mag|quat_madge_[69]dof|timestamp(?:sync)?(?:_(?:formatted)?unix)?)(?:_([wxyz]))?_cal"
)
"""Shimmer's: the device, the sensor, the axis; of two accelerometers the one of low noise and the one of wide range."""
NO_UNIT = re.compile(r"yyyy|no_?\s?units?$|n/a$|local$")
"""What Shimmer writes there of dates and of quaternions."""
UNIT = re.compile(r"[\(\[]([^\)\]]*)[\)\]]")
TIME = re.compile(
    r"(?:time|timestamp|t|elapsed|elapsedtime|epoch|(?:field)?headerstamp)(s|sec|ms|us|ns)?|(millis|micros)"
    r"|secondselapsed|timesincestartin(s|ms)"
)
"""With the unit at its end."""
BEHIND = {
    "g": "g", "mg": "mg", "ms2": "m/s2", "mps2": "m/s2", "m/s2": "m/s2", "m/s/s": "m/s2", "dps": "deg/s",
    "degs": "deg/s", "deg/s": "deg/s", "rads": "rad/s", "radps": "rad/s", "rps": "rad/s", "rad/s": "rad/s",
    "mdps": "mdps",
}  # fmt: skip
"""Units that stand behind an axis: `gx_dps`."""
THOUSANDTHS = ("mg", "milli-g", "millig", "mdps")
NAMED_UNITS = {"millis": "ms", "micros": "us"}
SENSORS = {
    "acc": re.compile(r"(?:a|acc|accel|acceleration|accelerometer|arss)([xyz])(?:axis)?"),
    "gyr": re.compile(
        r"(?:g|w|as|gyr|gyro|gyroscope|(?:field)?angularvelocity|angularrate|rotationrate|wrss)([xyz])(?:axis)?"
    ),
    "mag": re.compile(r"(?:m|mag|magn|magnetometer|magneticfield)([xyz])(?:axis)?"),
}
"""Such as `ax`, `gx`; WitMotion's `AsX`; EuRoC's `a_RS_S_x`, `w_RS_S_x`; ROS' `angular_velocity.x`; `x-axis` of a
sensor's own file."""
FIELD, FIELD_UNITS = re.compile(r"h([xyz])"), ("ut", "µt", "μt", "mg", "gauss", "nt")
"""A magnetic field's strength, as WitMotion calls it, where the unit says so: `Hz` is something else."""
OF_ROS = re.compile(r"(?:field\.)?linear_acceleration\.([xyz])")
"""With gravity in it. Written otherwise, linear acceleration is that without."""
G_FORCE = re.compile(r"gf(?:orce)?([xyz])")
"""Physics Toolbox's, in g; its `ax` is without gravity."""
QUATERNION = re.compile(r"(?:q|quat|quaternion|rotation|(?:field)?orientation)([wxyz])")
NUMBERED = re.compile(r"(?:q|quat|quaternion|ori|orientation)[ _.]?([0-4]) ?(?:\(\)|\[\])?")
DEGREES = 0.017453292519943295
UNITS: dict[str, dict[str, float]] = {
    "time": {
        "": 1.0, "s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "milliseconds": 1e-3,
        "us": 1e-6, "µs": 1e-6, "usec": 1e-6, "microseconds": 1e-6, "ns": 1e-9, "nanoseconds": 1e-9,
        "min": 60.0, "minutes": 60.0,
    },
    "q": {"": 1.0},
    "acc": {
        "": 1.0, "m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0, "ms-2": 1.0, "ms^-2": 1.0,
        "m/s/s": 1.0, "m/sec2": 1.0, "m/sec^2": 1.0, "m/s**2": 1.0, "mps2": 1.0,
        "g": GRAVITY, "gs": GRAVITY, "mg": 1e-3 * GRAVITY, "milli-g": 1e-3 * GRAVITY, "millig": 1e-3 * GRAVITY,
    },
    "gyr": {
        "": 1.0, "rad/s": 1.0, "rads-1": 1.0, "rads^-1": 1.0,
        "rad/sec": 1.0, "rps": 1.0, "deg/s": DEGREES, "deg/sec": DEGREES, "degrees/s": DEGREES, "degree/s": DEGREES,
        "d/s": DEGREES, "°/s": DEGREES, "°/sec": DEGREES, "dps": DEGREES, "mdps": 1e-3 * DEGREES,
    },
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A column in our terms.

    Attributes:
        name: `time_s`, `acc_x` and so on.
        factor: of its numbers, to our units.
        has_unit: whether its name says one.
    """

    name: str
    factor: float
    has_unit: bool = field(default=False, compare=False)


def devices_of_shimmer(names: Sequence[str]) -> tuple[str, ...]:
    """Those whose accelerometers, gyroscopes and the like the columns are; a clock may be all theirs."""
    found = [match for name in names if (match := SHIMMER.fullmatch(name)) and match[3]]
    return tuple(dict.fromkeys(match[1] for match in found))


def of_shimmer(names: Sequence[str], units: Sequence[str]) -> list[str]:
    """Columns of Shimmer's and the units in the row below them, as names that are known; others as they are.

    Of two accelerometers it is the one of wide range: a wrist that moves is beyond the other.
    """
    found = [SHIMMER.fullmatch(name) for name in names]
    has_wide = any(match and match[2] == "accel_wr" for match in found)
    has_heading = any(match and match[2] == "quat_madge_9dof" for match in found)
    known = {
        "accel_wr": "acc", "accel_ln": "low noise" if has_wide else "acc", "gyro": "gyr", "mag": "mag",
        "quat_madge_9dof": "quat", "quat_madge_6dof": "without heading" if has_heading else "quat",
    }  # fmt: skip
    # An asterisk says that the calibration was the maker's.
    plain = [re.sub(r"[()*]", "", unit.lower()).replace("secs", "s").replace("sec", "s") for unit in units]
    return [
        name
        if match is None
        else f"{known.get(match[2], 'timestamp')} {match[3] or ''}" + ("" if NO_UNIT.match(unit) else f" ({unit})")
        for name, unit, match in zip(names, plain, found, strict=True)
    ]


def known_as(header: str) -> Column | None:
    """What a column of this name is; None where it is not known, or its unit is not."""
    found = UNIT.search(header)
    unit = "" if found is None else found[1].strip().lower().replace(" ", "")
    words = UNIT.sub("", header).lower().strip('"#% ')
    if (
        not unit
        and (ending := re.fullmatch(r"(.*[\s_.]?[xyz])[\s_]([a-z0-9/°_]+)", words))
        and (behind := BEHIND.get(ending[2].replace("_", "")))
    ):
        words, unit = ending[1], behind
    base = re.sub(r"[\s_.\-/]+", "", words)
    if time := TIME.fullmatch(base):
        # Several times are not yet seconds.
        if base == "secondselapsed":
            return Column("time_s", 1.0, has_unit=True)
        said = "" if time[1] == "s" and not words.endswith(("_s", " s", ".s", "-s")) else time[1]
        return _in_unit("time", "time_s", unit or said or time[3] or NAMED_UNITS.get(time[2] or "", ""))
    if turn := QUATERNION.fullmatch(base):
        return _in_unit("q", f"q_{turn[1]}", unit)
    if force := G_FORCE.fullmatch(base):
        return Column(f"acc_{force[1]}", GRAVITY, has_unit=True)
    if of_ros := OF_ROS.fullmatch(words):
        return _in_unit("acc", f"acc_{of_ros[1]}", unit)
    if (field := FIELD.fullmatch(base)) and unit in FIELD_UNITS:
        return Column(f"mag_{field[1]}", 1.0)
    for sensor, pattern in SENSORS.items():
        if match := pattern.fullmatch(base):
            return _in_unit(sensor, f"{sensor}_{match[1]}", unit)
    return None


def numbered_quaternion(headers: Sequence[str]) -> list[str]:
    """The four columns that are numbered from 0 or from 1 as a quaternion's; none where it is not just these.

    Beside a column `q_w` the three others may be numbered.
    """
    found = {match[1]: header for header in headers if (match := NUMBERED.fullmatch(header))}
    numbers = "".join(sorted(found))
    first = ["q_w"] if "q_w" in headers and numbers == "123" else []
    return first + [found[number] for number in numbers] if first or numbers in ("0123", "1234") else []


def unit_in(header: str, ours: str) -> Column:
    """A column that is said to be `ours`, in the unit that its name says where no key of a recording can say it.

    Those are times, and thousandths: g and degrees are `acc_unit` and `gyr_unit`.
    """
    quantity, words = ours.split("_", maxsplit=1)[0], header.lower().strip('"# ')
    found = UNIT.findall(words)
    unit = (found[-1] if found else re.split(r"[\s,_]+", words)[-1]).strip().replace(" ", "")
    if quantity == "time" or unit in THOUSANDTHS:
        return _in_unit(quantity, ours, BEHIND.get(unit, unit)) or Column(ours, 1.0)
    return Column(ours, 1.0, has_unit=True)


def _in_unit(quantity: str, name: str, unit: str) -> Column | None:
    units = UNITS.get(quantity)
    # A magnetic field may be in any unit.
    if units is None:
        return Column(name, 1.0)
    return Column(name, units[unit], has_unit=bool(unit)) if unit in units else None
