"""`evaluate(track, truth)`: how far off a track is, in the terms of Tao & Hu's Table I and Li & Kulić's V-B.

Knows arrays of positions and nothing of filters or files.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.rotation import Triple, triple

if TYPE_CHECKING:
    from pytracker.recording.camera import Camera, WeakPerspective
    from pytracker.recording.recording import Truth
    from pytracker.rotation import Array
    from pytracker.tracking.tracks import JointTrack

__all__ = [
    "WITHIN_M",
    "JointScores",
    "Scored",
    "Scores",
    "SpeedBin",
    "average_error",
    "error_by_speed",
    "evaluate",
    "frames_to_recover",
    "held",
]

WITHIN_M = 0.05
"""The paper's error band (IV-A, Fig. 7)."""
LOST_M = 0.2
"""A joint that is farther off across the picture is lost."""


@dataclass(frozen=True)
class JointScores:
    """One joint against the truth; metres, per axis x, y, z unless said.

    Attributes:
        frames: how many were scored.
        mean_m: mean error (Table I).
        sd_m: standard deviation of the error (Table I).
        rms_m: 3-D root mean square error.
        median_m: median 3-D error.
        across_m: median error across the picture of the track's camera.
        depth_m: median error along its viewing direction, without sign.
        lost_share: share of frames that are off by more than 20 cm across the picture.
        average_m: mean 3-D error (Li & Kulić: Joint Average Error).
        average_sd_m: its standard deviation.
        worst_m: largest 3-D error.
        worst_frame: the frame that has it.
        within_5cm: share of frames within ±5 cm on every axis.
        coverage: share of frames whose 95 % band holds the truth; NaN of what has no bands.
        half_width_m: mean half-width of the band; likewise.
    """

    frames: int
    mean_m: Triple
    sd_m: Triple
    rms_m: float
    median_m: float
    across_m: float
    depth_m: float
    lost_share: float
    average_m: float
    average_sd_m: float
    worst_m: float
    worst_frame: int
    within_5cm: float
    coverage: Triple
    half_width_m: Triple


