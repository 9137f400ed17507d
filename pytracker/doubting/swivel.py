"""How far an elbow hangs below the line from shoulder to wrist: people let it hang."""

from __future__ import annotations

import numpy as np

from pytracker.tracking.arm import ArmTrack

__all__ = ["HANGS", "HANGS_SD", "hangs"]

HANGS, HANGS_SD = 0.3, 0.2
"""Of nineteen captured arms of people it is 0.26 to 0.94: less than this becomes unlikely so fast."""
STRAIGHT_M = 0.01
"""An elbow that is no farther off the line says little: two degrees of the sensor's axis put it on the other side."""


def hangs(track: ArmTrack) -> float:
    """1 where the elbow hangs as far as it can, -1 where it is as far above the line; `HANGS` where nothing tells.

    The mean cosine of the arm's swivel over valid frames, which weigh by how far the elbow is off the line and how
    level that is; of arms that are nearly straight, or upright, it is nearly `HANGS`.
    """
    shoulder = np.asarray(track.recording.arm.shoulder_m)
    elbow, wrist = (track.joints[joint].mean[track.valid] - shoulder for joint in ("elbow", "wrist"))
    line = wrist / np.maximum(np.linalg.norm(wrist, axis=1, keepdims=True), 1e-9)
    off = elbow - (elbow * line).sum(axis=1, keepdims=True) * line
    down = np.array([0.0, 0.0, -1.0]) + line[:, 2:] * line
    level = np.linalg.norm(down, axis=1)
    below, most = (off * down).sum(), (np.linalg.norm(off, axis=1) * level).sum()
    unknown = STRAIGHT_M * max(level.sum(), 1e-9)
    return float((below + HANGS * unknown) / (most + unknown))
