"""`evaluate(track, truth)`: how far off a track is, in the terms of Tao & Hu's Table I and Figs. 6-8.

Knows arrays of positions and nothing of filters or files.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.rotation import Triple, triple

if TYPE_CHECKING:
    from pytracker.recording import Truth
    from pytracker.rotation import Array
    from pytracker.joint_track import JointTrack

__all__ = ["JointScores", "Scores", "evaluate"]

WITHIN_M = 0.05
"""The paper's error band (IV-A, Fig. 7)."""


@dataclass(frozen=True)
class JointScores:
    """One joint against the truth; metres, per axis x, y, z unless said.

    Attributes:
        frames: how many were scored.
        mean_m: mean error (Table I).
        sd_m: standard deviation of the error (Table I).
        rms_m: 3-D root mean square error.
        worst_m: largest 3-D error.
        worst_frame: the frame that has it.
        within_5cm: share of frames within ±5 cm on every axis.
        coverage: share of frames whose 95 % band holds the truth.
        half_width_m: mean half-width of the band.
    """

    frames: int
    mean_m: Triple
    sd_m: Triple
    rms_m: float
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
        frames: frames of the track.
        frames_without_truth: frames that no truth covers; left out.
        frames_untracked: frames that were not tracked; left out.
        valid_share: share of frames that were tracked with the patch seen and the IMU heard.
    """

    joints: Mapping[str, JointScores]
    frames: int
    frames_without_truth: int
    frames_untracked: int
    valid_share: float

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
        scores[joint] = _score(joint, estimate.mean, estimate.lo, estimate.hi, at, known & tracked)
        without_truth = max(without_truth, int((~known).sum()))
        untracked = max(untracked, int((~tracked).sum()))
    return Scores(scores, len(track.time_s), without_truth, untracked, float(track.valid.mean()))


def _score(joint: str, mean: Array, lo: Array, hi: Array, truth: Array, use: np.ndarray) -> JointScores:
    if not use.any():
        raise InputError(f"no frame has both a track and truth of the {joint}, expected the times to overlap")
    error = (mean - truth)[use]
    distance = np.linalg.norm(error, axis=1)
    inside = (lo[use] <= truth[use]) & (truth[use] <= hi[use])
    return JointScores(
        frames=int(use.sum()),
        mean_m=triple(error.mean(axis=0)),
        sd_m=triple(error.std(axis=0)),
        rms_m=float(np.sqrt((distance**2).mean())),
        worst_m=float(distance.max()),
        worst_frame=int(np.flatnonzero(use)[np.argmax(distance)]),
        within_5cm=float((np.abs(error) <= WITHIN_M).all(axis=1).mean()),
        coverage=triple(inside.mean(axis=0)),
        half_width_m=triple(((hi - lo)[use] / 2).mean(axis=0)),
    )
