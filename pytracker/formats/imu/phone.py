"""Phones and watches: a folder with a CSV for every sensor (Sensor Logger, phyphox), or a watch's motion in one file.

Every sensor ticks on its own: turn rate and magnetic field are interpolated at the accelerometer's times.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.imu.clock import unit_of
from pytracker.formats.imu.core_motion import read_motion
from pytracker.formats.imu.names import known_as
from pytracker.formats.imu.stream import Stream
from pytracker.formats.imu.table import Header, header_of
from pytracker.formats.text import Table, cells_of, parse_table, read_lines
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog

__all__ = ["files_of_phone", "read_phone"]

Float = NDArray[np.float64]

TOTAL = ("totalacceleration",)
LINEAR = ("accelerometer", "acceleration", "accelerationwithg")
OF_GRAVITY = ("gravity",)
GYROSCOPE = ("gyroscope", "gyroscoperotationrate", "gyro")
MAGNETOMETER = ("magnetometer", "magneticfield")
WATCH = "wristmotion"
METADATA = "metadata"
FILES = {WATCH, METADATA, *TOTAL, *LINEAR, *OF_GRAVITY, *GYROSCOPE, *MAGNETOMETER}
PHYPHOX = "meta"
"""The folder in which phyphox says of itself; it counts as Android does on any phone."""
LEAST_GRAVITY = 0.5
"""Of the usual, in the median: less is none, or is in g."""
EPOCH = "epoch"
"""A time of the day, beside one that is counted from the start."""
CUT_S = 1.0
"""Sensors begin and end so far apart without a word."""


def files_of_phone(folder: Path) -> dict[str, Path]:
    """What a phone's folder has that is read, by name in small letters. Raises `InputError` for two of one name."""
    found: dict[str, Path] = {}
    for path in sorted(folder.glob("[!.]*.[cC][sS][vV]")):
        name = _sensor_of(path.stem)
        if name in found:
            raise InputError(f"{folder}: has {found[name].name} and {path.name}, expected one of them: one recording")
        if name in FILES:
            found[name] = path
    return found


def _sensor_of(stem: str) -> str:
    """What a file's name says: `Gyroscope`, or MetaWear's `MetaWear_2024-05-01_C8_Gyroscope_100.000Hz_1.7.2`."""
    plain = re.sub("[^a-z]", "", stem.lower())
    words = [word for word in stem.lower().split("_") if word in FILES]
    return words[0] if plain not in FILES and len(words) == 1 else plain


def read_phone(folder: Path) -> ImuLog:
    """A folder as Sensor Logger and phyphox export it. Raises `InputError`."""
    files = files_of_phone(folder)
    of = _platform(files.get(METADATA))
    if WATCH in files:
        log = read_motion(files[WATCH], read_lines(files[WATCH]))
        words = f"{folder.name} holds a watch's motion and a phone's: the watch's is taken, WristMotion.csv"
        has_phone = any(name in files for name in (*TOTAL, *LINEAR, *GYROSCOPE))
        return replace(log, warnings=(words,) if has_phone else ())
    acc = _acceleration(folder, files)
    sign = -1.0 if of.is_apple and not of.is_standard else 1.0
    warnings = []
    is_app = any(_sensor_of(path.stem) == re.sub("[^a-z]", "", path.stem.lower()) for path in files.values())
    if is_app and not (of.is_known or (folder / PHYPHOX).is_dir() or any(name in files for name in TOTAL)):
        warnings.append(
            f"{folder.name} has no Metadata.csv that says which phone it was: acceleration is taken to be up at rest, "
            "as Android counts it; Sensor Logger on an iPhone counts it the other way round, unless it is told to "
            "standardise frames"
        )
    others = (_found(files, GYROSCOPE, "gyr"), _found(files, MAGNETOMETER, "mag"))
    gyr, mag = (None if stream is None else stream.beside(acc) for stream in others)
    unread = {path.name for path in folder.glob("[!.]*.[cC][sS][vV]")} - {path.name for path in files.values()}
    return replace(_together(acc, sign, gyr, mag, tuple(warnings)), unread=tuple(sorted(unread)))


@dataclass(frozen=True)
class Platform:
    """Which phone it was, and whether the app turned its signs to Android's."""

    is_known: bool = False
    is_apple: bool = False
    is_standard: bool = False


