"""Whether a face is seen of who is taken to be seen from behind: left and right are then exchanged."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.picture.silhouette import BodyEvidence
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["LEAST_SEEN", "FaceSeen", "seen_from_behind"]

FACE_M = 0.06
"""Half as wide as a face."""
BEHIND = 0.3
"""Cosine between the viewing ray and where who is seen from behind looks; from the side it is less."""
LEAST_SEEN = 0.5
"""In fewer of the frames nobody is seen from behind."""


def seen_from_behind(camera: Camera | WeakPerspective, joints: Mapping[str, Array]) -> NDArray[np.bool_]:
    """In which frames `(T,)` joints, `(T, 3)` each, world, m, show a back."""
    left, right, head = (joints[name] for name in ("left_shoulder", "right_shoulder", "head"))
    ahead = np.cross(left - right, head - 0.5 * (left + right))
    away = camera.viewing_directions(head)
    return np.asarray((ahead * away).sum(axis=1) > BEHIND * np.linalg.norm(ahead, axis=1))


class FaceSeen:
    """How much of the head is skin, of a skeleton that is seen from behind."""

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._skin: list[float] = []

    def look(self, joints: Mapping[str, Array], evidence: BodyEvidence) -> None:
        """Take a frame's mean joints, `(3,)` each, world, m, and what it shows."""
        if not seen_from_behind(self._camera, {name: place[None] for name, place in joints.items()})[0]:
            self._skin.append(np.nan)
            return
        head = joints["head"]
        radius_px = FACE_M * float(self._camera.px_per_m(head[None])[0])
        self._skin.append(_share(evidence.skin, self._camera.project(head[None])[0], radius_px))

    @property
    def on_back(self) -> float:
        """Share of the head that is skin, the median of the frames; 0 where most do not have it seen from behind."""
        known = [share for share in self._skin if np.isfinite(share)]
        return float(np.median(known)) if known and len(known) >= LEAST_SEEN * len(self._skin) else 0.0


def _share(skin: NDArray[np.uint8], at: Array, radius_px: float) -> float:
    """Of a disc about a pixel that is skin; NaN outside the picture."""
    rows, columns = np.ogrid[: skin.shape[0], : skin.shape[1]]
    disc = (columns - at[0]) ** 2 + (rows - at[1]) ** 2 <= radius_px**2
    return float((skin[disc] > 0).mean()) if disc.any() else np.nan
