"""A recording to a track.

| file | what |
|---|---|
| `track` | any recording by any method: `arm`, `body` by its kind; `fits`: whether it can |
| `follow` | the loop from observations to a track |
| `tracks` | what every track holds |
| `cycle` | one cycle of a particle filter, to be looked at |
| `body_watch` | what frames say of a body's estimates, one by one, as they come |
| `alike`, `camera_moved` | whether patch and sensor move alike, and the camera stands |
| `found` | what a smoothed recording says of what was measured once |
"""

from __future__ import annotations

from pytracker._core import LayerRecord, Place, resample
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.body_watch import BodyWatch
from pytracker.tracking.cycle import Cloud, Cycle, CycleLayer, record_cycle
from pytracker.tracking.found import Found, found_by
from pytracker.tracking.track import default_method, track
from pytracker.tracking.tracks import JointTrack, Track

__all__ = [
    "ArmTrack",
    "BodyTrack",
    "BodyWatch",
    "Cloud",
    "Cycle",
    "CycleLayer",
    "Found",
    "JointTrack",
    "LayerRecord",
    "Place",
    "Track",
    "default_method",
    "found_by",
    "record_cycle",
    "resample",
    "track",
]
