"""The package's own average skeleton, for people who have no ASF: an adult's proportions, channels as CMU's files have.

Segment lengths are shares of the body's height (Drillis & Contini 1966, as in Winter, "Biomechanics and Motor
Control of Human Movement", fig. 4.1); the trunk's division is ours. Base pose: standing, facing +z, arms stretched
out to the sides. In this skeleton a shoulder's `rx` swings the arm forward, `ry` turns it up (left) or down
(right), `rz` twists it; a positive elbow `rx` bends it. Limits are coarse, after those of CMU's skeletons.
"""

from __future__ import annotations

import math

import numpy as np

from pytracker.rotation import Array, triple
from pytracker.skeleton.skeleton import Bone, Skeleton

__all__ = ["average_skeleton"]

Direction = tuple[float, float, float]
Limits = dict[str, tuple[float, float]]

UP, DOWN, FORWARD, OUT = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)

BEND: Limits = {"rx": (-30, 60), "ry": (-45, 45), "rz": (-30, 30)}

TRUNK: tuple[tuple[str, str, Direction, float, Limits], ...] = (
    ("lowerback", "root", UP, 0.075, BEND),
    ("upperback", "lowerback", UP, 0.080, BEND),
    ("thorax", "upperback", UP, 0.080, BEND),
    ("lowerneck", "thorax", UP, 0.050, BEND),
    ("upperneck", "lowerneck", UP, 0.050, BEND),
    ("head", "upperneck", UP, 0.095, BEND),
)
"""Bone, parent, direction, share of the height, limits in degrees by channel."""

SIDE: tuple[tuple[str, str, Direction, float, Limits], ...] = (
    ("hipjoint", "root", (0.75, -0.60, 0.28), 0.066, {}),
    ("femur", "hipjoint", DOWN, 0.245, {"rx": (-160, 20), "ry": (-70, 70), "rz": (-60, 70)}),
    ("tibia", "femur", DOWN, 0.246, {"rx": (-10, 170)}),
    ("foot", "tibia", (0.0, -0.35, 0.94), 0.080, {"rx": (-45, 90), "rz": (-70, 20)}),
    ("toes", "foot", FORWARD, 0.040, {"rx": (-90, 20)}),
    ("clavicle", "thorax", (0.91, 0.40, -0.10), 0.112, {"ry": (-20, 20), "rz": (-20, 20)}),
    ("humerus", "clavicle", OUT, 0.172, {"rx": (-60, 130), "ry": (-110, 90), "rz": (-90, 90)}),
    ("radius", "humerus", OUT, 0.098, {"rx": (-10, 160)}),
    ("wrist", "radius", OUT, 0.048, {"ry": (-90, 90)}),
    ("hand", "wrist", OUT, 0.045, {"rx": (-90, 90), "rz": (-30, 30)}),
    ("fingers", "hand", OUT, 0.040, {"rx": (0, 90)}),
    ("thumb", "wrist", (0.70, 0.0, 0.71), 0.045, {"rx": (-45, 45), "rz": (-45, 45)}),
)
"""The left side; the right one mirrors it. The two bones of the forearm together are Winter's forearm."""

ARM = {"humerus", "radius", "wrist", "hand", "fingers", "thumb"}


def average_skeleton(height_m: float) -> Skeleton:
    """An adult of `height_m`, with the bones and channels that CMU's skeletons have."""
    free = ((-math.inf, math.inf),) * 6
    root = ("tx", "ty", "tz", "rx", "ry", "rz")
    bones = [
        Bone(
            name="root", parent=None, reach_m=(0.0, 0.0, 0.0), frame=_matrix(np.eye(3)), channels=root, limits_rad=free
        )
    ]
    index = {"root": 0}

    def add(name: str, parent: str, reach: Array, frame: Array, limits: Limits, flipped: tuple[str, ...]) -> None:
        pairs = [(-high, -low) if channel in flipped else (low, high) for channel, (low, high) in limits.items()]
        bone = Bone(
            name=name,
            parent=index[parent],
            reach_m=triple(reach),
            frame=_matrix(frame),
            channels=tuple(limits),
            limits_rad=tuple((math.radians(low), math.radians(high)) for low, high in pairs),
        )
        index[name] = len(bones)
        bones.append(bone)

    for name, parent, direction, share, limits in TRUNK:
        add(name, parent, np.array(direction) * share * height_m, np.eye(3), limits, ())
    for letter, sign in (("l", 1.0), ("r", -1.0)):
        for kind, parent, direction, share, limits in SIDE:
            along = np.array(direction) / np.linalg.norm(direction) * [sign, 1.0, 1.0]
            frame = _arm_frame(sign) if kind in ARM else np.eye(3)
            # In a mirror turns about y and z change their sense; the arm's frame is mirrored already but for y.
            flipped = () if sign > 0 else ("ry",) if kind in ARM else ("ry", "rz")
            where = parent if parent in ("root", "thorax") else letter + parent
            add(letter + kind, where, along * share * height_m, frame, limits, flipped)
    return Skeleton(tuple(bones))


def _arm_frame(side: float) -> Array:
    """Axes of an arm stretched out to the `side` (+1 left): x is the elbow's hinge, z points along it to the body."""
    x, z = np.array([0.0, -side, 0.0]), np.array([-side, 0.0, 0.0])
    return np.column_stack([x, np.cross(z, x), z])


def _matrix(m: Array) -> tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]:
    return triple(m[0]), triple(m[1]), triple(m[2])
