"""Pixels to evidence, frame by frame, and all that was observed in order of time.

| file | what |
|---|---|
| `patch_colour`, `camshift`, `sightings` | an arm's colour patch in a frame, in one video, in all of them |
| `standing` | what of its colour stands where it is |
| `landmarks` | an arm's shoulder and elbow, by further patches or keypoints |
| `silhouette`, `skin`, `thresholds`, `smaller` | a body's foreground, edges and skin, in pictures as large as need be |
| `background`, `left_behind` | the scene without the person; what stays where a hand was |
| `complexion` | what the light does to skin |
| `keypoints`, `senses` | a detector's points; all that is seen of a frame |
| `detector`, `person` | a detector of our own; who is largest in a frame |
| `observations`, `ahead` | what a tracker takes, streamed in order of time; one frame ahead |
| `subject`, `followed`, `points_late` | whose keypoints are whose, left or right, and of which frame |
| `lag`, `clocks`, `hanging` | whether a patch moves as the sensor does: later, slower, or not at all |
| `borne_out`, `points_borne_out`, `ambiguity` | whether pictures, skin and keypoints bear a pose out |
| `lately`, `frozen` | what was so over the last moments; pictures that hung |
| `trunk`, `stature`, `facing` | whether who is seen is as large, as tall, and turned as is tracked |
| `stands_out`, `cut_off` | whether the person differs from the background; whether hands may be hidden |
| `coloured`, `boards`, `grid` | coloured things that move; calibration boards; a grid of pixels |
"""

from __future__ import annotations

from pytracker.evidence.background import median_background
from pytracker.evidence.camshift import PatchSighting, PatchTrack, PatchTracker, track_patch
from pytracker.evidence.observations import observations
from pytracker.evidence.patch_colour import CamshiftParameters
from pytracker.evidence.senses import Senses, senses_of
from pytracker.evidence.sightings import Landmarks, Sightings, sightings_of
from pytracker.evidence.silhouette import BodyEvidence, Silhouette
from pytracker.evidence.thresholds import SilhouetteParameters

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
