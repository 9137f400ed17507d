"""Whether an arm's video and its sensor go together: by other clocks a track is off, and as sure of itself as any."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.patch.clocks import NEAR_S, Clock, find_clock
from pytracker.evidence.patch.stepped import Step, find_step
from pytracker.inertial.gravity import GRAVITY
from pytracker.rotation import Array, rotate
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import where_of

__all__ = ["clocks_in_words", "is_another", "is_step", "of_clocks"]

BETTER_S = 8.0
"""By so much another clock must be worth more: over right ones, worn and captured, one of another rate was by 6.0."""
TIMES_LEFT = 0.6
"""And one that is seconds off must leave far less, as logarithms: movements come round again."""
LEAST_EXPLAINED = 0.75
"""Where less is explained at any, something else is wrong."""
MOST_DRIFT = 0.01
"""By a larger share no two clocks differ (`drift_ppm`)."""
LEAST_STEP_S, LEAST_BOTH, STEP_BETTER_S = 0.15, 0.88, 4.0
"""A clock that steps does so by as much, either stretch goes with the sensor so well, another rate is worth less by so
much;"""
SMALL_STEP_S, WORTH_OF_SMALL, WORTH_OF_STEP = 0.6, 0.62, 0.4
"""one clock is worth less than such a share of both together: of twelve recordings from which 0.3 to 4 s were cut 0.58
and 0.31 at most; of 249 right ones, where a circle's other turn may explain it, 0.54 at least, and none by a small
step."""
MOST_STRANGE = 0.65
"""No more is explained of what is strange to the sensor; of its own, slow and worn, 0.74 and more, mostly 0.9."""


def is_another(given: Clock, best: Clock) -> bool:
    """Whether the best clock is so much better that the given one is wrong."""
    if best.worth_s - given.worth_s < BETTER_S or best.explained < LEAST_EXPLAINED or best.is_last:
        return False
    return best.slower != 0.0 or np.log1p(-given.explained) > TIMES_LEFT * np.log1p(-best.explained)


def of_clocks(track: ArmTrack) -> tuple[str, ...]:
    """A sentence where the sensor moves as the patch does at another time or rate, at two times in turn, or never."""
    imu, sightings = track.recording.imus[0], track.sightings
    acceleration = rotate(imu.q_world_segment, imu.acc) - np.array([0.0, 0.0, GRAVITY])
    px_per_m = float(np.nanmedian(track.recording.camera.px_per_m(track.joints["wrist"].mean)))
    words = clocks_in_words(sightings.time_s, sightings.pixels[:, 0], imu.time_s, acceleration, px_per_m)
    return (f"{where_of(track.recording)}: {words}",) if words else ()


def is_step(given: Clock, best: Clock, step: Step) -> bool:
    """Whether two stretches with a clock each are so much better that something is missing between them."""
    by_s = abs(step.later_s[1] - step.later_s[0])
    if by_s < LEAST_STEP_S or min(step.explained) < LEAST_BOTH:
        return False
    if step.worth_s - max(given.worth_s, best.worth_s) < STEP_BETTER_S:
        return False
    most = WORTH_OF_SMALL if by_s < SMALL_STEP_S else WORTH_OF_STEP
    return given.worth_s < most * step.worth_s


def clocks_in_words(
    frame_s: Array, pixels: Array, imu_s: Array, acceleration: Array, px_per_m: float, near_s: float = NEAR_S
) -> str:
    """A sentence with numbers where another clock, or two one after the other, lay the IMU's movement over the patch's.

    Or where none does. Arguments as of `pytracker.evidence.patch.clocks.find_clock`; `px_per_m` is how large a metre is
    where the patch is.
    """
    clocks = find_clock(frame_s, pixels, imu_s, acceleration, near_s)
    if clocks is None:
        return ""
    given, best = clocks
    step = find_step(frame_s, pixels, imu_s, acceleration, given.later_s)
    if step is not None and is_step(given, best, step):
        return _step_in_words(given, step)
    return _words_of(given, best, px_per_m)


def _step_in_words(given: Clock, step: Step) -> str:
    before_s, after_s = step.later_s
    by_s = abs(after_s - before_s)
    # A sensor's file whose times were closed over what is missing lags behind.
    lost = (
        f"{by_s:.2f} s of {'the video' if after_s < before_s else 'the IMU'} seem to be missing there"
        if step.is_told
        else "some of the video or the IMU seems to be missing there (movement that comes round does not tell how much)"
    )
    return (
        f"the patch moves as the IMU does where the IMU's clock is moved by {before_s:+.2f} s until about "
        f"{step.until_s:.0f} s of the video, and by {after_s:+.2f} s from about {step.from_s:.0f} s on "
        f"({step.explained[0]:.1%} and {step.explained[1]:.1%} of its way in the picture are explained then, "
        f"{given.explained:.1%} as it is): {lost}, and the times go on as if not: give the true times, or cut it in two"
    )


def _words_of(given: Clock, best: Clock, px_per_m: float) -> str:
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
