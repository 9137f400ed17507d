"""Arms of real people by their captured joints, with sensors that are simulated as worn: real movement, real shoulders.

`python tests/captured_arm.py` prints the table of docs/accuracy.md. Tuned on `TUNED`; `KEPT` was kept back.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, filtfilt

import pytracker as pt
from pytracker.formats.amc import read_amc
from pytracker.formats.asf import read_asf
from pytracker.formats.c3d import read_c3d
from pytracker.formats.trc import read_trc
from pytracker.methods import ArmMethod
from pytracker.rotation import axes_to_quaternion, triple
from pytracker.scores.evaluate import JointScores, held
from pytracker.simulate.arm import ArmSimulation, look_at

Array = NDArray[np.float64]

GESTURES = {"20": "0_1_20_p0", "21": "0_1_21_p0", "22": "0_1_22_p0", "24": "0_1_24_p0", "29": "0_1_29_p1",
            "31": "0_1_31_p1", "33": "0_1_33_p1"}  # fmt: skip
TUNED = (*(f"{clip} {side}" for clip in ("20", "22", "29", "33") for side in "LR"), "box", "49_18 L", "49_18 R")
KEPT = (*(f"{clip} {side}" for clip in ("21", "24", "31") for side in "LR"), "49_19 L", "49_19 R")

CUT_HZ = 6.0
"""No arm moves faster; what is faster is the capture's noise."""
MARGIN_S = 0.1
PIXEL_SD = 2.0


class CapturedArm(ArmSimulation):
    """Joints that were captured at `time_s` `(T,)`: shoulder, elbow and wrist `(T, 3)`, m, z up.

    Filmed from `azimuth_deg`. Lengths and the shoulder's place are what a tape measure gives at the start, and 3 % off.
    """

    def __init__(self, time_s: Array, joints: Iterable[Array], azimuth_deg: float, seed: int) -> None:
        filtered = [smooth_path(time_s, points) for points in joints]
        self._shoulder, self._elbow, self._wrist = filtered
        self.azimuth_deg, self.seed = azimuth_deg, seed
        duration_s = float(time_s[-1] - time_s[0])
        shoulder, elbow, wrist = (path(np.linspace(MARGIN_S, duration_s - MARGIN_S, 500)) for path in filtered)
        self.scene = pt.ArmScene(
            worn=True,
            duration_s=duration_s - 3 * MARGIN_S,
            centre_m=triple(wrist.mean(axis=0)),
            shoulder_m=triple(shoulder[0]),
            upper_arm_m=float(np.linalg.norm(shoulder - elbow, axis=1).mean()),
            forearm_m=float(np.linalg.norm(wrist - elbow, axis=1).mean()),
        )

    def wrist(self, time_s: Array) -> Array:
        return np.asarray(self._wrist(time_s + MARGIN_S))

    def shoulder(self, time_s: Array) -> Array:
        return np.asarray(self._shoulder(time_s + MARGIN_S))

    def elbow(self, time_s: Array) -> Array:
        return np.asarray(self._elbow(time_s + MARGIN_S))

    def q_world_forearm(self, time_s: Array) -> Array:
        y = self.elbow(time_s) - self.wrist(time_s)
        y /= np.linalg.norm(y, axis=1, keepdims=True)
        z = np.array([0.0, 0.0, 1.0]) - y * y[:, 2:]
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        return axes_to_quaternion(np.cross(y, z), y, z)

    @property
    def cameras(self) -> tuple[pt.Camera, ...]:
        return (look_at(self.scene.centre_m, self.azimuth_deg, 10.0, 2.5, (0.0, 0.0, 0.0)),)

    def tracked(self, method: ArmMethod) -> pt.Track:
        """By a method, from the patch's centres with some noise."""
        sightings = pt.Sightings.of(self.frame_time_s, self.sightings(PIXEL_SD))
        return pt.track(self.recording(), method, self.seed, sightings=sightings)


