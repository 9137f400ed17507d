"""Keypoints as a table: CSV of MediaPipe or anybody, TRC of Sports2D in pixels."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Container, Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoint_log import Keypoints, in_range, ours, require_seen
from pytracker.formats.keypoint_models import name_of
from pytracker.formats.text import number, read_lines
from pytracker.formats.trc import read_trc_pixels
from pytracker.rotation import Array

__all__ = ["cells_of", "frame_in", "frames_of", "from_columns", "read_table", "read_trc_keypoints"]

FRAME = re.compile(r"frame([ _]?(id|idx|index|no|nr|number))?#?")
"""A column that counts frames."""
PICTURE = re.compile(r"\.(png|jpe?g|bmp|tiff?)\s*$", re.IGNORECASE)
"""What names one does too."""
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
    named = [(k, *split) for k, cell in enumerate(cells) if (split := _column(cell)) is not None]
    joints = sorted({joint for _, joint, _ in named if all((joint, axis) in {n[1:] for n in named} for axis in "xy")})
    if not set(joints) & set(KEYPOINTS):
        raise InputError(f"{path}:1: header names no joint, expected such as left_wrist_x and left_wrist_y")
    is_mediapipe = any(cell.startswith("X_") for cell in cells)
    counts, times = ([k for k, cell in enumerate(cells) if of.fullmatch(cell.lower())] for of in (FRAME, TIME))
    below = lines[1].split(",") if len(lines) > 1 else []
    counts += [k for k, cell in enumerate(below) if PICTURE.search(cell)]
    table = cells_of(path, lines, 1, len(cells), {k for k, _, _ in named} | {*counts[:1], *times[:1]})
    frames = frames_of(path, table[:, counts[0]]) if counts else np.arange(len(table), dtype=np.int64)
    time_s, odd = _times(path, table[:, times[0]]) if times and not counts else (None, ())
    places = table[:, [k for k, joint, axis in named if axis != "confidence"]]
    # No person is one pixel large.
    is_share = is_mediapipe or bool(np.nanmax(np.abs(places), initial=0.0) <= LARGEST_SHARE)
    found = from_columns(path, table, named, joints, is_share=is_share)
    return dataclasses.replace(found, frames=frames, time_s=time_s, warnings=odd)


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
    return dataclasses.replace(from_columns(path, table, columns, joints, is_share=False), time_s=time_s)


def _times(path: Path, column: Array) -> tuple[Array | None, tuple[str, ...]]:
    """Seconds since the video began, whichever unit they are in; None where they do not increase. And what is odd."""
    steps = np.diff(column)
    if not len(steps):
        return None, ()
    if not np.isfinite(column).all() or not (steps > 0).all() or column[0] < 0:
        k = int(np.argmin(np.concatenate([[column[0] >= 0], steps > 0])))
        words = f"{path}: the time of its row {k + 1} is {column[k]:g}, expected times that increase: rows are counted"
        return None, (f"{words} as frames instead",)
    unit_s = next(unit for limit, unit in UNITS_S if np.median(steps) < limit)
    if column[0] * unit_s <= LONGEST_S:
        return np.asarray(column * unit_s), ()
    words = f"{path}: its times begin at {column[0]:.15g}, as a clock's: its first row is taken to be the first frame's"
    return np.asarray((column - column[0]) * unit_s), (words,)


def frames_of(path: Path, column: Array) -> NDArray[np.int64]:
    """Numbers of frames, as a column of the table has them; rows are counted where it is empty. Raises `InputError`."""
    if np.isnan(column).all():
        return np.arange(len(column), dtype=np.int64)
    is_whole = np.isfinite(column) & (column == np.rint(column)) & (column >= 0)
    is_next = np.concatenate([is_whole[:1], is_whole[1:] & (np.diff(column) > 0)])
    if not is_next.all():
        k = int(np.argmin(is_next))
        is_what = "not there" if np.isnan(column[k]) else f"{column[k]:g}"
        raise InputError(f"{path}: the frame of its row {k + 1} is {is_what}, expected whole numbers that increase")
    return column.astype(np.int64)


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


def cells_of(path: Path, lines: list[str], first: int, columns: int, wanted: Container[int]) -> Array:
    """Numbers of the rows from line `first` on `(T, C)`; of a picture's name, its last; NaN in columns not `wanted`.

    Raises `InputError` for rows of other lengths, what is no number, or no row.
    """
    rows = []
    # A row of commas is a frame in which nobody was found, but after the last.
    end = max((k + 1 for k in range(first, len(lines)) if lines[k].strip(" ,")), default=first)
    for k in range(first, end):
        if not lines[k].strip():
            continue
        cells = lines[k].split(",")
        if len(cells) != columns:
            raise InputError(f"{path}:{k + 1}: row has {len(cells)} cells, expected {columns} as the header has")
        numbers = (frame_in(cell) if at in wanted else "" for at, cell in enumerate(cells))
        rows.append([number(cell, path, k + 1, "a keypoint") for cell in numbers])
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected one a frame")
    return np.array(rows)


def frame_in(cell: str) -> str:
    """The number in a picture's name, such as `labeled-data/trial/img0041.png`; other cells as they are."""
    name = cell.strip()
    if not PICTURE.search(name):
        return cell
    digits: list[str] = re.findall(r"\d+", PICTURE.sub("", name))
    return digits[-1] if digits else ""


def from_columns(
    path: Path, table: Array, named: Iterable[tuple[int, str, str]], joints: Sequence[str], *, is_share: bool
) -> Keypoints:
    """Of a table `(T, C)` whose columns are `named` by number, joint and axis. Raises `InputError`."""
    order = list(joints)
    people = np.full((len(table), len(order), 3), np.nan)
    people[:, :, 2] = 1.0
    in_range(path, table[:, [k for k, joint, _ in named if joint in order]])
    for k, joint, axis in named:
        if joint in order:
            people[:, order.index(joint), ("x", "y", "confidence").index(axis)] = table[:, k]
    points = np.stack([ours(row, order) for row in people])[:, None]
    return Keypoints(np.arange(len(table)), require_seen(path, points, people[:, :, 2]), is_share)
