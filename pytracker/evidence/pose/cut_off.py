"""Hands that something hides: a table or a desk cuts the body off, and forearms end at its edge.

A forearm that is seen as far as an edge looks like one that points at the camera, its hand before the body.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker.evidence.pose.lately import ASK_EVERY_S, Lately, mean_of_known
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["CutOff"]

WRISTS = ("left_wrist", "right_wrist")
HALF_WIDTH_M = 0.08
"""Hips are looked at so far to either side of their middle, wrists a third of it."""
GAP_M = 0.06
"""A belt of the wall's colour is no end."""
HIGHEST_M, LOWEST_M = -0.40, 0.30
"""From the chest to the middle of the thighs, below the hips' middle: what ends elsewhere is not cut off so."""
COVERED = 0.3
"""A row in which so much is foreground goes on."""
SAME_M = 0.06
"""What ends so near to where the body does is cut off by the same."""
NEAR_M = 0.15
"""A hand is that long: a wrist that is farther above an edge is seen with its hand."""
HIDDEN = "may be hidden, with its hand, by what hides the body below"


class CutOff:
    """Where the foreground ends below chest and wrists.

    Args:
        camera: what sees it.
    """

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._ask_s = -np.inf
        self._lately = Lately()

    def look(self, time_s: float, joints: Mapping[str, Array], foreground: Image) -> dict[str, str]:
        """Take a frame's mean joints, `(3,)` each, world, m, and its foreground `(H, W)`, 255 where the person is.

        In words what lately speaks against joints; those are left out that nothing speaks against.
        """
        is_hidden = np.full(len(WRISTS), np.nan)
        if time_s >= self._ask_s:
            self._ask_s = time_s + ASK_EVERY_S
            is_hidden = self._hidden(joints, foreground)
        shares = mean_of_known(self._lately.take(time_s, is_hidden))
        return {wrist: HIDDEN for wrist, share in zip(WRISTS, shares, strict=True) if share > 0.5}

    def _hidden(self, joints: Mapping[str, Array], foreground: Image) -> Array:
        """Of either wrist whether it may be hidden now, 0 or 1 `(2,)`."""
        px_per_m = float(self._camera.px_per_m(joints["root"][None])[0])
        root, *wrists = self._camera.project(np.stack([joints[name] for name in ("root", *WRISTS)]))
        chest = root + np.array([0.0, HIGHEST_M * px_per_m])
        body = _end(foreground, chest, HALF_WIDTH_M * px_per_m, GAP_M * px_per_m)
        if not (HIGHEST_M < (body - root[1]) / px_per_m < LOWEST_M):
            return np.zeros(len(WRISTS))
        ends = [_end(foreground, wrist, HALF_WIDTH_M / 3 * px_per_m, GAP_M * px_per_m) for wrist in wrists]
        return np.array(
            [
                float(abs(end - body) < SAME_M * px_per_m and abs(wrist[1] - body) < NEAR_M * px_per_m)
                for wrist, end in zip(wrists, ends, strict=True)
            ]
        )


def _end(foreground: Image, start: Array, half_px: float, gap_px: float) -> float:
    """The row where what goes on downwards from a pixel ends; NaN where nothing is there, or it goes on beyond."""
    height, width = foreground.shape
    if not np.isfinite(start).all() or not (0 <= start[0] < width):
        return float("nan")
    left, right = (int(np.clip(round(start[0] + by), 0, width - 1)) for by in (-half_px, half_px))
    top = int(np.clip(round(start[1]), 0, height - 1))
    rows = top + np.flatnonzero((foreground[top:, left : right + 1] > 0).mean(axis=1) > COVERED)
    if not len(rows) or rows[0] - top > gap_px:
        return float("nan")
    breaks = np.flatnonzero(np.diff(rows) > gap_px)
    end = rows[breaks[0]] if len(breaks) else rows[-1]
    return float("nan") if end >= height - 2 else float(end)