@dataclass(frozen=True)
class Scores:
    """A track against the truth.

    Attributes:
        joints: by joint.
        average_m: mean 3-D error over all joints and frames (Li & Kulić: Overall Average Error).
        average_sd_m: its standard deviation.
        frames: frames of the track.
        frames_without_truth: frames that no truth covers; left out.
        frames_untracked: frames that were not tracked; left out.
        valid_share: share of frames that were tracked with the patch seen and the IMU heard.
    """

    joints: Mapping[str, JointScores]
    average_m: float
    average_sd_m: float
    frames: int
    frames_without_truth: int
    frames_untracked: int
    valid_share: float

    def figure_m(self, judged_by: str) -> float:
        """The one figure of a track: RMS error of the joint `judged_by`; where that is empty, the average of all."""
        return self.joints[judged_by].rms_m if judged_by else self.average_m

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON."""
        return asdict(self)


class Scored(Protocol):
    """What is scored: a `Track`, or one read back from `track.csv`."""

    @property
    def time_s(self) -> Array:
        """Recording time `(T,)`, s."""

    @property
    def joints(self) -> Mapping[str, JointTrack]:
        """By name."""

    @property
    def valid(self) -> NDArray[np.bool_]:
        """`(T,)`."""

    @property
    def camera(self) -> Camera | WeakPerspective:
        """In whose picture and depth errors are taken apart."""


def evaluate(track: Scored, truth: Truth | None) -> Scores:
    """Score every joint that both have. Frames without truth or without a track are counted and left out.

    Raises `InputError` where there is no truth, no joint in common or no frame to score.
    """
    if truth is None:
        raise InputError("the recording has no truth, expected [truth] in recording.toml")
    joints = [joint for joint in track.joints if joint in truth.joints_m]
    if not joints:
        raise InputError(f"truth has {', '.join(truth.joints_m)}, expected one of {', '.join(track.joints)}")
    scores, without_truth, untracked = {}, 0, 0
    for joint in joints:
        at = truth.at(joint, track.time_s)
        estimate = track.joints[joint]
        known = np.isfinite(at.sum(axis=1))
        tracked = np.isfinite(estimate.mean.sum(axis=1))
        scores[joint] = _score(joint, estimate, at, known & tracked, track.camera)
        without_truth = max(without_truth, int((~known).sum()))
        untracked = max(untracked, int((~tracked).sum()))
    distances = np.stack([_distance(track, truth, joint) for joint in joints])
    return Scores(
        joints=scores,
        average_m=float(np.nanmean(distances)),
        average_sd_m=float(np.nanstd(distances)),
        frames=len(track.time_s),
        frames_without_truth=without_truth,
        frames_untracked=untracked,
        valid_share=float(track.valid.mean()),
    )


@dataclass(frozen=True, eq=False)
class _Held:
    """What is scored of a pose that is held."""

    time_s: Array
    joints: Mapping[str, JointTrack]
    valid: NDArray[np.bool_]
    camera: Camera | WeakPerspective


def held(track: Scored) -> Scored:
    """The trivial answer: the track's first estimate, held through every frame that was tracked, without bands.

    Whatever does not beat it has not tracked anything.
    """
    joints = {}
    for joint, rows in track.joints.items():
        tracked = np.asarray(np.isfinite(rows.mean).all(axis=1))
        first = rows.mean[int(np.argmax(tracked))]
        still, none = np.where(tracked[:, None], first, np.nan), np.full_like(rows.mean, np.nan)
        joints[joint] = dataclasses.replace(rows, mean=still, mode=still, sd=none, lo=none, hi=none)
    return _Held(track.time_s, joints, track.valid, track.camera)


def _score(
    joint: str, track: JointTrack, truth: Array, use: np.ndarray, camera: Camera | WeakPerspective
) -> JointScores:
    if not use.any():
        raise InputError(f"no frame has both a track and truth of the {joint}, expected the times to overlap")
    truth, lo, hi = truth[use], track.lo[use], track.hi[use]
    error = track.mean[use] - truth
    distance = np.linalg.norm(error, axis=1)
    depth = np.einsum("ti,ti->t", error, camera.viewing_directions(truth))
    across = np.sqrt(np.maximum(distance**2 - depth**2, 0.0))
    inside = np.where(np.isnan(lo) | np.isnan(hi), np.nan, (lo <= truth) & (truth <= hi))
    return JointScores(
        frames=int(use.sum()),
        mean_m=triple(error.mean(axis=0)),
        sd_m=triple(error.std(axis=0)),
        rms_m=float(np.sqrt((distance**2).mean())),
        median_m=float(np.median(distance)),
        across_m=float(np.median(across)),
        depth_m=float(np.median(np.abs(depth))),
        lost_share=float((across > LOST_M).mean()),
        average_m=float(distance.mean()),
        average_sd_m=float(distance.std()),
        worst_m=float(distance.max()),
        worst_frame=int(np.flatnonzero(use)[np.argmax(distance)]),
        within_5cm=float((np.abs(error) <= WITHIN_M).all(axis=1).mean()),
        coverage=triple(inside.mean(axis=0)),
        half_width_m=triple(((hi - lo) / 2).mean(axis=0)),
    )


def _distance(track: Scored, truth: Truth, joint: str) -> Array:
    """3-D error of a joint in every frame `(T,)`, m; NaN where there is none."""
    return np.asarray(np.linalg.norm(track.joints[joint].mean - truth.at(joint, track.time_s), axis=1))


def average_error(track: Scored, truth: Truth) -> Array:
    """Mean 3-D error over all joints with truth in every frame `(T,)`, m (Li & Kulić: Average Error).

    NaN where one is missing.
    """
    joints = [joint for joint in track.joints if joint in truth.joints_m]
    return np.asarray(np.mean([_distance(track, truth, joint) for joint in joints], axis=0))


@dataclass(frozen=True)
class SpeedBin:
    """Error where joints move at some speed.

    Attributes:
        from_m_s: slowest.
        to_m_s: fastest.
        count: joints times frames in it.
        average_m: mean 3-D error; NaN where there is none.
    """

    from_m_s: float
    to_m_s: float
    count: int
    average_m: float


def error_by_speed(
    track: Scored, truth: Truth, edges_m_s: tuple[float, ...] = (0.0, 0.25, 0.5, 1.0, 2.0, float("inf"))
) -> list[SpeedBin]:
    """Error against the true speed of the joints (Li & Kulić, Fig. 6: faster motion, larger error)."""
    if len(track.time_s) < 2:
        return []  # no speed
    speeds, errors = [], []
    for joint in (joint for joint in track.joints if joint in truth.joints_m):
        velocity = np.gradient(truth.at(joint, track.time_s), track.time_s, axis=0)
        speeds.append(np.linalg.norm(velocity, axis=1))
        errors.append(_distance(track, truth, joint))
    speed, error = np.concatenate(speeds), np.concatenate(errors)
    bins = []
    for low, high in itertools.pairwise(edges_m_s):
        inside = (speed >= low) & (speed < high) & np.isfinite(error)
        bins.append(
            SpeedBin(low, high, int(inside.sum()), float(error[inside].mean()) if inside.any() else float("nan"))
        )
    return bins


def frames_to_recover(error: Array, start: int, usual: float, factor: float = 1.2, steady: int = 3) -> int | None:
    """Frames from `start` until `error` `(T,)` is below `factor * usual` for `steady` frames on end; None: never."""
    good = error[start:] <= factor * usual
    for k in range(len(good) - steady + 1):
        if good[k : k + steady].all():
            return k
    return None
