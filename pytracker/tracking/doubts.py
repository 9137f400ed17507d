"""`doubts(track)`: what a recording says against its own description, which the bands of a track cannot know.

A heading or a clock that is off gives a track that is off, as sure of itself as any other. But the data fit worse:
another heading or clock then explains them better. And a skeleton beside the person has no person about its joints.
"""

from __future__ import annotations

import dataclasses
import functools
import re
from collections import Counter

import numpy as np

from pytracker._core import ARM_DOUBTS, InputError, TrackingError
from pytracker.evidence.sightings import Sightings
from pytracker.methods.arm import ArmMethod, Ekf, Mixture, Smooth
from pytracker.recording.recording import ArmRecording, Recording
from pytracker.rotation import Array
from pytracker.tracking.arm import JITTERY, ArmTrack, track_arm
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.found import found_by
from pytracker.tracking.suspects import MIRRORED, suspects
from pytracker.tracking.swivel import hangs
from pytracker.tracking.tracks import Track
from pytracker.tracking.upper_arm import of_upper_arm

__all__ = ["doubts", "unbelieved"]

PROBE = Mixture(components=1)
"""Fast, and its log evidence is that of what was seen: for any suspect."""

HELD = Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15)
"""Its log evidence is the arm's length's too, which a heading contradicts most; and any living arm somewhat."""
HELD_SUSPECTS = ("heading_deg", "offset_s", MIRRORED)

LOST = -1e3
SETTLED_S = 0.5
"""The first moments depend on the start more than on heading and clock."""

AT_MOST = 5.0
"""What one frame may add: a filter that is lost for a while must not decide."""

LEAST_FRAMES = 100
"""Fewer say too little."""

MOST_FRAMES = 500
"""More take longer, and what evidence others have over a right description grows with them: the limit is of these."""

CERTAIN = 25.0
"""Log evidence by which another description must be better; right ones were beaten by 19, worn reaches by 24."""

CERTAIN_HELD = 1.0
"""The same of each frame where the arm's length counts; right ones that are worn have 0.65 at most."""

AS_GOOD = 8.0
"""Descriptions that are as good as the best but for this cannot be told from it."""

SURPRISING = 2.0
"""What was measured once should not differ by more standard deviations; of right ones, worn and of minutes too, none
that the data tell does by 1.8."""

ABOVE = -0.1
"""No captured arm's elbow hangs less than 0.27 (`pytracker.tracking.swivel`)."""
LYING_DEG = 60.0
"""Nobody who is upright leans so far."""
FEW_UNSEEN = 0.2
"""Fewer frames without the patch are usual."""

HEAD_BESIDE_M, HEAD_ABOVE_M = 0.10, 0.07
"""The person's head may be so far beside and above the skeleton's; right ones have 5 and 2 cm at most."""

POINTS_OFF_M = 0.07
POINTS_ON_M = 0.05
"""Keypoints may lie so far from the first pose; right ones do by 3 cm at most: nearer ones bear it out."""
POINTS_ASTRAY_M = 0.3
ASTRAY_SHARE = 0.1
"""Nor may they lie so far from the track in so many of the frames."""
LATE_NEARER_M = 0.002
"""Keypoints at other frames may lie so much nearer to skin; of right ones none are by 0.1 mm, a tenth of a second gives
3 to 13."""
FEW_EXCHANGED, MOST_EXCHANGED = 0.02, 0.5
"""Where a detector takes left for right in a few frames, no word is lost; in most, more than the detector is wrong."""

LEAST_ON_PERSON = 0.6
"""Where fewer of the key joints are on the foreground, more is wrong than a limb that was lost."""


@functools.singledispatch
def doubts(track: Track) -> tuple[str, ...]:
    """Warnings, in words; empty where nothing speaks against the track.

    An arm's first `MOST_FRAMES` frames are tracked again under other descriptions (`suspects`): heading, clock, mount,
    lengths, shoulder, camera, a mirrored picture; by `PROBE`, some of them by `HELD` too. Where it was smoothed,
    lengths, shoulder and cameras should be what they are said to be. Where nothing of this was said, its elbow should
    hang below the line from shoulder to wrist; a sensor on the upper arm should point along it. A
    body's key joints should have foreground about them, and its head be where the person's is.
    """
    return ()


@doubts.register
def _(track: ArmTrack) -> tuple[str, ...]:
    return *_of_jitter(track), *(_of_arm_alone(track) or _of_elbow(track)), *of_upper_arm(track)


