"""What makes a recording ready.

| file | what |
|---|---|
| `begin` | `init`: a first recording.toml from the files that there are |
| `known`, `subject_entry`, `truth_entry` | what it says of camera and arm, of the subject, and of the truth |
| `upright` | which axis is up in a calibration's world |
| `draft` | recording.toml while it is incomplete |
| `check` | `check`: everything looked at; `check_camera`, `check_imu`, `check_worn`, `check_body`: its parts |
| `findings` | a line |
| `detect` | keypoints found in the video |
| `first_pose` | a body's first pose from keypoints; `first_person`: whose |
| `first_outline` | the same from outline and skin, where there are none |
| `pose_fit` | how either is fitted |
| `frame` | one frame with a grid |
| `calibrate` | a camera from a video of a board; its pose from points, or from tape and level |
| `conventions` | units, quaternion and earth frame, from an IMU's numbers alone |
| `worn` | clock, heading and the axis along the forearm, from all that is known |
"""

from pytracker.setup.begin import init
from pytracker.setup.check import Checkup, check
from pytracker.setup.detect import Detected, detect
from pytracker.setup.findings import Finding

__all__ = ["Checkup", "Detected", "Finding", "check", "detect", "init"]
