"""Whether a body's camera stands where it is said to: by where the first pose's feet would be in the world.

A laboratory's world begins on its floor, or on a table. One whose camera's place was written where the translation
belongs, whose metres are ten times too long, whose picture was cut or whose rotation is transposed has people who stand
in the air.
"""

from __future__ import annotations

import numpy as np

from pytracker.recording.camera import Camera
from pytracker.rotation import Array
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.tracks import where_of

__all__ = ["of_camera_place"]

FAR_M = 10.0
"""Nobody is filmed so far from where a room's world begins."""
FLOOR_M, AIR_M = 0.12, 0.35
"""On the floor, and in the air or below it."""
LOOKS_UP_DEG, LOW_M = 10.0, 0.5
"""A camera that looks up by more at who stands is near the ground."""
PLACE_M = 0.5
"""A camera nearer to where the world begins is where it begins: that tells no floor."""


def of_camera_place(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the first pose does not stand on the floor, and what would explain it."""
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
    if np.linalg.norm(translation) < PLACE_M:
        return ()
    said = _as_place(feet, rotation, translation) or _transposed(feet, rotation, camera.position_m[1]) or _in_air(feet)
    return (f"{where_of(recording)}: in the first pose the feet are {said}",) if said else ()


def _as_place(feet: Array, rotation: Array, translation: Array) -> str:
    """In words, where who stands would stand on the floor if the camera stood at `translation`."""
    # The same in the camera's frame, from where the camera would stand.
    otherwise = feet + rotation.T @ translation + translation
    if not (abs(otherwise[1]) < FLOOR_M and abs(feet[1]) > AIR_M):
        return ""
    return (
        f"{feet[1]:.2f} m above where the world begins, and would be at {otherwise[1]:.2f} m if camera.translation_m "
        "were where the camera stands: is it? A translation is -rotation times that place"
    )


def _transposed(feet: Array, rotation: Array, camera_m: float) -> str:
    """In words, where a camera looks up from near the ground, which is not where the world begins."""
    up, down = (float(np.degrees(np.arcsin(np.clip(part, -1.0, 1.0)))) for part in (rotation[2, 1], -rotation[1, 2]))
    is_near = FLOOR_M < abs(feet[1]) < AIR_M  # worlds that begin on a table, or a stage, begin farther off
    if not (up > LOOKS_UP_DEG and camera_m - feet[1] < LOW_M and is_near):
        return ""
    side = "above" if feet[1] > 0 else "below"
    return (
        f"{abs(feet[1]):.2f} m {side} where the world begins, and the camera looks up by {up:.0f}° from "
        f"{camera_m - feet[1]:.2f} m above them, expected one ground for both: does camera.rotation take the camera to "
        f"the world? Its transpose looks down by {down:.0f}°"
    )


def _in_air(feet: Array) -> str:
    """In words, where who stands does so high above where the world begins."""
    if not feet[1] > AIR_M:
        return ""
    return (
        f"{feet[1]:.2f} m above where the world begins, expected on its floor or below it: was the picture cut (then "
        "camera.matrix is another), or is the camera's rotation or translation_m another's?"
    )
