"""`[truth]` of a recording that is being made: which of a file's points are joints, by how they are called."""

from __future__ import annotations

from pathlib import Path

import tomlkit

from pytracker._core import InputError
from pytracker.recording.truth.names import JOINTS_OF, markers_of
from pytracker.recording.truth.points import POINT_FORMATS

__all__ = ["truth_lines"]


def truth_lines(name: str, file: Path, kind: str, side: str, up: str = "") -> list[str]:
    """The table of a file that the recording calls `name`; `up` is the axis that is up in it, where it is not ours.

    Of one that cannot be read it says why.
    """
    lines = ["[truth]", f"file = {name}"]
    reader = POINT_FORMATS.get(file.suffix.lower())
    if reader is None:
        return [*lines, ""]
    try:
        names = list(reader(file).positions_m)
    except InputError as error:
        return [*lines, f"# it cannot be read: {_one_line(str(error))}", ""]
    markers = markers_of(names, kind, side)
    if set(names) & set(JOINTS_OF[kind]):
        pass  # called as joints are
    elif markers:
        pairs = ", ".join(f"{joint} = {tomlkit.item(of).as_string()}" for joint, of in markers.items())
        lines.append(f"markers = {{ {pairs} }}  # by their names: look whether they are joints, or lie on the skin")
    else:
        lines.append(f"# markers = {{ ... }}  # missing: which of {_one_line(', '.join(names))} are joints")
    if up:
        lines.append(f'up = "{up}"  # as of the camera; "y" where the file\'s y axis is up')
    return [*lines, ""]


def _one_line(words: str) -> str:
    """As a comment can hold it."""
    return "".join(letter if letter.isprintable() else " " for letter in words)[:200]
