"""Matrices of the YAML and XML files that OpenCV's FileStorage writes, and ROS with it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pytracker._core import InputError
from pytracker.rotation import Array

__all__ = ["matrices_of", "picture_size"]

MATRIX = re.compile(
    r"^\s*(?P<name>\w+):\s*(!!opencv-matrix)?\s*\n\s*rows:\s*(?P<rows>\d+)\s*\n\s*cols:\s*(?P<cols>\d+)\s*\n"
    r"(\s*dt:\s*\S+\s*\n)?\s*data:\s*\[(?P<data>[^\]]*)\]",
    re.MULTILINE,
)
"""One in YAML."""
MODELS = ("plumb_bob", "radtan", "rational_polynomial")
"""Of distortion, that are OpenCV's; Kalibr calls it radtan."""


def matrices_of(path: Path, text: str) -> dict[str, Array]:
    """By name; none where the text holds none.

    Raises `InputError` where one has other numbers than rows times columns.
    """
    if text.lstrip().startswith("<"):
        elements = [element for element in _root(path, text).iter() if element.find("rows") is not None]
        each = [(element.tag, _cells(element)) for element in elements]
    else:
        each = [(m["name"], (m["rows"], m["cols"], m["data"].replace(",", " "))) for m in MATRIX.finditer(text)]
    found = dict(each)
    if len(found) != len(each):
        twice = next(name for name, _ in each if [other for other, _ in each].count(name) > 1)
        raise InputError(f"{path}: has {twice} more than once, expected a file of one camera")
    _check_known(path, text, list(found))
    return {name: _matrix(path, name, *cells) for name, cells in found.items()}


def picture_size(text: str, matrices: Mapping[str, Array]) -> tuple[int, int] | None:
    """Width and height of the pictures, px, where the text says both."""
    for name in ("image_size", "imageSize", "img_size"):
        if name in matrices and matrices[name].size == 2:
            width, height = (round(side) for side in matrices[name].ravel().tolist())
            return width, height
    found = [re.search(rf"\b{name}\W+(\d{{1,5}})\b", text, re.IGNORECASE) for name in ("image_width", "image_height")]
    of_width, of_height = (None if side is None else int(side[1]) for side in found)
    return None if of_width is None or of_height is None else (of_width, of_height)


def _check_known(path: Path, text: str, names: list[str]) -> None:
    """What is said of a lens must be understood, not passed over."""
    model = re.search(r"distortion_model\W+(\w+)", text)
    if model is not None and model[1] not in MODELS:
        raise InputError(f"{path}: distortion_model is {model[1]!r}, expected one of: {', '.join(MODELS)}")
    if re.search(r"fisheye(_model)?\W+(1|true)\b", text, re.IGNORECASE):
        raise InputError(f"{path}: the camera is a fisheye, expected one with OpenCV's five distortions")
    keys = re.findall(r"^\s*<?(\w*dist\w*|d|k[123])\s*(?::|>|\s\w+=)", text, re.IGNORECASE | re.MULTILINE)
    strange = [key for key in keys if key not in names and key != "distortion_model"]
    if names and strange:
        raise InputError(
            f"{path}: {strange[0]} cannot be read, expected rows, cols and data as OpenCV writes them: else the "
            "distortion would be lost"
        )


def _root(path: Path, text: str) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(text.encode())  # noqa: S314 - a file of the user's own
    except (ElementTree.ParseError, ValueError, LookupError) as error:
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
