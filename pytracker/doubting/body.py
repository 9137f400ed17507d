"""What speaks against a body's track: light, keypoints of another side, frame or person, a first pose beside it."""

from __future__ import annotations

import numpy as np

from pytracker.doubting.body_sensors import of_sensors
from pytracker.doubting.camera_place import of_camera_place
from pytracker.doubting.foreground import of_foreground
from pytracker.evidence.points.late import Counted
from pytracker.evidence.points.subject import points_of_subject
from pytracker.evidence.pose.facing import LEAST_SEEN, seen_from_behind
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.tracks import where_of

__all__ = ["of_body"]

LYING_DEG = 60.0
"""Nobody who is upright leans so far."""
ASKEW_DEG, APART_DEG = 6.0, 5.0
"""Trunk and shoulders that lean to one side by so much, and by the same but for so much, in the median frame: of ten
right recordings by 3° at most."""
POINTS_OFF_M = 0.07
"""Keypoints may lie so far from the first pose; right ones do by 3 cm at most."""
POINTS_ASTRAY_M = 0.3
ASTRAY_SHARE = 0.1
"""Nor may they lie so far from the track in so many of the frames."""
OFF_SKIN_M, OFF_SKIN_SD_M = 0.027, 0.024
"""Keypoints of wrists that are farther from skin on average, now more and now less, are of another take: of 15 pairs
of clips 2.9 cm and 2.7 at least. Of seven right ones it is 0.4 and 0.4 at most, of people in long sleeves, who are bare
only from a few centimetres on, 2.4 and 1.9."""
FEW_EXCHANGED, MOST_EXCHANGED = 0.02, 0.5
"""Exchanges of left and right, or of people, in no more than the first share of the frames are not told; beyond the
second it is the recording that is suspected, not the detector."""
FEW_BESIDE = 0.1
"""Detectors' points are wild in a few frames in a hundred, and left out."""
MANY_BESIDE = 0.2
"""Of another take those of both wrists are beside skin, and of one alone in a tenth of the frames."""

FACE = 0.45
"""So much of a head is skin, in the median frame, where its face is seen: of seven clips of two people 0.48 to 1."""


def of_body(track: BodyTrack) -> tuple[str, ...]:
    """Sentences, as of `doubts`."""
    if track.is_grey and track.recording.view.keypoints is None:
        return _of_light(track)
    others = _of_others(track)
    late = others or _of_late_points(track)
    # Keypoints of other frames would be laid on the sensors' clocks.
    sensors = () if late else of_sensors(track)
    first = _lies(track) or _of_points_beside(track) or of_foreground(track) or of_camera_place(track)
    # Who is not followed may lean in any way.
    first = first or _is_askew(track)
    return (*_of_light(track), *_of_sides(track), *_of_face(track), *late, *first, *sensors)


