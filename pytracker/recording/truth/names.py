"""Which of a file's points are joints, by how they are called."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from pytracker._core import KEY_JOINTS

__all__ = ["JOINTS_OF", "markers_of"]

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

PLUG_IN_GAIT = {"shoulder": ("sho",), "elbow": ("elb",), "wrist": ("wra", "wrb")}
"""What markers about these joints are called in Vicon's set: a wrist is the middle of both on its bar."""


def markers_of(names: Iterable[str], kind: str, side: str = "right") -> dict[str, str | list[str]]:
    """Joints of a `kind` of recording to points called RShoulder, left_elbow, LELB, or the middle of LHip and RHip.

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

    def about(of: str, joint: str) -> str | list[str] | None:
        there = [plain[of[0] + name] for name in PLUG_IN_GAIT[joint] if of[0] + name in plain]
        return called(of, joint) or (there[0] if len(there) == 1 else there or None)

    # As points are called, by what the recording calls them: an arm's joints have no side.
    points: dict[str, str | list[str] | None] = {joint: about(side, joint) for joint in JOINTS}
    points |= {f"{of}_{joint}": about(of, joint) for joint in JOINTS for of in SIDES}
    markers = {joint: name for joint, name in points.items() if name is not None and joint in JOINTS_OF[kind]}
    hips = [name for of in SIDES if (name := called(of, "hip")) is not None]
    return ({"root": hips} if "root" in JOINTS_OF[kind] and len(hips) == len(SIDES) else {}) | markers
