"""Any IMU file to one kind of log, with orientation.

| format | file | reader |
|---|---|---|
| csv | plain CSV with a header (design of the recording folder) | `imu_csv` |
| mt-manager | Xsens MT Manager's or DOT's text export, any columns and delimiter | `mt_manager` |
| mt9-log | Xsens MT9 software logs, acceleration and orientation in two files | `mt9_log` |
| mat | MATLAB, such as BROAD's | `mat` |
| mvnx | Xsens MVN's suit, the sensor of one segment | `mvnx` |
| apdm | APDM's HDF5, the sensor of one segment | `apdm` |
| phone | a phone's or a watch's: a folder with a CSV a sensor, or Core Motion in one | `imu_phone` |
"""

from __future__ import annotations

import dataclasses
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats import imu_csv, mt9_log, mt_manager
from pytracker.formats.apdm import is_hdf5, read_apdm
from pytracker.formats.imu_bias import BY_GRAVITY, bias_at_rest, bias_by_gravity
from pytracker.formats.imu_gravity import WINDOW_S, check_up, check_windows, unsteadiness
from pytracker.formats.imu_log import ImuLog
from pytracker.formats.imu_phone import files_of_phone, is_motion, read_motion, read_phone
from pytracker.formats.mat import is_mat, read_mat_imu
from pytracker.formats.mvnx import is_mvnx, read_mvnx
from pytracker.formats.text import read_lines
from pytracker.formats.ximu3 import files_of_ximu3, is_ximu3, read_ximu3

__all__ = ["FORMATS", "files_of_imu", "holds_several", "orient", "read_imu"]

Float = NDArray[np.float64]

MOST_STEPS = 4
"""Steps of VQF for every sample, at the most."""
BRIDGED_S = 1.0
"""Nobody knows how a sensor turned in a longer gap."""
BIASED = 0.05
"""A gyroscope at rest that reads more is worth a word, rad/s."""
OTHER_GYROSCOPES: dict[str, Float] = {
    "it is in degrees per second": np.full(3, np.pi / 180),
    "it is 57 times as much, which is the other way round": np.full(3, 180 / np.pi),
    "its x has the other sign": np.array([-1.0, 1.0, 1.0]),
    "its y has the other sign": np.array([1.0, -1.0, 1.0]),
    "its z has the other sign": np.array([1.0, 1.0, -1.0]),
}
LEAST_UNSTEADY = 0.25
"""Gravity that is as steady tells of no fault, m/s²: a sensor that lies still has less, whatever its gyroscope."""
BIASED_UNSTEADY = 0.6
"""A bias that matters leaves gravity no steadier than this, m/s²."""
STEADIER = 0.4
"""Another gyroscope must leave gravity this much steadier."""

WITHOUT_LINES: Mapping[str, Callable[[Path], bool]] = {"mvnx": is_mvnx, "mat": is_mat, "apdm": is_hdf5}
"""What is told otherwise than by its lines, and how."""
FORMATS = ("auto", "csv", "mt-manager", "mt9-log", "mat", "mvnx", "apdm", "phone", "x-imu3")


def read_imu(
    path: Path,
    *,
    orientation_file: Path | None = None,
    form: str = "auto",
    rate_hz: float | None = None,
    columns: Mapping[str, str] | None = None,
    segment: str = "right_forearm",
) -> ImuLog:
    """Read an IMU file of any known format.

    `segment` says whose sensor of a file that holds several, `rate_hz` is for exports that do not say theirs, `columns`
    for a CSV whose names are not known.

    Raises `InputError` naming file, line, value and expectation. Nothing is judged yet: see `check`.
    """
    if form not in FORMATS:
        raise InputError(f"IMU format is {form!r}, expected one of: {', '.join(FORMATS)}")
    form, lines = _told_by_content(path) if form == "auto" else (form, _lines(path, form))
    if columns and form != "csv":
        raise InputError(f"{path}: columns go with format csv, but this is {form}")
    if orientation_file is not None and form != "mt9-log":
        raise InputError(f"{path}: orientation_file goes with format mt9-log, but this is {form}")
    readers: dict[str, Callable[[], ImuLog]] = {
        "csv": lambda: imu_csv.read(path, lines, columns, rate_hz),
        "mt-manager": lambda: mt_manager.read(path, lines, rate_hz),
        "mt9-log": lambda: mt9_log.read(path, lines, orientation_file),
        "mat": lambda: read_mat_imu(path, rate_hz),
        "mvnx": lambda: read_mvnx(path, segment),
        "apdm": lambda: read_apdm(path, segment),
        "phone": lambda: read_phone(path) if path.is_dir() else read_motion(path, lines),
        "x-imu3": lambda: read_ximu3(path),
    }
    log = readers[form]()
    return log if rate_hz is None else dataclasses.replace(log, rate_hz=rate_hz)


def _told_by_content(path: Path) -> tuple[str, list[str]]:
    """The format, and the lines of one that has some."""
    if path.is_dir():
        return "x-imu3" if is_ximu3(path) else "phone", []
    for form, is_such in WITHOUT_LINES.items():
        if is_such(path):
            return form, []
    if zipfile.is_zipfile(path):
        raise InputError(f"{path}: is a ZIP or a workbook, expected what it unpacks to: a phone's folder, or a CSV")
    lines = read_lines(path)
    return _recognise(path, lines), lines


def _lines(path: Path, form: str) -> list[str]:
    return [] if form in WITHOUT_LINES or path.is_dir() else read_lines(path)


