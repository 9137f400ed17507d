"""A built-in motion for the average skeleton: arms go from pose to pose, the rest is never quite still."""

from __future__ import annotations

import numpy as np

from pytracker.rotation import Array
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["arm_script"]

ARM_POSES_DEG = {
    "hanging": (5, -75, 0, 10),
    "out": (5, 0, 0, 8),
    "up": (10, 55, 0, 20),
    "forward": (70, -10, 0, 15),
    "bent out": (10, -5, 60, 85),
    "bent forward": (40, -30, 20, 95),
    "hand on hip": (-20, -45, -50, 85),
    "reaching across": (95, -20, 0, 45),
    "waving": (0, 15, 75, 100),
}
"""Shoulder rx, ry (of the left; the right one mirrors it), rz and elbow rx: see `average_skeleton`."""

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
    skeleton: Skeleton, time_s: Array, root_height_m: float, pace_s: float, rng: np.random.Generator
) -> Array:
    """Poses `(T, C)` of the average skeleton, m and rad; an arm changes its pose every `pace_s` or so."""
    poses = np.zeros((len(time_s), len(skeleton.channels)))

    def column(name: str) -> Array:
        return poses[:, skeleton.channels.index(name)]

    for name, size in SWAY_DEG.items():
        column(name)[:] = np.deg2rad(size) * _slow(time_s, rng)
    for name, size in SWAY_M.items():
        column(name)[:] = size * _slow(time_s, rng)
    column("root_ty")[:] += root_height_m
    for letter, mirror in (("l", 1.0), ("r", -1.0)):
        angles = np.deg2rad(_arm(time_s, pace_s, rng))
        for channel, values in zip(("humerus_rx", "humerus_ry", "humerus_rz", "radius_rx"), angles.T, strict=True):
            sign = mirror if channel == "humerus_ry" else 1.0
            column(letter + channel)[:] = sign * values
    return poses


def _arm(time_s: Array, pace_s: float, rng: np.random.Generator) -> Array:
    """Angles of one arm `(T, 4)`, degrees: from pose to pose, easing in and out, resting in between."""
    names = list(ARM_POSES_DEG)
    knots, targets = [time_s[0]], [ARM_POSES_DEG["hanging" if rng.random() < 0.5 else "out"]]
    while knots[-1] < time_s[-1]:
        knots.append(knots[-1] + pace_s * rng.uniform(0.7, 1.4))
        targets.append(ARM_POSES_DEG[names[rng.integers(len(names))]])
    aim = np.array(targets, dtype=float) + 6.0 * rng.standard_normal((len(targets), 4))
    k = np.clip(np.searchsorted(knots, time_s, side="right") - 1, 0, len(knots) - 2)
    start, end = np.array(knots)[k], np.array(knots)[k + 1]
    share = np.clip((time_s - start) / (0.8 * (end - start)), 0.0, 1.0)
    eased = (share**3 * (10 - 15 * share + 6 * share**2))[:, None]
    return np.asarray(aim[k] * (1 - eased) + aim[k + 1] * eased)


def _slow(time_s: Array, rng: np.random.Generator) -> Array:
    """A smooth random function of unit RMS: four sines of 0.1 to 0.6 Hz."""
    rate, phase = rng.uniform(0.1, 0.6, 4), rng.uniform(0, 2 * np.pi, 4)
    return np.asarray(np.sin(2 * np.pi * rate * time_s[:, None] + phase).sum(axis=1) / np.sqrt(2))
