"""Which of several people is the subject, frame by frame: the one of the first pose, and whoever goes on from there.

People move at the speed of people. Whoever stands beside the subject stays somebody else while the subject is not seen:
taken for the subject a track goes over to him, without a jump that a filter would see.
"""

from __future__ import annotations

import functools
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.evidence.points.followed import EXCHANGED, LIMBS
from pytracker.formats.keypoints.read import Keypoints
from pytracker.recording.body_view import rate_of
from pytracker.recording.keypoints.spreads import with_spreads
from pytracker.recording.recording import BodyRecording
from pytracker.rotation import Array

__all__ = ["points_of_subject", "subject_of"]

SLACK_M = 0.12
"""How far most joints of somebody may be from where they were, besides what he moved: a detector trembles."""
SPEED_M_S, MOST_M = 4.0, 1.0
"""Nobody moves on faster, and who is gone for long is looked for no farther off."""
START_M = 0.5
"""A first pose is usually off by no more, m."""
FEW = 0.2
"""Where it finds the person in a smaller share of the rows that show anybody, whoever is nearest to it in the first is
taken."""
RECENT = 4
"""Where somebody was so many frames ago he may be again: a detector leaps aside in between."""
GOES_ON_S, NEWS = 0.3, 0.15
"""Somebody goes on as before for so long; of how he goes each frame says so much."""
WILD_M = 0.5
"""One wild joint says no more than one so far off."""
FORGOTTEN_S = 10.0
"""Others who were not seen for so long are new when they come again; the subject never is."""


@dataclass
class _Somebody:
    """Where every joint was of late, px `(9, 2)`, and in which frames; how he was going, px a frame `(2,)`."""

    recent: deque[tuple[Array, int]]
    slack_m: float = SLACK_M
    velocity: Array = field(default_factory=lambda: np.zeros(2))

    @property
    def frame(self) -> int:
        """When he was seen last."""
        return self.recent[-1][1]

    def expected(self, frame: int, rate_hz: float) -> tuple[list[Array], list[float]]:
        """Where he may be, and how far from there, m: where he was, going on from there, and where he was before."""
        pixels, then = self.recent[-1]
        reach_m = min(self.slack_m + SPEED_M_S * (frame - then) / rate_hz, max(MOST_M, self.slack_m))
        going = pixels + self.velocity * min(frame - then, GOES_ON_S * rate_hz)
        return [pixels, going, self.recent[0][0]], [reach_m, reach_m, SLACK_M]

    def seen(self, pixels: Array, frame: int) -> None:
        """Take where he is now; a joint that is not seen stays where it was."""
        before, then = self.recent[-1]
        moved = pixels - before
        moved = moved[np.isfinite(moved).all(axis=1)]
        if len(moved):
            self.velocity += NEWS * (np.median(moved, axis=0) / max(frame - then, 1) - self.velocity)
        self.recent.append((np.where(np.isfinite(pixels), pixels, before), frame))
        self.slack_m = SLACK_M


def _somebody(pixels: Array, frame: int, slack_m: float = SLACK_M) -> _Somebody:
    return _Somebody(deque([(pixels, frame)], maxlen=RECENT), slack_m)


@functools.lru_cache(maxsize=1)  # who tracks it, and who doubts it
def points_of_subject(recording: BodyRecording, keypoints: Keypoints) -> dict[int, Array]:
    """By frame the subject's points `(1, 9, 3)`: u, v and standard deviation, px. Frames without are left out."""
    view, joints = recording.view, recording.skeleton.joints(recording.initial[None])
    first_px = np.full((len(KEYPOINTS), 2), np.nan)
    for name in LIMBS:
        first_px[KEYPOINTS.index(name)] = view.camera.project(joints[name])[0]
    px_per_m = float(view.camera.px_per_m(joints["root"])[0])
    found = subject_of(with_spreads(keypoints), keypoints.frames, first_px, px_per_m, rate_of(view))
    rows = zip(keypoints.frames.tolist(), found, strict=True)
    return {frame: row[None] for frame, row in rows if np.isfinite(row[:, 0]).any()}


