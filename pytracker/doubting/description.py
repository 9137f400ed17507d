"""Whether another description of an arm explains what was seen better than its own: each is tried by a filter."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError, TrackingError
from pytracker.doubting.suspects import AFTER_PAUSE, HEADING, MIRRORED, MOUNT, Suspect, suspects
from pytracker.evidence.sightings import Sightings
from pytracker.methods.arm import ArmMethod, Ekf, Mixture
from pytracker.recording.recording import ArmRecording, Imu
from pytracker.rotation import Array, triple
from pytracker.tracking.arm import ArmTrack, filter_arm
from pytracker.tracking.tracks import where_of

__all__ = ["LEAST_FRAMES", "PAUSE_S", "of_description", "of_last_frames"]

PROBE = Mixture(components=1)
"""Fast, and its log evidence is that of what was seen: for any suspect."""

HELD = Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15, arm_length_sd_m=0.03)
"""Its log evidence is the arm's length's too, which a heading contradicts most; and any living arm by centimetres."""
HELD_SUSPECTS = (HEADING, "offset_s", MIRRORED, AFTER_PAUSE)

LOST = -1e3
SETTLED_S = 0.5
"""The first moments depend on the start more than on heading and clock."""

PAUSE_S, AFTER_PAUSE_S = 0.3, 2.0
"""A pause of the sensor is explained by whatever holds the wrist; so is what comes after it for so long."""

AT_MOST = 5.0
"""What one frame may add: a filter that is lost for a while must not decide."""

LEAST_FRAMES = 100
"""Fewer say too little."""

MOST_FRAMES = 500
"""More take longer, and what evidence others have over a right description grows with them: the limit is of these."""

CERTAIN = 50.0
"""Log evidence by which another description must be better; of 96 right worn arms, seen from four places, one was
beaten by 45, the others by 34 at most."""

CERTAIN_HELD = 0.4
"""The same of each frame where the arm's length counts; right ones that are worn, of four views, have 0.26 at most, of
headings 20° off 0.6 at least, or nothing tells them."""

CERTAIN_AT_END = 0.5
"""And of each of the last frames; of 500 right ones that rest there two have 0.42 and 0.44, the others 0.35 at most; of
shoulders that sag by 6 cm until then half have more."""

AS_GOOD = 8.0
"""Descriptions that are as good as the best but for this cannot be told from it."""


AMID_M, AMID_M_S = 0.1, 0.8
"""How well a track knows wrist and velocity where its last frames begin, m and m/s per axis."""


@functools.lru_cache(maxsize=1)  # several methods on one recording share it
def of_description(recording: ArmRecording, sightings: Sightings, pixel_sd: float, speed_sd: float) -> tuple[str, ...]:
    """A sentence that names what it may be; empty where the recording's own explains it as well as any."""
    sightings = sightings.first(MOST_FRAMES)
    every = list(suspects(recording))
    certain_held = CERTAIN_HELD * max(LEAST_FRAMES, len(sightings.time_s))
    for probe, certain in ((HELD, certain_held), (PROBE, CERTAIN)):
        method = dataclasses.replace(probe, pixel_sd=pixel_sd, velocity_start_sd=speed_sd)
        tell = functools.partial(_gains, recording, sightings, method)
        gains = tell([s for s in every if s.kind in HELD_SUSPECTS] if probe is HELD else every)
        best, gain = max(gains, key=lambda found: found[1])
        if gain < certain:
            continue
        if probe is HELD:
            # What else contradicts the arm's length tells nothing by itself, but may explain more.
            gains += tell([s for s in every if s.kind not in HELD_SUSPECTS])
            other, most = max(gains, key=lambda found: found[1])
            best, gain = (other, most) if most > gain + AS_GOOD else (best, gain)
        others = dict.fromkeys(s.kind for s, g in gains if g > gain - AS_GOOD and s.kind != best.kind)
        alike = f"; {' or '.join(others)} may be it as well: these cannot be told apart here" if others else ""
        return (
            f"{where_of(recording)}: camera and IMU agree better with {best.words} (log evidence "
            f"+{gain:.0f}, expected less than +{certain:g} of any change): check {best.kind}{alike}",
        )
    return ()


