"""Acclaim skeleton files (ASF): as written by Vicon's BodyBuilder, with all the liberties that real files take.

Latin-1 or UTF-8, LF or CRLF; keys of a bone in any order; `axis` with or without its order; limits with `inf`, in
one or several pairs of brackets; bones without `dof`. Lengths are in units of `1 / length` inches.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.text import read_lines
from pytracker.rotation import Array, Matrix, triple
from pytracker.skeleton.skeleton import Bone, Skeleton

__all__ = ["INCH_M", "read_asf"]

INCH_M = 0.0254
ROTATIONS = {"rx", "ry", "rz"}
TRANSLATIONS = {"tx", "ty", "tz"}
BONE_KEYS = {"id", "name", "direction", "length", "axis", "dof", "limits", "bodymass", "cofmass"}


@dataclass
class _Entry:
    """A bone as it stands in the file: words by key, with the line of each."""

    line: int
    words: dict[str, list[str]] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)


class _File:
    """Sections of the file, and how to complain about it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.sections: dict[str, list[tuple[int, list[str]]]] = {}
        section = ""
        for number, raw in enumerate(read_lines(path), 1):
            line = raw.strip()
            if not line or line.startswith("#"):
                continue
            if line.startswith(":"):
                head, *rest = line[1:].split() or [""]
                section = head.lower()
                self.sections.setdefault(section, [])
                if rest:
                    self.sections[section].append((number, rest))
            elif section:
                self.sections[section].append((number, line.split()))
            else:
                raise self.fault(number, f"{line[:40]!r} stands before any section, expected an Acclaim skeleton")
        missing = [name for name in ("root", "bonedata", "hierarchy") if not self.sections.get(name)]
        if missing:
            raise InputError(f"{path}: has no section :{missing[0]}, expected an Acclaim skeleton (.asf)")

    def fault(self, line: int, words: str) -> InputError:
        return InputError(f"{self.path}:{line}: {words}")

    def numbers(self, entry: _Entry, key: str, count: int) -> list[float]:
        """The first `count` words of a key as finite numbers."""
        if key not in entry.words:
            raise self.fault(entry.line, f"this bone has no {key}, expected {count} number(s)")
        words = entry.words[key][:count]
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = []
        if len(values) != count or not all(math.isfinite(v) for v in values):
            raise self.fault(entry.lines[key], f"{key} is {' '.join(words)!r}, expected {count} finite number(s)")
        return values


def read_asf(path: Path | str) -> Skeleton:
    """Read a skeleton. Raises `InputError` naming line, value and expectation."""
    file = _File(Path(path))
    unit_m, in_degrees = _units(file)
    bones = {bone.name: bone for bone in (_bone(file, entry, unit_m, in_degrees) for entry in _entries(file))}
    root = _root(file, math.pi / 180 if in_degrees else 1.0)
    ordered = _hierarchy(file, bones)
    index = {"root": 0, **{name: k + 1 for k, (name, _) in enumerate(ordered)}}
    whole = [root]
    for name, parent in ordered:
        bone = bones[name]
        whole.append(
            Bone(
                name=name, parent=index[parent], reach_m=bone.reach_m, frame=bone.frame, order=bone.order,
                channels=bone.channels, limits_rad=bone.limits_rad,
            )
        )  # fmt: skip
    unused = sorted(set(bones) - set(index))
    if unused:
        raise InputError(f"{path}: bone {unused[0]!r} is not in :hierarchy, expected every bone to hang on another")
    return Skeleton(tuple(whole), unit_m, in_degrees)


def _units(file: _File) -> tuple[float, bool]:
    length, in_degrees = 1.0, True
    for line, (key, *words) in file.sections.get("units", []):
        if key.lower() == "length":
            try:
                length = float(words[0])
            except (ValueError, IndexError):
                length = math.nan
            if not (math.isfinite(length) and length > 0):
                raise file.fault(line, f"length is {' '.join(words)!r}, expected a positive number")
        elif key.lower() == "angle":
            if not words or words[0].lower() not in ("deg", "rad"):
                raise file.fault(line, f"angle is {' '.join(words)!r}, expected deg or rad")
            in_degrees = words[0].lower() == "deg"
    return INCH_M / length, in_degrees


def _entries(file: _File) -> list[_Entry]:
    """Bones between `begin` and `end`; a line without a known key goes on with the key before it (limits)."""
    entries: list[_Entry] = []
    entry: _Entry | None = None
    key = ""
    for line, words in file.sections["bonedata"]:
        head = words[0].lower()
        if head == "begin":
            if entry is not None:
                raise file.fault(line, f"begin before the end of the bone that began at line {entry.line}")
            entry, key = _Entry(line), ""
        elif head == "end":
            if entry is None:
                raise file.fault(line, "end without begin")
            entries.append(entry)
            entry = None
        elif entry is None:
            raise file.fault(line, f"{' '.join(words)[:40]!r} stands outside of begin and end")
        elif head in BONE_KEYS:
            key = head
            entry.words[key] = list(words[1:])
            entry.lines[key] = line
        elif key == "limits":
            entry.words[key] += words
        else:
            raise file.fault(line, f"{words[0]!r} is no key of a bone, expected one of: {', '.join(sorted(BONE_KEYS))}")
    if entry is not None:
        raise file.fault(entry.line, "this bone has no end: the file is cut short")
    return entries


