"""Keypoints as a table: CSV of MediaPipe or anybody, TRC of Sports2D in pixels."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoints.log import Keypoints, are_shares, in_range, ours, require_seen
from pytracker.formats.keypoints.models import MODELS, name_of
from pytracker.formats.keypoints.rows import rows_of
from pytracker.formats.text import cells_of, delimited, number, read_lines
from pytracker.formats.trc import read_trc_pixels
from pytracker.rotation import Array

__all__ = ["from_columns", "numbers_in", "person_in", "read_table", "read_trc_keypoints", "rows_below", "split"]

PAIRS = (("x_px", "y_px"), ("x", "y"), ("u_px", "v_px"), ("u", "v"))
"""What the two axes are called, those first that say most."""
CONFIDENCES = [
    "confidence",
    "conf",
    "likelihood",
    "score",
    "visibility",
    "v",
    "prob",
    "probability",
    "presence",
    "c",
    "p",
]
"""What says how sure a point is, that first which says most."""
PLACES = (
    re.compile(r"(?P<axis>x|y|visibility)_(?P<joint>.+)"),
    re.compile(rf"(?P<joint>.+)[ _.](?P<axis>[xyuv]|{'|'.join(CONFIDENCES)})(?P<px>[ _]?[(\[]?(px|pixels?)[)\]]?)?"),
)
"""What names a joint and its axis, or how sure it is."""
NUMBERED = re.compile(r"(x|y|z|v|visibility|c|conf|confidence|score)[_ ]?(\d+)")
"""A joint by its number in a model's order, and its axis."""
LEAST_PX = 20.0
"""A person whose points all lie nearer to the corner is in metres."""


def read_table(path: Path) -> Keypoints:
    """A CSV. Raises `InputError`."""
    lines = with_commas(read_lines(path))
    header = split(lines[0])
    named = _named(header)
    if not {joint for _, joint, _ in named} & set(KEYPOINTS):
        named = _numbered(header) or named
    joints = sorted({joint for _, joint, _ in named if all((joint, axis) in {n[1:] for n in named} for axis in "xy")})
    if not set(joints) & set(KEYPOINTS):
        raise InputError(f"{path}:1: header names no joint, expected such as left_wrist_x and left_wrist_y")
    is_mediapipe = any(cell.startswith("X_") for cell in header)
    rows = rows_below(path, lines, 1, len(header))
    points = [k for k, _, _ in named]
    table = numbers_in(path, rows, points)
    of = rows_of(path, header, list(rows.values()), [k for k in range(len(header)) if k not in points])
    is_share = is_mediapipe or are_shares(table[:, [k for k, _, axis in named if axis != "confidence"]])
    found = from_columns(path, table, named, joints, is_share=is_share)
    return dataclasses.replace(found, frames=of.frames, time_s=of.time_s, warnings=of.warnings)


def read_trc_keypoints(path: Path) -> Keypoints:
    """Sports2D's `..._px_person00.trc`, whose unit says m. Raises `InputError`."""
    time_s, points, odd = read_trc_pixels(path)
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
    found = from_columns(path, table, columns, joints, is_share=False)
    return dataclasses.replace(found, time_s=time_s, warnings=odd)


def _named(header: Sequence[str]) -> list[tuple[int, str, str]]:
    """Number, joint and axis (x, y, confidence) of the columns that name one, each axis of a joint once.

    Of several the surest by its name: pixels before what says no unit, x and y before u and v.
    """
    found: dict[str, dict[str, list[int]]] = {}
    for k, cell in enumerate(header):
        match = next((match for pattern in PLACES if (match := pattern.fullmatch(cell.lower()))), None)
        if match is not None:
            said = match["axis"] + ("_px" if match.groupdict().get("px") else "")
            found.setdefault(name_of(match["joint"]), {}).setdefault(said, []).append(k)
    named = []
    for joint, columns in found.items():
        # Beside x and y, v is a visibility.
        sides = next((pair for pair in PAIRS if set(pair) <= set(columns)), None)
        for axis, side in zip("xy", sides or (), strict=False):
            named.append((columns[side][0], joint, axis))
        sure = next((name for name in CONFIDENCES if name in columns and name not in (sides or ())), None)
        if sure is not None:
            named.append((columns[sure][0], joint, "confidence"))
    return sorted(named)


