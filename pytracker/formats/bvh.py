"""BVH files (Biovision hierarchy): a skeleton and its motion, to where its joints are.

Nothing in the file says its unit: it is told by how tall the skeleton is.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.markers import Markers
from pytracker.formats.text import first_line, number, read_lines
from pytracker.rotation import Array

__all__ = ["read_bvh"]

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
CMU_M = 0.0254 / 0.45
"""The unit of CMU's motions, kept where they were turned into BVH; where no usual one fits."""
TALL_M = (1.0, 2.3)
"""A person in the first frame is as large along one axis; no unit but one makes it so."""
INTERVALS_S = (1e-4, 1.0)
"""Between two frames."""
LARGEST = 1e6
"""No channel or offset has a larger number."""
CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")


@dataclass
class Joint:
    """A joint of the hierarchy: its parent's number, its offset from it, and its channels in the order of the file."""

    name: str
    parent: int | None
    offset: Array = field(default_factory=lambda: np.zeros(3))
    channels: list[str] = field(default_factory=list)


def read_bvh(path: Path | str) -> Markers:
    """Every joint by name, an end of a limb as `NAME_end`; y is up.

    Raises `InputError` naming line, value and expectation.
    """
    path = Path(path)
    lines = read_lines(path)
    top = first_line(lines)
    if lines[top].strip().upper() != "HIERARCHY":
        raise InputError(f"{path}:{top + 1}: starts with {lines[top][:40]!r}, expected HIERARCHY")
    joints, first = _hierarchy(path, lines, top + 1)
    names = [joint.name for joint in joints]
    if len(set(names)) != len(names):
        raise InputError(f"{path}: has two joints of one name, expected a name each: {', '.join(names)[:200]}")
    rate_hz, rows = _motion(path, lines, first, sum(len(joint.channels) for joint in joints))
    places = _places(joints, rows)
    unit = _unit_m(path, np.stack(list(places.values()))[:, 0])
    positions = {name: unit * place for name, place in places.items()}
    return Markers(np.arange(len(rows)) / rate_hz, positions, rate_hz)


def _hierarchy(path: Path, lines: list[str], top: int) -> tuple[list[Joint], int]:
    """The joints, parents first; and the number of the line after MOTION."""
    joints: list[Joint] = []
    stack: list[int] = []
    for at, line in enumerate(lines[top:], start=top):
        words = line.split()
        match words:
            case []:
                continue
            case ["ROOT" | "JOINT", *name]:
                joints.append(Joint(" ".join(name), stack[-1] if stack else None))
            case ["End", *_] if stack:
                joints.append(Joint(f"{joints[stack[-1]].name}_end", stack[-1]))
            case ["{"] if joints:
                stack.append(len(joints) - 1)
            case ["}"] if stack:
                stack.pop()
            case ["OFFSET", x, y, z] if stack:
                joints[stack[-1]].offset = _offset(path, at + 1, (x, y, z))
            case ["CHANNELS", count, *channels] if stack and _are_channels(count, channels):
                joints[stack[-1]].channels = _as_ours(channels)
            case ["MOTION"] if joints and not stack:
                return joints, at + 1
            case _:
                raise InputError(
                    f"{path}:{at + 1}: {line.strip()[:60]!r} is no line of a hierarchy here, expected ROOT, JOINT, "
                    "End Site, OFFSET of three numbers, CHANNELS with their count, braces, or MOTION after the last"
                )
    raise InputError(f"{path}: has no MOTION, expected it after the hierarchy: cut short?")


def _offset(path: Path, line: int, cells: tuple[str, ...]) -> Array:
    offset = np.array([number(cell, path, line, "OFFSET") for cell in cells])
    if not (np.abs(offset) <= LARGEST).all():
        raise InputError(f"{path}:{line}: OFFSET is {' '.join(cells)}, expected usual numbers")
    return offset


def _are_channels(count: str, channels: list[str]) -> bool:
    return count == str(len(channels)) and set(_as_ours(channels)) <= {*CHANNELS}


