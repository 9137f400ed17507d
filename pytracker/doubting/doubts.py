"""`doubts(track)`: what a recording says against its own description, which the bands of a track cannot know.

A heading or a clock that is off gives a track that is off, as sure of itself as any other. But the data fit worse:
another heading or clock then explains them better. And a skeleton beside the person has little of them beneath it.
"""

from __future__ import annotations

import functools
import re
from collections import Counter

from pytracker._core import ARM_DOUBTS
from pytracker.doubting.arm import of_arm
from pytracker.doubting.body import of_body
from pytracker.doubting.pauses import of_pauses
from pytracker.tracking.alike import UNLIKE
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.tracks import Track

__all__ = ["FEW_VALID", "doubts", "is_unusable", "unbelieved"]

FEW_UNSEEN = 0.2
"""Fewer frames without the patch are usual."""
FEW_VALID = 0.5
"""Fewer valid frames are no track."""


@functools.singledispatch
def doubts(track: Track) -> tuple[str, ...]:
    """Warnings, in words; empty where nothing speaks against the track.

    An arm's patch should move as its sensor does by the clocks that are given (`of_clocks`). Its first
    frames are tracked again under other descriptions (`description`): heading, clock, mount, lengths, shoulder, camera,
    a mirrored picture; its last ones under other headings. Where it was smoothed, lengths, shoulder and cameras
    should be what they are said to be, and the patch where it is said to be. Where nothing of this was said, its elbow
    should hang below the line from shoulder to wrist; a sensor on the upper arm should point along it. Of a
    body's trunk and arms most should lie on the foreground, which should be no larger than a person, and its head be
    where the person's is. Of either, frames should follow
    each other without long pauses.
    """
    return ()


@doubts.register
def _(track: ArmTrack) -> tuple[str, ...]:
    return *of_pauses(track), *of_arm(track)


@doubts.register
def _(track: BodyTrack) -> tuple[str, ...]:
    return *of_pauses(track), *of_body(track)


def unbelieved(track: Track) -> tuple[str, ...]:
    """A sentence where frames are not to be believed, with the reasons.

    Empty where all are, or a few were only not seen.
    """
    said = (words for reason in track.reason if reason for words in reason.split("; "))
    counts = Counter(re.sub(r" for [\d.]+ s$", "", words) for words in said)
    bad = int((~track.valid).sum())
    if not bad or (bad < FEW_UNSEEN * len(track.valid) and not any(words in counts for words in (*ARM_DOUBTS, UNLIKE))):
        return ()
    named = ", ".join(f"{words} ({count})" for words, count in counts.most_common(3))
    share = bad / len(track.valid)
    return (f"{bad} of {len(track.valid)} frames ({share:.0%}) are not valid, do not use them: {named}",)


def is_unusable(track: Track) -> bool:
    """Whether most of its frames are not to be believed."""
    return bool(track.valid.mean() < FEW_VALID)


Track.doubter = staticmethod(doubts)
