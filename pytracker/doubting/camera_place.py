"""Whether a body's camera stands where it is said to: by where the first pose's feet would be in the world.

A laboratory's world begins on its floor. One whose camera's place was written where the translation belongs, or whose
metres are ten times too long, has people who stand in the air.
"""

from __future__ import annotations

import numpy as np

from pytracker.recording.camera import Camera
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.tracks import where_of

__all__ = ["of_camera_place"]

FAR_M = 10.0
"""Nobody is filmed so far from where a room's world begins."""
FLOOR_M, AIR_M = 0.12, 0.35
"""On the floor, and in the air or below it."""
PLACE_M = 0.5
"""A camera nearer to where the world begins is where it begins: that tells no floor."""


def of_camera_place(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the first pose stands on the floor if the translation is taken for the camera's place."""
    recording, camera = track.recording, track.recording.view.camera
    if not isinstance(camera, Camera):
        return ()
    root = recording.skeleton.joints(recording.initial[None])["root"][0]
    if np.linalg.norm(root) > FAR_M:
        return (
            f"{where_of(recording)}: in the first pose the person is at {np.round(root, 1).tolist()} m, expected "
            f"within {FAR_M:g} m of where the world begins: is the camera's translation_m in metres?",
        )
    rotation, translation = np.array(camera.rotation), np.array(camera.translation_m)
    _, ends, _ = recording.skeleton.core.pose(np.ascontiguousarray(recording.initial[None], dtype=float))
    feet = ends[0][np.argmin(ends[0][:, 1])]
    # The same in the camera's frame, from where the camera would stand.
    otherwise = feet + rotation.T @ translation + translation
    stands = abs(otherwise[1]) < FLOOR_M and abs(feet[1]) > AIR_M
    if not stands or np.linalg.norm(translation) < PLACE_M:
        return ()
    return (
        f"{where_of(recording)}: in the first pose the feet are {feet[1]:.2f} m above where the world begins, and "
        f"would be at {otherwise[1]:.2f} m if camera.translation_m were where the camera stands: is it? A translation "
        "is -rotation times that place",
    )