def _of_light(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the face of the first frame is not as faces usually are, and was made so."""
    if track.is_grey and track.recording.view.keypoints is None:
        return (
            f"{where_of(track.recording)}: the video has no colour, as of an infra-red camera: no skin is seen in it, "
            "by which hands are found; with keypoints (pytracker keypoints) it is tracked as well as any",
        )
    if track.red_is_blue:
        return (
            f"{where_of(track.recording)}: the face of the first frame is blue, and would be as faces are with red and "
            "blue exchanged: was the video written from RGB? No skin is seen in it (ffmpeg -i VIDEO -vf "
            "colorchannelmixer=rr=0:rb=1:br=1:bb=0 other.mp4 exchanges them)",
        )
    if track.gains == (1.0, 1.0, 1.0):
        return ()
    blue, green, red = track.gains
    return (
        f"{where_of(track.recording)}: the light is dim or of another colour than the camera took it for, or the face "
        f"of the first frame is hidden: pictures were multiplied by {blue:.2f} (blue), {green:.2f} (green) and "
        f"{red:.2f} (red), which makes that face as faces usually are",
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
    """A sentence where keypoints are of other frames than they are counted as, or of a mirrored or padded picture."""
    counted, nearer_m = track.points_late
    if track.points_mirrored:
        return (
            f"{where_of(track.recording)}: the keypoints of the wrists lie beside skin, and on it if the picture is "
            "mirrored: were they found in a mirrored copy of this video, as phones show who films themselves?",
        )
    if track.points_padded_m:
        return (
            f"{where_of(track.recording)}: the keypoints of the wrists lie nearer to skin, by "
            f"{100 * track.points_padded_m:.1f} cm on average, if they are shares of a square that the picture was "
            "padded to, as MoveNet and YOLO look at it, and not of the picture: write them as pixels of the video",
        )
    if counted == Counted():
        told = _of_another_take(track), _of_points_beside_skin(track)
        return (told[0] or told[1]) if track.points_beside_skin < MANY_BESIDE * len(track.time_s) else told[1]
    if counted.every > 1:
        otherwise = f"they are taken to be of one frame in {counted.every}: are they? A column frame says which"
    else:
        side = "before" if counted.late > 0 else "after"
        why = (
            "is the video cut or counted otherwise than the one that they were found in?"
            if not counted.since
            else "do rows lack there, of frames in which nobody was found (a column frame says which there are)?"
            if counted.late < 0
            else "does the video lack frames there?"
        )
        since = f"from about frame {counted.since} on " if counted.since else ""
        otherwise = f"{since}those of a frame are taken to be of {abs(counted.late)} frames {side} it: {why}"
    return (
        f"{where_of(track.recording)}: the keypoints of the wrists lie nearer to skin, by {100 * nearer_m:.1f} cm on "
        f"average, if {otherwise}",
    )


def _of_points_beside_skin(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where those of one wrist at a time were left out."""
    if track.points_beside_skin <= FEW_BESIDE * len(track.time_s):
        return ()
    return (
        f"{where_of(track.recording)}: {track.points_beside_skin} keypoints of wrists lie beside all skin, while that "
        "of the other lies on it: guessed, or stuck where the hand was, not seen, and left out",
    )


def _of_another_take(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where the keypoints of wrists are beside skin, and no lag puts them on it."""
    mean_m, sd_m = track.points_off_skin_m
    if not (mean_m >= OFF_SKIN_M and sd_m >= OFF_SKIN_SD_M):
        return ()
    return (
        f"{where_of(track.recording)}: the keypoints of the wrists lie beside all skin in the picture, by "
        f"{100 * mean_m:.1f} cm on average, now more and now less (standard deviation {100 * sd_m:.1f} cm), sooner or "
        "later too: are they of another video, or of another take of the same person?",
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
    """A sentence where a skeleton that is seen from behind has a face, or may have one and there is no picture."""
    if not track.recording.has_picture:
        joints = {name: joint.mean for name, joint in track.joints.items()}
        if seen_from_behind(track.recording.camera, joints).mean() < LEAST_SEEN:
            return ()
        return (
            f"{where_of(track.recording)}: the keypoints show the person from behind most of the time: where they face "
            "the camera, left and right are exchanged, as of a mirrored video (all is well if it is their back)",
        )
    if track.face_on_back < FACE:
        return ()
    return (
        f"{where_of(track.recording)}: the skeleton is seen from behind, but "
        f"{track.face_on_back:.0%} of its head is skin, as of a face: left and right are exchanged, of the keypoints, "
        "the picture or the first pose (all is well if it is a back, and the head is bald or fair)",
    )


def _of_points_beside(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where keypoints lie beside the first pose, or beside who is tracked."""
    where = where_of(track.recording)
    if track.points_off_m > POINTS_OFF_M:
        return (
            f"{where}: at the first frame the keypoints of an arm lie {100 * track.points_off_m:.0f} cm beside the "
            f"first pose, expected at most {100 * POINTS_OFF_M:.0f} cm: check the first pose, the camera, and that "
            "the keypoints are of this video and of its size (without a video, size_px)",
        )
    astray = np.flatnonzero(track.points_astray_m > POINTS_ASTRAY_M)
    if len(astray) <= ASTRAY_SHARE * len(track.time_s):
        return ()
    return (
        f"{where}: in {len(astray)} frames, first in frame {astray[0]}, the keypoints of the arms lie "
        f"{np.median(track.points_astray_m[astray]):.1f} m beside the person who is tracked: does the detector "
        "follow somebody else there, or has the track left the person?",
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


def _is_askew(track: BodyTrack) -> tuple[str, ...]:
    """A sentence where trunk and shoulders lean alike, to one side as the camera sees it, most of the time."""
    head, root, left, right = (
        track.joints[joint].mean for joint in ("head", "root", "left_shoulder", "right_shoulder")
    )
    up = np.array([0.0, 1.0, 0.0])
    away = track.recording.camera.viewing_directions(root)
    aside = np.cross(away, up)
    across = left - right
    across = across * np.sign((across * aside).sum(axis=1, keepdims=True))
    trunk = head - root
    lean = np.arctan2((trunk * aside).sum(axis=1), trunk @ up)
    tilt = np.arctan2(-(across @ up), (across * aside).sum(axis=1))
    if not np.isfinite(lean).any():
        return ()
    lean_deg, tilt_deg = (float(np.degrees(np.nanmedian(angle))) for angle in (lean, tilt))
    if min(abs(lean_deg), abs(tilt_deg)) < ASKEW_DEG or abs(lean_deg - tilt_deg) > APART_DEG:
        return ()
    return (
        f"{where_of(track.recording)}: trunk and shoulders lean by {abs(0.5 * (lean_deg + tilt_deg)):.0f}° to the "
        f"{'right' if lean_deg > 0 else 'left'} of the picture most of the time: was the camera rolled, or the picture "
        "turned, since it was calibrated (all is well if they stand so)?",
    )
