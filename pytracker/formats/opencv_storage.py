"""Matrices of the YAML and XML files that OpenCV's FileStorage writes, and ROS with it."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pytracker._core import InputError
from pytracker.rotation import Array

__all__ = ["matrices_of"]

MATRIX = re.compile(
    r"^\s*(?P<name>\w+):\s*(!!opencv-matrix)?\s*\n\s*rows:\s*(?P<rows>\d+)\s*\n\s*cols:\s*(?P<cols>\d+)\s*\n"
    r"(\s*dt:\s*\S+\s*\n)?\s*data:\s*\[(?P<data>[^\]]*)\]",
    re.MULTILINE,
)
"""One in YAML."""


def matrices_of(path: Path, text: str) -> dict[str, Array]:
    """By name; none where the text holds none.

    Raises `InputError` where one has other numbers than rows times columns.
    """
    if text.lstrip().startswith("<"):
        found = {
            element.tag: _cells(element) for element in _root(path, text).iter() if element.find("data") is not None
        }
    else:
        found = {m["name"]: (m["rows"], m["cols"], m["data"].replace(",", " ")) for m in MATRIX.finditer(text)}
    return {name: _matrix(path, name, *cells) for name, cells in found.items()}


def _root(path: Path, text: str) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(text.encode())  # noqa: S314 - a file of the user's own
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"{path}: is no calibration: its XML is broken ({error})") from None


def _cells(element: ElementTree.Element) -> tuple[str, str, str]:
    rows, cols, data = (element.findtext(name) or "" for name in ("rows", "cols", "data"))
    return rows, cols, data


def _matrix(path: Path, name: str, rows: str, cols: str, data: str) -> Array:
    try:
        values = np.array([float(cell) for cell in data.split()])
        shape = int(rows), int(cols)
        if not np.isfinite(values).all():
            raise ValueError
        return values.reshape(shape)
    except ValueError:
        raise InputError(f"{path}: {name} is {data.strip()[:60]!r}, expected {rows} x {cols} numbers") from None