def _of_arm_alone(track: ArmTrack) -> tuple[str, ...]:
    """By the patch and the forearm's sensor, whatever else there is: what is usual is known of these."""
    recording, sightings = _without_senses(track.recording, track.sightings)
    found = _of_arm(recording, sightings, track.method.pixel_sd)
    if found or not isinstance(track.method, Smooth) or recording is track.recording:
        return found or _of_setup(track)
    try:
        return _of_setup(track_arm(recording, track.method, track.seed, sightings=sightings))
    except TrackingError:
        return ()


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
def _of_arm(recording: ArmRecording, sightings: Sightings, pixel_sd: float) -> tuple[str, ...]:
    sightings = _first(sightings)
    held = [suspect for suspect in suspects() if suspect.kind in HELD_SUSPECTS]
    certain_held = CERTAIN_HELD * max(LEAST_FRAMES, len(sightings.time_s))
    for probe, tried, certain in ((HELD, held, certain_held), (PROBE, list(suspects()), CERTAIN)):
        method = dataclasses.replace(probe, pixel_sd=pixel_sd)
        base = _log_evidence(recording, sightings, method)
        gains = [
            (s, _gain(_log_evidence(s.change(recording), s.see(recording, sightings), method) - base)) for s in tried
        ]
        best, gain = max(gains, key=lambda found: found[1])
        if gain < certain:
            continue
        others = dict.fromkeys(s.kind for s, g in gains if g > gain - AS_GOOD and s.kind != best.kind)
        alike = f"; {' or '.join(others)} may be it as well: these cannot be told apart here" if others else ""
        return (
            f"{where_of(recording)}: camera and IMU agree better with {best.words} (log evidence "
            f"+{gain:.0f}, expected less than +{certain:g} of any change): check {best.kind}{alike}",
        )
    return ()


def _of_setup(track: ArmTrack) -> tuple[str, ...]:
    """Whether what was measured once is as it is said to be, where the whole recording was smoothed."""
    # What the data tell nothing of cannot surprise: a camera's distance drifts off where an arm reaches slowly.
    told = [found for found in found_by(track) if found.name != "offset_s" and found.is_told]
    surprising = [found for found in told if found.surprise > SURPRISING]
    if not surprising or len(track.time_s) < LEAST_FRAMES:
        return ()
    worst = max(surprising, key=lambda found: found.surprise)
    return (
        f"{where_of(track.recording)}: camera and IMU agree better with another {worst.what}, by {worst.change:+.3g} ± "
        f"{worst.sd:.2g} {worst.unit}, expected at most ± {SURPRISING * worst.given_sd:.2g} {worst.unit}: check "
        f"{' and '.join(dict.fromkeys(found.name for found in surprising))}",
    )


def _first(sightings: Sightings) -> Sightings:
    """Of the first `MOST_FRAMES` frames."""
    if len(sightings.time_s) <= MOST_FRAMES:
        return sightings
    return Sightings(sightings.time_s[:MOST_FRAMES], sightings.pixels[:MOST_FRAMES], sightings.reasons[:MOST_FRAMES])


def _gain(better: Array) -> float:
    """By how much a setting is better over the whole recording; nothing where only a part of it says so."""
    better = np.clip(better[np.isfinite(better)], -AT_MOST, AT_MOST)
    if len(better) < LEAST_FRAMES:
        return 0.0
    quarters = [float(part.sum()) for part in np.array_split(better, 4)]
    return sum(quarters) if sum(quarter > 0 for quarter in quarters) >= 3 else 0.0


def _log_evidence(recording: ArmRecording, sightings: Sightings, method: ArmMethod) -> Array:
    """Of every frame `(T,)`; NaN where there is none, as bad as can be once the filter was lost."""
    found = np.full(len(sightings.time_s), np.nan)
    track: Track
    try:
        track = track_arm(recording, method, sightings=sightings)
    except InputError:
        return found
    except TrackingError as error:
        found[:] = LOST
        if not hasattr(error, "track"):
            return found
        track = error.track
    known = np.isfinite(track.log_evidence)
    found[known] = track.log_evidence[known]
    found[sightings.time_s < recording.imus[0].time_s[0] + SETTLED_S] = np.nan
    return found


def unbelieved(track: Track) -> tuple[str, ...]:
    """A sentence where frames are not to be believed, with the reasons.

    Empty where all are, or a few were only not seen.
    """
    said = (words for reason in track.reason if reason for words in reason.split("; "))
    counts = Counter(re.sub(r" for [\d.]+ s$", "", words) for words in said)
    bad = int((~track.valid).sum())
    if not bad or (bad < FEW_UNSEEN * len(track.valid) and not any(words in counts for words in ARM_DOUBTS)):
        return ()
    named = ", ".join(f"{words} ({count})" for words, count in counts.most_common(3))
    share = bad / len(track.valid)
    return (f"{bad} of {len(track.valid)} frames ({share:.0%}) are not valid, do not use them: {named}",)


def where_of(recording: Recording) -> str:
    """What to call a recording in a sentence: the name of its folder."""
    return recording.folder.resolve().name if recording.folder else "the recording"