def _numbered(header: Sequence[str]) -> list[tuple[int, str, str]]:
    """The same of columns such as `x0, y0, z0, v0, x1, ...`, where so many are of one model; else none."""
    found = {match.groups(): k for k, cell in enumerate(header) if (match := NUMBERED.fullmatch(cell.lower()))}
    numbers = sorted({int(number) for _, number in found})
    fitting = [order for order in MODELS.values() if len(order) == len(numbers)]
    if len(fitting) != 1 or numbers != list(range(numbers[0], numbers[0] + len(numbers))):
        return []
    names = [name_of(name) for name in fitting[0]]
    return sorted(
        (k, names[int(number) - numbers[0]], axis if axis in "xy" else "confidence")
        for (axis, number), k in found.items()
        if axis != "z"
    )


def with_commas(lines: list[str]) -> list[str]:
    """The same, with commas between the cells, where semicolons or tabs part them; those within a cell are gone."""
    delimiter, lines = delimited(lines)
    return lines if delimiter == "," else [line.replace(",", " ").replace(delimiter, ",") for line in lines]


def split(line: str) -> list[str]:
    """Its cells, of which quoted ones may hold commas."""
    return [cell.strip().strip('"').strip() for cell in cells_of(line)]


def rows_below(path: Path, lines: list[str], first: int, columns: int) -> dict[int, list[str]]:
    """Cells by number of their line, from 1, of the lines from `first` on.

    Raises `InputError` for another length, or none.
    """
    rows = {}
    # A row of commas is a frame in which nobody was found, but after the last.
    end = max((k + 1 for k in range(first, len(lines)) if lines[k].strip(" ,")), default=first)
    for k in range(first, end):
        if not lines[k].strip():
            continue
        rows[k + 1] = split(lines[k])
        if len(rows[k + 1]) != columns:
            raise InputError(f"{path}:{k + 1}: row has {len(rows[k + 1])} cells, expected {columns} as the header has")
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected one a frame")
    return rows


def numbers_in(path: Path, rows: Mapping[int, Sequence[str]], wanted: Sequence[int]) -> Array:
    """The rows `(T, C)`; NaN in columns not `wanted`. Raises `InputError` for what is no number there."""
    table = np.full((len(rows), len(next(iter(rows.values())))), np.nan)
    for at, (line, cells) in enumerate(rows.items()):
        table[at, wanted] = [number(cells[k], path, line, "a keypoint") for k in wanted]
    return table


def from_columns(
    path: Path, table: Array, named: Iterable[tuple[int, str, str]], joints: Sequence[str], *, is_share: bool
) -> Keypoints:
    """Of a table `(T, C)` whose columns are `named` by number, joint and axis. Raises `InputError`."""
    points, confidences = person_in(path, table, named, joints)
    return Keypoints(np.arange(len(table)), require_seen(path, points[:, None], confidences), is_share)


def person_in(
    path: Path, table: Array, named: Iterable[tuple[int, str, str]], joints: Sequence[str]
) -> tuple[Array, Array]:
    """One person's points `(T, 9, 3)`, and the confidences of all `joints` `(T, J)`. Raises `InputError`."""
    order = list(joints)
    people = np.full((len(table), len(order), 3), np.nan)
    people[:, :, 2] = 1.0
    in_range(path, table[:, [k for k, joint, _ in named if joint in order]])
    for k, joint, axis in named:
        if joint in order:
            people[:, order.index(joint), ("x", "y", "confidence").index(axis)] = table[:, k]
    return np.stack([ours(row, order) for row in people]), people[:, :, 2]
