"""DeepLabCut's table: what its levels of columns name, of one individual or more, and its index of the frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoints.log import Keypoints, require_seen
from pytracker.formats.keypoints.models import name_of
from pytracker.formats.keypoints.people import in_order
from pytracker.formats.keypoints.rows import frames_of
from pytracker.formats.keypoints.table import numbers_in, person_in, rows_below, split
from pytracker.formats.text import read_lines
from pytracker.rotation import Array

__all__ = ["is_deeplabcut", "of_deeplabcut", "read_deeplabcut"]

LEVELS = ("scorer", "individuals", "bodyparts", "coords")


def is_deeplabcut(path: Path) -> bool:
    """Whether a CSV begins as DeepLabCut's do. Raises `InputError`."""
    return read_lines(path)[0].split(",")[0].strip().lower() == "scorer"


def read_deeplabcut(path: Path) -> Keypoints:
    """A CSV. Raises `InputError`."""
    lines = read_lines(path)
    head = [split(line) for line in lines[:4]]
    levels = {cells[0].lower(): cells for cells in head if cells[0].lower() in LEVELS}
    if "bodyparts" not in levels or "coords" not in levels or len(levels["bodyparts"]) != len(levels["coords"]):
        raise InputError(f"{path}: has no rows of bodyparts and coords below scorer, expected DeepLabCut's table")
    # Before the points stands the frame's number or its picture's name, of which folders may have columns of their own.
    columns = len(levels["coords"])
    points = next((k for k, cell in enumerate(levels["coords"]) if k and cell), 1)
    rows = rows_below(path, lines, len(levels), columns)
    table = numbers_in(path, rows, range(points, columns))[:, points:]
    index = [cells[points - 1] for cells in rows.values()]
    return of_deeplabcut(path, {name: cells[points:] for name, cells in levels.items()}, table, index)


def of_deeplabcut(path: Path, levels: Mapping[str, Sequence[str]], table: Array, index: Sequence[str]) -> Keypoints:
    """Values `(T, C)` whose columns' names are the `levels`' (bodyparts, coords), and what the index says of each.

    Raises `InputError`.
    """
    if not {"bodyparts", "coords"} <= set(levels):
        raise InputError(f"{path}: its columns have {', '.join(levels)}, expected bodyparts and coords")
    axes = {"x": "x", "y": "y", "likelihood": "confidence"}
    whose = levels.get("individuals", [""] * table.shape[1])
    people: dict[str, list[tuple[int, str, str]]] = {}
    for k, (person, part, axis) in enumerate(zip(whose, levels["bodyparts"], levels["coords"], strict=True)):
        if axis in axes:
            people.setdefault(person, []).append((k, name_of(part), axes[axis]))
    # What is single of its kind, such as a corner of the table, stands there as one more individual.
    people = {person: named for person, named in people.items() if {joint for _, joint, _ in named} & set(KEYPOINTS)}
    if not people:
        raise InputError(f"{path}: its bodyparts name no joint of ours, expected such as left_wrist")
    found = [person_in(path, table, named, sorted({joint for _, joint, _ in named})) for named in people.values()]
    points = in_order(np.stack([person for person, _ in found], axis=1))
    seen = require_seen(path, points, np.concatenate([confidences for _, confidences in found], axis=1))
    return Keypoints(frames_of(path, index), seen)
