"""Acclaim motion files (AMC): poses of a skeleton, read and written.

Latin-1 or UTF-8, LF or CRLF; bones of a frame in any order; exponents of three digits; `#!OML` and other comments. A bone
that a file never names keeps its base pose, and is said.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.text import read_lines
from pytracker.rotation import Array
from pytracker.skeleton import Skeleton

__all__ = ["Motion", "read_amc", "write_amc"]


@dataclass(frozen=True, eq=False)
class Motion:
    """Poses of a skeleton.

    Attributes:
        poses: `(T, C)`, metres and radians, in the order of `Skeleton.channels`.
        warnings: what is odd but usable, in words.
    """

    poses: Array
    warnings: tuple[str, ...] = ()


def read_amc(path: Path | str, skeleton: Skeleton) -> Motion:
    """Read the poses of `skeleton`. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    in_degrees, frames = skeleton.in_degrees, []
    columns = _columns(skeleton)
    seen: dict[str, int] = {}
    row: list[float] | None = None
    in_frame: set[str] = set()
    number = 0
    for line, raw in enumerate(read_lines(path), 1):
        words = raw.split()
        if not words or raw.lstrip().startswith("#"):
            continue
        if words[0].startswith(":"):
            if words[0].upper() in (":DEGREES", ":RADIANS"):
                in_degrees = words[0].upper() == ":DEGREES"
            continue
        if len(words) == 1 and words[0].lstrip("-").isdigit():
            if row is not None and int(words[0]) <= number:
                raise InputError(f"{path}:{line}: frame {words[0]} after frame {number}, expected increasing numbers")
            number, row, in_frame = int(words[0]), [0.0] * len(skeleton.channels), set()
            frames.append(row)
            continue
        name = words[0]
        if row is None:
            raise InputError(f"{path}:{line}: {raw.strip()[:40]!r} stands before the first frame number")
        if name not in columns:
            raise InputError(f"{path}:{line}: bone {name!r} is not in the skeleton, expected one of: {', '.join(columns)}")
        if name in in_frame:
            raise InputError(f"{path}:{line}: bone {name!r} is there twice in frame {number}, expected once")
        in_frame.add(name)
        seen[name] = seen.get(name, 0) + 1
        where = columns[name]
        if len(words) - 1 != len(where):
            raise InputError(f"{path}:{line}: {name} has {len(words) - 1} values, expected {len(where)} as its dof say")
        for column, word in zip(where, words[1:], strict=True):
            row[column] = _value(path, line, name, word)
    if not frames:
        raise InputError(f"{path}: holds no frame, expected an Acclaim motion (.amc)")
    poses = np.array(frames, dtype=float) * _scale(skeleton, in_degrees)
    return Motion(poses, tuple(_missing(path, columns, seen, len(frames))))


def _columns(skeleton: Skeleton) -> dict[str, list[int]]:
    columns: dict[str, list[int]] = {}
    first = 0
    for bone in skeleton.bones:
        if bone.channels:
            columns[bone.name] = list(range(first, first + len(bone.channels)))
        first += len(bone.channels)
    return columns


def _value(path: Path, line: int, name: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in word:
        raise InputError(f"{path}:{line}: {name} has the value {word!r}, expected a finite number")
    return value


def _scale(skeleton: Skeleton, in_degrees: bool) -> Array:
    """Of every channel: units of the file to metres or radians."""
    turn = math.pi / 180 if in_degrees else 1.0
    return np.array([skeleton.unit_m if name.split("_")[-1].startswith("t") else turn for name in skeleton.channels])


def _missing(path: Path, columns: dict[str, list[int]], seen: dict[str, int], frames: int) -> list[str]:
    return [
        f"{path}: bone {name!r} is missing in {frames - seen.get(name, 0)} of {frames} frames; its angles are taken as 0"
        for name in columns
        if seen.get(name, 0) < frames
    ]


def write_amc(path: Path | str, skeleton: Skeleton, poses: Array) -> None:
    """Write poses `(T, C)` as a file that any Acclaim reader opens, in the skeleton's own units.

    Raises `InputError` for poses of another size, or numbers that are not finite.
    """
    poses = np.asarray(poses, dtype=float)
    if poses.ndim != 2 or poses.shape[1] != len(skeleton.channels):
        raise InputError(f"poses have shape {poses.shape}, expected (T, {len(skeleton.channels)})")
    bad = np.argwhere(~np.isfinite(poses))
    if bad.size:
        frame, column = bad[0]
        raise InputError(f"pose {frame}: {skeleton.channels[column]} is {poses[frame, column]}, expected a finite number")
    values = poses / _scale(skeleton, skeleton.in_degrees)
    columns = _columns(skeleton)
    with Path(path).open("w", encoding="latin-1", newline="\n") as file:
        file.write(f"# written by pytracker\n:FULLY-SPECIFIED\n{':DEGREES' if skeleton.in_degrees else ':RADIANS'}\n")
        for number, row in enumerate(values, 1):
            file.write(f"{number}\n")
            for name, where in columns.items():
                file.write(f"{name} {' '.join(f'{row[c]:.7g}' for c in where)}\n")
