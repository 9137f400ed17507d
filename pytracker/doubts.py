"""`doubts(track)`: what a recording says against its own description, which the bands of a track cannot know.

A heading or a clock that is off gives a track that is off, as sure of itself as any other. But the data fit worse:
another heading or clock then explains them better. And a skeleton beside the person has no person about its joints.
"""

from __future__ import annotations

import dataclasses
import functools
from collections import Counter

import numpy as np

from pytracker._core import InputError, TrackingError
from pytracker.evidence.sightings import Sightings
from pytracker.joint_track import Track
from pytracker.methods import Ekf
from pytracker.recording import ArmRecording, Recording
from pytracker.rotation import Array, multiply, rotation_vector_to_quaternion
from pytracker.track_arm import ArmTrack, track_arm
from pytracker.track_body import BodyTrack

__all__ = ["doubts", "unbelieved"]

PROBE = Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15)
"""Fast, and its log evidence is that of the data."""

HEADINGS_DEG = (-90.0, -40.0, -20.0, -10.0, 10.0, 20.0, 40.0, 90.0)
OFFSETS_S = (-0.4, -0.2, -0.1, 0.1, 0.2, 0.4)

SETTLED_S = 0.5
"""The first moments depend on the start more than on heading and clock."""

AT_MOST = 5.0
"""What one frame may add: a filter that is lost for a while must not decide."""

LEAST_FRAMES = 100
"""Fewer say too little of heading and clock."""

CERTAIN = 15.0
"""Log evidence by which another setting must be better; right ones were beaten by 6 at most on 54 simulations."""

FEW_UNSEEN = 0.2
"""Fewer frames without the patch are usual."""
IMPLAUSIBLE = (
    "the wrist is beyond the arm's reach and its own band",
    "the cloud of particles has collapsed",
    "the estimate lies beside the patch that is seen",
)
"""What the tracker says of an estimate that no arm can have (`rust/arm/plausible.rs`): worth a word at any share."""

LEAST_ON_PERSON = 0.6
"""Where fewer of the key joints are on the foreground, more is wrong than a limb that was lost."""


def doubts(track: Track) -> tuple[str, ...]:
    """Warnings, in words; empty where nothing speaks against the track.

    An arm is tracked again by an extended Kalman filter with other headings and clocks of the IMU (some 0.1 s for a
    recording of 20 s). A body's key joints should have foreground about them.
    """
    if isinstance(track, ArmTrack):
        return _of_arm(track.recording, track.sightings, track.method.pixel_sd)
    return _of_body(track) if isinstance(track, BodyTrack) else ()


@functools.lru_cache(maxsize=1)  # several methods on one recording share it
def _of_arm(recording: ArmRecording, sightings: Sightings, pixel_sd: float) -> tuple[str, ...]:
    probe = dataclasses.replace(PROBE, pixel_sd=pixel_sd)
    base = _log_evidence(recording, sightings, probe, 0.0, 0.0)
    settings = [*((h, 0.0) for h in HEADINGS_DEG), *((0.0, d) for d in OFFSETS_S)]
    gains = [_gain(_log_evidence(recording, sightings, probe, *setting) - base) for setting in settings]
    best = int(np.argmax(gains))
    if gains[best] < CERTAIN:
        return ()
    heading_deg, offset_s = settings[best]
    what = f"heading_deg turned by {heading_deg:+g}°" if heading_deg else f"offset_s changed by {offset_s:+g} s"
    look = "heading_deg and mount" if heading_deg else "offset_s and start_s"
    return (
        f"{where_of(recording)}: camera and IMU agree better with {what} (log evidence "
        f"+{gains[best]:.0f}, expected less than +{CERTAIN:g} of any change): check {look}, then the camera and the "
        "arm's lengths",
    )


def _gain(better: Array) -> float:
    """By how much a setting is better over the whole recording; nothing where only a part of it says so."""
    better = np.clip(better[np.isfinite(better)], -AT_MOST, AT_MOST)
    if len(better) < LEAST_FRAMES:
        return 0.0
    quarters = [float(part.sum()) for part in np.array_split(better, 4)]
    return sum(quarters) if sum(quarter > 0 for quarter in quarters) >= 3 else 0.0


def _log_evidence(
    recording: ArmRecording, sightings: Sightings, method: Ekf, heading_deg: float, offset_s: float
) -> Array:
    """Of every frame `(T,)`; NaN where there is none, or the filter was lost."""
    imu = recording.imus[0]
    turn = rotation_vector_to_quaternion(np.array([0.0, 0.0, np.radians(heading_deg)]))
    q = np.ascontiguousarray(multiply(turn, imu.q_world_sensor))
    changed = dataclasses.replace(imu, q_world_sensor=q, time_s=imu.time_s + offset_s)
    found = np.full(len(sightings.time_s), np.nan)
    try:
        track = track_arm(dataclasses.replace(recording, imus=(changed,)), method, sightings=sightings)
    except (InputError, TrackingError):
        return found
    found[len(found) - len(track.time_s) :] = track.log_evidence
    found[sightings.time_s < imu.time_s[0] + max(OFFSETS_S) + SETTLED_S] = np.nan
    return found


def unbelieved(track: Track) -> tuple[str, ...]:
    """A sentence where frames are not to be believed, with the reasons; empty where all are, or a few were only not seen."""
    counts = Counter(words for reason in track.reason if reason for words in reason.split("; "))
    bad = int((~track.valid).sum())
    if not bad or (bad < FEW_UNSEEN * len(track.valid) and not any(words in counts for words in IMPLAUSIBLE)):
        return ()
    named = ", ".join(f"{words} ({count})" for words, count in counts.most_common(3))
    share = bad / len(track.valid)
    return (f"{bad} of {len(track.valid)} frames ({share:.0%}) are not valid, do not use them: {named}",)


def where_of(recording: Recording) -> str:
    """What to call a recording in a sentence: the name of its folder."""
    return recording.folder.resolve().name if recording.folder else "the recording"


def _of_body(track: BodyTrack) -> tuple[str, ...]:
    where = where_of(track.recording)
    first, all_frames = track.on_person[0], float(np.mean(track.on_person))
    least = f"expected {LEAST_ON_PERSON:.0%} at least"
    if first < LEAST_ON_PERSON:
        return (
            f"{where}: at the first frame {first:.0%} of the joints are on the foreground, {least}: check the first "
            "pose, the skeleton and the camera, and that the background does not hold the person",
        )
    if all_frames < LEAST_ON_PERSON:
        return (
            f"{where}: {all_frames:.0%} of the joints are on the foreground, {least}: see the overlay for whether the "
            "skeleton has left the person",
        )
    return ()