def _lies(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the first pose has its head beside its hips, not above them."""
    joints = track.recording.skeleton.joints(track.recording.initial[None])
    trunk = (joints["head"] - joints["root"])[0]
    off_deg = float(np.degrees(np.arccos(np.clip(trunk[1] / np.linalg.norm(trunk), -1.0, 1.0))))
    if off_deg < LYING_DEG:
        return ()
    return (
        f"{where_of(track.recording)}: in the first pose the head is {off_deg:.0f}° off straight above the hips, and a "
        "body's world has its y axis up: is another axis up in the camera's world (rotation, points)?",
    )


Track.doubter = staticmethod(doubts)


@doubts.register
def _(track: BodyTrack) -> tuple[str, ...]:
    return (*_of_light(track), *_of_sides(track), *_of_late_points(track), *_of_first_pose(track))


def _of_light(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the face of the first frame is not as faces usually are, and was made so."""
    if track.gains == (1.0, 1.0, 1.0):
        return ()
    blue, green, red = track.gains
    return (
        f"{where_of(track.recording)}: the light is dim or of another colour than the camera took it for, or the face "
        f"of the first frame is hidden: pictures were multiplied by {blue:.2f} (blue), {green:.2f} (green) and "
        f"{red:.2f} (red), which makes that face as faces usually are",
    )


def _of_late_points(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where keypoints are of other frames than they are counted as."""
    late, nearer_m = track.points_late
    if nearer_m < LATE_NEARER_M:
        return ()
    side = "before" if late > 0 else "after"
    return (
        f"{where_of(track.recording)}: the keypoints of the wrists lie nearer to skin, by {100 * nearer_m:.1f} cm on "
        f"average, if those of a frame are taken to be of {abs(late)} frames {side} it: is the video cut or counted "
        "otherwise than the one that they were found in?",
    )


def _of_sides(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where left and right of keypoints are not the pose's, and were exchanged."""
    frames = np.flatnonzero(track.points_exchanged)
    if len(frames) <= FEW_EXCHANGED * len(track.time_s):
        return ()
    said = (
        f"{where_of(track.recording)}: in {len(frames)} of {len(track.time_s)} frames, first in frame {frames[0]}, "
        "left and right of the keypoints are exchanged against the body that is tracked, and were taken so"
    )
    if len(frames) < MOST_EXCHANGED * len(track.time_s):
        return (said,)
    return (f"{said}: are they of a mirrored video, or does the first pose face the other way?",)


def _of_first_pose(track: BodyTrack) -> tuple[str, ...]:
    """The first that is found to be wrong with first pose, keypoints or foreground."""
    where = where_of(track.recording)
    if lies := _lies(track):
        return lies
    if track.points_off_m > POINTS_OFF_M:
        return (
            f"{where}: at the first frame the keypoints of the arms lie {100 * track.points_off_m:.0f} cm beside the "
            f"first pose, expected at most {100 * POINTS_OFF_M:.0f} cm: check the first pose, the camera, and size_px",
        )
    astray = np.flatnonzero(track.points_astray_m > POINTS_ASTRAY_M)
    if len(astray) > ASTRAY_SHARE * len(track.time_s):
        return (
            f"{where}: in {len(astray)} frames, first in frame {astray[0]}, the keypoints of the arms lie "
            f"{np.median(track.points_astray_m[astray]):.1f} m beside the person who is tracked: does the detector "
            "follow somebody else there, or has the track left the person?",
        )
    if not len(track.on_person):
        return ()
    first, all_frames = track.on_person[0], float(np.mean(track.on_person))
    least = f"expected {LEAST_ON_PERSON:.0%} at least"
    if min(first, all_frames) < LEAST_ON_PERSON and track.points_off_m < POINTS_ON_M:
        return (
            f"{where}: {min(first, all_frames):.0%} of the joints are on the foreground, {least}, though the arms are "
            "where their keypoints are: the background holds a part of the person; camera.background names one without",
        )
    if first < LEAST_ON_PERSON:
        return (
            f"{where}: at the first frame {first:.0%} of the joints are on the foreground, {least}: check the first "
            "pose, the skeleton and the camera, and that the background does not hold the person",
        )
    right_m, below_m = track.head_off_m
    if abs(right_m) > HEAD_BESIDE_M or abs(below_m) > HEAD_ABOVE_M:
        side, height = "right" if right_m > 0 else "left", "below" if below_m > 0 else "above"
        return (
            f"{where}: at the first frame the person's head is {100 * abs(right_m):.0f} cm {side} of the skeleton's "
            f"and {100 * abs(below_m):.0f} cm {height} it, expected at most {100 * HEAD_BESIDE_M:.0f} and "
            f"{100 * HEAD_ABOVE_M:.0f} cm: check the first pose, the skeleton's size, and the camera or its points",
        )
    if all_frames < LEAST_ON_PERSON:
        return (
            f"{where}: {all_frames:.0%} of the joints are on the foreground, {least}: see the overlay for whether the "
            "skeleton has left the person",
        )
    return ()
