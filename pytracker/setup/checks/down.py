"""Whether an earth frame whose z seems to be down is such a one, or the accelerometer reads gravity, as an iPhone's.

Both turn gravity over, and the sensor alone cannot tell them. They make of one movement one that is mirrored: by what
the camera saw, with any clock, heading and mount, one explains it better.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from pytracker.evidence.sightings import Sightings
from pytracker.inertial.conventions import OVER
from pytracker.inertial.log import ImuLog
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import conjugate, multiply
from pytracker.setup.checks.findings import Finding
from pytracker.setup.draft import Draft
from pytracker.setup.worn import CLEAR, find_worn, lags_of

__all__ = ["seems_down", "which_is_down"]

EARTH, READS = "imu.earth", "imu.acc_reads"


def seems_down(draft: Draft, findings: Sequence[Finding]) -> bool:
    """Whether the first sensor's earth frame has its z down, as it was found or is given."""
    written = {place: value for finding in findings for place, value in finding.writes.items()}
    return bool(written.get(EARTH, draft.get(EARTH)) == "z down")


def which_is_down(
    draft: Draft, log: ImuLog, recording_with: Callable[[ImuLog], ArmRecording], sightings: Sightings
) -> tuple[Finding | None, ImuLog | None]:
    """What to say in place of the earth frame's line, None where that stands; and the log to go on with, if any.

    `log` is in our terms by a z that is down; `recording_with` puts a log into the recording.
    """
    other = _by_gravity(log)
    down, gravity = (_explained(recording_with(one), sightings) for one in (log, other))
    words = (
        f"an earth frame with z down explains what the camera saw with a log evidence of {down:.0f}, an accelerometer "
        f"that reads gravity, as an iPhone's does, with {gravity:.0f}"
    )
    if down > gravity + CLEAR:
        return None, log
    if gravity < down + CLEAR:
        return Finding(
            "earth frame", "cannot be told", f'{words}: give imu.earth = "z down" or {READS} = "gravity"'
        ), None
    earth = {EARTH: "z up"} if draft.get(EARTH) == "z down" else {}
    return Finding("earth frame", "wrong", f"{words} (or with a mirrored video)", {READS: "gravity", **earth}), other


def _by_gravity(log: ImuLog) -> ImuLog:
    """The same file with z up and all signs of the acceleration turned."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    back = np.broadcast_to(conjugate(OVER), log.q_world_sensor.shape)
    return dataclasses.replace(
        log, acc=-log.acc, q_world_sensor=np.ascontiguousarray(multiply(back, log.q_world_sensor))
    )


def _explained(recording: ArmRecording, sightings: Sightings) -> float:
    """Log evidence of the way to wear the sensor that explains it best."""
    ways = find_worn(recording, sightings, lags_of(recording, sightings))
    return max((way.log_evidence for way in ways), default=-np.inf)