def _as_ours(channels: list[str]) -> list[str]:
    """In the usual letters: `Xposition`."""
    return [channel.capitalize() for channel in channels]


def _motion(path: Path, lines: list[str], first: int, width: int) -> tuple[float, Array]:
    """Frames a second, and a row of channels a frame `(T, width)`."""
    head = [line.split(":") for line in lines[first : first + 2]]
    if [words[0].strip() for words in head] != ["Frames", "Frame Time"] or any(len(words) != 2 for words in head):
        raise InputError(f"{path}:{first + 1}: expected the lines Frames: and Frame Time: after MOTION")
    count, interval_s = (number(words[1].strip(), path, first + 1 + k, words[0]) for k, words in enumerate(head))
    if not INTERVALS_S[0] <= interval_s <= INTERVALS_S[1]:
        raise InputError(
            f"{path}:{first + 2}: Frame Time is {interval_s}, expected {INTERVALS_S[0]:g} to {INTERVALS_S[1]:g} s"
        )
    rows = []
    for at, line in enumerate(lines[first + 2 :], start=first + 3):
        cells = line.split()
        if not cells:
            continue
        if len(cells) != width:
            raise InputError(f"{path}:{at}: row has {len(cells)} numbers, expected {width}, one a channel")
        rows.append([number(cell, path, at, "a channel") for cell in cells])
    if len(rows) != count or not rows:
        raise InputError(f"{path}: has {len(rows)} frames, expected {count:g} as it says: cut short?")
    values = np.array(rows)
    odd = np.argwhere(~(np.abs(values) <= LARGEST))
    if len(odd):
        raise InputError(
            f"{path}: row {odd[0, 0] + 1} of the motion has {values[tuple(odd[0])]:g}, expected a usual number"
        )
    return 1.0 / interval_s, values


def _unit_m(path: Path, first: Array) -> float:
    """By how large the skeleton `(J, 3)` is in its first frame."""
    large = float((first.max(axis=0) - first.min(axis=0)).max())
    fitting = [unit for unit in UNITS_M.values() if TALL_M[0] <= large * unit <= TALL_M[1]]
    if not fitting and TALL_M[0] <= large * CMU_M <= TALL_M[1]:
        return CMU_M
    if len(fitting) != 1:
        least, most = TALL_M
        raise InputError(
            f"{path}: the skeleton is {large:.4g} units large in the first frame, expected {least:g} to {most:g} m in "
            f"one of: {', '.join(UNITS_M)}, CMU's 1/0.45 inch"
        )
    return fitting[0]


def _places(joints: list[Joint], rows: Array) -> dict[str, Array]:
    """Where the joints are `(T, 3)`, in the file's unit."""
    turns: list[Array] = []
    places: list[Array] = []
    column = 0
    for joint in joints:
        place = np.broadcast_to(joint.offset, (len(rows), 3)).copy()
        turn = np.broadcast_to(np.eye(3), (len(rows), 3, 3))
        for channel in joint.channels:
            axis, values = "XYZ".index(channel[0]), rows[:, column]
            column += 1
            if channel.endswith("position"):
                place[:, axis] = values
            else:
                turn = turn @ _about(axis, np.radians(values))
        if joint.parent is not None:
            place = places[joint.parent] + np.einsum("tij,tj->ti", turns[joint.parent], place)
            turn = turns[joint.parent] @ turn
        turns.append(turn)
        places.append(place)
    return {joint.name: place for joint, place in zip(joints, places, strict=True)}


def _about(axis: int, angle: Array) -> Array:
    """Turns `(T, 3, 3)` about an axis by angles `(T,)`, rad."""
    turn = np.zeros((len(angle), 3, 3))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    turn[:, axis, axis] = 1.0
    turn[:, j, j] = turn[:, k, k] = np.cos(angle)
    turn[:, k, j] = np.sin(angle)
    turn[:, j, k] = -np.sin(angle)
    return turn
