"""How far an elbow hangs below the line from shoulder to wrist: people let it hang."""

from __future__ import annotations

import numpy as np

from pytracker.tracking.arm import ArmTrack

__all__ = ["HANGS", "HANGS_SD", "hangs"]

HANGS, HANGS_SD = 0.3, 0.2
"""Of nineteen captured arms of people it is 0.27 to 0.94: less than this becomes unlikely so fast."""


def hangs(track: ArmTrack) -> float:
    """1 where the elbow hangs as far as it can, -1 where it is as far above the line.

    The mean cosine of the arm's swivel; a frame weighs by how far the elbow is off the line, and by how level that is.
    """
    shoulder = np.asarray(track.recording.arm.shoulder_m)
    elbow, wrist = (track.joints[joint].mean - shoulder for joint in ("elbow", "wrist"))
    line = wrist / np.maximum(np.linalg.norm(wrist, axis=1, keepdims=True), 1e-9)
    off = elbow - (elbow * line).sum(axis=1, keepdims=True) * line
    down = np.array([0.0, 0.0, -1.0]) + line[:, 2:] * line
    weights = np.linalg.norm(off, axis=1) * np.linalg.norm(down, axis=1)
    return float(np.nansum(off * down) / max(np.nansum(weights), 1e-9))
