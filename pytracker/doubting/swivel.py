"""How far an elbow hangs below the line from shoulder to wrist: people let it hang."""

from __future__ import annotations

import numpy as np

from pytracker.tracking.arm import ArmTrack

__all__ = ["HANGS", "HANGS_SD", "hangs", "surely_hangs"]

HANGS, HANGS_SD = 0.3, 0.2
"""Of nineteen captured arms of people it is 0.26 to 0.94: less than this becomes unlikely so fast."""
STRAIGHT_M = 0.01
"""An elbow that is no farther off the line says little: two degrees of the sensor's axis put it on the other side."""


def hangs(track: ArmTrack) -> float:
    """1 where the elbow hangs as far as it can, -1 where it is as far above the line; `HANGS` where nothing tells.

    The mean cosine of the arm's swivel over valid frames, which weigh by how far the elbow is off the line and how
    level that is; of arms that are nearly straight, or upright, it is nearly `HANGS`.
    """
    return _swivel(track, 0.0)


def surely_hangs(track: ArmTrack) -> float:
    """As `hangs`; an elbow that is off the line by less than its own band says little.

    Of an arm that hangs and is nearly straight, how deep it is in the picture, and so on which side, nothing tells.
    """
    return _swivel(track, 1.0)


def _swivel(track: ArmTrack, bands: float) -> float:
    """`hangs`; so many standard deviations of the elbow say little."""
    shoulder = np.asarray(track.recording.arm.shoulder_m)
    elbow, wrist = (track.joints[joint].mean[track.valid] - shoulder for joint in ("elbow", "wrist"))
    line = wrist / np.maximum(np.linalg.norm(wrist, axis=1, keepdims=True), 1e-9)
    off = elbow - (elbow * line).sum(axis=1, keepdims=True) * line
    down = np.array([0.0, 0.0, -1.0]) + line[:, 2:] * line
    level = np.linalg.norm(down, axis=1)
    below, most = (off * down).sum(), (np.linalg.norm(off, axis=1) * level).sum()
    # Along `down`, which is `level` long.
    band = bands * np.linalg.norm(down * track.joints["elbow"].sd[track.valid], axis=1)
    unknown = max(np.maximum(STRAIGHT_M * level, band).sum(), 1e-9)
    return float((below + HANGS * unknown) / (most + unknown))
