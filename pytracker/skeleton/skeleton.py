"""A skeleton: bones, channels, limits; poses to joints. Acclaim's conventions (see `rust/skeleton.rs`).

A pose is one row `(C,)`: the root's place in metres and all angles in radians, in the order of `Skeleton.channels`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEY_JOINTS, KEY_PLACES, InputError
from pytracker._core import Skeleton as CoreSkeleton
from pytracker.rotation import Array, Matrix, Triple

__all__ = ["KEY_BONES", "UPPER_BODY", "Bone", "Part", "Skeleton", "upper_body_parts"]

KEY_BONES: dict[str, tuple[str, float]] = dict(zip(KEY_JOINTS, KEY_PLACES, strict=True))
"""Where the key joints sit: bone, and 0 for its start or 1 for its end."""

UPPER_BODY = (
    "root_tx", "root_ty", "root_rz",
    "lhumerus_rx", "lhumerus_ry", "lhumerus_rz", "lradius_rx",
    "rhumerus_rx", "rhumerus_ry", "rhumerus_rz", "rradius_rx",
)  # fmt: skip
"""The 11 channels of Li & Kulić IV-A1: the root in the image plane, shoulders, elbows."""


@dataclass(frozen=True, kw_only=True)
class Bone:
    """One bone.

    Attributes:
        name: as in the file; `root` for the first.
        parent: index of the bone that it hangs on; None for the root.
        reach_m: direction times length, in global axes of the base pose, m.
        frame: the frame in which its joint turns (Acclaim's `axis`), a rotation.
        order: in which order the turns are applied; (0, 1, 2) is x, y, z.
        channels: `tx`, `ty`, `tz` (root only), `rx`, `ry`, `rz`, in the order of the file.
        limits_rad: lower and upper limit of every channel; infinite where there is none.
    """

    name: str
    parent: int | None
    reach_m: Triple
    frame: Matrix
    order: tuple[int, int, int] = (0, 1, 2)
    channels: tuple[str, ...] = ()
    limits_rad: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Skeleton:
    """Bones, the root first and parents before children. Raises `InputError` for what is no skeleton.

    Attributes:
        bones: the bones.
        unit_m: metres in a unit of its AMC files (CMU: 0.056444).
        in_degrees: whether angles in its files are degrees.
    """

    bones: tuple[Bone, ...]
    unit_m: float = 0.0254 / 0.45
    in_degrees: bool = True
    core: CoreSkeleton = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Let the compiled half check it."""
        object.__setattr__(self, "core", CoreSkeleton(list(self.bones)))

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels of a pose, `bone_dof`."""
        return tuple(f"{bone.name}_{channel}" for bone in self.bones for channel in bone.channels)

    @cached_property
    def limits_rad(self) -> Array:
        """Limits of every channel, `(C, 2)`."""
        return np.array([limit for bone in self.bones for limit in bone.limits_rad], dtype=float).reshape(-1, 2)

    def outer_shape(self, crown_m: float = 0.0) -> list[Part]:
        """The outer shape of its upper body, whose head reaches `crown_m` beyond the end of the skeleton's head, m.

        A skeleton whose head has no length has none to reach beyond. Raises `InputError` when out of range.
        """
        if not 0.0 <= crown_m <= 1.0:
            raise InputError(f"crown_m is {crown_m}, expected 0 to 1 m")
        head_m = float(np.linalg.norm(self.bones[self.bone("head")].reach_m))
        return list(upper_body_parts(1.0 + crown_m / head_m if head_m > 0.0 else 1.0))

    def bone(self, name: str) -> int:
        """Index of a bone. Raises `InputError`."""
        for index, bone in enumerate(self.bones):
            if bone.name == name:
                return index
        raise InputError(f"skeleton has no bone {name!r}, expected one of: {', '.join(b.name for b in self.bones)}")

    def below(self, name: str) -> NDArray[np.bool_]:
        """Which bones are this one, or hang on it `(B,)`. Raises `InputError`."""
        found = np.zeros(len(self.bones), dtype=bool)
        found[self.bone(name)] = True
        for index, bone in enumerate(self.bones):
            found[index] |= bone.parent is not None and found[bone.parent]
        return found

    def columns(self, names: tuple[str, ...]) -> list[int]:
        """Indices of channels by name. Raises `InputError`."""
        twice = [name for k, name in enumerate(names) if name in names[:k]]
        if twice:
            raise InputError(f"channel {twice[0]!r} is there twice, expected every channel once")
        missing = [name for name in names if name not in self.channels]
        if missing:
            raise InputError(f"skeleton has no channel {missing[0]!r}, expected one of: {', '.join(self.channels)}")
        return [self.channels.index(name) for name in names]

    def joints(self, poses: Array) -> dict[str, Array]:
        """Key joints of poses `(T, C)`: world, m, `(T, 3)` each. Raises `InputError`."""
        starts, ends, _ = self.core.pose(np.ascontiguousarray(poses, dtype=float))
        return {
            joint: np.ascontiguousarray((ends if along else starts)[:, self.bone(bone)])
            for joint, (bone, along) in KEY_BONES.items()
        }

    def scaled(self, factor: float) -> Skeleton:
        """The same skeleton, larger or smaller; its AMC files' unit stays."""
        bones = tuple(
            dataclasses.replace(bone, reach_m=tuple(factor * x for x in bone.reach_m))  # type: ignore[arg-type]  # three
            for bone in self.bones
        )
        return Skeleton(bones, self.unit_m, self.in_degrees)


@dataclass(frozen=True)
class Part:
    """A part of the outer shape: a rectangle about the line between two places (Li & Kulić IV-A2).

    Attributes:
        name: in words.
        start: bone, and 0 (its start) to 1 (its end); more than 1 is beyond it.
        end: the same.
        half_width_m: at either end, m.
    """

    name: str
    start: tuple[str, float]
    end: tuple[str, float]
    half_width_m: tuple[float, float]


def upper_body_parts(crown: float = 1.0) -> tuple[Part, ...]:
    """The six rectangles of the upper body: torso, head up to `crown` along its bone, upper arms, forearms."""
    parts = [
        Part("torso", ("root", 0.0), ("thorax", 1.0), (0.165, 0.18)),
        Part("head", ("upperneck", 0.0), ("head", crown), (0.072, 0.072)),
    ]
    for side, letter in (("left", "l"), ("right", "r")):
        humerus, radius, wrist = f"{letter}humerus", f"{letter}radius", f"{letter}wrist"
        parts.append(Part(f"{side} upper arm", (humerus, 0.0), (humerus, 1.0), (0.058, 0.05)))
        parts.append(Part(f"{side} forearm", (radius, 0.0), (wrist, 1.0), (0.043, 0.043)))
    return tuple(parts)
