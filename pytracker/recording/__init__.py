"""A recording: cameras, IMUs, arm or skeleton, and truth, read from a folder.

| file | what |
|---|---|
| `recording` | what a recording holds, in SI units, world coordinates and recording time |
| `load` | a folder to a recording: `arm`, `body` by its kind; `body_view`, `imu`, `keypoints`, `truth` by entry |
| `arm_start`, `upper_arm` | an arm's first place; a second sensor on it |
| `arm_truth`, `body_truth` | what was measured besides, checked |
| `truth_filled`, `truth_strays` | rows of it that nobody measured |
| `truth_names` | points that are called like joints |
| `keypoint_frames`, `keypoint_spreads` | of which frames, and how good |
| `keypoints_filled`, `keypoints_stuck` | which nobody saw |
| `found_pose`, `upright` | a first pose that was found; worlds with another axis up |
| `camera` | pinhole and weak perspective |
| `schema` | what `recording.toml` may hold |
| `worn` | how a sensor lies on a body's segment |
| `projection` | weak perspective from point pairs |
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