def subject_of(people: Array, frames: NDArray[np.int64], first_px: Array, px_per_m: float, rate_hz: float) -> Array:
    """The subject's points in every row, `(T, 9, 3)`; NaN where only others, or nobody, were found.

    Args:
        people: u, v and anything else of everybody `(T, P, 9, 3)`; NaN where not seen.
        frames: of which frame each row is `(T,)`.
        first_px: where the first pose has the points `(9, 2)`, px; NaN where it says nothing.
        px_per_m: about the subject.
        rate_hz: frames a second.
    """
    seen: NDArray[np.bool_] = np.asarray(np.isfinite(people[..., 0]).any(axis=2))
    if not seen.any():
        return np.full((len(people), *people.shape[2:]), np.nan)
    first = int(np.argmax(seen.any(axis=1)))
    frame = int(frames[first])
    found = _followed(people, frames, _somebody(first_px, frame, START_M), px_per_m, rate_hz)
    if np.isfinite(found[..., 0]).any(axis=1).sum() >= FEW * seen.any(axis=1).sum():
        return found
    # The first pose is rough: whoever is nearest to it in the first row.
    there = people[first][seen[first]]
    nearest = there[int(np.argmin(_off(there, first_px)[1]))]
    return _followed(people, frames, _somebody(nearest[:, :2], frame), px_per_m, rate_hz)


def _followed(people: Array, frames: NDArray[np.int64], subject: _Somebody, px_per_m: float, rate_hz: float) -> Array:
    """The subject's points in every row."""
    found = np.full((len(people), *people.shape[2:]), np.nan)
    known = [subject]
    for row, frame in enumerate(frames.tolist()):
        known = [one for one in known if one is subject or frame - one.frame <= FORGOTTEN_S * rate_hz]
        those = people[row][np.isfinite(people[row, ..., 0]).any(axis=1)]
        if not len(those):
            continue
        for k, one in _matched(those, known, frame, px_per_m, rate_hz).items():
            one.seen(those[k, :, :2], frame)
            if one is subject:
                found[row] = those[k]
    return found


def _matched(those: Array, known: list[_Somebody], frame: int, px_per_m: float, rate_hz: float) -> dict[int, _Somebody]:
    """Who each of those is, the nearest first; whom nobody could have become is new, and known from here on."""
    expected = [one.expected(frame, rate_hz) for one in known]
    off, most = _off(those[:, None, None], np.array([places for places, _ in expected]))
    is_in_reach = most <= px_per_m * np.array([reaches for _, reaches in expected])
    # Of two who pass each other most joints are alike; how they hold their arms is not.
    capped = np.fmin(off, WILD_M * px_per_m)
    seen = np.isfinite(off)
    apart = np.where(seen, capped, 0.0).sum(axis=-1) / np.maximum(seen.sum(axis=-1), 1)
    apart = np.where(is_in_reach, apart, np.inf).min(axis=-1)
    matched: dict[int, _Somebody] = {}
    while np.isfinite(apart).any():
        k, j = (int(at) for at in np.unravel_index(np.argmin(apart), apart.shape))
        matched[k] = known[j]
        apart[k], apart[:, j] = np.inf, np.inf
    for k in range(len(those)):
        if k not in matched:
            matched[k] = _somebody(those[k, :, :2], frame)
            known.append(matched[k])
    return matched


def _off(people: Array, places: Array) -> tuple[Array, Array]:
    """How far people's points are from some places, px `(..., 9)`, left and right as they are nearer; and most of them.

    NaN of what is not seen; most of nothing is infinitely far.
    """
    ways = np.stack([np.linalg.norm(of[..., :2] - places, axis=-1) for of in (people, people[..., EXCHANGED, :])])
    ordered, count = np.sort(ways, axis=-1), np.isfinite(ways).sum(axis=-1, keepdims=True)
    middle = [np.take_along_axis(ordered, np.maximum(k, 0), axis=-1)[..., 0] for k in ((count - 1) // 2, count // 2)]
    most = np.where(count[..., 0] > 0, 0.5 * (middle[0] + middle[1]), np.inf)
    nearer = most[1] < most[0]
    return np.where(nearer[..., None], ways[1], ways[0]), np.where(nearer, most[1], most[0])
