"""DeepLabCut's table of one individual: what its levels of columns name, and what its index says of the frames."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoints.log import Keypoints
from pytracker.formats.keypoints.models import name_of
from pytracker.formats.keypoints.rows import frames_of
from pytracker.formats.keypoints.table import from_columns, numbers_in, rows_below, split
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
    if len(set(levels.get("individuals", ()))) > 1:
        raise InputError(f"{path}: has several individuals, expected DeepLabCut's table of one")
    if not {"bodyparts", "coords"} <= set(levels):
        raise InputError(f"{path}: its columns have {', '.join(levels)}, expected bodyparts and coords")
    axes = {"x": "x", "y": "y", "likelihood": "confidence"}
    parts = zip(levels["bodyparts"], levels["coords"], strict=True)
    named = [(k, name_of(part), axes[axis]) for k, (part, axis) in enumerate(parts) if axis in axes]
    joints = sorted({joint for _, joint, _ in named})
    if not set(joints) & set(KEYPOINTS):
        raise InputError(f"{path}: its bodyparts name no joint of ours, expected such as left_wrist")
    found = from_columns(path, table, named, joints, is_share=False)
    return dataclasses.replace(found, frames=frames_of(path, index))