def _platform(file: Path | None) -> Platform:
    """As Sensor Logger's Metadata.csv says."""
    try:
        rows = list(csv.reader(read_lines(file)[:2])) if file is not None else []
    except csv.Error as error:
        raise InputError(f"{file}: is no table: {error}") from None
    if len(rows) < 2:
        return Platform()
    said = {name.strip().lower(): value.strip().lower() for name, value in zip(*rows, strict=False)}
    platform = said.get("platform", "")
    return Platform(platform in ("ios", "android"), platform == "ios", said.get("standardisation", "") == "true")


def _acceleration(folder: Path, files: dict[str, Path]) -> Stream:
    """With gravity in it: as it is, or put together. Raises `InputError`."""
    if (total := _found(files, TOTAL, "acc")) is not None:
        return total
    acc, gravity = _found(files, LINEAR, "acc"), _found(files, OF_GRAVITY, "acc")
    if acc is None:
        there = ", ".join(sorted(path.name for path in folder.glob("*.csv"))[:6]) or "no CSV file"
        raise InputError(
            f"{folder}: a folder with {there}, expected a phone's: Accelerometer.csv and Gyroscope.csv, with "
            "TotalAcceleration.csv or Gravity.csv of Sensor Logger; or WristMotion.csv of a watch"
        )
    length = float(np.median(np.linalg.norm(acc.values, axis=1)))
    if gravity is None and length > LEAST_GRAVITY * GRAVITY:
        return acc
    if gravity is None:
        raise InputError(
            f"{acc.path}: acceleration is {length:.2f} m/s² in the median, expected about {GRAVITY:.1f}: gravity is "
            "not in it; expected TotalAcceleration.csv or Gravity.csv beside it"
        )
    gravity = gravity.beside(acc)
    covered = gravity.covers(acc.time_s)
    if covered.sum() < 2:
        raise InputError(f"{folder}: its sensors do not overlap ({_spans(acc, gravity)}), expected one recording")
    down = gravity.at(acc.time_s)
    # A lively arm's acceleration is as long as gravity too, but not along it.
    along = (acc.values * down).sum(axis=1) / np.maximum(np.linalg.norm(down, axis=1), 1e-9)
    if float(np.median(along)) > LEAST_GRAVITY * GRAVITY:
        return acc
    values = acc.values + down
    return Stream(acc.path, acc.lines[covered], acc.time_s[covered], values[covered], acc.began_s)


def _spans(*streams: Stream) -> str:
    return "; ".join(f"{s.path.name} {s.time_s[0]:.2f} to {s.time_s[-1]:.2f} s" for s in streams)


def _found(files: dict[str, Path], called: tuple[str, ...], sensor: str) -> Stream | None:
    """The first file of one of these names, read as a `sensor`. Raises `InputError`."""
    path = next((files[name] for name in called if name in files), None)
    if path is None:
        return None
    header = header_of(read_lines(path))
    names, factors = _named(header, sensor)
    axes = tuple(f"{sensor}_{axis}" for axis in "xyz")
    if missing := [name for name in ("time_s", *axes) if name not in names]:
        raise InputError(
            f"{path}:{header.first}: header has no column {', '.join(missing)} (it has {', '.join(header.names)[:99]}),"
            " expected seconds_elapsed or Time (s), and x, y, z"
        )
    table = parse_table(path, header.lines, header.first, names, header.delimiter, {"time_s", EPOCH, *axes})
    time_s, values = table.columns("time_s"), table.columns(*axes)
    assert time_s is not None
    assert values is not None
    time_s *= factors["time_s"] or unit_of(time_s[:, 0])[1]
    began_s = _began_s(table, time_s[:, 0], factors[EPOCH]) if EPOCH in names else np.nan
    if (back := np.flatnonzero(~(np.diff(time_s[:, 0]) >= 0))).size:
        line = int(table.lines[back[0] + 1])
        raise InputError(f"{path}:{line}: time goes back to {time_s[back[0] + 1, 0]} s, expected increasing times")
    # A row without a value is none.
    has = np.isfinite(values).all(axis=1)
    if not has.any():
        raise InputError(f"{path}: none of its {len(values)} rows has x, y and z, expected a sensor's values")
    values = values[has] * np.array([factors[name] for name in axes])
    return Stream(path, table.lines[has], time_s[has, 0], values, began_s)


