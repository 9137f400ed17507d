"""Whether the person stands out: hardly differing from the wall there is too little of the pose on the foreground.

Where all else differs from the background too, every pose is on it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker.evidence.borne_out import recent
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["StandsOut"]

POINTS = 12
"""So many along every line."""
LEAST_ON_TRUNK = 0.6
"""Of clips of people who stand out 0.72 of trunk and shoulders at least lie on the foreground, in 95 % of the frames;
where they differ from the wall by half as much, 0.61 at most. Chest and shoulders alone are more."""
UNSEEN = "hardly differs from the background"
MOST_M2, MOST_SHARE = 1.5, 0.25
"""More foreground, and a larger share of the picture, is no person: one has 0.6 m² at most, two have 1.2."""
EVERYWHERE = "more of the picture than a person differs from the background"
TRUNK = (("root", "neck"), ("neck", "head"), ("left_shoulder", "right_shoulder"))
ARMS = tuple(
    (f"{side}_{a}", f"{side}_{b}") for side in ("left", "right") for a, b in (("shoulder", "elbow"), ("elbow", "wrist"))
)


class StandsOut:
    """How much of the lines from joint to joint, of trunk and arms, lies on the foreground.

    Args:
        camera: what sees it.
    """

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._time_s: list[float] = []
        self._trunk: list[float] = []
        self.floods: list[bool] = []
        """Whether more of every frame than a person differs from the background."""
        self.shares: list[float] = []
        """Of all lines of every frame; NaN where they are outside the picture."""

    def look(self, time_s: float, joints: Mapping[str, Array], foreground: Image) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and its foreground `(H, W)`, 255 where the person is."""
        on_trunk, on_arms = (self._on(foreground, joints, lines) for lines in (TRUNK, ARMS))
        both = np.concatenate([on_trunk, on_arms])
        self._time_s.append(time_s)
        px_per_m = float(self._camera.px_per_m(joints["root"][None])[0])
        count = int(np.count_nonzero(foreground))
        self.floods.append(count > max(MOST_M2 * px_per_m**2, MOST_SHARE * foreground.size))
        self._trunk.append(float(on_trunk.mean()) if len(on_trunk) else np.nan)
        self.shares.append(float(both.mean()) if len(both) else np.nan)

    def _on(self, foreground: Image, joints: Mapping[str, Array], lines: tuple[tuple[str, str], ...]) -> Array:
        """Which points of lines lie on it, 1 or 0 `(P,)`, of those within the picture."""
        names = list(joints)
        pixels = dict(zip(names, self._camera.project(np.stack([joints[name] for name in names])), strict=True))
        pixels["neck"] = 0.5 * (pixels["left_shoulder"] + pixels["right_shoulder"])
        points = np.concatenate([np.linspace(pixels[a], pixels[b], POINTS) for a, b in lines])
        points = np.rint(points[np.isfinite(points).all(axis=1)])
        u, v = points[((points >= 0) & (points < foreground.shape[::-1])).all(axis=1)].astype(int).T
        return np.asarray(foreground[v, u] > 0, dtype=np.float64)

    def reasons(self) -> list[str]:
        """Of every frame; empty where nothing speaks against it."""
        shares = recent(np.array(self._time_s), np.array(self._trunk).reshape(-1, 1))[:, 0]
        words = (UNSEEN if share < LEAST_ON_TRUNK else "" for share in shares)
        return [EVERYWHERE if floods else why for floods, why in zip(self.floods, words, strict=True)]
