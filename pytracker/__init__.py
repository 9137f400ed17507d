"""pytracker: human motion tracking with particle filters, on a laptop CPU, with honest error bars.

    recording = pytracker.load("trial03")
    track = pytracker.track(recording, pytracker.Layered(particles=500), seed=7)
    scores = pytracker.evaluate(track, recording.truth)
    pytracker.write_report([track], "report/")

Conventions: SI units (metres, seconds, radians, m/s²), pixels as (u right, v down) with pixel centres at integers.
Quaternions are Hamilton, w first, named for what they do: `q_world_sensor` takes sensor vectors to the world.
World: right-handed, z up for the arm; for the body the Acclaim file's own frame, y up, metres. Camera: OpenCV's (x
right, y down, z forward), `R|t` maps world to camera. Arrays are `(T, 3)`, `(N, D)`: a row is a sample. An
accelerometer at rest, z up, reads +9.81. Units are in the name where a bare number crosses a border (`forearm_m`,
`rate_hz`). The same seed gives the same bits, for any number of threads.
"""

from __future__ import annotations

import signal as _signal
import sys as _sys

if (
    _sys.orig_argv[1:3] == ["-m", "pytracker"] or "".join(_sys.argv[:1]).endswith(("/pytracker", "\\pytracker"))
) and _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
    # The command line: until `pytracker.cli` takes over, Ctrl-C ends it without a traceback of half an import.
    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)

from pytracker._core import (
    KEY_JOINTS,
    ArmTracker,
    BodyEstimate,
    BodyTracker,
    Estimate,
    InputError,
    LayerRecord,
    TrackingError,
    __version__,
    resample,
)
from pytracker.average_skeleton import average_skeleton
from pytracker.body_methods import Annealed, BodyPlain, Partitioned
from pytracker.cycle import Cloud, Cycle, CycleLayer, record_cycle
from pytracker.doubts import doubts
from pytracker.evaluate import JointScores, Scores, evaluate
from pytracker.evidence.camshift import CamshiftParameters, PatchSighting, PatchTrack, PatchTracker, track_patch
from pytracker.evidence.senses import Senses, senses_of
from pytracker.evidence.sightings import Sightings, sight
from pytracker.evidence.silhouette import BodyEvidence, Silhouette, SilhouetteParameters, median_background
from pytracker.formats.amc import Motion, read_amc, write_amc
from pytracker.formats.asf import read_asf
from pytracker.intervals import Interval, mean_interval, paired_difference, paired_ratio
from pytracker.joint_track import JointTrack, Track
from pytracker.load import load
from pytracker.methods import Ekf, Inertial, Joint, Layered, LayeredFromConstraint, Mixture, Plain, Smooth
from pytracker.projection import fit_weak_perspective
from pytracker.recording import (
    Arm,
    ArmRecording,
    BodyRecording,
    BodyView,
    Camera,
    Imu,
    ProjectionFit,
    Recording,
    Truth,
    View,
    WeakPerspective,
)
from pytracker.report import write_report
from pytracker.reproduce import reproduce
from pytracker.simulate import ArmScene, ArmSimulation, BodyScene, simulate_arm, simulate_body
from pytracker.skeleton import UPPER_BODY, Bone, Part, Skeleton
from pytracker.study import Study, StudyRecording, StudyTable, read_study, run_study
from pytracker.track import track
from pytracker.track_arm import ArmTrack
from pytracker.track_body import BodyTrack, make_tracker

__all__ = [
    "KEY_JOINTS",
    "UPPER_BODY",
    "Annealed",
    "Arm",
    "ArmRecording",
    "ArmScene",
    "ArmSimulation",
    "ArmTrack",
    "ArmTracker",
    "BodyEstimate",
    "BodyEvidence",
    "BodyPlain",
    "BodyRecording",
    "BodyScene",
    "BodyTrack",
    "BodyTracker",
    "BodyView",
    "Bone",
    "Camera",
    "CamshiftParameters",
    "Cloud",
    "Cycle",
    "CycleLayer",
    "Ekf",
    "Estimate",
    "Imu",
    "Inertial",
    "InputError",
    "Interval",
    "Joint",
    "JointScores",
    "JointTrack",
    "LayerRecord",
    "Layered",
    "LayeredFromConstraint",
    "Mixture",
    "Motion",
    "Part",
    "Partitioned",
    "PatchSighting",
    "PatchTrack",
    "PatchTracker",
    "Plain",
    "ProjectionFit",
    "Recording",
    "Scores",
    "Senses",
    "Sightings",
    "Silhouette",
    "SilhouetteParameters",
    "Skeleton",
    "Smooth",
    "Study",
    "StudyRecording",
    "StudyTable",
    "Track",
    "TrackingError",
    "Truth",
    "View",
    "WeakPerspective",
    "__version__",
    "average_skeleton",
    "doubts",
    "evaluate",
    "fit_weak_perspective",
    "load",
    "make_tracker",
    "mean_interval",
    "median_background",
    "paired_difference",
    "paired_ratio",
    "read_amc",
    "read_asf",
    "read_study",
    "record_cycle",
    "reproduce",
    "resample",
    "run_study",
    "senses_of",
    "sight",
    "simulate_arm",
    "simulate_body",
    "track",
    "track_patch",
    "write_amc",
    "write_report",
]
