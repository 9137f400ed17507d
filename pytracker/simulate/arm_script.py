"""A built-in motion for the average skeleton: arms go from pose to pose, the rest is never quite still."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pytracker.rotation import Array
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["MOVEMENTS", "arm_script"]

ARM_CHANNELS = ("humerus_rx", "humerus_ry", "humerus_rz", "radius_rx")
BACK = ("lowerback_rx", "upperback_rx", "thorax_rx")

ARM_POSES_DEG = {
    "hanging": (5, -75, 0, 10),
    "out": (5, 0, 0, 8),
    "up": (10, 55, 0, 20),
    "forward": (70, -10, 0, 15),
    "bent out": (10, -5, 60, 85),
    "bent forward": (40, -30, 20, 95),
    "hand on hip": (33, -21, -85, 107),
    "reaching across": (95, -20, 0, 45),
    "waving": (0, 15, 75, 100),
}
"""Shoulder rx, ry, rz and elbow rx of the left arm, between which `any` chooses; the right one mirrors ry and rz."""

NAMED_POSES_DEG = {
    "hanging": (71, -63, -73, 13),
    "wave in": (-23, -35, 59, 138),
    "wave out": (-37, -18, 90, 99),
    "forward": (70, -63, 3, 20),
    "high": (61, -59, 64, 24),
    "across": (107, -27, -26, 41),
    "aside": (-3, -24, 84, 12),
    "down": (81, -48, -53, 9),
    "folded": (71, -25, -69, 106),
    "hugging": (83, -39, -44, 111),
    "at the chest": (50, -40, -38, 117),
    "at the belly": (73, -33, -71, 58),
    "overhead": (56, -5, 79, 71),
}
"""The same of the named movements: upper arm and forearm as people hold them, elbows out and down."""


MEETING = ("hanging", "at the chest", "at the belly", "overhead", "at the chest")


@dataclass(frozen=True)
class Movement:
    """A movement by name: the poses that either arm goes through, and how far the trunk bends at every other one."""

    left: tuple[str, ...]
    right: tuple[str, ...]
    bend_deg: float = 0.0


MOVEMENTS = {
    "waving": Movement(("hanging",), ("wave in", "wave out")),
    "reaching": Movement(("hanging", "forward", "hanging", "high"), ("forward", "hanging", "across", "aside")),
    "bending": Movement(("hanging", "down", "hanging", "forward"), ("hanging", "forward", "hanging", "down"), 45.0),
    "crossing": Movement(("hanging", "folded", "hugging", "folded"), ("hanging", "hugging", "folded", "across")),
    "meeting": Movement(MEETING, MEETING),
}
"""What people do before a camera, beside `any`: arms that go anywhere, each by itself."""

SWAY_DEG = {
    "lowerback_rx": 2.5, "lowerback_ry": 4.0, "lowerback_rz": 2.0, "upperback_rx": 1.5, "upperback_rz": 1.5,
    "thorax_ry": 4.0, "lowerneck_rx": 4.0, "upperneck_ry": 6.0, "head_ry": 8.0, "head_rx": 4.0,
    "root_rx": 1.5, "root_ry": 5.0, "root_rz": 1.5,
    "lclavicle_rz": 4.0, "rclavicle_rz": 4.0, "lclavicle_ry": 3.0, "rclavicle_ry": 3.0,
    "lfemur_rx": 3.0, "rfemur_rx": 3.0, "ltibia_rx": 4.0, "rtibia_rx": 4.0,
    "lwrist_ry": 30.0, "rwrist_ry": 30.0, "lhand_rx": 12.0, "rhand_rx": 12.0,
}  # fmt: skip
"""RMS of the slow motion of everything else."""

SWAY_M = {"root_tx": 0.02, "root_ty": 0.008, "root_tz": 0.02}


def arm_script(
    skeleton: Skeleton,
    time_s: Array,
    root_height_m: float,
    pace_s: float,
    rng: np.random.Generator,
    movement: str = "any",
    turned_deg: float = 0.0,
) -> Array:
    """Poses `(T, C)` of the average skeleton, m and rad; an arm changes its pose every `pace_s` or so.

    `movement` is `any` or of `MOVEMENTS`, `turned_deg` how far the person is turned to their left.
    """
    poses = np.zeros((len(time_s), len(skeleton.channels)))

    def column(name: str) -> Array:
        return poses[:, skeleton.channels.index(name)]

    for name, size in SWAY_DEG.items():
        column(name)[:] = np.deg2rad(size) * _slow(time_s, rng)
    for name, size in SWAY_M.items():
        column(name)[:] = size * _slow(time_s, rng)
    column("root_ty")[:] += root_height_m
    column("root_ry")[:] += np.deg2rad(turned_deg)
    left, right, bend = _anything(time_s, pace_s, rng) if movement == "any" else _named(movement, time_s, pace_s, rng)
    for letter, signs, angles in (("l", (1, 1, 1, 1), left), ("r", (1, -1, -1, 1), right)):
        for channel, sign, values in zip(ARM_CHANNELS, signs, np.deg2rad(angles).T, strict=True):
            column(letter + channel)[:] = sign * values
    for name in BACK:
        column(name)[:] += np.deg2rad(bend) / len(BACK)
    return poses


def _anything(time_s: Array, pace_s: float, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Angles of either arm `(T, 4)` and of the back `(T,)`, degrees: each arm goes where it likes when it likes."""
    names = list(ARM_POSES_DEG)

    def arm() -> Array:
        knots, targets = [time_s[0]], [ARM_POSES_DEG["hanging" if rng.random() < 0.5 else "out"]]
        while knots[-1] < time_s[-1]:
            knots.append(knots[-1] + pace_s * rng.uniform(0.7, 1.4))
            targets.append(ARM_POSES_DEG[names[rng.integers(len(names))]])
        return _eased(time_s, np.array(knots), np.array(targets) + 6.0 * rng.standard_normal((len(targets), 4)))

    return arm(), arm(), np.zeros(len(time_s))


