"""Keypoints as a table: CSV of MediaPipe, DeepLabCut or anybody, TRC of Sports2D in pixels."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoint_log import Keypoints, in_range, ours, require_seen
from pytracker.formats.keypoint_models import name_of
from pytracker.formats.text import number, read_lines
from pytracker.formats.trc import read_trc_pixels
from pytracker.rotation import Array

__all__ = ["of_deeplabcut", "read_table", "read_trc_keypoints"]

FRAME = re.compile(r"frame([ _]?(id|idx|index|no|nr|number))?#?")
"""A column that counts frames."""
TIME = re.compile(r"time(stamp)?([ _(\[]*(s|sec|ms|us|ns)[)\]]?)?")
"""A column of their times."""
UNITS_S = ((0.5, 1.0), (500.0, 1e-3), (5e5, 1e-6), (np.inf, 1e-9))
"""Frames that are less than so far apart are in this unit, s: no detector is slower than two a second."""
LONGEST_S = 24 * 3600.0
"""Times that begin later are those of a clock, not of the video."""
LARGEST_SHARE = 1.5
"""Of a picture's width or height; a point may lie somewhat outside."""
LEAST_PX = 20.0
"""A person whose points all lie nearer to the corner is in metres."""


def read_table(path: Path) -> Keypoints:
    """A CSV. Raises `InputError`."""
    lines = read_lines(path)
    cells = [cell.strip() for cell in lines[0].split(",")]
    if cells[0].lower() == "scorer":
        return _deeplabcut(path, lines)
    named = [(k, *split) for k, cell in enumerate(cells) if (split := _column(cell)) is not None]
    joints = sorted({joint for _, joint, _ in named if all((joint, axis) in {n[1:] for n in named} for axis in "xy")})
    if not set(joints) & set(KEYPOINTS):
        raise InputError(f"{path}:1: header names no joint, expected such as left_wrist_x and left_wrist_y")
    is_mediapipe = any(cell.startswith("X_") for cell in cells)
    table = _cells(path, lines, 1, len(cells))
    counts, times = ([k for k, cell in enumerate(cells) if of.fullmatch(cell.lower())] for of in (FRAME, TIME))
    frames = _frames(path, table[:, counts[0]]) if counts else np.arange(len(table), dtype=np.int64)
    time_s = _times(table[:, times[0]]) if times and not counts else None
    places = table[:, [k for k, joint, axis in named if axis != "confidence"]]
    # No person is one pixel large.
    is_share = is_mediapipe or bool(np.nanmax(np.abs(places), initial=0.0) <= LARGEST_SHARE)
    found = _from_columns(path, table, named, joints, is_share=is_share)
    return dataclasses.replace(found, frames=frames, time_s=time_s)


def read_trc_keypoints(path: Path) -> Keypoints:
    """Sports2D's `..._px_person00.trc`, whose unit says m. Raises `InputError`."""
    time_s, points = read_trc_pixels(path)
    # Its head is the crown; ours lies between the ears.
    named = {name_of(name): uv for name, uv in points.items() if name.lower() != "head"}
    joints = sorted(set(named) & {*KEYPOINTS, "nose"})
    if not set(joints) & set(KEYPOINTS):
        raise InputError(
            f"{path}:4: names no joint, expected such as LWrist and RShoulder (it has {', '.join(points)[:200]})"
        )
    table = np.concatenate([named[joint] for joint in joints], axis=1)
    if not np.nanmax(np.abs(table), initial=0.0) > LEAST_PX:
        raise InputError(f"{path}: is in metres, expected pixels: Sports2D writes them as ..._px_person00.trc")
    columns = [(2 * k + axis, joint, "xy"[axis]) for k, joint in enumerate(joints) for axis in (0, 1)]
    return dataclasses.replace(_from_columns(path, table, columns, joints, is_share=False), time_s=time_s)


def _times(column: Array) -> Array | None:
    """Seconds, whichever unit they are in; None where they do not increase, or are those of a clock."""
    steps = np.diff(column)
    if not len(steps) or not np.isfinite(column).all() or not (steps > 0).all() or column[0] < 0:
        return None
    unit_s = next(unit for limit, unit in UNITS_S if np.median(steps) < limit)
    return None if column[0] * unit_s > LONGEST_S else np.asarray(column * unit_s)


