"""What speaks against an arm's track: its clocks, its description, what it says of its own set-up, its elbow."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from pytracker._core import TrackingError
from pytracker.doubting.clocks import of_clocks
from pytracker.doubting.description import LEAST_FRAMES, PAUSE_S, of_description, of_last_frames
from pytracker.doubting.patch_place import of_patch_place
from pytracker.doubting.pauses import of_hanging
from pytracker.doubting.swivel import hangs, surely_hangs
from pytracker.doubting.upper_arm import of_unused_senses, of_upper_arm
from pytracker.evidence.sightings import Sightings
from pytracker.formats.video import probe
from pytracker.methods.arm import Smooth
from pytracker.recording.recording import ArmRecording
from pytracker.tracking.alike import UNLIKE
from pytracker.tracking.arm import JITTERY, ArmTrack, filter_arm
from pytracker.tracking.found import found_by
from pytracker.tracking.tracks import where_of

__all__ = ["of_arm"]

SURPRISING = 2.4
"""What was measured once should not differ by more standard deviations of what the data can tell of it; of simulated
right ones, worn too, none does by 1.6, of captured arms, whose shoulders move, 2 in 38 do by more than 2.1."""

LEAST_MEASURED = 0.7
"""Where the sensor measured in fewer of the frames, what holds the wrist in the others moves lengths and cameras."""

MOST_UNLIKE = 0.1
"""Where patch and sensor do not move alike in more of the frames, where the patch sits is not the question."""

ABOVE = -0.12
"""No captured arm's elbow hangs less than 0.27 (`pytracker.doubting.swivel`)."""


def of_arm(track: ArmTrack) -> tuple[str, ...]:
    """Sentences, as of `doubts`."""
    alone = _tracked_alone(track)
    upper_arm = of_upper_arm(track, alone)
    described = of_clocks(track) or _of_description_or_patch(track, alone, upper_arm) or _of_elbow(track)
    if _has_odd_camera(track):
        # It would be taken for another shoulder, distance or mount.
        described = tuple(
            f"{words}; or it is the camera's matrix, which is odd: mend that first" for words in described
        )
    odd = *of_hanging(track), *_of_jitter(track)
    return *odd, *described, *upper_arm, *of_unused_senses(track)


def _has_odd_camera(track: ArmTrack) -> bool:
    seen = [(view.camera, probe(view.video)) for view in track.recording.views if view.video is not None]
    return any(camera.oddities((info.width, info.height)) for camera, info in seen)


def _of_description_or_patch(track: ArmTrack, alone: ArmTrack | None, upper_arm: tuple[str, ...]) -> tuple[str, ...]:
    """A patch that sits elsewhere looks like another heading, and is told beside it.

    So does, as such a patch, a second sensor that points elsewhere, a clock, and whatever makes patch and sensor move
    unlike each other: beside these it is not asked for.
    """
    # By the patch and the forearm's sensor, whatever else there is: what is usual is known of these.
    recording, sightings = _without_senses(track.recording, track.sightings)
    described = of_description(recording, sightings, track.method.pixel_sd, track.method.velocity_start_sd)
    if not described and (changed := of_last_frames(track, recording, sightings)):
        return changed  # lengths, cameras and the patch's place would be bent by it
    described = described or (() if alone is None else _of_setup(alone))
    unlike = np.mean([UNLIKE in reason for reason in track.reason])
    if upper_arm or unlike > MOST_UNLIKE or any("offset_s" in words for words in described):
        return described
    return *described, *of_patch_place(track)


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
    if surely_hangs(track) > ABOVE or np.count_nonzero(track.valid) < LEAST_FRAMES:
        return ()
    return (
        f"{where_of(track.recording)}: the elbow would be above the line from shoulder to wrist most of the time (mean "
        f"cosine of the arm's swivel {hangs(track):.2f}, of people 0.3 to 0.9): check mount, heading_deg and side, "
        "unless it was raised indeed",
    )


@functools.lru_cache(maxsize=1)  # the same recording for several methods, which then share what is found of it
def _without_senses(recording: ArmRecording, sightings: Sightings) -> tuple[ArmRecording, Sightings]:
    if not (recording.landmarks or recording.has_upper_arm):
        return recording, sightings
    alone = dataclasses.replace(recording, imus=recording.imus[:1], landmarks=())
    return alone, dataclasses.replace(sightings, landmarks=())


def _of_setup(track: ArmTrack) -> tuple[str, ...]:
    """Whether what was measured once is as it is said to be, where the whole recording was smoothed."""
    # What the data tell nothing of cannot surprise: a camera's distance drifts off where an arm reaches slowly.
    told = [found for found in found_by(track) if found.name != "offset_s" and found.is_told]
    surprising = [found for found in told if found.surprise > SURPRISING]
    imu_s = track.recording.imus[0].time_s
    last = np.searchsorted(imu_s, track.time_s, side="right") - 1
    measured = np.mean((last >= 0) & (track.time_s - imu_s[last] < PAUSE_S))
    if not surprising or len(track.time_s) < LEAST_FRAMES or measured < LEAST_MEASURED:
        return ()
    surprising.sort(key=lambda found: -found.surprise)
    worst = surprising[0]
    # From one place a camera that is nearer sees what one with a longer lens does, one that is turned what one with
    # another principal point does.
    camera, _, of = worst.name.partition(".")
    lens = {"translation_m": "focal length", "rotation": "principal point"}.get(of)
    lens = None if worst.what.endswith("roll") else lens
    alike = f" (or {camera}.matrix, its {lens})" if lens else ""
    return (
        f"{where_of(track.recording)}: camera and IMU agree better with another {worst.what}, by {worst.change:+.3g} ± "
        f"{worst.sd:.2g} {worst.unit}, expected at most ± {SURPRISING * worst.change_sd:.2g} {worst.unit}: check "
        f"{' and '.join(dict.fromkeys(found.name for found in surprising))}{alike}",
    )
