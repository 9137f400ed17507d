"""`found_by(track)`: what a smoothed recording says of what was measured once: lengths, shoulder, cameras, clock.

Each with its standard deviation before and after: one that did not shrink was not told by the data.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from pytracker.methods.arm import Smooth
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import Track

__all__ = ["CLOCK", "MOTION_COLUMNS", "Found", "found_by"]

CLOCK = "IMU's clock"
"""What is said of the offset of its clock."""
TOLD = 0.85
"""The data say something of a quantity whose standard deviation they make smaller than this share of what it was."""

WINDOW, WINDOW_S = 600, 24.0
"""So many frames, and of so many seconds, are smoothed together at least (`rust/smoothing.rs`): each window says for
itself how late the camera sees."""
LEAST_WINDOWS = 4
"""Fewer say nothing of a drift."""
CLOCK_PPM = 50.0
"""How well two clocks go alike, as a standard deviation."""

MOTION_COLUMNS = 12
"""Position, velocity, bias and orientation error come first in the state of a worn arm."""


@dataclass(frozen=True)
class Found:
    """A constant of a recording.

    Attributes:
        name: the key of `recording.toml` that it belongs to.
        what: which part of it, in words.
        unit: of what follows.
        change: what has to be added to what is given.
        given_sd: how well it was known.
        sd: how well it is known now.
    """

    name: str
    what: str
    unit: str
    change: float
    given_sd: float
    sd: float

    @property
    def is_told(self) -> bool:
        """Whether the data say something of it."""
        return self.sd < TOLD * self.given_sd

    @property
    def change_sd(self) -> float:
        """How far the data may move it where all is described rightly: what they tell of what was not known before."""
        return float(np.sqrt(max(self.given_sd**2 - self.sd**2, 0.0)))

    @property
    def surprise(self) -> float:
        """The change in standard deviations of such changes."""
        return abs(self.change) / max(self.change_sd, 1e-12)

    @property
    def words(self) -> str:
        """The change, in a sentence with numbers."""
        return f"differs by {self.change:+.3g} ± {self.sd:.2g} {self.unit}, known to ± {self.given_sd:.2g} {self.unit}"


@singledispatch
def found_by(track: Track) -> tuple[Found, ...]:
    """What was estimated as constant: of an arm; empty where the method does not smooth, or could not."""
    return ()


@found_by.register
def _(track: ArmTrack) -> tuple[Found, ...]:
    if not isinstance(track.method, Smooth):
        return ()
    senses = len(track.recording.landmarks) + track.recording.has_upper_arm
    first = MOTION_COLUMNS + 3 * (track.method.patch_offset + track.method.shoulder + senses)
    names = list(_constants(track.method, len(track.recording.views)))
    known = np.isfinite(track.state_mean).all(axis=1)
    if track.state_mean.shape[1] != first + len(names) or not known.any():
        return ()
    # A long recording is smoothed in windows: each has its own estimate of the same.
    changes = track.state_mean[known, first:].mean(axis=0)
    spread = np.sqrt(np.square(track.state_sd[known, first:]).mean(axis=0))
    scaled = zip(names, changes, spread, strict=True)
    constants = (
        Found(name, what, unit, scale * float(change), abs(scale) * given_sd, abs(scale) * float(sd))
        for (name, what, unit, scale, given_sd), change, sd in scaled
        if given_sd > 0.0
    )
    return (*constants, *_drift(track, np.asarray(known)))


def _drift(track: ArmTrack, known: NDArray[np.bool_]) -> Iterator[Found]:
    """By how much the IMU's clock goes slower than the camera's: the line through what each window says of it."""
    frames, span_s = int(known.sum()), float(np.ptp(track.time_s[known]))
    count = frames // max(WINDOW, round(WINDOW_S * (frames - 1) / span_s)) if span_s > 0.0 else 0
    if count < LEAST_WINDOWS or not (track.state_sd[known, -1] > 0.0).all():
        return
    windows = [
        np.array_split(of[known], count) for of in (track.time_s, -track.state_mean[:, -1], track.state_sd[:, -1])
    ]
    time_s, late_s, sd_s = (np.array([part.mean() for part in parts]) for parts in windows)
    line, spread = np.polyfit(time_s, late_s, 1, w=1.0 / sd_s, cov="unscaled")
    # Windows that scatter by more than they know tell less.
    scatter = max(1.0, float(np.square((late_s - np.polyval(line, time_s)) / sd_s).sum() / (count - 2)))
    told, given = 1e12 * float(spread[0, 0]) * scatter, CLOCK_PPM**2
    share = given / (given + told)
    yield Found(
        "drift_ppm", "drift of the IMU's clock", "ppm", 1e6 * float(line[0]) * share, CLOCK_PPM, (told * share) ** 0.5
    )


def _constants(method: Smooth, cameras: int) -> Iterator[tuple[str, str, str, float, float]]:
    """Key, words, unit, unit a state's unit, and standard deviation beforehand, column by column."""
    yield "upper_arm_m", "upper arm", "cm", 100.0, method.upper_arm_sd_m
    yield "forearm_m", "forearm", "cm", 100.0, method.forearm_sd_m
    for axis in "xyz":
        yield "shoulder_m", f"shoulder along {axis}", "cm", 100.0, method.shoulder_place_sd_m
    for axis in "xz":
        yield "mount", f"forearm about the sensor's {axis}", "°", float(np.degrees(1)), method.mount_sd_rad
    for camera in range(cameras):
        of = "camera" if cameras == 1 else f"camera {camera}"
        for turn in ("pitch", "pan", "roll"):
            yield f"camera[{camera}].rotation", f"{of}'s {turn}", "°", float(np.degrees(1)), method.camera_turn_sd_rad
        yield f"camera[{camera}].translation_m", f"{of}'s distance", "cm", 100.0, method.camera_distance_sd_m
        yield f"camera[{camera}].matrix", f"{of}'s focal length", "%", 100.0, method.focal_sd
    # A camera that sees later than the IMU's clock says: the IMU's times are too early.
    yield "offset_s", CLOCK, "ms", -1000.0, method.clock_sd_s
