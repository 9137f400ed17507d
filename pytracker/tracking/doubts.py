"""`doubts(track)`: what a recording says against its own description, which the bands of a track cannot know.

A heading or a clock that is off gives a track that is off, as sure of itself as any other. But the data fit worse:
another heading or clock then explains them better. And a skeleton beside the person has little of them beneath it.
"""

from __future__ import annotations

import dataclasses
import functools
import re
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from pytracker._core import ARM_DOUBTS, InputError, TrackingError
from pytracker.evidence.sightings import Sightings
from pytracker.methods.arm import ArmMethod, Ekf, Mixture, Smooth
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array
from pytracker.tracking.alike import UNLIKE
from pytracker.tracking.arm import JITTERY, ArmTrack, filter_arm
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.body_doubts import of_body
from pytracker.tracking.clocks import of_clocks
from pytracker.tracking.found import found_by
from pytracker.tracking.patch_place import of_patch_place
from pytracker.tracking.pauses import of_hanging, of_pauses
from pytracker.tracking.suspects import AFTER_PAUSE, MIRRORED, Suspect, suspects
from pytracker.tracking.swivel import hangs
from pytracker.tracking.tracks import Track, where_of
from pytracker.tracking.upper_arm import of_unused_senses, of_upper_arm

__all__ = ["doubts", "is_unusable", "unbelieved"]

PROBE = Mixture(components=1)
"""Fast, and its log evidence is that of what was seen: for any suspect."""

HELD = Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15, arm_length_sd_m=0.03)
"""Its log evidence is the arm's length's too, which a heading contradicts most; and any living arm by centimetres."""
HELD_SUSPECTS = ("heading_deg", "offset_s", MIRRORED, AFTER_PAUSE)

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

AS_GOOD = 8.0
"""Descriptions that are as good as the best but for this cannot be told from it."""

SURPRISING = 2.4
"""What was measured once should not differ by more standard deviations of what the data can tell of it; of simulated
right ones, worn too, none does by 1.6, of captured arms, whose shoulders move, 2 in 38 do by more than 2.1."""

ABOVE = -0.1
"""No captured arm's elbow hangs less than 0.27 (`pytracker.tracking.swivel`)."""
FEW_UNSEEN = 0.2
"""Fewer frames without the patch are usual."""
FEW_VALID = 0.5
"""Fewer valid frames are no track."""


@functools.singledispatch
def doubts(track: Track) -> tuple[str, ...]:
    """Warnings, in words; empty where nothing speaks against the track.

    An arm's patch should move as its sensor does by the clocks that are given (`of_clocks`). Its first `MOST_FRAMES`
    frames are tracked again under other descriptions (`suspects`): heading, clock, mount, lengths, shoulder, camera, a
    mirrored picture; by `PROBE`, some of them by `HELD` too. Where it was smoothed, lengths, shoulder and cameras
    should be what they are said to be, and the patch where it is said to be. Where nothing of this was said, its elbow
    should hang below the line from shoulder to wrist; a sensor on the upper arm should point along it. Of a
    body's trunk and arms most should lie on the foreground, which should be no larger than a person, and its head be
    where the person's is. Of either, frames should follow
    each other without long pauses.
    """
    return ()


@doubts.register
def _(track: ArmTrack) -> tuple[str, ...]:
    alone = _tracked_alone(track)
    upper_arm = of_upper_arm(track, alone)
    # A patch that sits elsewhere looks like another heading, and is told beside it; a second sensor that points
    # elsewhere looks like such a patch.
    alone_or_patch = *_of_arm_alone(track, alone), *(() if upper_arm else of_patch_place(track))
    described = of_clocks(track) or alone_or_patch or _of_elbow(track)
    odd = *of_pauses(track), *of_hanging(track), *_of_jitter(track)
    return *odd, *described, *upper_arm, *of_unused_senses(track)


def _of_arm_alone(track: ArmTrack, alone: ArmTrack | None) -> tuple[str, ...]:
    """By the patch and the forearm's sensor, whatever else there is: what is usual is known of these."""
    recording, sightings = _without_senses(track.recording, track.sightings)
    return _of_arm(recording, sightings, track.method.pixel_sd, track.method.velocity_start_sd) or (
        () if alone is None else _of_setup(alone)
    )


