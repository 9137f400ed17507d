"""Times at which a video has no frames, or none of its own: what lies between is bridged, and was not seen."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.patch.hanging import RESTS, rests_in_words
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import Track, where_of

__all__ = ["of_hanging", "of_pauses"]

PAUSE_S = 0.5
"""Cameras in dim light take fewer frames; none waits so long."""
TIMES_USUAL = 5.0
"""Nor so many times as long as usually."""


def of_pauses(track: Track) -> tuple[str, ...]:
    """A sentence where frames are missing, as of a file that is damaged or a camera that hung."""
    steps = np.diff(track.time_s)
    if not len(steps):
        return ()
    long = np.flatnonzero(steps > max(PAUSE_S, TIMES_USUAL * float(np.median(steps))))
    if not long.size:
        return ()
    longest = int(long[np.argmax(steps[long])])
    begins, ends = track.time_s[longest : longest + 2]
    return (
        f"{where_of(track.recording)}: for {steps[long].sum():.3g} s in {long.size} pauses there is no frame, the "
        f"longest from {begins:.3f} to {ends:.3f} s, and what lies between was not seen: was the file damaged, or did "
        "the camera hang?",
    )


def of_hanging(track: ArmTrack) -> tuple[str, ...]:
    """A sentence for each camera whose picture hung, or patch stood still, while the sensor moved: it is not used."""
    return tuple(
        f"{where_of(track.recording)}: camera {number}: {words}"
        for number, patch in enumerate(track.sightings.tracks)
        for why in RESTS
        if (words := rests_in_words(patch, why))
    )
