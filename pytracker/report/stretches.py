"""Stretches of frames that are not valid: of which joint, from when to when, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from pytracker.rotation import Array
from pytracker.series import runs
from pytracker.tracking.tracks import Track

__all__ = ["Stretch", "stretches_of"]

PAUSE_S = 0.25
"""What is believed for no longer between two stretches is not worth a line of its own."""


@dataclass(frozen=True)
class Stretch:
    """Frames on end that are not valid.

    Attributes:
        joint: which is not; empty where nothing of the frame is.
        from_s: when it begins, recording time.
        to_s: its last frame's time.
        why: the reason of most of its frames.
    """

    joint: str
    from_s: float
    to_s: float
    why: str


def stretches_of(track: Track) -> list[Stretch]:
    """In order of time; those of joints that are judged on their own apart from those of whole frames."""
    reasons = {joint: of.reason for joint, of in track.joints.items() if of.reason}
    if not reasons:
        return _of("", track.time_s, track.reason)
    none = [all(of[frame] for of in reasons.values()) for frame in range(len(track.time_s))]
    found = _of("", track.time_s, [words if whole else "" for words, whole in zip(track.reason, none, strict=True)])
    for joint, of in reasons.items():
        alone = ["" if whole else words for words, whole in zip(of, none, strict=True)]
        found += _of(joint.replace("_", " "), track.time_s, alone)
    return sorted(found, key=lambda one: (one.from_s, one.joint))


def _of(joint: str, time_s: Array, reasons: Sequence[str]) -> list[Stretch]:
    joined: list[list[int]] = []
    for first, after in runs([bool(words) for words in reasons]):
        if joined and time_s[first] - time_s[joined[-1][1] - 1] < PAUSE_S:
            joined[-1][1] = after
        else:
            joined.append([first, after])
    return [
        Stretch(
            joint,
            float(time_s[first]),
            float(time_s[after - 1]),
            Counter(filter(None, reasons[first:after])).most_common(1)[0][0],
        )
        for first, after in joined
    ]
