"""The body's kinematics and edge cue in plain vectorised NumPy: the check on the Rust core, and its peer in speed.

Written as a careful NumPy user would: all particles at once, only the bones that lead to a wanted point, constant
rotations multiplied out beforehand, every pixel of every outline looked up in one go.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import pytracker as pt

Float = NDArray[np.float64]


def turn(axis: int, angle: Float) -> Float:
    """Rotations about one axis `(N, 3, 3)`."""
    out = np.zeros((len(angle), 3, 3))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    s, c = np.sin(angle), np.cos(angle)
    out[:, axis, axis] = 1.0
    out[:, j, j], out[:, j, k], out[:, k, j], out[:, k, k] = c, -s, s, c
    return out


class NumpyKinematics:
    """Starts and ends of the bones that lead to the key joints, hands and head, for states `(N, D)`."""

    def __init__(self, skeleton: pt.Skeleton, pose: Float, free: tuple[str, ...]) -> None:
        self.bones = skeleton.bones
        columns = {name: k for k, name in enumerate(free)}
        wanted = {skeleton.bone(name) for name in ("head", "lhand", "rhand")}
        for leaf in sorted(wanted):
            parent = self.bones[leaf].parent
            while parent is not None:
                wanted.add(parent)
                parent = self.bones[parent].parent
        self.order = sorted(wanted)
        first = np.cumsum([0, *(len(bone.channels) for bone in self.bones)])
        self.joints = {}
        for b in self.order:
            bone = self.bones[b]
            values = {c: (pose[first[b] + k], columns.get(f"{bone.name}_{c}")) for k, c in enumerate(bone.channels)}
            self.joints[b] = values
        self.constant = {b: self._constant(b) for b in self.order}

    def _constant(self, b: int) -> Float | None:
        """`C M C'` of a joint that does not move."""
        if any(column is not None for _, column in self.joints[b].values()):
            return None
        m = np.eye(3)
        for axis in self.bones[b].order:
            value, _ = self.joints[b].get("r" + "xyz"[axis], (0.0, None))
            m = turn(axis, np.array([value]))[0] @ m
        frame = np.array(self.bones[b].frame)
        return np.asarray(frame @ m @ frame.T)

    def __call__(self, states: Float) -> tuple[dict[int, Float], dict[int, Float]]:
        starts: dict[int, Float] = {}
        ends: dict[int, Float] = {}
        rotations: dict[int, Float] = {}
        for b in self.order:
            bone, joint = self.bones[b], self.joints[b]
            rotation = self.constant[b]
            if rotation is None:
                frame = np.array(bone.frame)
                rotation = np.eye(3)
                for axis in bone.order:
                    value, column = joint.get("r" + "xyz"[axis], (0.0, None))
                    if column is not None:
                        rotation = turn(axis, states[:, column]) @ rotation
                    elif value:
                        rotation = turn(axis, np.array([value]))[0] @ rotation
                rotation = frame @ rotation @ frame.T
            if bone.parent is None:
                place = [joint.get("t" + axis, (0.0, None)) for axis in "xyz"]
                starts[b] = np.stack([np.full(len(states), v) if c is None else states[:, c] for v, c in place], axis=1)
                rotations[b] = rotation
            else:
                starts[b] = ends[bone.parent]
                rotations[b] = rotations[bone.parent] @ rotation
            ends[b] = starts[b] + rotations[b] @ np.array(bone.reach_m)
        return starts, ends


def missed_edges(edges: NDArray[np.uint8], outlines: Float) -> Float:
    """Eq. (4) for outlines `(N, 4, 2)`: share of pixels that lie on no edge."""
    start, end = outlines, np.roll(outlines, -1, axis=1)
    step = end - start
    steps = np.maximum(np.rint(np.abs(step).max(axis=2)), 1.0).astype(int)
    longest = int(steps.max())
    k = np.arange(longest + 1)
    share = np.minimum(k / steps[..., None], 1.0)
    u = np.floor(start[..., 0, None] + share * step[..., 0, None] + 0.5).astype(int)
    v = np.floor(start[..., 1, None] + share * step[..., 1, None] + 0.5).astype(int)
    counted = k <= steps[..., None]
    inside = counted & (u >= 0) & (v >= 0) & (u < edges.shape[1]) & (v < edges.shape[0])
    hit = np.zeros(u.shape, dtype=bool)
    hit[inside] = edges[v[inside], u[inside]] > 0
    return np.asarray(1.0 - hit.sum(axis=(1, 2)) / counted.sum(axis=(1, 2)))
