"""Whether the person differs from the background, and the rest of the picture does not.

Where they hardly do, little of the pose lies on the foreground; where everything does, every pose lies there.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.pose.lately import ASK_EVERY_S, Lately, mean_of_known
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["StandsOut"]

POINTS = 12
"""So many along every line."""
LEAST_ON_TRUNK = 0.6
"""Of clips of people who stand out 0.72 of trunk and shoulders at least lie on the foreground, in 95 % of the frames;
where they differ from the wall by half as much, 0.61 at most. Chest and shoulders alone are more."""
HARDLY = "the person hardly differs from the background"
MOST_M2, MOST_SHARE = 1.5, 0.15
"""More foreground, and a larger share of the picture, is no person: one has 0.6 m² at most, two have 1.2."""
MOST_OF_ALL = 0.5
"""Where more of the picture does, nothing is known of the person: shadows that pass are less."""
EVERYWHERE = "most of the picture differs from the background"
TRUNK_LINES = (("root", "neck"), ("neck", "head"), ("left_shoulder", "right_shoulder"))
ARM_LINES = tuple(
    (f"{side}_{a}", f"{side}_{b}") for side in ("left", "right") for a, b in (("shoulder", "elbow"), ("elbow", "wrist"))
)


class StandsOut:
    """How much of the lines from joint to joint, of trunk and arms, lies on the foreground, and how large that is.

    Args:
        camera: what sees it.
    """

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._ask_s = -np.inf
        self._lately = Lately()
        self.share = float("nan")
        """Of all lines of the last frame; NaN where they are outside the picture, or were not asked for."""
        self.floods = False
        """Whether more than a person differs from the background there."""

    def look(self, time_s: float, joints: Mapping[str, Array], foreground: Image) -> str:
        """Take a frame's mean joints, `(3,)` each, world, m, and its foreground `(H, W)`, 255 where the person is.

        What lately speaks against it, in words; empty where nothing does.
        """
        px_per_m = float(self._camera.px_per_m(joints["root"][None])[0])
        most_px = max(MOST_M2 * px_per_m**2, MOST_SHARE * foreground.size)
        count = int(np.count_nonzero(foreground))
        self.floods = count > most_px
        on_trunk, self.share = np.nan, np.nan
        if time_s >= self._ask_s:
            self._ask_s = time_s + ASK_EVERY_S
            on_trunk, self.share = self._on(foreground, joints)
        lately = mean_of_known(self._lately.take(time_s, np.array([on_trunk])))[0]
        if count > max(most_px, MOST_OF_ALL * foreground.size):
            return EVERYWHERE
        return HARDLY if lately < LEAST_ON_TRUNK else ""

    def _on(self, foreground: Image, joints: Mapping[str, Array]) -> tuple[float, float]:
        """Share of the trunk's lines, and of all, on the foreground; NaN where they are outside the picture."""
        names = list(joints)
        pixels = dict(zip(names, self._camera.project(np.stack([joints[name] for name in names])), strict=True))
        pixels["neck"] = 0.5 * (pixels["left_shoulder"] + pixels["right_shoulder"])
        on_trunk, on_arms = (_on(foreground, pixels, lines) for lines in (TRUNK_LINES, ARM_LINES))
        return _share(on_trunk), _share(np.concatenate([on_trunk, on_arms]))


def _on(foreground: Image, pixels: Mapping[str, Array], lines: tuple[tuple[str, str], ...]) -> NDArray[np.bool_]:
    """Which points of lines lie on it `(P,)`, of those within the picture."""
    points = np.concatenate([np.linspace(pixels[a], pixels[b], POINTS) for a, b in lines])
    points = np.rint(points[np.isfinite(points).all(axis=1)])
    u, v = points[((points >= 0) & (points < foreground.shape[::-1])).all(axis=1)].astype(int).T
    return np.asarray(foreground[v, u] > 0)


def _share(is_on: NDArray[np.bool_]) -> float:
    return float(is_on.mean()) if len(is_on) else float("nan")
