"""What speaks against a body's track: light, keypoints of another side, frame or person, a first pose beside it."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.subject import points_of_subject
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.body_sensors import of_sensors
from pytracker.tracking.camera_place import of_camera_place
from pytracker.tracking.tracks import where_of

__all__ = ["of_body"]

LYING_DEG = 60.0
"""Nobody who is upright leans so far."""
HEAD_BESIDE_M, HEAD_ABOVE_M = 0.10, 0.07
"""The person's head may be so far beside and above the skeleton's; right ones have 5 and 2 cm at most."""

TOWERS_M = 0.5
"""Nobody's head is so far above: something else is there."""

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
"""Exchanges of left and right, or of people, in no more than the first share of the frames are not told; beyond the
second it is the recording that is suspected, not the detector."""

FACE = 0.45
"""So much of a head is skin, in the median frame, where its face is seen: of seven clips of two people 0.48 to 1."""

NOBODY = 0.1
"""Where less of the first pose is, nobody is there."""
FIRST_ON_PERSON, LEAST_ON_PERSON = 0.65, 0.6
"""Less of trunk and arms lies on the foreground, of the first pose and of all, where the pose is beside the person, or
the person too like the wall. Of right first poses of people 0.75 lies there at least, and of their tracks; half as
different from the wall they have 0.5 at most."""


def of_body(track: BodyTrack) -> tuple[str, ...]:
    """Sentences, as of `doubts`."""
    others = _of_others(track)
    late = others or _of_late_points(track)
    # Keypoints of other frames would be laid on the sensors' clocks.
    sensors = () if late else of_sensors(track)
    first = _of_background(track) or _of_first_pose(track) or of_camera_place(track)
    return (*_of_light(track), *_of_sides(track), *_of_face(track), *late, *first, *sensors)


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


def _of_background(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where more is foreground than a person: little is known of where they are then."""
    if not track.floods.any():
        return ()
    floods = np.flatnonzero(track.floods)
    return (
        f"{where_of(track.recording)}: in {len(floods)} of {len(track.time_s)} frames, first in frame {floods[0]}, "
        "more of the picture differs from the background than a person: did the light change, or the camera move, "
        "since it was taken, or is it dark?",
    )


def _of_others(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where a detector found others than the subject alone, or points that leapt as nobody does."""
    keypoints = track.recording.view.keypoints
    if keypoints is None:
        return ()
    mine = points_of_subject(track.recording, keypoints)
    there = keypoints.frames[np.isfinite(keypoints.points[..., 0]).any(axis=(1, 2))]
    others = [frame for frame in there.tolist() if frame not in mine]
    if len(others) <= FEW_EXCHANGED * len(track.time_s):
        return ()
    return (
        f"{where_of(track.recording)}: in {len(others)} of {len(track.time_s)} frames, first in frame {others[0]}, "
        "keypoints are of somebody else than the first pose's person, or of that one leapt aside as nobody does: they "
        "are left out",
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


def _of_face(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where a skeleton that is seen from behind has a face."""
    if track.face_on_back < FACE:
        return ()
    return (
        f"{where_of(track.recording)}: the skeleton is seen from behind, but "
        f"{track.face_on_back:.0%} of its head is skin, as of a face: left and right are exchanged, of the keypoints, "
        "the picture or the first pose (all is well if it is a back, and the head is bald or fair)",
    )


def _of_first_pose(track: BodyTrack) -> tuple[str, ...]:
    """The first that is found to be wrong with first pose, keypoints or foreground."""
    where = where_of(track.recording)
    if lies := _lies(track):
        return lies
    if track.points_off_m > POINTS_OFF_M:
        return (
            f"{where}: at the first frame the keypoints of the arms lie {100 * track.points_off_m:.0f} cm beside the "
            f"first pose, expected at most {100 * POINTS_OFF_M:.0f} cm: check the first pose, the camera, and that "
            "the keypoints are of this video and of its size (without a video, size_px)",
        )
    astray = np.flatnonzero(track.points_astray_m > POINTS_ASTRAY_M)
    if len(astray) > ASTRAY_SHARE * len(track.time_s):
        return (
            f"{where}: in {len(astray)} frames, first in frame {astray[0]}, the keypoints of the arms lie "
            f"{np.median(track.points_astray_m[astray]):.1f} m beside the person who is tracked: does the detector "
            "follow somebody else there, or has the track left the person?",
        )
    on_person = track.on_person[np.isfinite(track.on_person)]
    if not len(on_person):
        return ()
    first, all_frames = float(on_person[0]), float(np.median(on_person))
    is_first_off, is_off = first < FIRST_ON_PERSON, all_frames < LEAST_ON_PERSON
    if (is_first_off or is_off) and track.points_off_m < POINTS_ON_M:
        return (
            f"{where}: {min(first, all_frames):.0%} of trunk and arms lie on the foreground, expected "
            f"{LEAST_ON_PERSON:.0%} at least, though the arms are where their keypoints are: are these of "
            "another clip or size than the video, does the background hold a part of the person (camera.background "
            "names one without), or is the person too like it?",
        )
    too_little = (
        f"{first:.0%} of the pose's trunk and arms lie on the foreground, expected {FIRST_ON_PERSON:.0%} at least"
        if is_first_off
        else ""
    )
    if said := "; ".join(filter(None, (too_little, _head_off(track)))):
        like = "; the background may hold the person, or be too like clothes and skin" if is_first_off else ""
        later = np.flatnonzero(track.on_person > FIRST_ON_PERSON)
        if first < NOBODY and len(later):
            like += f"; from frame {later[0]} on somebody is there: does the person come in later?"
        return (
            f"{where}: at the first frame {said}: check the first pose, the skeleton's size, and the camera or its "
            f"points{like}",
        )
    if is_off:
        return (
            f"{where}: in half of the frames less than {all_frames:.0%} of trunk and arms lie on the foreground, "
            f"expected {LEAST_ON_PERSON:.0%} at least: has the skeleton left the person (see the overlay), or do "
            "clothes and skin hardly differ from the background?",
        )
    return ()


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
        f"the person's head is {100 * abs(right_m):.0f} cm {side} of the skeleton's and {100 * abs(below_m):.0f} cm "
        f"{height} it, expected at most {100 * HEAD_BESIDE_M:.0f} and {100 * HEAD_ABOVE_M:.0f} cm"
    )


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
