"""APDM's HDF5 (Opal; Moveo, Mobility Lab; file format 5), by h5py (the extra `apdm`): one of its sensors.

`/Sensors/<id>` holds `Accelerometer` (m/s²), `Gyroscope` (rad/s), `Magnetometer` and `Time` (µs since 1970), its
`Configuration` where it was worn, `/Processed/<id>/Orientation` the sensor's, w first, where it was computed.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError
from pytracker.formats.hdf5 import opened
from pytracker.inertial.log import ImuLog
from pytracker.rotation import Array

__all__ = ["read_apdm"]

SIDES = {"l": "left", "r": "right"}
"""What a letter of its own stands for in a label."""
WORN = {"forearm": ("forearm", "wrist", "lower arm"), "upper_arm": ("upper arm",)}
"""What APDM calls where a sensor is worn, in small letters, after the side."""


def read_apdm(path: Path, segment: str) -> ImuLog:
    """The sensor that is worn on `segment`, or the only one. Raises `InputError`."""
    with opened(path, "file of APDM's") as file:
        return _read(path, file, segment)


def _read(path: Path, file: Any, segment: str) -> ImuLog:
    if "Sensors" not in file:
        raise InputError(f"{path}: holds {', '.join(file)[:200] or 'nothing'}, expected /Sensors, APDM's format 5")
    labels = {name: _label(group) for name, group in file["Sensors"].items()}
    name, said = _chosen(path, labels, segment)
    group = file["Sensors"][name]
    acc = _array(path, group, "Accelerometer", 3)
    if acc is None:
        raise InputError(f"{path}: /Sensors/{name} holds {', '.join(group)[:200]}, expected Accelerometer")
    ticks = np.asarray(group["Time"]).astype(np.int64).ravel()
    processed = file.get(f"Processed/{name}")
    found = {
        "gyr": _array(path, group, "Gyroscope", 3),
        "mag": _array(path, group, "Magnetometer", 3),
        "q_world_sensor": None if processed is None else _array(path, processed, "Orientation", 4),
    }
    for what, values in (("Time", ticks), *found.items()):
        if values is not None and len(values) != len(acc):
            raise InputError(f"{path}: /Sensors/{name} has {len(values)} rows of {what}, expected {len(acc)}")
    time_s = (ticks - ticks[:1]) / 1e6  # before they are no whole numbers any more
    return ImuLog(
        path=path, lines=np.arange(1, len(acc) + 1), time_s=time_s,
        acc=acc, gyr=found["gyr"], mag=found["mag"], q_world_sensor=found["q_world_sensor"], warnings=said,
    )  # fmt: skip


def _label(group: Any) -> str:
    """Where a sensor is worn, as its configuration says; empty where it does not."""
    configuration = group.get("Configuration")
    labels = [] if configuration is None else [configuration.attrs.get(f"Label {k}", "") for k in range(3)]
    words = [label.decode("utf-8", "replace") if isinstance(label, bytes) else str(label) for label in labels]
    return ", ".join(filter(None, (word.strip("\0 ") for word in words)))


def _chosen(path: Path, labels: dict[str, str], segment: str) -> tuple[str, tuple[str, ...]]:
    """The sensor on a segment, or the only one; a word where that one says that it is worn elsewhere."""
    side, _, place = segment.partition("_")
    if side not in ("left", "right") or place not in WORN:
        raise InputError(f"{path}: segment is {segment!r}, expected a side's forearm or upper arm: right_forearm, ...")
    sided = {name: re.sub(r"\b([lr])\b", lambda short: SIDES[short[1]], of.lower()) for name, of in labels.items()}
    fitting = [name for name, label in sided.items() if side in label and any(worn in label for worn in WORN[place])]
    if len(fitting) == 1:
        return fitting[0], ()
    if not fitting and len(labels) == 1:
        ((name, label),) = labels.items()
        words = f"{path}: its only sensor says it is worn at {label!r}, and is taken for the {_in_words(segment)}'s"
        return name, (words,) if label else ()
    there = ", ".join(f"{name} ({label or 'nowhere'})" for name, label in labels.items())[:300] or "none"
    raise InputError(f"{path}: its sensors are {there}, expected one on the {_in_words(segment)}")


def _in_words(segment: str) -> str:
    return segment.replace("_", " ")


def _array(path: Path, group: Any, name: str, width: int) -> Array | None:
    if name not in group:
        return None
    values = np.asarray(group[name], dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != width:
        raise InputError(f"{path}: {group.name}/{name} has shape {values.shape}, expected (M, {width})")
    return np.ascontiguousarray(values)
