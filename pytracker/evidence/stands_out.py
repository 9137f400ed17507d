"""Whether the person differs from the background, and the rest of the picture does not.

Where they hardly do, little of the pose lies on the foreground; where everything does, every pose lies there.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.lately import ASK_EVERY_S, mean_lately
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
        self._time_s: list[float] = []
        self._on_trunk: list[float] = []
        self._on_lines: list[float] = []
        self._floods: list[bool] = []
        self._drowns: list[bool] = []

    def look(self, time_s: float, joints: Mapping[str, Array], foreground: Image) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and its foreground `(H, W)`, 255 where the person is."""
        px_per_m = float(self._camera.px_per_m(joints["root"][None])[0])
        most_px = max(MOST_M2 * px_per_m**2, MOST_SHARE * foreground.size)
        self._time_s.append(time_s)
        count = int(np.count_nonzero(foreground))
        self._floods.append(count > most_px)
        self._drowns.append(count > max(most_px, MOST_OF_ALL * foreground.size))
        on_trunk, on_lines = np.nan, np.nan
        if time_s >= self._ask_s:
            self._ask_s = time_s + ASK_EVERY_S
            on_trunk, on_lines = self._on(foreground, joints)
        self._on_trunk.append(on_trunk)
        self._on_lines.append(on_lines)

    def _on(self, foreground: Image, joints: Mapping[str, Array]) -> tuple[float, float]:
        """Share of the trunk's lines, and of all, on the foreground; NaN where they are outside the picture."""
        names = list(joints)
        pixels = dict(zip(names, self._camera.project(np.stack([joints[name] for name in names])), strict=True))
        pixels["neck"] = 0.5 * (pixels["left_shoulder"] + pixels["right_shoulder"])
        on_trunk, on_arms = (_on(foreground, pixels, lines) for lines in (TRUNK_LINES, ARM_LINES))
        return _share(on_trunk), _share(np.concatenate([on_trunk, on_arms]))

    @property
    def shares(self) -> Array:
        """Of all lines of every frame `(T,)`; NaN where they are outside the picture, or were not asked for."""
        return np.array(self._on_lines)

    @property
    def floods(self) -> NDArray[np.bool_]:
        """In which frames more than a person differs from the background `(T,)`."""
        return np.array(self._floods, dtype=bool)

    def reasons(self) -> list[str]:
        """Of every frame; empty where nothing speaks against it."""
        lately = mean_lately(np.array(self._time_s), np.array(self._on_trunk).reshape(-1, 1))[:, 0]
        hardly = [HARDLY if share < LEAST_ON_TRUNK else "" for share in lately]
        return [EVERYWHERE if drowns else why for drowns, why in zip(self._drowns, hardly, strict=True)]


def _on(foreground: Image, pixels: Mapping[str, Array], lines: tuple[tuple[str, str], ...]) -> NDArray[np.bool_]:
    """Which points of lines lie on it `(P,)`, of those within the picture."""
    points = np.concatenate([np.linspace(pixels[a], pixels[b], POINTS) for a, b in lines])
    points = np.rint(points[np.isfinite(points).all(axis=1)])
    u, v = points[((points >= 0) & (points < foreground.shape[::-1])).all(axis=1)].astype(int).T
    return np.asarray(foreground[v, u] > 0)


def _share(is_on: NDArray[np.bool_]) -> float:
    return float(is_on.mean()) if len(is_on) else float("nan")
