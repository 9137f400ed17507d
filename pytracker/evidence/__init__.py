"""Pixels to evidence, frame by frame, and all that was observed in order of time.

| file or room | what |
|---|---|
| `observations`, `ahead` | what a tracker takes, streamed in order of time; one frame ahead |
| `sightings`, `patch` | where an arm's patch is in all videos; how it is found and followed in one |
| `senses`, `picture`, `points` | all that a body's frame shows; its foreground and skin; a detector's keypoints |
| `pose` | whether frames bear out what is tracked |
| `boards`, `grid` | calibration boards; a grid of pixels |
"""

from __future__ import annotations

from pytracker.evidence.observations import observations
from pytracker.evidence.patch.camshift import PatchSighting, PatchTrack, PatchTracker, track_patch
from pytracker.evidence.patch.colour import CamshiftParameters
from pytracker.evidence.picture.background import median_background
from pytracker.evidence.picture.silhouette import BodyEvidence, Silhouette
from pytracker.evidence.picture.thresholds import SilhouetteParameters
from pytracker.evidence.senses import Senses, senses_of
from pytracker.evidence.sightings import Landmarks, Sightings, sightings_of

__all__ = [
    "BodyEvidence",
    "CamshiftParameters",
    "Landmarks",
    "PatchSighting",
    "PatchTrack",
    "PatchTracker",
    "Senses",
    "Sightings",
    "Silhouette",
    "SilhouetteParameters",
    "median_background",
    "observations",
    "senses_of",
    "sightings_of",
    "track_patch",
]