def of_last_frames(track: ArmTrack, recording: ArmRecording, sightings: Sightings) -> tuple[str, ...]:
    """A sentence where the last frames of a longer recording ask for another heading or mount, which the first did not.

    So does an orientation that drifts about the vertical, and a strap that slips. `recording` and `sightings` are what
    they are asked of, `track` says where the wrist was.
    """
    measured = int(np.searchsorted(sightings.time_s, recording.imus[0].time_s[-1], side="right"))
    sightings = sightings.first(measured).last(MOST_FRAMES)
    if len(sightings.time_s) < LEAST_FRAMES:
        return ()
    first = int(np.searchsorted(track.time_s, sightings.time_s[0]))
    wrist_m = track.joints["wrist"].mean[first]
    if first < LEAST_FRAMES or not np.isfinite(wrist_m).all():
        return ()
    arm = dataclasses.replace(recording.arm, wrist_start_m=triple(wrist_m))
    recording = dataclasses.replace(recording, arm=arm, imus=(_from(recording.imus[0], sightings.time_s[0]),))
    tried = [s for s in suspects(recording) if s.kind in (HEADING, MOUNT)]
    for probe, certain in ((HELD, CERTAIN_AT_END * len(sightings.time_s)), (PROBE, CERTAIN)):
        method = dataclasses.replace(
            probe, pixel_sd=track.method.pixel_sd, position_start_sd_m=AMID_M, velocity_start_sd=AMID_M_S
        )
        best, gain = max(_gains(recording, sightings, method, tried), key=lambda found: found[1])
        if gain >= certain:
            return (
                f"{where_of(recording)}: from about {sightings.time_s[0]:.0f} s on camera and IMU agree better with "
                f"{best.words} (log evidence +{gain:.0f}, expected less than +{certain:g} of any change), and did not "
                "before: does the orientation drift about the vertical, did the sensor slip, or did the shoulder go?",
            )
    return ()


def _from(imu: Imu, time_s: float) -> Imu:
    """Its samples from about a time on."""
    some = slice(max(0, int(np.searchsorted(imu.time_s, time_s - SETTLED_S))), None)
    gyr = None if imu.gyr is None else imu.gyr[some]
    q_world_segment = imu.q_world_segment[some]
    return dataclasses.replace(
        imu, time_s=imu.time_s[some], acc=imu.acc[some], gyr=gyr, q_world_segment=q_world_segment
    )


def _gains(
    recording: ArmRecording, sightings: Sightings, method: ArmMethod, tried: list[Suspect]
) -> list[tuple[Suspect, float]]:
    """By how much each of them explains a recording better than its description does."""
    base = _log_evidence(recording, sightings, method)
    return [(s, _gain(_log_evidence(s.change(recording), s.see(recording, sightings), method) - base)) for s in tried]


def _gain(better: Array) -> float:
    """By how much a setting is better over all that it changes; nothing where only a part of that says so."""
    better = np.clip(better[np.isfinite(better) & (better != 0.0)], -AT_MOST, AT_MOST)
    if len(better) < LEAST_FRAMES:
        return 0.0
    quarters = [float(part.sum()) for part in np.array_split(better, 4)]
    return sum(quarters) if sum(quarter > 0 for quarter in quarters) >= 3 else 0.0


def _log_evidence(recording: ArmRecording, sightings: Sightings, method: ArmMethod) -> Array:
    """Of every frame `(T,)`; NaN where there is none, as bad as can be once the filter was lost."""
    found = np.full(len(sightings.time_s), np.nan)
    try:
        track = filter_arm(recording, method, sightings=sightings)
    except InputError:
        return found
    except TrackingError:
        return np.full(len(found), LOST)
    if track.lost:
        found[:] = LOST
    known = np.isfinite(track.log_evidence)
    found[known] = track.log_evidence[known]
    found[_beside_sensor(recording.imus[0].time_s, sightings.time_s)] = np.nan
    return found


def _beside_sensor(imu_s: Array, time_s: Array) -> NDArray[np.bool_]:
    """Which frames `(T,)` are before, behind and in pauses of the sensor, or soon after: there a filter looks anew."""
    beside = np.asarray((time_s < max(imu_s[0], time_s[0]) + SETTLED_S) | (time_s > imu_s[-1]))
    for k in np.flatnonzero(np.diff(imu_s) > PAUSE_S):
        beside |= (time_s > imu_s[k]) & (time_s < imu_s[k + 1] + AFTER_PAUSE_S)
    return beside
