"""What the foreground says against a body's track: a pose beside the person, or a person who does not stand out."""

from __future__ import annotations

import numpy as np

from pytracker.tracking.body import BodyTrack
from pytracker.tracking.tracks import where_of

__all__ = ["of_foreground"]

HEAD_BESIDE_M, HEAD_ABOVE_M = 0.10, 0.07
"""The person's head may be so far beside and above the skeleton's; right ones have 5 and 2 cm at most."""
TOWERS_M = 0.5
"""Nobody's head is so far above: something else is there."""
FIRST_ON_PERSON, LEAST_ON_PERSON = 0.65, 0.6
"""Less of trunk and arms lies on the foreground, of the first pose and of all, where the pose is beside the person, or
the person too like the wall. Of right first poses of people 0.75 lies there at least, and of their tracks; half as
different from the wall they have 0.5 at most."""
NOBODY = 0.1
"""Where less of the first pose is, nobody is there."""
POINTS_ON_M = 0.05
"""Keypoints that are nearer to the first pose bear it out; right ones are by 3 cm at most."""
ON_SKIN_M = 0.015
"""Keypoints of wrists that are no farther from skin, on average, are of this video; right ones are within 4 mm."""
FLOODED = 0.25
"""Where the picture differs everywhere in so many of the frames, or in the first, nothing else is told by it."""


def of_foreground(track: BodyTrack) -> tuple[str, ...]:
    """Sentences, as of `doubts`."""
    floods = _of_floods(track)
    if len(floods) and (track.floods[0] or track.floods.mean() > FLOODED):
        return floods
    return (*floods, *(_of_shares(track) or _of_first_frame(track) or _of_all_frames(track)))


def _of_floods(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where more is foreground than a person: little is known of where they are then."""
    if not track.floods.any():
        return ()
    floods = np.flatnonzero(track.floods)
    return (
        f"{where_of(track.recording)}: in {len(floods)} of {len(track.time_s)} frames, first in frame {floods[0]}, "
        "more of the picture differs from the background than a person: did the light change, or the camera move, "
        "since the background was taken, or is it dark?",
    )


def _shares(track: BodyTrack) -> tuple[float, float]:
    """Of the first pose's trunk and arms, and of all frames' in the median, on the foreground; NaN where unknown."""
    known = track.on_person[np.isfinite(track.on_person)]
    return (float(track.on_person[0]), float(np.median(known))) if len(known) else (np.nan, np.nan)


def _of_shares(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where keypoints bear the first pose out and the foreground does not."""
    first, all_frames = _shares(track)
    is_first_off = first < FIRST_ON_PERSON
    if not (track.points_off_m < POINTS_ON_M and (is_first_off or all_frames < LEAST_ON_PERSON)):
        return ()
    share, least = (first, FIRST_ON_PERSON) if is_first_off else (all_frames, LEAST_ON_PERSON)
    others = "" if track.points_off_skin_m[0] < ON_SKIN_M else "are these of another clip or size than the video, "
    without = ", without colour" if track.is_grey else ""
    return (
        f"{where_of(track.recording)}: {share:.0%} of trunk and arms lie on the foreground, expected {least:.0%} at "
        f"least, though the arms are where their keypoints are: {others}does the background hold a part of the person "
        f"(camera.background names one without), or is the person too like it{without}, or in too dim a light?",
    )


def _of_first_frame(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the first pose is not where the person is, by trunk and arms or by the head."""
    first, _ = _shares(track)
    said, asked = [_head_off(track)], ["check the first pose, the skeleton's size, and the camera or its points"]
    if first < FIRST_ON_PERSON:
        words = (
            f"{first:.0%} of the pose's trunk and arms lie on the foreground, expected {FIRST_ON_PERSON:.0%} at least"
        )
        said.insert(0, words)
        asked.append("something may hide the person, the background may hold them, or be too like clothes and skin")
        later = np.flatnonzero(track.on_person > FIRST_ON_PERSON)
        if first < NOBODY and len(later):
            asked.append(f"from frame {later[0]} on somebody is there: does the person come in later?")
    if not any(said):
        return ()
    found = "; ".join(filter(None, said))
    return (f"{where_of(track.recording)}: at the first frame {found}: {'; '.join(asked)}",)


def _of_all_frames(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the track is beside the person in most frames."""
    _, all_frames = _shares(track)
    if not all_frames < LEAST_ON_PERSON:
        return ()
    return (
        f"{where_of(track.recording)}: in half of the frames less than {all_frames:.0%} of trunk and arms lie on the "
        f"foreground, expected {LEAST_ON_PERSON:.0%} at least: has the skeleton left the person (see the overlay), or "
        "do clothes and skin hardly differ from the background?",
    )


def _head_off(track: BodyTrack) -> str:
    """Where the person's head is at the first frame, where that is not the skeleton's; else empty."""
    right_m, below_m = track.head_off_m
    if not (abs(right_m) > HEAD_BESIDE_M or abs(below_m) > HEAD_ABOVE_M):
        return ""
    if below_m < -TOWERS_M:
        return (
            f"what differs from the background reaches {-100 * below_m:.0f} cm above the skeleton's head, expected at "
            f"most {100 * HEAD_ABOVE_M:.0f} cm (is the background of another place of the camera, or another light?)"
        )
    side, height = "right" if right_m > 0 else "left", "below" if below_m > 0 else "above"
    return (
        f"the person's head is {100 * abs(right_m):.1f} cm {side} of the skeleton's and {100 * abs(below_m):.1f} cm "
        f"{height} it, expected at most {100 * HEAD_BESIDE_M:.0f} and {100 * HEAD_ABOVE_M:.0f} cm"
    )
