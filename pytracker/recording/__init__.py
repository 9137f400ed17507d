"""A recording: cameras, IMUs, arm or skeleton, and truth, read from a folder.

| file or room | what |
|---|---|
| `recording` | what a recording holds, in SI units, world coordinates and recording time |
| `load` | a folder to a recording: `arm`, `body` by its kind |
| `schema` | what `recording.toml` may hold |
| `imu`, `body_view` | a sensor, and a body's camera, by their entries |
| `keypoints`, `truth` | what a detector found, and what was measured besides |
| `arm_start`, `upper_arm`, `worn` | an arm's first place; sensors on an upper arm, on a body's segments |
| `found_pose`, `upright` | a first pose that was found; worlds with another axis up |
| `camera`, `projection` | pinhole and weak perspective; the latter from point pairs |
"""

from __future__ import annotations

from pytracker.recording.camera import Camera, ProjectionFit, WeakPerspective
from pytracker.recording.load import load
from pytracker.recording.projection import fit_weak_perspective
from pytracker.recording.recording import Arm, ArmRecording, BodyRecording, BodyView, Imu, Recording, Truth, View

__all__ = [
    "Arm",
    "ArmRecording",
    "BodyRecording",
    "BodyView",
    "Camera",
    "Imu",
    "ProjectionFit",
    "Recording",
    "Truth",
    "View",
    "WeakPerspective",
    "fit_weak_perspective",
    "load",
]
