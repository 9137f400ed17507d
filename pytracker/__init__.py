"""pytracker: human motion tracking with particle filters, on a laptop CPU, with honest error bars.

    recording = pytracker.load("trial03")
    track = pytracker.track(recording, pytracker.Layered(particles=500), seed=7)
    scores = pytracker.evaluate(track, recording.truth)
    pytracker.write_report([track], "report/")

Conventions: SI units (metres, seconds, radians, m/s²), pixels as (u right, v down) with pixel centres at integers.
Quaternions are Hamilton, w first, named for what they do: `q_world_sensor` takes sensor vectors to the world.
World: right-handed, z up. Camera: OpenCV's (x right, y down, z forward), `R|t` maps world to camera. Arrays are
`(T, 3)`, `(N, D)`: a row is a sample. An accelerometer at rest, z up, reads +9.81. Units are in the name where a bare
number crosses a border (`forearm_m`, `rate_hz`). The same seed gives the same bits, for any number of threads.
"""

from __future__ import annotations

from pytracker._core import ArmTracker, Estimate, InputError, TrackingError, __version__, resample
from pytracker.evaluate import JointScores, Scores, evaluate
from pytracker.evidence.camshift import CamshiftParameters, PatchSighting, PatchTrack, PatchTracker, track_patch
from pytracker.evidence.sightings import Sightings, sight
from pytracker.load import load
from pytracker.methods import Ekf, Inertial, Joint, Layered, LayeredFromConstraint, Plain
from pytracker.recording import Arm, Camera, Imu, Recording, Truth, View
from pytracker.report import write_report
from pytracker.simulate import ArmScene, ArmSimulation, simulate_arm
from pytracker.track import JointTrack, Track, track

__all__ = [
    "Arm",
    "ArmScene",
    "ArmSimulation",
    "ArmTracker",
    "Camera",
    "CamshiftParameters",
    "Ekf",
    "Estimate",
    "Imu",
    "Inertial",
    "InputError",
    "Joint",
    "JointScores",
    "JointTrack",
    "Layered",
    "LayeredFromConstraint",
    "PatchSighting",
    "PatchTrack",
    "PatchTracker",
    "Plain",
    "Recording",
    "Scores",
    "Sightings",
    "Track",
    "TrackingError",
    "Truth",
    "View",
    "__version__",
    "evaluate",
    "load",
    "resample",
    "sight",
    "simulate_arm",
    "track",
    "track_patch",
    "write_report",
]
