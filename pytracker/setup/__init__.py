"""What makes a recording ready.

| file | what |
|---|---|
| `begin` | `init`: a first recording.toml from the files that there are; `entries`: what it says of them |
| `draft` | recording.toml while it is incomplete |
| `check` | `check`: everything looked at; `checks`: its parts |
| `conventions`, `worn` | of an IMU units, quaternion and earth frame; clock, heading and the axis along the forearm |
| `clap` | the clock of an IMU from frames in which hands met |
| `heading` | the heading again, by what a worn sensor and a living shoulder do |
| `upright` | which axis is up in a calibration's world |
| `poses` | a body's first pose, from keypoints or from outline and skin |
| `detect` | keypoints found in the video |
| `frame` | one frame with a grid |
| `calibrate` | a camera from a video of a board; its pose from points, or from tape and level |
"""

from pytracker.setup.begin import init
from pytracker.setup.check import Checkup, check
from pytracker.setup.checks.findings import Finding
from pytracker.setup.detect import Detected, detect

__all__ = ["Checkup", "Detected", "Finding", "check", "detect", "init"]
