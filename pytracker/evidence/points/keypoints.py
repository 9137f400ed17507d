"""A detector's keypoints as evidence of frames of which there is no picture."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pytracker.rotation import Array

__all__ = ["PointsEvidence"]


@dataclass(frozen=True, eq=False)
class PointsEvidence:
    """What is known of a frame of which there is no picture.

    Attributes:
        keypoints: as of `pytracker.evidence.BodyEvidence`; None where a detector found nobody.
        edges: none.
        blobs: none `(0, 2)`.
        skin_region: none.
        foreground_region: none.
        shrunk: 1: of no picture.
    """

    keypoints: Array | None
    edges: None = None
    blobs: Array = field(default_factory=lambda: np.zeros((0, 2)))
    skin_region: None = None
    foreground_region: None = None
    shrunk: int = 1
