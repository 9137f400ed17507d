"""An IMU's samples, or measured points, as arrays: in MATLAB's files (SciPy, the extra `mat`), or in HDF5 (h5py).

MATLAB's version 7.3 is HDF5. Arrays are told apart by their names, such as those of BROAD (Laidig et al. 2021):
`imu_acc`, `imu_gyr`, `imu_mag` `(M, 3)` in m/s², rad/s and any unit, `opt_pos` `(M, 3)` in m, `sampling_rate` in Hz.
"""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.hdf5 import is_hdf5, opened
from pytracker.formats.markers import Markers, without_fillers
from pytracker.inertial.log import ImuLog
from pytracker.rotation import Array

__all__ = ["is_mat", "read_mat_imu", "read_mat_points"]

HEAD_OF_HDF5 = b"MATLAB 7.3 MAT-file"
HEADS = (b"MATLAB 5.0 MAT-file", HEAD_OF_HDF5)
NAMES = {
    "acc": ("imu_acc", "acc", "accelerometer", "acceleration"),
    "gyr": ("imu_gyr", "gyr", "gyro", "gyroscope"),
    "mag": ("imu_mag", "mag", "magnetometer"),
    "q_world_sensor": ("imu_quat", "quat", "quaternion", "orientation"),
}
"""What an IMU measures, by the names that it has."""
RATES = ("sampling_rate", "rate_hz", "fs", "rate")
TIMES = ("time_s", "time", "t")
UNREADABLE = (
    NotImplementedError, OSError, ValueError, TypeError, KeyError, IndexError, OverflowError, MemoryError, zlib.error
)  # fmt: skip
"""What SciPy raises for bytes that are none of MATLAB's."""
WIDTHS = {"q_world_sensor": 4}
SLOWEST_HZ, FASTEST_HZ, OFF_RATE = 1.0, 1e5, 0.05
"""No sensor or laboratory is slower or faster; and a rate may be off by this share from the times."""


def is_mat(path: Path) -> bool:
    """Whether it begins as MATLAB's files do, or is HDF5 and holds what an IMU measures by the same names."""
    return _head(path) in HEADS or (is_hdf5(path) and _has_arrays(path))


def _has_arrays(path: Path) -> bool:
    try:
        with opened(path, "file of arrays") as file:
            return any(name.lower() in NAMES["acc"] for name in file)
    except InputError:  # which who reads it will say
        return False


def _head(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(len(HEAD_OF_HDF5))
    except OSError:
        return b""


def read_mat_imu(path: Path, rate_hz: float | None = None) -> ImuLog:
    """An IMU's samples; `rate_hz` where the file does not say it. Raises `InputError`."""
    arrays = _arrays(path)
    found = {ours: _named(arrays, theirs) for ours, theirs in NAMES.items()}
    acc = found["acc"]
    if acc is None:
        raise InputError(f"{path}: has {_listed(arrays)}, expected imu_acc or acc, specific force (M, 3) in m/s²")
    count = max(acc.shape)
    for ours, values in found.items():
        if values is not None and values.shape != (expected := (count, WIDTHS.get(ours, 3))):
            raise InputError(f"{path}: {ours} has shape {values.shape}, expected {expected}, a row a sample")
    time_s, rate_hz = _times(path, arrays, len(acc), rate_hz)
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
    if short := [name for name, values in points.items() if len(values) != count]:
        raise InputError(f"{path}: {short[0]} has {len(points[short[0]])} rows and others {count}, expected as many")
    time_s, rate_hz = _times(path, arrays, count)
    seen = {name: np.isfinite(of).all(axis=1).reshape(-1, 1) for name, of in points.items()}
    positions = {name: without_fillers(np.where(seen[name], of, np.nan)) for name, of in points.items()}
    return Markers(time_s, positions, rate_hz)


def _arrays(path: Path) -> dict[str, Array]:
    """Every array of numbers, by name."""
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if is_hdf5(path) or _head(path) == HEAD_OF_HDF5:
        return _of_hdf5(path)
    try:
        from scipy.io import loadmat  # noqa: PLC0415 - an extra
        from scipy.io.matlab import MatReadError  # noqa: PLC0415 - likewise
    except ImportError:
        raise InputError(f"{path}: reading MATLAB's files needs SciPy: pip install scipy") from None
    try:
        found = loadmat(path)
    except (*UNREADABLE, MatReadError) as error:
        raise InputError(f"{path}: is no MATLAB file that can be read: {str(error)[:200]}") from None
    numbers = {name: of for name, of in found.items() if isinstance(of, np.ndarray) and of.dtype.kind in "fiub"}
    measured = {name for names in NAMES.values() for name in names} | {*TIMES, *RATES}
    lost = [name for name in found if name.lower() in measured and name not in numbers]
    if lost:
        raise InputError(f"{path}: {lost[0]} is no plain array of real numbers, expected one")
    return {name: np.asarray(values, dtype=np.float64) for name, values in numbers.items()}


def _of_hdf5(path: Path) -> dict[str, Array]:
    """Its arrays and attributes that are numbers, by name; MATLAB's are written column by column."""
    with opened(path, "file of arrays") as file:
        found = {}
        for name, of in (*file.items(), *file.attrs.items()):
            values = np.asarray(of) if np.isscalar(of) or hasattr(of, "dtype") else None
            if values is not None and values.dtype.kind in "fiub":
                is_turned = "MATLAB_class" in getattr(of, "attrs", ())
                found[name] = np.asarray(values.T if is_turned else values, dtype=np.float64)
        return found


def _named(arrays: dict[str, Array], names: tuple[str, ...]) -> Array | None:
    by_name = {name.lower(): values for name, values in arrays.items()}
    return next((np.ascontiguousarray(by_name[name]) for name in names if name in by_name), None)


def _times(
    path: Path, arrays: dict[str, Array], count: int, given_hz: float | None = None
) -> tuple[Array, float | None]:
    """As the file has them, or by its rate, or by the one that is given."""
    time_s, rate = _named(arrays, TIMES), _named(arrays, RATES)
    rate_hz = given_hz if rate is None or rate.size != 1 else float(rate.item())
    if rate_hz is not None and not SLOWEST_HZ <= rate_hz <= FASTEST_HZ:
        raise InputError(f"{path}: its rate is {rate_hz:g} Hz, expected {SLOWEST_HZ:g} to {FASTEST_HZ:g} Hz")
    if time_s is None:
        if rate_hz is None:
            raise InputError(f"{path}: has {_listed(arrays)}, expected sampling_rate in Hz, or time_s")
        return np.arange(count) / rate_hz, rate_hz
    time_s = time_s.ravel()
    if len(time_s) != count:
        raise InputError(f"{path}: has {len(time_s)} times for {count} rows, expected one each")
    if not np.isfinite(time_s).all() or not (np.diff(time_s) > 0).all():
        raise InputError(f"{path}: its times do not increase all along, expected finite seconds that do")
    if count > 1 and rate_hz is not None and abs(float(np.median(np.diff(time_s))) * rate_hz - 1.0) > OFF_RATE:
        usual_hz = 1.0 / float(np.median(np.diff(time_s)))
        raise InputError(f"{path}: says {rate_hz:g} Hz and has times at {usual_hz:.4g} Hz, expected them to agree")
    return time_s, rate_hz


def _listed(arrays: dict[str, Array]) -> str:
    return ", ".join(f"{name} {values.shape}" for name, values in arrays.items())[:300] or "no arrays of numbers"
