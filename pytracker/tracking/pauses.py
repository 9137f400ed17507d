"""Times at which a video has no frames, or none of its own: what lies between is bridged, and was not seen."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.hanging import HANGS, LIES_STILL
from pytracker.series import runs
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import Track, where_of

__all__ = ["of_hanging", "of_pauses"]

PAUSE_S = 0.5
"""Cameras in dim light take fewer frames; none waits so long."""
TIMES_USUAL = 5.0
"""Nor so many times as long as usually."""
RESTS = {HANGS: "did camera or recorder hang", LIES_STILL: "does another thing of its colour lie there"}
"""Why a patch that rests is not believed, and what is asked."""


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
    found: list[str] = []
    for number, patch in enumerate(track.sightings.tracks):
        for why, asks in RESTS.items():
            rests = [words == why for words in patch.reason]
            if not any(rests):
                continue
            first, end = max(runs(rests), key=lambda run: run[1] - run[0])
            found.append(
                f"{where_of(track.recording)}: in {sum(rests)} frames of camera {number}, longest from "
                f"{patch.time_s[first]:.3f} to {patch.time_s[end - 1]:.3f} s of its video, {why}: they are "
                f"not used, {asks}?"
            )
    return tuple(found)