def smooth_path(time_s: Array, points: Array) -> Callable[[Array], Array]:
    """A path through captured points `(T, 3)`, gaps bridged, from 0 s on."""
    whole = np.array(points, dtype=float)
    for column in whole.T:
        known = np.isfinite(column)
        column[:] = np.interp(time_s, time_s[known], column[known])
    b, a = butter(2, CUT_HZ * 2 * np.median(np.diff(time_s)))
    path: Callable[[Array], Array] = CubicSpline(time_s - time_s[0], filtfilt(b, a, whole, axis=0))
    return path


@cache
def captured(shared: Path, name: str) -> tuple[Array, tuple[Array, Array, Array], float]:
    """Times, joints and where the camera stands, of one of `TUNED` or `KEPT`."""
    clip, _, side = name.partition(" ")
    data = shared / "data"
    if clip in GESTURES:
        marked = read_trc(data / "people" / "gestures" / f"{GESTURES[clip]}.trc")
        shoulder, elbow, wrist = (marked.positions_m[side + joint] for joint in ("Shoulder", "Elbow", "Wrist"))
        return marked.time_s, (shoulder, elbow, wrist), 180.0
    if clip == "box":
        found = read_c3d(data / "markers" / "pyomeca_markers_analogs.c3d")
        at = found.positions_m
        joints = at["ACRO_tip"], 0.5 * (at["EPICl"] + at["EPICm"]), 0.5 * (at["STYLr"] + at["STYLu"])
        assert found.rate_hz is not None
        return np.arange(len(joints[0])) / found.rate_hz, joints, 90.0
    skeleton = read_asf(data / "cmu" / "49.asf")
    at = skeleton.joints(read_amc(data / "cmu" / f"{clip}.amc", skeleton).poses)
    which = "left" if side == "L" else "right"
    shoulder, elbow, wrist = (at[f"{which}_{joint}"][:, [2, 0, 1]] for joint in ("shoulder", "elbow", "wrist"))
    return np.arange(len(wrist)) / 120.0, (shoulder, elbow, wrist), -90.0


def scored(shared: Path, name: str, method: ArmMethod, seed: int) -> tuple[JointScores, float]:
    """The wrist's scores, of what could be tracked, and the RMS error of the first place held, m."""
    simulation = CapturedArm(*captured(shared, name), seed)
    try:
        track = simulation.tracked(method)
    except pt.TrackingError as error:
        if error.track is None:
            raise
        track = error.track
    ours, still = (pt.evaluate(of, track.recording.truth).joints["wrist"] for of in (track, held(track)))
    return ours, still.rms_m


def pooled(shared: Path, names: Iterable[str], method: ArmMethod, seeds: Iterable[int]) -> tuple[float, Array, float]:
    """3-D RMS of the wrist, m, coverage per axis, and 3-D RMS of the first place held, over clips and seeds."""
    runs = [(name, seed) for name in names for seed in seeds]
    found = [scored(shared, name, method, seed) for name, seed in runs]
    rms, still = (np.sqrt(np.mean(np.square(each))) for each in ([f[0].rms_m for f in found], [f[1] for f in found]))
    return float(rms), np.mean([ours.coverage for ours, _ in found], axis=0), float(still)


METHODS: tuple[ArmMethod, ...] = (
    pt.Smooth(), pt.Mixture(), pt.Joint(), pt.Layered(),
    pt.Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15),
)  # fmt: skip


def main() -> None:
    shared = Path(__file__).parents[2] / "shared"
    if not shared.is_dir():
        sys.exit(f"{shared} is absent")
    with ProcessPoolExecutor() as pool:
        runs = [(method, names) for method in METHODS for names in (TUNED, KEPT)]
        each = [pool.submit(pooled, shared, names, method, range(1, 6)) for method, names in runs]
        for (method, names), run in zip(runs, each, strict=True):
            rms, inside, still = run.result()
            which = "tuned on" if names is TUNED else "kept back"
            print(f"{method.name}, {which}: {100 * rms:.1f} cm, bands {np.round(100 * inside)}, held {100 * still:.1f}")


if __name__ == "__main__":
    main()
