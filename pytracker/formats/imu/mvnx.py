"""MVNX, what Xsens MVN exports of its suit: the sensor of one segment, by its orientation and its acceleration.

Version 3 and 4. A sensor's acceleration is there without gravity and in the suit's world, z up: gravity is put back and
it is turned into the sensor. There is no turn rate of a sensor, only of a segment, which is left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.rotation import conjugate, rotate

__all__ = ["is_mvnx", "read_mvnx"]

LABELS = {
    "right_forearm": "RightForeArm",
    "left_forearm": "LeftForeArm",
    "right_upper_arm": "RightUpperArm",
    "left_upper_arm": "LeftUpperArm",
}
WHAT = {"sensorOrientation": 4, "sensorFreeAcceleration": 3}
"""Numbers a sensor."""


def is_mvnx(path: Path) -> bool:
    """Whether it is called so."""
    return path.suffix.lower() == ".mvnx"


def read_mvnx(path: Path, segment: str) -> ImuLog:
    """The sensor on `segment`, one of `LABELS`. Raises `InputError` naming frame and expectation."""
    if segment not in LABELS:
        raise InputError(f"{path}: segment is {segment!r}, expected one of: {', '.join(LABELS)}")
    sensors: list[str] = []
    rows: list[tuple[float, NDArray[np.float64]]] = []
    for element in _elements(path):
        if _name(element) == "sensor":
            sensors.append(str(element.get("label", "")))
        elif _name(element) == "frame":
            if element.get("type", "normal") == "normal":
                rows.append(_row(path, element, len(rows), sensors, segment))
            element.clear()
    if not rows:
        raise InputError(f"{path}: has no frame of type normal, expected a recording")
    time_s = np.array([time_s for time_s, _ in rows])
    values = np.stack([of for _, of in rows])
    q = np.ascontiguousarray(values[:, :4])
    force = rotate(conjugate(q), values[:, 4:] + np.array([0.0, 0.0, GRAVITY]))
    return ImuLog(path=path, lines=np.arange(1, len(rows) + 1), time_s=time_s, acc=np.asarray(force), q_world_sensor=q)


def _elements(path: Path) -> Iterator[ElementTree.Element]:
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        for _, element in ElementTree.iterparse(path):  # noqa: S314 - a file of the user's own
            yield element
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path}: is no MVNX: {error}") from None


def _name(element: ElementTree.Element) -> str:
    """Without its namespace."""
    return element.tag.rsplit("}", 1)[-1]


def _row(
    path: Path, frame: ElementTree.Element, number: int, sensors: list[str], segment: str
) -> tuple[float, NDArray[np.float64]]:
    """Time, s, and orientation and free acceleration of the segment's sensor `(7,)`."""
    label = LABELS[segment]
    if label not in sensors:
        there = ", ".join(sensors)[:200] or "none"
        raise InputError(f"{path}: its sensors are {there}, expected {label}, of the {segment}")
    at, found = sensors.index(label), []
    for name, width in WHAT.items():
        text = next((child.text for child in frame if _name(child) == name), None)
        if text is None:
            raise InputError(
                f"{path}: frame {number} has no {name}, expected it: export the file again with all its sensor data"
            )
        try:
            values = np.array(text.split(), dtype=np.float64)
        except ValueError:
            raise InputError(f"{path}: frame {number}: {name} holds {text[:60]!r}, expected numbers") from None
        if len(values) != width * len(sensors) or not np.isfinite(values).all():
            raise InputError(
                f"{path}: frame {number}: {name} holds {len(values)} numbers, expected {width} of each of "
                f"{len(sensors)} sensors, all finite"
            )
        found.append(values[width * at : width * (at + 1)])
    try:
        time_s = float(frame.get("time", "")) / 1000.0
    except ValueError:
        raise InputError(f"{path}: frame {number}: time is {frame.get('time')!r}, expected milliseconds") from None
    return time_s, np.concatenate(found)
