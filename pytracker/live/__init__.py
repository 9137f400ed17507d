"""Live: a camera and a sensor that are there now, set up by a recording that was made with them.

| file | what |
|---|---|
| `run` | estimates as frames come: a camera and a sensor, each read in a thread of its own |
| `following` | what arrives, one by one, to estimates |
| `camera` | frames of a camera, each with the time at which it arrived |
| `sensor` | a sensor's lines as they come, and its clock by when they arrive |
| `subject` | what an arm or a body takes of a frame, and what speaks against an estimate |
| `rows` | estimates as rows of a table |
"""

from __future__ import annotations

from pytracker.live.camera import camera_frames
from pytracker.live.following import Estimated, Live
from pytracker.live.rows import Rows
from pytracker.live.run import live
from pytracker.live.sensor import sensor_samples

__all__ = ["Estimated", "Live", "Rows", "camera_frames", "live", "sensor_samples"]
