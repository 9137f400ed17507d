"""pytracker: human motion tracking with particle filters, on a laptop CPU, with honest error bars.

    recording = pytracker.load("trial03")
    track = pytracker.track(recording, pytracker.Layered(particles=500), seed=7)
    scores = pytracker.evaluate(track, recording.truth)
    pytracker.write_report([track], "report/")

Data flows one way: `formats` are read into a `recording`, whose pixels become `evidence`, which by a choice of
`methods` and `tracking` becomes a track, of which `doubting` asks, and which gets `scores` and a `report`; `cli` types
the same. Beside the stream: `inertial` is what every IMU log must pass, `setup` makes a recording ready, `simulate`
makes one from nothing, `live` follows a camera that is there now, `study` runs many, `reproduce` the papers'. What is
not named here is in those modules: `from pytracker.evidence import PatchTracker`.

Conventions: SI units (metres, seconds, radians, m/s²), pixels as (u right, v down) with pixel centres at integers.
Quaternions are Hamilton, w first, named for what they do: `q_world_sensor` takes sensor vectors to the world.
World: right-handed, z up for the arm; for the body the Acclaim file's own frame, y up, metres. Camera: OpenCV's (x
right, y down, z forward), `R|t` maps world to camera. Arrays are `(T, 3)`, `(N, D)`: a row is a sample. An
accelerometer at rest, z up, reads +9.81. Units are in the name where a bare number crosses a border (`forearm_m`,
`rate_hz`). The same seed gives the same bits, for any number of threads.
"""

from __future__ import annotations

import sys as _sys

if _sys.orig_argv[1:3] == ["-m", "pytracker"] or "".join(_sys.argv[:1]).endswith(("/pytracker", "\\pytracker")):
    # The command line: until `pytracker.cli` takes over, Ctrl-C ends it without a traceback of half an import.
    try:
        import signal as _signal

        if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
            _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    except KeyboardInterrupt:
        raise SystemExit(130) from None

from pytracker._core import Estimate, InputError, Observation, Tracker, TrackingError, __version__
from pytracker.doubting import doubts
from pytracker.evidence import Sightings
from pytracker.methods import (
    Annealed,
    BodyMixture,
    BodyPlain,
    BodySmooth,
    Ekf,
    Inertial,
    Joint,
    Layered,
    LayeredFromConstraint,
    Mixture,
    Partitioned,
    Plain,
    Smooth,
)
from pytracker.recording import Arm, ArmRecording, BodyRecording, BodyView, Camera, Imu, Recording, Truth, View, load
from pytracker.report import write_report
from pytracker.reproduce import reproduce
from pytracker.scores import Scores, evaluate
from pytracker.simulate import ArmScene, BodyScene, simulate_arm, simulate_body
from pytracker.skeleton import Skeleton
from pytracker.study import read_study, run_study
from pytracker.tracking import Track, record_cycle, track

__all__ = [
    "Annealed",
    "Arm",
    "ArmRecording",
    "ArmScene",
    "BodyMixture",
    "BodyPlain",
    "BodyRecording",
    "BodyScene",
    "BodySmooth",
    "BodyView",
    "Camera",
    "Ekf",
    "Estimate",
    "Imu",
    "Inertial",
    "InputError",
    "Joint",
    "Layered",
    "LayeredFromConstraint",
    "Mixture",
    "Observation",
    "Partitioned",
    "Plain",
    "Recording",
    "Scores",
    "Sightings",
    "Skeleton",
    "Smooth",
    "Track",
    "Tracker",
    "TrackingError",
    "Truth",
    "View",
    "__version__",
    "doubts",
    "evaluate",
    "load",
    "read_study",
    "record_cycle",
    "reproduce",
    "run_study",
    "simulate_arm",
    "simulate_body",
    "track",
    "write_report",
]