def _bone(file: _File, entry: _Entry, unit_m: float, in_degrees: bool) -> Bone:
    """One bone without its parent."""
    name = (entry.words.get("name") or [""])[0]
    if not name or name == "root":
        raise file.fault(entry.lines.get("name", entry.line), f"name is {name!r}, expected a bone's name")
    direction = np.array(file.numbers(entry, "direction", 3))
    length = file.numbers(entry, "length", 1)[0]
    norm = float(np.linalg.norm(direction))
    if length < 0 or (length > 0 and norm == 0):
        raise file.fault(
            entry.lines["length"], f"{name}: length {length} along {direction}, expected 0 or more along a direction"
        )
    if norm > 0 and abs(norm - 1) > 0.01:
        raise file.fault(entry.lines["direction"], f"{name}: direction has norm {norm:.4f}, expected 1")
    angles = np.array(file.numbers(entry, "axis", 3))
    order = _order(file, entry.lines["axis"], entry.words["axis"][3:4])
    channels = tuple(word.lower() for word in entry.words.get("dof", []))
    unknown = [word for word in channels if word not in ROTATIONS]
    if unknown or len(set(channels)) != len(channels):
        raise file.fault(
            entry.lines["dof"], f"{name}: dof is {' '.join(channels)!r}, expected rx, ry, rz, each at most once"
        )
    scale = math.pi / 180 if in_degrees else 1.0
    frame = _rotation(angles * scale, order)
    limits = _limits(file, entry, name, len(channels), scale)
    reach = direction * length * unit_m
    return Bone(
        name=name, parent=None, reach_m=triple(reach), frame=frame, order=order,
        channels=channels, limits_rad=limits,
    )  # fmt: skip


def _order(file: _File, line: int, words: list[str]) -> tuple[int, int, int]:
    """`XYZ` where the file says nothing."""
    letters = words[0].lower() if words else "xyz"
    if sorted(letters) != ["x", "y", "z"]:
        raise file.fault(line, f"order of axes is {letters!r}, expected a permutation of XYZ")
    a, b, c = ("xyz".index(letter) for letter in letters)
    return a, b, c


def _rotation(angles: Array, order: tuple[int, int, int]) -> Matrix:
    m = np.eye(3)
    for axis in order:
        j, k = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        s, c = math.sin(angles[axis]), math.cos(angles[axis])
        turn[j, j], turn[j, k], turn[k, j], turn[k, k] = c, -s, s, c
        m = turn @ m
    return triple(m[0]), triple(m[1]), triple(m[2])


def _limits(file: _File, entry: _Entry, name: str, count: int, scale: float) -> tuple[tuple[float, float], ...]:
    """Pairs in brackets; none at all are no limits."""
    if "limits" not in entry.words:
        return ((-math.inf, math.inf),) * count
    words = re.sub(r"[(),]", " ", " ".join(entry.words["limits"])).split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        raise file.fault(entry.lines["limits"], f"{name}: limits are {' '.join(words)!r}, expected numbers") from None
    if len(values) != 2 * count:
        raise file.fault(
            entry.lines["limits"], f"{name}: {len(values)} limits for {count} dof, expected {2 * count}: a pair each"
        )
    pairs = tuple((low * scale, high * scale) for low, high in zip(values[::2], values[1::2], strict=True))
    if any(math.isnan(x) for pair in pairs for x in pair) or any(low > high for low, high in pairs):
        raise file.fault(entry.lines["limits"], f"{name}: limits are {values}, expected lower before upper")
    return pairs


def _root(file: _File, scale: float) -> Bone:
    channels: tuple[str, ...] = ("tx", "ty", "tz", "rx", "ry", "rz")
    angles, order, first = np.zeros(3), (0, 1, 2), file.sections["root"][0][0]
    for line, (key, *words) in file.sections["root"]:
        if key.lower() == "order":
            channels = tuple(word.lower() for word in words)
            if set(channels) - ROTATIONS - TRANSLATIONS or len(set(channels)) != len(channels):
                raise file.fault(line, f"root order is {' '.join(words)!r}, expected TX TY TZ RX RY RZ in some order")
        elif key.lower() == "axis":
            order = _order(file, line, words[:1])
        elif key.lower() in ("orientation", "position"):
            try:
                values = np.array([float(word) for word in words[:3]])
            except ValueError:
                values = np.zeros(0)
            if values.shape != (3,) or not np.isfinite(values).all():
                raise file.fault(line, f"{key} is {' '.join(words)!r}, expected three finite numbers")
            if key.lower() == "orientation":
                angles = values * scale
    if not channels:
        raise file.fault(first, "root has no order, expected TX TY TZ RX RY RZ")
    free = ((-math.inf, math.inf),) * len(channels)
    return Bone(
        name="root", parent=None, reach_m=(0.0, 0.0, 0.0), frame=_rotation(angles, order), order=order,
        channels=channels, limits_rad=free,
    )  # fmt: skip


def _hierarchy(file: _File, bones: dict[str, Bone]) -> list[tuple[str, str]]:
    """(bone, parent), parents first."""
    parents: dict[str, str] = {}
    lines: dict[str, int] = {}
    for line, (parent, *children) in file.sections["hierarchy"]:
        if parent.lower() in ("begin", "end"):
            continue
        for name in (parent, *children):
            if name not in bones and name != "root":
                raise file.fault(line, f"{name!r} is not in :bonedata, expected one of: {', '.join(bones)}")
        for child in children:
            if child in parents or child == "root":
                raise file.fault(line, f"{child!r} already hangs on {parents.get(child)!r}, expected one parent")
            parents[child], lines[child] = parent, line
    ordered: list[tuple[str, str]] = []
    placed = {"root"}
    waiting = list(parents)
    while waiting:
        ready = [name for name in waiting if parents[name] in placed]
        if not ready:
            raise file.fault(lines[waiting[0]], f"{waiting[0]!r} does not hang on the root, expected a tree")
        for name in ready:
            ordered.append((name, parents[name]))
            placed.add(name)
        waiting = [name for name in waiting if name not in placed]
    return ordered
