"""A check of a body's recording: camera, skeleton, and the first pose, from keypoints or else from the outline."""

from __future__ import annotations

from typing import Any

import numpy as np

from pytracker._core import InputError
from pytracker.evidence.picture.background import read_background
from pytracker.formats.keypoints.read import Keypoints
from pytracker.formats.video import frames
from pytracker.recording.body import skeleton_of
from pytracker.recording.body_view import view_of
from pytracker.recording.found_pose import fingerprint, is_as_found, is_stale, lines_of
from pytracker.recording.recording import BodyView
from pytracker.recording.schema import BodyCameraEntry, SkeletonEntry
from pytracker.setup.checks.findings import Finding
from pytracker.setup.draft import Draft
from pytracker.setup.entries.subject import LEVEL
from pytracker.setup.poses.fit import FoundPose
from pytracker.setup.poses.keypoints import first_pose
from pytracker.setup.poses.outline import first_outline
from pytracker.setup.poses.person import first_person, first_row
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["check_body"]

INITIAL = "initial.toml"
USUALLY = np.radians(10.0)
"""So far cameras look down: a trunk that looks short may lean either way, and few look up."""
STEEPEST = np.radians(40.0)
"""A camera that looks down by more sees no trunk that tells."""
HANGS = "how far joints lie towards the camera hangs on it, 1.7 cm for each 10 cm of height and 10°"
PITCH_SD = 8
"""So far apart it is found of different people before one camera, °: 9 to 30 of one that looks down by 20."""
VAGUE = 0.03
"""A focal length that is known to a larger share is worth a word."""


def check_body(draft: Draft) -> list[Finding]:
    """Line by line; what is not there stops only what needs it."""
    found: list[Finding] = []
    skeleton, view = _skeleton(draft, found), _view(draft, found)
    focal_sd = float(draft.get("camera.focal_sd") or 0.0)
    found += _tilt(draft)
    if focal_sd > VAGUE:
        words = (
            f"known to {focal_sd:.0%}, and so is how far off the person is: pytracker calibrate camera finds it; how "
            "the joints lie to each other hardly depends on it"
        )
        found.append(Finding("focal length", "doubtful", words))
    inputs = None if skeleton is None or view is None else fingerprint(skeleton, view, focal_sd)
    is_changed = (
        inputs is not None and draft.get("initial.angles") == INITIAL and is_stale(draft.folder / INITIAL, inputs)
    )
    if not is_changed and (draft.get("initial.angles") is not None or draft.get("initial.frame") is not None):
        found.append(Finding("first pose", "right", "is given; how it stands on the person is said below"))
    elif str(draft.get("truth.file") or "").endswith(".amc"):
        found.append(Finding("first pose", "right", "is the truth's own"))
    elif skeleton is None or view is None:
        words = "not given: [initial] angles, or camera and skeleton to find it from the first frame"
        found.append(Finding("first pose", "missing", words))
    elif view.keypoints is None:
        found.append(_by_outline(draft, skeleton, view, focal_sd))
    else:
        if draft.get("camera.rotation") == LEVEL and draft.get("camera.translation_m") == [0.0, 0.0, 0.0]:
            view = _pitched(draft, skeleton, view, found)
        found.append(_first_pose(draft, skeleton, view, focal_sd))
    return found


def _pitched(draft: Draft, skeleton: Skeleton, view: BodyView, found: list[Finding]) -> BodyView:
    """The camera turned so that the person stands upright before it, where it was guessed that it is level."""
    assert view.keypoints is not None
    points, _ = first_person(view.keypoints.points)
    try:
        pose = first_pose(skeleton, _looking_down(draft, USUALLY).camera, points)
    except InputError:
        return view  # said of the first pose
    _, _, rotations = skeleton.core.pose(pose.channels(skeleton)[None])
    _, up, near = rotations[0, skeleton.bone("lowerback")][:, 1]
    pitch = USUALLY + float(np.arctan2(near, up))
    if abs(pitch) > STEEPEST:
        words = (
            f"the person seems to lean by {abs(np.degrees(pitch)):.0f}° in the first frame, or the camera looks down "
            "so steeply, or the picture is stretched (are its pixels square?): it is taken to be level, give "
            "camera.rotation where it is not"
        )
        found.append(Finding("camera's pitch", "doubtful", words))
        return view
    words = (
        f"looks {'down' if pitch > 0 else 'up'} by about {abs(np.degrees(pitch)):.0f}°, give or take {PITCH_SD}°, if "
        f"the person stands upright in the first frame: {HANGS}"
    )
    found.append(Finding("camera's pitch", "missing", words, {"camera.rotation": _rotation(pitch)}))
    return _looking_down(draft, pitch)


def _tilt(draft: Draft) -> list[Finding]:
    """A word on a camera from which the joints are told: its pitch was found once, and is no calibration."""
    rotation, place = draft.get("camera.rotation"), draft.get("camera.translation_m")
    if place != [0.0, 0.0, 0.0] or rotation == LEVEL:
        return []
    try:
        pitch = float(np.arctan2(rotation[1][2], -rotation[1][1]))
        is_pitch = np.allclose(rotation, _rotation(pitch), atol=1e-4)
    except (TypeError, ValueError, IndexError):
        return []  # said of the camera
    if not is_pitch:
        return []
    words = f"is given as {np.degrees(pitch):.0f}° down, of a camera whose place is not known: {HANGS}"
    return [Finding("camera's pitch", "doubtful", words)]


