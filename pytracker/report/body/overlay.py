"""A body's overlay, as Li & Kulić Fig. 9: green skeleton, white rectangles, and blobs of skin that weighed.

Forearms are orange where their wrist is not valid.
"""

from __future__ import annotations

from pathlib import Path
from threading import Event

import cv2
import numpy as np

from pytracker.formats.video import Image
from pytracker.report.overlay import caption, enlarged, write_overlay
from pytracker.rotation import Array
from pytracker.skeleton.skeleton import Part
from pytracker.tracking.body import BodyTrack

__all__ = ["draw_body", "write_body_overlay"]

SKELETON = (60, 200, 60)
UNSURE = (0, 140, 255)
"""Forearms whose wrist is not valid."""
SHAPE = (255, 255, 255)
SKIN = (60, 60, 230)
LOWER_ARM = ("radius", "wrist", "hand")
LEGS = ("femur", "tibia", "foot", "toes", "hipjoint", "fingers", "thumb")


def write_body_overlay(path: Path, track: BodyTrack, stop: Event) -> bool:
    """Write it, until `stop` is set. Raises as `write_overlay`."""
    view = track.recording.view
    if view.video is None:
        return False
    return write_overlay(
        path, view.video, view.start_s, track.time_s, track.time_s, lambda i, row: draw_body(i, track, row), stop
    )


def draw_body(frame: Image, track: BodyTrack, row: int) -> Image:
    """One frame, enlarged, with the expected pose of that row."""
    image, scale = enlarged(frame)
    if np.isfinite(track.poses[row]).all():
        starts, ends, _ = track.recording.skeleton.core.pose(track.poses[row : row + 1])
        is_known = {side[0]: track.joints[f"{side}_wrist"].valid[row] for side in ("left", "right")}
        for part in track.recording.skeleton.outer_shape(track.method.crown_m):
            _rectangle(image, track, part, starts[0], ends[0], scale)
        for k, bone in enumerate(track.recording.skeleton.bones):
            if not bone.name.endswith(LEGS):
                ends_px = track.recording.view.camera.project(np.stack([starts[0, k], ends[0, k]])) * scale
                _line(image, ends_px, SKELETON if bone.name[1:] not in LOWER_ARM or is_known[bone.name[0]] else UNSURE)
    for blob in track.blobs[row]:
        if "blobs" in track.method.cues and np.isfinite(blob).all():
            cv2.circle(image, np.rint(blob * scale).astype(int).tolist(), 6, SKIN, 2, cv2.LINE_AA)
    caption(image, f"{track.time_s[row]:6.2f} s  {track.reason[row]}")
    return image


def _line(image: Image, pixels: Array, colour: tuple[int, int, int]) -> None:
    if np.isfinite(pixels).all() and np.abs(pixels).max() < 10_000:
        a, b = np.rint(pixels).astype(int).tolist()
        cv2.line(image, a, b, colour, 2, cv2.LINE_AA)


def _rectangle(image: Image, track: BodyTrack, part: Part, starts: Array, ends: Array, scale: float) -> None:
    """The outline that the edge cue walks."""
    skeleton, camera = track.recording.skeleton, track.recording.view.camera
    places = np.stack(
        [
            starts[skeleton.bone(bone)] * (1 - along) + ends[skeleton.bone(bone)] * along
            for bone, along in (part.start, part.end)
        ]
    )
    pixels, widths = camera.project(places) * scale, np.array(part.half_width_m) * camera.px_per_m(places) * scale
    along = pixels[1] - pixels[0]
    length = float(np.linalg.norm(along))
    normal = np.array([-along[1], along[0]]) / length if length > 1e-9 else np.array([1.0, 0.0])
    corners = np.array(
        [
            pixels[0] + normal * widths[0],
            pixels[1] + normal * widths[1],
            pixels[1] - normal * widths[1],
            pixels[0] - normal * widths[0],
        ]
    )
    if np.isfinite(corners).all() and np.abs(corners).max() < 10_000:
        cv2.polylines(image, [np.rint(corners).astype(np.int32)], True, SHAPE, 1, cv2.LINE_AA)