def _named(name: str, time_s: Array, pace_s: float, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """The same of a movement of `MOVEMENTS`: both arms and the back go at the same times."""
    movement = MOVEMENTS[name]
    knots = [time_s[0]]
    while knots[-1] < time_s[-1]:
        knots.append(knots[-1] + pace_s * rng.uniform(0.7, 1.4))

    def arm(poses: tuple[str, ...]) -> Array:
        targets = np.array([NAMED_POSES_DEG[poses[k % len(poses)]] for k in range(len(knots))])
        return _eased(time_s, np.array(knots), targets + 4.0 * rng.standard_normal(targets.shape))

    bends = movement.bend_deg * (np.arange(len(knots)) % 2) * rng.uniform(0.7, 1.1, len(knots))
    return arm(movement.left), arm(movement.right), _eased(time_s, np.array(knots), bends[:, None])[:, 0]


def _eased(time_s: Array, knots: Array, aim: Array) -> Array:
    """From one row of `aim` to the next, easing in and out, resting in between."""
    k = np.clip(np.searchsorted(knots, time_s, side="right") - 1, 0, len(knots) - 2)
    start, end = knots[k], knots[k + 1]
    share = np.clip((time_s - start) / (0.8 * (end - start)), 0.0, 1.0)
    eased = (share**3 * (10 - 15 * share + 6 * share**2))[:, None]
    return np.asarray(aim[k] * (1 - eased) + aim[k + 1] * eased)


def _slow(time_s: Array, rng: np.random.Generator) -> Array:
    """A smooth random function of unit RMS: four sines of 0.1 to 0.6 Hz."""
    rate, phase = rng.uniform(0.1, 0.6, 4), rng.uniform(0, 2 * np.pi, 4)
    return np.asarray(np.sin(2 * np.pi * rate * time_s[:, None] + phase).sum(axis=1) / np.sqrt(2))