def _looking_down(draft: Draft, pitch: float) -> BodyView:
    turned = BodyCameraEntry.model_validate({**draft.table("camera"), "rotation": _rotation(pitch)})
    return view_of(draft.folder, draft.path, turned)


def _rotation(pitch: float) -> list[list[float]]:
    """Of a camera that looks down by so much, rad, along -z."""
    c, s = round(float(np.cos(pitch)), 5), round(float(np.sin(pitch)), 5)
    return [[1.0, 0.0, 0.0], [0.0, -c, s], [0.0, -s, -c]]


def _skeleton(draft: Draft, found: list[Finding]) -> Skeleton | None:
    given = draft.table("skeleton")
    if not given:
        found.append(Finding("skeleton", "missing", "neither skeleton.file nor skeleton.height_m is given"))
        return None
    try:
        skeleton, _ = skeleton_of(draft.folder, draft.path, SkeletonEntry.model_validate(given))
    except (InputError, OSError) as error:
        found.append(Finding("skeleton", "wrong", str(error)))
        return None
    return skeleton


def _view(draft: Draft, found: list[Finding]) -> BodyView | None:
    given: dict[str, Any] = draft.table("camera")
    if not {"points", "affine", "matrix"} & set(given):
        words = "none of points, affine or matrix is given: pytracker calibrate says how to find them"
        found.append(Finding("camera", "missing", words))
        return None
    lacks = [key for key in ("rotation", "translation_m") if "matrix" in given and key not in given]
    if lacks:
        words = f"{' and '.join(lacks)} not given: pytracker calibrate pose finds them from points with known places"
        found.append(Finding("camera", "missing", words))
        return None
    try:
        return view_of(draft.folder, draft.path, BodyCameraEntry.model_validate(given))
    except (InputError, OSError) as error:
        found.append(Finding("camera or keypoints", "wrong", str(error)))
        return None


def _first_pose(draft: Draft, skeleton: Skeleton, view: BodyView, focal_sd: float) -> Finding:
    assert view.keypoints is not None
    if view.keypoints.frames[0] != 0:
        words = f"the keypoints begin at frame {view.keypoints.frames[0]}, expected the video's first to find it from"
        return Finding("first pose", "missing", words)
    points, people = first_person(view.keypoints.points)
    try:
        pose = first_pose(skeleton, view.camera, points, focal_sd)
    except InputError as error:
        return Finding("first pose", "missing", f"{error}{_when(view.keypoints)}")
    name, sds = pose.worst
    words = (
        f"joints lie {pose.rms_px:.1f} px from the frame's keypoints (RMS), the {name.replace('_', ' ')} farthest: "
        f"{sds:.1f} standard deviations; depth is as people usually stand"
    )
    if people > 1:
        u, v = np.nanmean(points[:, :2], axis=0)
        words += f"; of {people} people there, the largest in the picture is taken, about ({u:.0f}, {v:.0f}) px"
    if pose.is_from_behind:
        words += "; the person is seen from behind, or the picture is mirrored"
    if not pose.fits:
        return Finding("first pose", "cannot be told", f"{words}: check camera, skeleton and keypoints")
    return _written(draft, pose, words, fingerprint(skeleton, view, focal_sd))


def _by_outline(draft: Draft, skeleton: Skeleton, view: BodyView, focal_sd: float) -> Finding:
    """Of a video without keypoints."""
    assert view.video is not None
    better = "keypoints tell more (camera.keypoints; pytracker keypoints finds them)"
    source = view.video if view.background is None else view.background
    try:
        first, background = next(frames(view.video)).image, read_background(source)
        if background.shape != first.shape:
            raise InputError(f"the background is {background.shape}, expected {first.shape} as the video")
        pose = first_outline(skeleton, view.camera, first, background, focal_sd)
    except (InputError, OSError) as error:
        return Finding("first pose", "missing", f"not given, and not found: {error}; {better}")
    words = (
        f"by the outline of the first frame: {pose.explained:.0%} of it lies on the pose, {pose.on_person:.0%} of the "
        "pose on it; depth is as people usually stand, who is taken to look at the camera"
    )
    if not pose.is_whole:
        words += "; the feet are not in the picture, so that the distance is a guess"
    if view.background is None:
        words += "; the background is the video's median, which may hold a part of the person"
    if not pose.fits:
        return Finding(
            "first pose", "cannot be told", f"{words}: check camera, height and background, or give it; {better}"
        )
    return _written(draft, pose, f"{words}; {better}", fingerprint(skeleton, view, focal_sd))


def _written(draft: Draft, pose: FoundPose, words: str, inputs: str) -> Finding:
    """What should stand in the folder, where nothing of the user's own stands there."""
    if (draft.folder / INITIAL).exists() and not is_as_found(draft.folder / INITIAL):
        words += f"; {INITIAL} is there already: name it (initial.angles), or remove it to have this one written"
        return Finding("first pose", "doubtful", words)
    if draft.get("initial.angles") is not None:
        words += f"; the one in {INITIAL} was found with another camera, height or keypoints"
    values: dict[str, object] = {"initial.angles": INITIAL}
    if pose.distance_sd_m is not None:
        values["initial.distance_sd_m"] = pose.distance_sd_m
    return Finding("first pose", "missing", words, values, {INITIAL: lines_of(pose.angles, inputs)})


def _when(keypoints: Keypoints) -> str:
    """From which frame on there is enough to see, in words."""
    row = first_row(keypoints.points)
    if not row:
        return ""
    frame = int(keypoints.frames[row])
    return f"; there are from frame {frame} on: cut what is before it off the video, and find the keypoints again"