def _frames(path: Path, column: Array) -> NDArray[np.int64]:
    """Numbers of frames, as a column of the table has them. Raises `InputError`."""
    whole = np.isfinite(column) & (column == np.rint(column)) & (column >= 0)
    if not whole.all() or not (np.diff(column) > 0).all():
        k = int(np.argmin(np.concatenate([whole[:1], whole[1:] & (np.diff(column) > 0)])))
        raise InputError(f"{path}: the frame of its row {k + 1} is {column[k]:g}, expected whole numbers that increase")
    return column.astype(np.int64)


def _deeplabcut(path: Path, lines: list[str]) -> Keypoints:
    head = [[cell.strip() for cell in line.split(",")] for line in lines[:4]]
    rows = {
        cells[0].lower(): cells
        for cells in head
        if cells[0].lower() in ("scorer", "individuals", "bodyparts", "coords")
    }
    if "bodyparts" not in rows or "coords" not in rows or len(rows["bodyparts"]) != len(rows["coords"]):
        raise InputError(f"{path}: has no rows of bodyparts and coords below scorer, expected DeepLabCut's table")
    table = _cells(path, lines, len(rows), len(rows["coords"]))
    found = of_deeplabcut(path, {name: cells[1:] for name, cells in rows.items()}, table[:, 1:])
    # Before the points stands the frame's number, or a picture's name.
    counts = bool(np.isfinite(table[:, 0]).all())
    return dataclasses.replace(found, frames=_frames(path, table[:, 0])) if counts else found


def of_deeplabcut(path: Path, levels: Mapping[str, Sequence[str]], table: Array) -> Keypoints:
    """Values `(T, C)` whose columns' names are the `levels`' (bodyparts, coords). Raises `InputError`."""
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
    return _from_columns(path, table, named, joints, is_share=False)


def _column(cell: str) -> tuple[str, str] | None:
    """Joint and axis that a column's name means."""
    words = cell.lower()
    for pattern in (
        r"(?P<axis>x|y|visibility)_(?P<joint>.+)",
        r"(?P<joint>.+)_(?P<axis>x|y|confidence|likelihood|score)",
    ):
        match = re.fullmatch(pattern, words)
        if match:
            axis = match["axis"] if match["axis"] in "xy" else "confidence"
            return name_of(match["joint"]), axis
    return None


def _cells(path: Path, lines: list[str], first: int, columns: int) -> Array:
    rows = []
    # A row of commas is a frame in which nobody was found, but after the last.
    end = max((k + 1 for k in range(first, len(lines)) if lines[k].strip(" ,")), default=first)
    for k in range(first, end):
        if not lines[k].strip():
            continue
        cells = lines[k].split(",")
        if len(cells) != columns:
            raise InputError(f"{path}:{k + 1}: row has {len(cells)} cells, expected {columns} as the header has")
        rows.append([number(cell, path, k + 1, "a keypoint") if _is_number(cell) else np.nan for cell in cells])
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected one a frame")
    return np.array(rows)


def _is_number(cell: str) -> bool:
    """DeepLabCut's first column may hold a picture's name."""
    return not re.search(r"\.(png|jpe?g)$", cell.strip(), re.IGNORECASE)


def _from_columns(
    path: Path, table: Array, named: Iterable[tuple[int, str, str]], joints: Sequence[str], *, is_share: bool
) -> Keypoints:
    order = list(joints)
    people = np.full((len(table), len(order), 3), np.nan)
    people[:, :, 2] = 1.0
    in_range(path, table[:, [k for k, joint, _ in named if joint in order]])
    for k, joint, axis in named:
        if joint in order:
            people[:, order.index(joint), ("x", "y", "confidence").index(axis)] = table[:, k]
    points = np.stack([ours(row, order) for row in people])[:, None]
    return Keypoints(np.arange(len(table)), require_seen(path, points, people[:, :, 2]), is_share)
