"""`[truth]` of a recording that is being made: which of a file's points are joints, by how they are called."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import tomlkit

from pytracker._core import KEY_JOINTS, InputError
from pytracker.recording.truth import POINT_FORMATS

__all__ = ["markers_of", "truth_lines"]

SIDES = {"left": ("left", "l"), "right": ("right", "r")}
JOINTS = ("shoulder", "elbow", "wrist")
JOINTS_OF: Mapping[str, Sequence[str]] = {"arm": JOINTS, "body": KEY_JOINTS}
"""By kind of recording, as a truth calls them."""
BONES = (
    {"shoulder": "arm", "elbow": "forearm", "wrist": "hand"},
    {"shoulder": "upperarm", "elbow": "lowerarm", "wrist": "hand"},
    {"shoulder": "humerus", "elbow": "radius", "wrist": "hand"},
)
"""What bones that begin at these joints are called in BVH files."""


def markers_of(names: list[str], kind: str, side: str = "right") -> dict[str, str | list[str]]:
    """Joints of a `kind` of recording to points called RShoulder, left_elbow, L.Wrist, or the middle of LHip and RHip.

    `side` is an arm's. Those that no point is called like are left out.
    """
    plain: dict[str, str] = {}
    for point in names:  # the first of LeftHand, LeftHand1
        plain.setdefault(re.sub(r"[^a-z]", "", point.split(":")[-1].lower()), point)

    def called(of: str, joint: str) -> str | None:
        # Of a skeleton's bones each begins at its joint; its LeftShoulder is the collar bone.
        joints = any(word + "elbow" in plain for word in SIDES[of])
        bones = [names for names in BONES if any(word + names["elbow"] in plain for word in SIDES[of]) and not joints]
        name = bones[0].get(joint, joint) if bones else joint
        return next((plain[word + name] for word in SIDES[of] if word + name in plain), None)

    # As points are called, by what the recording calls them: an arm's joints have no side.
    points: dict[str, str | None] = {joint: called(side, joint) for joint in JOINTS}
    points |= {f"{of}_{joint}": called(of, joint) for joint in JOINTS for of in SIDES}
    markers = {joint: name for joint, name in points.items() if name is not None and joint in JOINTS_OF[kind]}
    hips = [name for of in SIDES if (name := called(of, "hip")) is not None]
    return ({"root": hips} if "root" in JOINTS_OF[kind] and len(hips) == len(SIDES) else {}) | markers


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
