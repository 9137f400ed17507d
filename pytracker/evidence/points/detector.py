"""2-D keypoints of a video, by MediaPipe's pose landmarker: offline, its model comes with its wheel.

It is the extra `keypoints`. Blazepose: Bazarevsky et al., "BlazePose: on-device real-time body pose tracking",
CVPR workshop 2020. It follows one person, the one that it finds first.
"""

from __future__ import annotations

import importlib
from types import ModuleType

import cv2
import numpy as np

from pytracker._core import InputError
from pytracker.formats.keypoints.models import COCO
from pytracker.formats.video import Frame
from pytracker.rotation import Array

__all__ = ["Detector"]

MEDIAPIPE = "mediapipe==0.10.21"
LANDMARKS = (0, 2, 5, 7, 8, *range(11, 17), *range(23, 29))
"""Of MediaPipe's 33, those of `COCO`, in its order."""
BLAZEPOSE_FULL = 1
"""The model that is in the wheel; the others would be fetched."""


class Detector:
    """Finds the joints of `COCO` in the frames of one video, in their order. A context.

    Attributes:
        name: what it is, and its version.

    Raises `InputError` where MediaPipe is not installed, or is of a version that would fetch its model.
    """

    def __init__(self) -> None:
        mediapipe = _mediapipe()
        self.name = f"MediaPipe {mediapipe.__version__}, BlazePose full"
        # Smoothed points lag, and do not show what they are worth by how they jump.
        self._pose = mediapipe.solutions.pose.Pose(model_complexity=BLAZEPOSE_FULL, smooth_landmarks=False)

    def __enter__(self) -> Detector:
        return self

    def __exit__(self, *error: object) -> None:
        self._pose.close()

    def found(self, frame: Frame) -> Array:
        """u, v, px (pixel centres at integers), and confidence of each joint `(17, 3)`; NaN where it is not seen."""
        height, width = frame.image.shape[:2]
        landmarks = self._pose.process(cv2.cvtColor(frame.image, cv2.COLOR_BGR2RGB)).pose_landmarks
        if landmarks is None:
            return np.full((len(COCO), 3), np.nan)
        shares = np.array([[mark.x, mark.y, mark.visibility] for mark in landmarks.landmark])[list(LANDMARKS)]
        points = shares * [width, height, 1.0] - [0.5, 0.5, 0.0]
        # What is not in the picture it makes up.
        points[(np.abs(shares[:, :2] - 0.5) > 0.5).any(axis=1)] = np.nan
        return np.asarray(points)


def _mediapipe() -> ModuleType:
    try:
        found = importlib.import_module("mediapipe")
    except ImportError as error:
        raise InputError(
            f"MediaPipe is not installed ({error}), expected it: pip install {MEDIAPIPE}, for Python 3.10 to 3.12"
        ) from None
    if not hasattr(found, "solutions"):
        raise InputError(
            f"MediaPipe {found.__version__} brings no model with it, expected 0.10.21: pip install {MEDIAPIPE}"
        )
    return found
