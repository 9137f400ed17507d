"""Whether a sensor on the upper arm points where the track has the upper arm."""

from __future__ import annotations

import numpy as np

from pytracker.methods.arm import Mixture
from pytracker.rotation import Array, rotate
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import where_of

__all__ = ["of_upper_arm"]

MOST_OFF_DEG = 12.0
"""A sensor may point so far beside it, in the median: right ones that are worn do by 7° at most."""
HOLDS_S = 0.1
"""A sample says no longer where the upper arm points."""
ALONG = np.array([0.0, 1.0, 0.0])


def of_upper_arm(track: ArmTrack) -> tuple[str, ...]:
    """A warning, in words, where it does not; or where the method uses neither it nor what else is seen."""
    recording = track.recording
    if not isinstance(track.method, Mixture):
        there = [*recording.landmarks, *(["the upper arm's sensor"] if recording.has_upper_arm else [])]
        words = f"there is {' and '.join(there)}, which {track.method.name} does not use; mixture and smooth do"
        return (f"{where_of(recording)}: {words}",) if there else ()
    if not recording.has_upper_arm:
        return ()
    off_deg = angles_deg(track)
    off_deg = off_deg[np.isfinite(off_deg)]
    if not len(off_deg) or np.median(off_deg) <= MOST_OFF_DEG:
        return ()
    words = (
        f"the upper arm's sensor points {np.median(off_deg):.0f}° beside where the track has the upper arm (median), "
        f"expected at most {MOST_OFF_DEG:.0f}°: check heading_deg, mount and offset_s of imu[1], and shoulder_m"
    )
    return (f"{where_of(recording)}: {words}",)


def angles_deg(track: ArmTrack) -> Array:
    """Between sensor and upper arm at every frame `(T,)`; NaN where either is not known."""
    imu, elbow = track.recording.imus[1], track.joints["elbow"].mean
    at = np.searchsorted(imu.time_s, track.time_s, side="right") - 1
    pointing = rotate(imu.q_world_segment[np.clip(at, 0, None)], np.broadcast_to(ALONG, (len(at), 3)))
    upper_arm = np.array(track.recording.arm.shoulder_m) - elbow
    upper_arm /= np.linalg.norm(upper_arm, axis=1, keepdims=True)
    old = (at < 0) | (track.time_s - imu.time_s[np.clip(at, 0, None)] > HOLDS_S)
    return np.where(old, np.nan, np.degrees(np.arccos(np.clip((upper_arm * pointing).sum(axis=1), -1.0, 1.0))))
