"""Any IMU file to one kind of log.

| format | file | reader |
|---|---|---|
| csv | plain CSV with a header (design of the recording folder) | `table` |
| mt-manager | Xsens MT Manager's or DOT's text export, any columns and delimiter | `mt_manager` |
| mt9-log | Xsens MT9 software logs, acceleration and orientation in two files | `mt9_log` |
| mat | MATLAB or arrays in HDF5, such as BROAD's | `mat` |
| mvnx | Xsens MVN's suit, the sensor of one segment | `mvnx` |
| apdm | APDM's HDF5, the sensor of one segment | `apdm` |
| x-imu3 | x-io's x-IMU3: a folder with a CSV a kind of message | `ximu3` |
| phone | a phone's or a watch's: a folder with a CSV a sensor, or Core Motion in one | `phone` |
"""

from __future__ import annotations

import dataclasses
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal, get_args

from pytracker._core import InputError
from pytracker.formats.hdf5 import is_hdf5
from pytracker.formats.imu import mt9_log, mt_manager, table
from pytracker.formats.imu.apdm import read_apdm
from pytracker.formats.imu.core_motion import is_motion, read_motion
from pytracker.formats.imu.mvnx import is_mvnx, read_mvnx
from pytracker.formats.imu.phone import files_of_phone, read_phone
from pytracker.formats.imu.ximu3 import files_of_ximu3, is_ximu3, read_ximu3
from pytracker.formats.mat import is_mat, read_mat_imu
from pytracker.formats.text import read_lines
from pytracker.inertial.log import ImuLog

__all__ = ["FORMATS", "ImuFormat", "files_of_imu", "holds_several", "read_imu"]

WITHOUT_LINES: Mapping[str, Callable[[Path], bool]] = {"mvnx": is_mvnx, "mat": is_mat, "apdm": is_hdf5}
"""What is told otherwise than by its lines, and how."""
ImuFormat = Literal["auto", "csv", "mt-manager", "mt9-log", "mat", "mvnx", "apdm", "phone", "x-imu3"]
FORMATS: tuple[str, ...] = get_args(ImuFormat)


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
        "csv": lambda: table.read(path, lines, columns, rate_hz),
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
    if path.suffix.lower() == ".ximu3":
        raise InputError(f"{path}: is an x-IMU3's own log, expected what its GUI converts it to: a folder of CSVs")
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
