"""Acclaim motion files (AMC): poses of a skeleton, read and written.

Latin-1 or UTF-8, LF or CRLF; bones of a frame in any order; exponents of three digits; `#!OML` and other comments.
A bone that a file never names keeps its base pose, and is said.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.text import read_lines
from pytracker.rotation import Array
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["Motion", "read_amc", "write_amc"]

MOST = 100.0
"""Nobody is farther off in metres, or has turned farther in radians (16 turns)."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Poses of a skeleton.

    Attributes:
        poses: `(T, C)`, metres and radians, in the order of `Skeleton.channels`.
        numbers: of the frames, as the file has them `(T,)`, increasing.
        warnings: what is odd but usable, in words.
    """

    poses: Array
    numbers: NDArray[np.int64]
    warnings: tuple[str, ...] = ()


def read_amc(path: Path | str, skeleton: Skeleton) -> Motion:
    """Read the poses of `skeleton`. Raises `InputError` naming line, value and expectation."""
    path = Path(path)
    reader = _Reader(path, skeleton)
    for line, raw in enumerate(read_lines(path), 1):
        words = raw.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            reader.keyword(words[0])
        elif len(words) == 1 and re.fullmatch(r"[0-9]{1,9}", words[0]):
            reader.frame(line, int(words[0]))
        else:
            reader.bone(line, words[0], words[1:])
    if not reader.frames:
        raise InputError(f"{path}: holds no frame, expected an Acclaim motion (.amc)")
    poses = np.array(reader.frames, dtype=float) * _scale(skeleton, reader.in_degrees)
    return Motion(
        poses,
        np.array(reader.numbers, dtype=np.int64),
        tuple(_missing(path, reader.columns, reader.seen, len(reader.frames))),
    )


class _Reader:
    """The frames read so far."""

    def __init__(self, path: Path, skeleton: Skeleton) -> None:
        self.path, self.skeleton, self.in_degrees = path, skeleton, skeleton.in_degrees
        self.columns, self.channels = _columns(skeleton), len(skeleton.channels)
        self.frames: list[list[float]] = []
        self.numbers: list[int] = []
        self.seen: dict[str, int] = {}
        self._number = 0
        self._most = np.empty(0)
        self._in_frame: set[str] = set()

    def keyword(self, word: str) -> None:
        if word.upper() in (":DEGREES", ":RADIANS"):
            self.in_degrees = word.upper() == ":DEGREES"

    def frame(self, line: int, number: int) -> None:
        if self.frames and number <= self._number:
            raise InputError(
                f"{self.path}:{line}: frame {number} after frame {self._number}, expected increasing numbers"
            )
        if not self.frames:
            self._most = MOST / _scale(self.skeleton, self.in_degrees)
        self._number, self._in_frame = number, set()
        self.numbers.append(number)
        self.frames.append([0.0] * self.channels)

    def bone(self, line: int, name: str, words: list[str]) -> None:
        place = f"{self.path}:{line}"
        if not words:
            raise InputError(f"{place}: {name[:40]!r} stands alone, expected a frame number or a bone and its values")
        if not self.frames:
            raise InputError(f"{place}: {name[:40]!r} stands before the first frame number")
        if name not in self.columns:
            known = ", ".join(self.columns)
            raise InputError(f"{place}: bone {name[:40]!r} is not in the skeleton, expected one of: {known}")
        if name in self._in_frame:
            raise InputError(f"{place}: bone {name!r} is there twice in frame {self._number}, expected once")
        where = self.columns[name]
        if len(words) != len(where):
            raise InputError(f"{place}: {name} has {len(words)} values, expected {len(where)} as its dof say")
        self._in_frame.add(name)
        self.seen[name] = self.seen.get(name, 0) + 1
        for column, word in zip(where, words, strict=True):
            self.frames[-1][column] = _value(place, name, word, self._most[column])


def _columns(skeleton: Skeleton) -> dict[str, list[int]]:
    columns: dict[str, list[int]] = {}
    first = 0
    for bone in skeleton.bones:
        if bone.channels:
            columns[bone.name] = list(range(first, first + len(bone.channels)))
        first += len(bone.channels)
    return columns


def _value(place: str, name: str, word: str, most: float) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in word:
        raise InputError(f"{place}: {name} has the value {word!r}, expected a finite number")
    if abs(value) > most:
        raise InputError(
            f"{place}: {name} has the value {word!r}, expected at most {most:.6g} in the file's units, "
            f"{MOST:g} m or rad"
        )
    return value


def _scale(skeleton: Skeleton, in_degrees: bool) -> Array:
    """Of every channel: units of the file to metres or radians."""
    turn = math.pi / 180 if in_degrees else 1.0
    return np.array([skeleton.unit_m if name.split("_")[-1].startswith("t") else turn for name in skeleton.channels])


def _missing(path: Path, columns: dict[str, list[int]], seen: dict[str, int], frames: int) -> list[str]:
    return [
        f"{path}: bone {name!r} is missing in {frames - seen.get(name, 0)} of {frames} frames; "
        "its angles are taken as 0"
        for name in columns
        if seen.get(name, 0) < frames
    ]


def write_amc(
    path: Path | str, skeleton: Skeleton, poses: Array, numbers: Iterable[int] | None = None, note: str = ""
) -> None:
    """Write poses `(T, C)` as a file that any Acclaim reader opens, in the skeleton's own units.

    Frames have these numbers, from 1 on where none are given; a note goes into the head. Raises `InputError` for poses
    of another size, or numbers that are not finite.
    """
    poses = np.asarray(poses, dtype=float)
    if poses.ndim != 2 or poses.shape[1] != len(skeleton.channels):
        raise InputError(f"poses have shape {poses.shape}, expected (T, {len(skeleton.channels)})")
    bad = np.argwhere(~np.isfinite(poses))
    if bad.size:
        frame, column = bad[0]
        raise InputError(
            f"pose {frame}: {skeleton.channels[column]} is {poses[frame, column]}, expected a finite number"
        )
    values = poses / _scale(skeleton, skeleton.in_degrees)
    columns = _columns(skeleton)
    with Path(path).open("w", encoding="latin-1", newline="\n") as file:
        angles = ":DEGREES" if skeleton.in_degrees else ":RADIANS"
        file.write(f"# written by pytracker{note and ': '}{note}\n:FULLY-SPECIFIED\n{angles}\n")
        for number, row in zip(range(1, len(values) + 1) if numbers is None else numbers, values, strict=True):
            file.write(f"{number}\n")
            for name, where in columns.items():
                file.write(f"{name} {' '.join(f'{row[c]:.7g}' for c in where)}\n")