def _recognise(path: Path, lines: list[str]) -> str:
    first = next(line for line in lines if line.strip())
    if first.startswith("//") or any("PacketCounter" in line for line in lines[: mt_manager.HEADER_WITHIN]):
        return "mt-manager"
    if is_motion(lines):
        return "phone"
    words = first.replace(",", " ").replace(";", " ").split()
    try:
        [float(word) for word in words]
    except ValueError:
        return "csv"
    if "\t" in first:
        return "mt9-log"
    raise InputError(
        f"{path}:1: begins with numbers ({first[:40]!r}) but is not tab-separated like an MT9 log, "
        "expected a header such as time_s,acc_x,acc_y,acc_z,q_w,q_x,q_y,q_z"
    )


def files_of_imu(path: Path) -> list[Path]:
    """What is read of it: the file, or the CSV files of a phone's or an x-IMU3's folder."""
    if not path.is_dir():
        return [path]
    return list((files_of_ximu3(path) if is_ximu3(path) else files_of_phone(path)).values())


def holds_several(path: Path) -> bool:
    """Whether one file has the sensors of several segments."""
    return is_mvnx(path) or is_hdf5(path)


def orient(log: ImuLog) -> ImuLog:
    """Fill in a missing orientation by VQF (Laidig & Seel 2023).

    From gyroscope, acceleration and, where there is one, the magnetometer. Raises `InputError` without a gyroscope, or
    where what comes of it contradicts gravity.
    """
    if log.q_world_sensor is not None:
        return log
    if log.gyr is None or log.acc is None:
        raise InputError(
            f"{log.path}: has neither orientation nor a gyroscope, expected q_w, q_x, q_y, q_z or gyr_x, gyr_y, gyr_z"
        )

    bias, told_by = _bias(log)
    mag = None if log.mag is None or not np.isfinite(log.mag).all() else log.mag
    q = _by_vqf(log, log.gyr - bias, mag)
    heading = (
        "there is no magnetometer, so the heading is arbitrary: set heading_deg"
        if mag is None
        else "its heading is magnetic north along +y (ENU): set heading_deg to turn it to the world"
    )
    warning = f"{log.path}: has no orientation; computed from its gyroscope by VQF; {heading}"
    if np.linalg.norm(bias) > BIASED:
        warning += f". {told_by} {np.round(bias, 3).tolist()} rad/s, which is taken off"
    if mag is None and (longest_s := float(np.diff(log.time_s).max())) > BRIDGED_S:
        warning += f". Over its longest gap, {longest_s:.3g} s, the heading is taken to have stayed"
    oriented = dataclasses.replace(log, q_world_sensor=q, warnings=(*log.warnings, warning))
    _check_gyroscope(oriented, bias)
    up = check_up(oriented, "computed from the gyroscope: is gyr in rad/s, and in the axes of acc?")
    return dataclasses.replace(oriented, warnings=(*oriented.warnings, *(up or check_windows(oriented))))


def _bias(log: ImuLog) -> tuple[Float, str]:
    """Of the gyroscope `(3,)`, rad/s, and in words what tells it."""
    assert log.gyr is not None
    still = bias_at_rest(log)
    if still is not None:
        return still, "At rest the gyroscope reads"
    moving = bias_by_gravity(log)
    if np.linalg.norm(moving) < BY_GRAVITY:
        return np.zeros(3), ""
    without, beside = (
        unsteadiness(dataclasses.replace(log, q_world_sensor=_by_vqf(log, log.gyr - bias, None)))
        for bias in (np.zeros(3), moving)
    )
    if without < BIASED_UNSTEADY or beside > STEADIER * without:
        return np.zeros(3), ""
    return moving, "The sensor never lies still, and gravity stays where it is if the gyroscope is biased by"


def _by_vqf(log: ImuLog, gyr: Float, mag: Float | None) -> Float:
    """Orientation of every sample `(M, 4)`.

    VQF wants a steady rate: gaps are bridged, each sample takes its nearest. Over longer ones than `BRIDGED_S`, as if
    they lasted that, nothing turns.
    """
    import vqf  # noqa: PLC0415 - only recordings without orientation pay for it

    assert log.acc is not None
    steps = np.diff(log.time_s)
    time_s = np.concatenate([[0.0], np.cumsum(np.minimum(steps, BRIDGED_S))])
    # Where samples come in bursts, their usual distance is none that a recording could be cut into.
    interval = max(float(np.median(steps)), time_s[-1] / (MOST_STEPS * len(time_s)))
    grid = np.arange(round(time_s[-1] / interval) + 1) * interval

    def steady(values: Float) -> Float:
        return np.stack([np.interp(grid, time_s, values[:, d]) for d in range(3)], axis=1)

    turning = steady(gyr)
    for k in np.flatnonzero(steps > BRIDGED_S):
        turning[(grid > time_s[k]) & (grid < time_s[k + 1])] = 0.0
    out = vqf.offlineVQF(turning, steady(log.acc), None if mag is None else steady(mag), interval)
    q = out["quat6D"] if mag is None else out["quat9D"]
    nearest = np.clip(np.rint(time_s / interval).astype(int), 0, len(grid) - 1)
    return np.asarray(q[nearest])


def _check_gyroscope(log: ImuLog, bias: Float) -> None:
    """With its unit, and the signs of its axes, gravity is steadier than with others. Raises `InputError`."""
    assert log.gyr is not None
    off = unsteadiness(log)
    if off < LEAST_UNSTEADY:
        return
    for words, factor in OTHER_GYROSCOPES.items():
        other = dataclasses.replace(log, q_world_sensor=_by_vqf(log, (log.gyr - bias) * factor, None))
        if unsteadiness(other) < STEADIER * off:
            raise InputError(
                f"{log.path}: turned by the orientation, the mean acceleration is {off:.2f} m/s² from gravity "
                "(median of "
                f"{WINDOW_S:g} s), and {unsteadiness(other):.2f} if {words}; computed from the gyroscope: is "
                "gyr in rad/s, "
                "and in the axes of acc?"
            )
