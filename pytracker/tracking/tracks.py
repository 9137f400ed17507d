"""What every track holds: joints over time, with error bars."""

# No deferred annotations here: those who inherit have other names in scope.
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pytracker.methods.method import Method
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.recording.recording import Recording
from pytracker.rotation import Array

__all__ = ["QUANTITIES", "JointTrack", "Track", "where_of"]

QUANTITIES = (("", "mean"), ("_sd", "sd"), ("_lo", "lo"), ("_hi", "hi"))
"""How a joint's columns end in tables, and what they are."""


@dataclass(frozen=True, eq=False)
class JointTrack:
    """One joint over time: world, m, `(T, 3)` each; NaN where it was not tracked.

    Attributes:
        mean: weighted mean.
        mode: where the cloud is densest.
        sd: standard deviation per axis.
        lo: 2.5 % quantile per axis.
        hi: 97.5 % quantile per axis.
        reason: why it is not to be believed, frame by frame `(T,)`, each empty where nothing speaks against this joint;
            none at all where joints are not judged on their own.
    """

    mean: Array
    mode: Array
    sd: Array
    lo: Array
    hi: Array
    reason: tuple[str, ...] = ()

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Whether it was tracked and nothing speaks against it `(T,)`."""
        tracked = np.asarray(np.isfinite(self.mean).all(axis=1))
        return tracked & (np.array([not words for words in self.reason]) if self.reason else True)


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """What a method made of a recording: one row a camera frame.

    Attributes:
        method: the method with its parameters.
        recording: what was tracked.
        seed: of the random streams.
        time_s: recording time `(T,)`, s.
        joints: by name.
        ess: effective sample size `(T,)`; NaN for a Gaussian method.
        log_evidence: of each frame's observations `(T,)`; NaN where nothing was observed or weights are no likelihoods.
        valid: whether the frame was tracked and something was seen, `(T,)`.
        reason: why not `(T,)`.
        stage_s: run time of each stage, s; never compared.
        lost: the error that ended the track early; empty where it did not.
    """

    method: Method
    recording: Recording
    seed: int
    time_s: Array
    joints: Mapping[str, JointTrack]
    ess: Array
    log_evidence: Array
    valid: NDArray[np.bool_]
    reason: tuple[str, ...]
    stage_s: Mapping[str, float] = field(default_factory=dict)
    lost: str = ""

    doubter: ClassVar[Callable[["Track"], tuple[str, ...]]]
    """What finds doubts: set by the stage that can, which comes after this one."""

    judged_by: ClassVar[str] = ""
    """The joint whose RMS error is its one figure; empty: the average error of all joints is."""

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """What the recording says against its own description, in words: see `pytracker.doubts`.

        Found when it is first asked for: an arm is tracked again under other descriptions.
        """
        return type(self).doubter(self)

    @property
    def channels(self) -> Mapping[str, Array]:
        """What was tracked besides joints, by name with unit: mean, mode, sd, 2.5 and 97.5 % quantile `(5, T)`."""
        return {}

    @property
    def camera(self) -> Camera | WeakPerspective:
        """The first camera: errors are taken apart into across its picture and in its depth."""
        return self.recording.camera


def where_of(recording: Recording) -> str:
    """What to call a recording in a sentence: the name of its folder."""
    return recording.folder.resolve().name if recording.folder else "the recording"
