"""2-D keypoints as a table that `keypoints` reads: `frame, left_wrist_x, left_wrist_y, left_wrist_confidence, ...`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pytracker.rotation import Array

__all__ = ["keypoints_text"]


def keypoints_text(joints: Sequence[str], frames: Iterable[Array]) -> str:
    """The table of one person: u, v, px, and confidence of each joint `(J, 3)`, frame by frame; NaN: an empty cell."""
    header = ",".join(f"{joint}_{axis}" for joint in joints for axis in ("x", "y", "confidence"))
    rows = [
        ",".join([str(number), *("" if np.isnan(value) else f"{value:.3f}" for value in points.ravel())])
        for number, points in enumerate(frames)
    ]
    return "\n".join([f"frame,{header}", *rows]) + "\n"