def _began_s(table: Table, elapsed_s: Float, unit_s: float) -> float:
    """When a clock that counts from the start began, by the one of the day beside it, s; `unit_s` is 0 if not said."""
    epoch = table.columns(EPOCH)
    assert epoch is not None
    return float(np.median(epoch[:, 0] * (unit_s or unit_of(epoch[:, 0])[1]) - elapsed_s))


def _is_number(header: Header, column: int) -> bool:
    """Whether the first row has one there: a clock of the day may be words."""
    first = cells_of(header.lines[header.first], header.delimiter) if header.first < len(header.lines) else []
    return column < len(first) and re.fullmatch(r"\s*[\d.]+\s*", first[column]) is not None


def _named(header: Header, sensor: str) -> tuple[list[str], dict[str, float]]:
    """Columns in our terms, and the factors of their units; 0 of a clock that does not say its own.

    Sensor Logger's `time` is in nanoseconds. Beside a time that is counted from the start one of the day is `EPOCH`.
    """
    names, factors = list(header.names), {}
    for k in sorted(range(len(names)), key=lambda k: "elapsed" not in header.names[k]):
        column = known_as(header.names[k]) or known_as(f"{sensor} {header.names[k]}")
        is_second = column is not None and column.name == "time_s" and "time_s" in factors and EPOCH not in names
        if column is not None and is_second and _is_number(header, k):
            names[k], factors[EPOCH] = EPOCH, column.factor if column.has_unit else 0.0
        if column is not None and column.name not in factors:
            is_told = column.has_unit or column.name != "time_s"
            names[k], factors[column.name] = column.name, column.factor if is_told else 0.0
    return names, factors


def _together(acc: Stream, sign: float, gyr: Stream | None, mag: Stream | None, warnings: tuple[str, ...]) -> ImuLog:
    """At the accelerometer's times, as far as the gyroscope goes. Raises `InputError`."""
    said = []
    if mag is not None and (mag.time_s[0] > acc.time_s[0] + CUT_S or mag.time_s[-1] < acc.time_s[-1] - CUT_S):
        said.append(
            f"{mag.path.name} goes from {mag.time_s[0]:.2f} to {mag.time_s[-1]:.2f} s only: it is left out, and the "
            "heading is arbitrary"
        )
        mag = None
    others = [stream for stream in (gyr, mag) if stream is not None]
    first, last = max(s.time_s[0] for s in (acc, *others)), min(s.time_s[-1] for s in (acc, *others))
    # Twice the same time says nothing twice.
    kept = (acc.time_s >= first) & (acc.time_s <= last) & np.append(True, np.diff(acc.time_s) > 0)
    if kept.sum() < 2:
        raise InputError(
            f"{acc.path.parent}: its sensors do not overlap ({_spans(acc, *others)}), expected one recording"
        )
    time_s = acc.time_s[kept]
    if (cut_s := float(np.ptp(acc.time_s) - np.ptp(time_s))) > 2 * CUT_S:
        said.append(f"{acc.path.parent.name}: {cut_s:.2f} s are left out, where not every sensor says something")
    heard = np.ones(len(time_s), dtype=bool) if gyr is None else gyr.covers(time_s)
    if gyr is not None and not heard.all():
        said.append(
            f"{gyr.path.name} says nothing for {float(np.diff(gyr.time_s).max()):.2f} s: {int((~heard).sum())} of "
            f"{len(time_s)} samples of {acc.path.name}, where it is silent for long, are left out"
        )
    if mag is not None and not mag.covers(time_s).all():
        longest_s = float(np.diff(mag.time_s).max())
        said.append(f"{mag.path.name} says nothing for {longest_s:.2f} s: what is between is interpolated")
    log = ImuLog(
        path=acc.path,
        lines=acc.lines[kept],
        time_s=time_s,
        acc=sign * acc.values[kept],
        gyr=None if gyr is None else gyr.at(time_s),
        mag=None if mag is None else mag.at(time_s),
        warnings=(*warnings, *said),
    )
    return log.kept(heard)
