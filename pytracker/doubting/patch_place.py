"""Whether the patch sits along the forearm where it is said to: strapped 6 cm farther up the track is off by as much.

A smoothed track estimates how far the patch is from where it is said to be, and holds on to what is said: what the data
alone say is farther off.
"""

from __future__ import annotations

import numpy as np

from pytracker.methods.arm import Smooth
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.found import MOTION_COLUMNS
from pytracker.tracking.tracks import where_of

__all__ = ["of_patch_place"]

ALONG = MOTION_COLUMNS + 1
"""The column of the state: the offset along the segment's y axis, from its far joint to its near one."""
LEAST_TOLD = 0.22
"""Where the data tell less, as a share of what is not known, they say nothing."""
SURPRISING = 2.0
"""By so many standard deviations of what the data tell of it; of 117 right recordings, worn too, at most 1.5."""
LEAST_FRAMES = 100


def of_patch_place(track: ArmTrack) -> tuple[str, ...]:
    """A sentence where the data place the patch elsewhere along the forearm; of a smoothed track alone."""
    method = track.method
    has_patch = any(view.patch_box is not None or view.keypoints is None for view in track.recording.views)
    if not (isinstance(method, Smooth) and method.patch_offset and has_patch):
        return ()
    known = np.isfinite(track.state_mean[:, ALONG])
    given_sd = method.patch_offset_start_sd_m
    if known.sum() < LEAST_FRAMES or given_sd <= 0.0:
        return ()
    change_m = float(track.state_mean[known, ALONG].mean())
    left = float(np.square(track.state_sd[known, ALONG]).mean()) / given_sd**2
    told = np.sqrt(max(1.0 - left, 0.0))
    if told < LEAST_TOLD or abs(change_m) < SURPRISING * told * given_sd:
        return ()
    alone_cm = 100.0 * change_m / told**2
    return (
        f"{where_of(track.recording)}: camera and IMU agree better with a patch about {abs(alone_cm):.0f} cm "
        f"{'nearer the elbow' if alone_cm > 0 else 'nearer the hand'} than is said, expected at most "
        f"{100 * SURPRISING * given_sd / told:.0f} cm: check patch_offset_m, and arm lengths and shoulder_m besides",
    )
