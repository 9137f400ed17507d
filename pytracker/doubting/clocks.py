"""Whether an arm's video and its sensor go together: by other clocks a track is off, and as sure of itself as any."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.patch.clocks import Clock, find_clock
from pytracker.inertial.gravity import GRAVITY
from pytracker.rotation import rotate
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import where_of

__all__ = ["is_another", "of_clocks", "words_of"]

BETTER_S = 8.0
"""By so much another clock must be worth more: over right ones, worn and captured, one of another rate was by 6.0."""
TIMES_LEFT = 0.6
"""And one that is seconds off must leave far less, as logarithms: movements come round again."""
LEAST_EXPLAINED = 0.75
"""Where less is explained at any, something else is wrong."""
MOST_DRIFT = 0.01
"""By a larger share no two clocks differ (`drift_ppm`)."""
MOST_STRANGE = 0.65
"""No more is explained of what is strange to the sensor; of its own, slow and worn, 0.74 and more, mostly 0.9."""


def is_another(given: Clock, best: Clock) -> bool:
    """Whether the best clock is so much better that the given one is wrong."""
    if best.worth_s - given.worth_s < BETTER_S or best.explained < LEAST_EXPLAINED or best.is_last:
        return False
    return best.slower != 0.0 or np.log1p(-given.explained) > TIMES_LEFT * np.log1p(-best.explained)


def of_clocks(track: ArmTrack) -> tuple[str, ...]:
    """A sentence where the sensor moves as the patch does at another rate, or at another time, or never."""
    imu, sightings = track.recording.imus[0], track.sightings
    acceleration = rotate(imu.q_world_segment, imu.acc) - np.array([0.0, 0.0, GRAVITY])
    clocks = find_clock(sightings.time_s, sightings.pixels[:, 0], imu.time_s, acceleration)
    px_per_m = float(np.nanmedian(track.recording.camera.px_per_m(track.joints["wrist"].mean)))
    words = "" if clocks is None else words_of(*clocks, px_per_m)
    return (f"{where_of(track.recording)}: {words}",) if words else ()


def words_of(given: Clock, best: Clock, px_per_m: float) -> str:
    """A sentence with numbers where the best clock is another than the given one, or explains nothing either.

    `px_per_m` is how large a metre is where the patch is.
    """
    if best.is_strange(px_per_m, MOST_STRANGE):
        return (
            f"the patch moves as the IMU does by no clock (at most {best.explained:.0%} of its way in the picture is "
            "explained, expected 90%): are video and IMU of one take, and is the patch on the wrist that wears the IMU?"
        )
    if not is_another(given, best):
        return ""
    if best.slower == 0.0:
        change, check = f"is moved by {best.later_s:+.2f} s", "offset_s"
    else:
        change = f"goes {abs(best.slower):.1%} {'slower' if best.slower > 0 else 'faster'} than the video's"
        check = "the video's frame rate and the IMU's rate_hz"
        # No clock is as bad as that.
        lost = ", and whether some of either was lost and its times go on as if not"
        check += " or drift_ppm" if abs(best.slower) <= MOST_DRIFT else lost
    return (
        f"the patch moves as the IMU does where the IMU's clock {change} ({best.explained:.1%} of its way in the "
        f"picture is explained then, {given.explained:.1%} as it is): check {check}"
    )
