"""An arm's overlay: the first camera's video, what was seen in it, the tracked arm and its 95 % ellipse."""

from __future__ import annotations

from pathlib import Path
from threading import Event

import cv2
import numpy as np

from pytracker.formats.video import Image
from pytracker.recording.camera import Camera
from pytracker.report.overlay import caption, enlarged, write_overlay
from pytracker.rotation import Array
from pytracker.tracking.arm import ArmTrack

__all__ = ["draw_arm", "write_arm_overlay"]

CHI2_95 = 5.991
ARM = (153, 110, 11)
BAND = (235, 200, 120)
PATCH = (60, 60, 230)


def write_arm_overlay(path: Path, track: ArmTrack, stop: Event) -> bool:
    """Write it, until `stop` is set; False where the recording has no video. Raises as `write_overlay`."""
    view = track.recording.views[0]
    if view.video is None:
        return False
    # The first camera's own frames: with several cameras the track has rows of the others between them.
    own = track.sightings.tracks[0].time_s if track.sightings.tracks else track.time_s
    return write_overlay(
        path, view.video, view.start_s, own, track.time_s, lambda image, row: draw_arm(image, track, row), stop
    )


def draw_arm(frame: Image, track: ArmTrack, row: int) -> Image:
    """One frame, scaled to `WIDTH`, annotated."""
    image, scale = enlarged(frame)
    camera = track.recording.views[0].camera
    wrist, elbow = track.joints["wrist"].mean[row], track.joints["elbow"].mean[row]
    if np.isfinite(wrist).all():
        _ellipse(image, camera, wrist, track.wrist_covariance[row], scale)
        shoulder = np.asarray(track.recording.arm.shoulder_m)
        points = camera.project(np.stack([shoulder, elbow, wrist])) * scale
        if np.isfinite(points).all() and np.abs(points).max() < 10_000:
            corners = np.rint(points).astype(np.int32)
            cv2.polylines(image, [corners], False, ARM, 2, cv2.LINE_AA)
            for corner in corners:
                cv2.circle(image, corner.tolist(), 4, ARM, -1, cv2.LINE_AA)
    others = [of.pixels[row] for of in track.sightings.landmarks if of.camera == 0]
    for seen in (track.sightings.pixels[row, 0], *others):
        if np.isfinite(seen).all():
            at = np.rint(seen * scale).astype(int).tolist()
            cv2.drawMarker(image, at, PATCH, cv2.MARKER_CROSS, 12, 2, cv2.LINE_AA)
    caption(image, f"{track.time_s[row]:6.2f} s  {track.reason[row]}")
    return image


def _ellipse(image: Image, camera: Camera, wrist: Array, covariance: Array, scale: float) -> None:
    """The 95 % ellipse of the wrist in the image."""
    h = 1e-3
    around = camera.project(np.concatenate([wrist + h * np.eye(3), wrist - h * np.eye(3)])) * scale
    slope = (around[:3] - around[3:]).T / (2 * h)
    spread = CHI2_95 * slope @ covariance @ slope.T
    centre = camera.project(wrist[None])[0] * scale
    if not (np.isfinite(spread).all() and np.isfinite(centre).all()):
        return
    values, vectors = np.linalg.eigh(spread)
    half = np.sqrt(np.maximum(values, 0.0))
    if half.max() < 1000:
        angle = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
        axes = (max(1, round(half[1])), max(1, round(half[0])))
        cv2.ellipse(image, np.rint(centre).astype(int).tolist(), axes, angle, 0, 360, BAND, 2, cv2.LINE_AA)