def _tracked_alone(track: ArmTrack) -> ArmTrack | None:
    """By patch and forearm only, itself where there is nothing else; None where that is lost, or not smoothed."""
    recording, sightings = _without_senses(track.recording, track.sightings)
    if recording is track.recording:
        return track
    if not isinstance(track.method, Smooth):
        return None
    try:
        alone = filter_arm(recording, track.method, track.seed, sightings=sightings)
    except TrackingError:
        return None
    return None if alone.lost else alone


def _of_jitter(track: ArmTrack) -> tuple[str, ...]:
    """A sentence where centres of the patch jump by more than the method expects."""
    jitter_px, pixel_sd = track.sightings.jitter_px, track.method.pixel_sd
    is_taken = pixel_sd == jitter_px
    if not is_taken and not jitter_px > JITTERY * pixel_sd:
        return ()
    taken = "was taken to be as uncertain as that" if is_taken else f"is taken to be known to {pixel_sd:g} px"
    return (
        f"{where_of(track.recording)}: the centre of the patch jumps by {jitter_px:.1f} px from frame to frame "
        f"(standard deviation along an axis), more than pixel_sd allows, and {taken}: is the patch large, sharp and of "
        "one colour, and is its track on it?",
    )


def _of_elbow(track: ArmTrack) -> tuple[str, ...]:
    """Whether the arm is held as people hold it, most of the time."""
    swivel = hangs(track)
    if swivel > ABOVE or np.count_nonzero(track.valid) < LEAST_FRAMES:
        return ()
    return (
        f"{where_of(track.recording)}: the elbow would be above the line from shoulder to wrist most of the time (mean "
        f"cosine of the arm's swivel {swivel:.2f}, of people 0.3 to 0.9): check mount, heading_deg and side, unless "
        "it was raised indeed",
    )


@functools.lru_cache(maxsize=1)  # the same recording for several methods, which then share what is found of it
def _without_senses(recording: ArmRecording, sightings: Sightings) -> tuple[ArmRecording, Sightings]:
    if not (recording.landmarks or recording.has_upper_arm):
        return recording, sightings
    alone = dataclasses.replace(recording, imus=recording.imus[:1], landmarks=())
    return alone, dataclasses.replace(sightings, landmarks=())


@functools.lru_cache(maxsize=1)  # several methods on one recording share it
def _of_arm(recording: ArmRecording, sightings: Sightings, pixel_sd: float, speed_sd: float) -> tuple[str, ...]:
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


def _gains(
    recording: ArmRecording, sightings: Sightings, method: ArmMethod, tried: list[Suspect]
) -> list[tuple[Suspect, float]]:
    """By how much each of them explains a recording better than its description does."""
    base = _log_evidence(recording, sightings, method)
    return [(s, _gain(_log_evidence(s.change(recording), s.see(recording, sightings), method) - base)) for s in tried]


def _of_setup(track: ArmTrack) -> tuple[str, ...]:
    """Whether what was measured once is as it is said to be, where the whole recording was smoothed."""
    # What the data tell nothing of cannot surprise: a camera's distance drifts off where an arm reaches slowly.
    told = [found for found in found_by(track) if found.name != "offset_s" and found.is_told]
    surprising = [found for found in told if found.surprise > SURPRISING]
    if not surprising or len(track.time_s) < LEAST_FRAMES:
        return ()
    surprising.sort(key=lambda found: -found.surprise)
    worst = surprising[0]
    return (
        f"{where_of(track.recording)}: camera and IMU agree better with another {worst.what}, by {worst.change:+.3g} ± "
        f"{worst.sd:.2g} {worst.unit}, expected at most ± {SURPRISING * worst.change_sd:.2g} {worst.unit}: check "
        f"{' and '.join(dict.fromkeys(found.name for found in surprising))}",
    )


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


@doubts.register
def _(track: BodyTrack) -> tuple[str, ...]:
    return *of_pauses(track), *of_body(track)
