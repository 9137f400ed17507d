"""MATLAB files (version 5 to 7), by SciPy (`pip install pytracker[mat]`): an IMU's samples, or measured points.

Arrays are told apart by their names, such as those of BROAD (Laidig et al. 2021): `imu_acc`, `imu_gyr`, `imu_mag`
`(M, 3)` in m/s², rad/s and any unit, `opt_pos` `(M, 3)` in m, `sampling_rate` in Hz.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.imu_log import ImuLog
from pytracker.formats.qualisys import Markers
from pytracker.rotation import Array

__all__ = ["is_mat", "read_mat_imu", "read_mat_points"]

HEADS = (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file")
NAMES = {
    "acc": ("imu_acc", "acc", "accelerometer", "acceleration"),
    "gyr": ("imu_gyr", "gyr", "gyro", "gyroscope"),
    "mag": ("imu_mag", "mag", "magnetometer"),
    "q_world_sensor": ("imu_quat", "quat", "quaternion", "orientation"),
}
"""What an IMU measures, by the names that it has."""
RATES = ("sampling_rate", "rate_hz", "fs", "rate")
TIMES = ("time_s", "time", "t")
WIDTHS = {"q_world_sensor": 4}


def is_mat(path: Path) -> bool:
    """Whether it begins as MATLAB's files do."""
    try:
        with path.open("rb") as file:
            return file.read(19) in HEADS
    except OSError:
        return False


def read_mat_imu(path: Path) -> ImuLog:
    """An IMU's samples. Raises `InputError`."""
    arrays = _arrays(path)
    found = {ours: _named(arrays, theirs) for ours, theirs in NAMES.items()}
    acc = found["acc"]
    if acc is None:
        raise InputError(f"{path}: has {_listed(arrays)}, expected imu_acc or acc, specific force (M, 3) in m/s²")
    for ours, values in found.items():
        if values is not None and values.shape != (len(acc), WIDTHS.get(ours, 3)):
            raise InputError(f"{path}: {ours} has shape {values.shape}, expected {(len(acc), WIDTHS.get(ours, 3))}")
    time_s, rate_hz = _times(path, arrays, len(acc))
    return ImuLog(
        path=path, lines=np.arange(1, len(acc) + 1), time_s=time_s, rate_hz=rate_hz,
        acc=acc, gyr=found["gyr"], mag=found["mag"], q_world_sensor=found["q_world_sensor"],
    )  # fmt: skip


def read_mat_points(path: Path) -> Markers:
    """Measured points, m: every array of three columns; rows without numbers were not seen. Raises `InputError`."""
    arrays = _arrays(path)
    measured = {name for names in NAMES.values() for name in names}
    points = {n: of for n, of in arrays.items() if of.ndim == 2 and of.shape[1] == 3 and n.lower() not in measured}
    if not points:
        raise InputError(f"{path}: has {_listed(arrays)}, expected points (M, 3) in m")
    count = max(len(values) for values in points.values())
    points = {name: values for name, values in points.items() if len(values) == count}
    time_s, rate_hz = _times(path, arrays, count)
    seen = {name: np.isfinite(of).all(axis=1).reshape(-1, 1) for name, of in points.items()}
    positions = {name: np.where(seen[name], of, np.nan) for name, of in points.items()}
    gaps = {name: int(np.isnan(rows[:, 0]).sum()) for name, rows in positions.items()}
    return Markers(time_s, positions, gaps, rate_hz)


def _arrays(path: Path) -> dict[str, Array]:
    """Every array of numbers, by name."""
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        from scipy.io import loadmat  # noqa: PLC0415 - an extra
        from scipy.io.matlab import MatReadError  # noqa: PLC0415
    except ImportError:
        raise InputError(f"{path}: reading MATLAB's files needs SciPy: pip install 'pytracker[mat]'") from None
    try:
        found = loadmat(path)
    except NotImplementedError:
        raise InputError(f"{path}: is a MATLAB 7.3 file, expected version 5 to 7: save it with -v7") from None
    except (OSError, ValueError, TypeError, KeyError, IndexError, OverflowError, MemoryError, MatReadError) as error:
        raise InputError(f"{path}: is no MATLAB file that can be read: {str(error)[:200]}") from None
    numbers = {name: values for name, values in found.items() if getattr(values, "dtype", np.dtype("O")).kind in "fiub"}
    return {name: np.asarray(values, dtype=np.float64) for name, values in numbers.items()}


def _named(arrays: dict[str, Array], names: tuple[str, ...]) -> Array | None:
    by_name = {name.lower(): values for name, values in arrays.items()}
    return next((np.ascontiguousarray(by_name[name]) for name in names if name in by_name), None)


def _times(path: Path, arrays: dict[str, Array], count: int) -> tuple[Array, float | None]:
    """As the file has them, or by its rate."""
    time_s, rate = _named(arrays, TIMES), _named(arrays, RATES)
    if time_s is not None and time_s.size == count:
        return time_s.ravel(), None
    if rate is None or rate.size != 1 or not 0 < float(rate.item()) < np.inf:
        raise InputError(f"{path}: has {_listed(arrays)}, expected sampling_rate in Hz, or time_s")
    return np.arange(count) / float(rate.item()), float(rate.item())


def _listed(arrays: dict[str, Array]) -> str:
    return ", ".join(f"{name} {values.shape}" for name, values in arrays.items())[:300] or "no arrays of numbers"
