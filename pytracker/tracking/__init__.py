"""A recording to a track, and what can be asked of it.

| file | what |
|---|---|
| `track` | any recording by any method: `arm`, `body` by its kind; `fits`: whether it can |
| `follow` | the loop from observations to a track |
| `tracks` | what every track holds |
| `cycle` | one cycle of a particle filter, to be looked at |
| `body_watch` | what frames say of a body's estimates, one by one, as they come |
| `doubts`, `body_doubts` | what a recording says against its own description, of an arm's tried by `suspects` |
| `foreground` | of a body: whether pose and person are in one place, and the person is told from the rest |
| `upper_arm`, `body_sensors`, `swivel` | whether sensors point where an arm is, and elbows hang |
| `clocks`, `pauses` | whether clocks go together, and frames are missing |
| `alike`, `camera_moved` | whether patch and sensor move alike, and the camera stands |
| `patch_place`, `camera_place` | whether patch and camera are where they are said to be |
| `found` | what a smoothed recording says of what was measured once |
"""

from __future__ import annotations

from pytracker._core import LayerRecord, Place, resample
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.body_watch import BodyWatch
from pytracker.tracking.cycle import Cloud, Cycle, CycleLayer, record_cycle
from pytracker.tracking.doubts import doubts
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
    "doubts",
    "found_by",
    "record_cycle",
    "resample",
    "track",
]
