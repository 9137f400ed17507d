"""Shoulder and elbow of an arm as its cameras see them: by further patches, or as a detector's keypoints."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS, InputError
from pytracker.evidence.patch.camshift import PatchTrack, track_patch
from pytracker.evidence.patch.colour import CamshiftParameters
from pytracker.formats.keypoints.read import Keypoints
from pytracker.formats.video import Frame
from pytracker.recording.keypoints.load import tallest
from pytracker.recording.keypoints.spreads import with_spreads
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array

__all__ = ["JointPixels", "joints_seen", "wrist_seen"]

PATCH_SD_PX = 4.0
"""Of a patch's centre, as of the one on the wrist."""
NEARER = 3.0
"""A patch that lies so many times nearer to the other wrist is worn there."""

MOST_BESIDE_M = 0.20
"""A shoulder moves, and what is seen lies on its skin; not so far."""

SHORTEST, LONGEST = 0.35, 1.6
"""A forearm looks as long at least once, and never longer, in its own lengths."""
MOST_APART = 0.8
"""A patch lies on the wrist that a detector finds, but for so many lengths of the forearm."""
BRIDGED_S = 0.15
"""Between frames that are no farther apart, as of a detector that looks at every third one, a wrist is not unseen."""

JointPixels = tuple[Array, Array]
"""Pixels `(T, 2)`, NaN where not seen, and their standard deviations `(T,)`, px; a row a frame of the video."""


def joints_seen(
    recording: ArmRecording,
    camera: int,
    patch: PatchTrack,
    parameters: CamshiftParameters | None,
    film: Callable[[str], Iterator[Frame]],
) -> dict[str, JointPixels]:
    """What `camera`, which saw the wrist's `patch`, saw of other joints, by name; `film` starts its video, for a stage.

    Raises `InputError` where keypoints show that the patch is worn on the other arm, or the shoulder is elsewhere.
    """
    view = recording.views[camera]
    found = {} if view.keypoints is None else _of_keypoints(recording, camera, patch)
    for joint, box in view.patches.items():
        try:
            track = track_patch(film(f"patch on the {joint}"), box, parameters)
        except InputError as error:
            raise InputError(f"camera[{camera}].patches.{joint}: {error}") from None
        found[joint] = track.pixel, np.full(len(track.pixel), PATCH_SD_PX)
    if "shoulder" in found:
        _check_shoulder(recording, camera, found["shoulder"][0])
    if "elbow" in found:
        _check_elbow(recording, camera, found["elbow"][0], patch.pixel)
    return found


def _check_elbow(recording: ArmRecording, camera: int, pixels: Array, wrist: Array) -> None:
    """It must be as far from the wrist, in the picture, as a forearm can look."""
    view, arm = recording.views[camera].camera, recording.arm
    px_per_m = float(view.px_per_m(np.array([arm.shoulder_m]))[0])
    off_px = np.linalg.norm(pixels - wrist, axis=1)
    off_px = off_px[np.isfinite(off_px)]
    if not len(off_px) or not px_per_m > 0:
        return
    off_m = float(np.quantile(off_px, 0.9)) / px_per_m
    if not SHORTEST * arm.forearm_m < off_m < LONGEST * arm.forearm_m:
        raise InputError(
            f"camera[{camera}]: what is seen of the elbow is {100 * off_m:.0f} cm from the wrist in the picture (in "
            f"nine of ten frames at most), expected {100 * SHORTEST * arm.forearm_m:.0f} to "
            f"{100 * LONGEST * arm.forearm_m:.0f} cm: check patches.elbow or keypoints, patch_box and arm.forearm_m"
            f"{_or_without(recording, camera)}"
        )


def _check_shoulder(recording: ArmRecording, camera: int, pixels: Array) -> None:
    """What is seen of it must lie where the recording has it, but for skin and movement."""
    view, shoulder = recording.views[camera].camera, np.array(recording.arm.shoulder_m)
    most_px = MOST_BESIDE_M * float(view.px_per_m(shoulder[None])[0])
    off_px = np.linalg.norm(pixels - view.project(shoulder[None])[0], axis=1)
    if np.isfinite(off_px).any() and (off := float(np.nanmedian(off_px))) > most_px:
        raise InputError(
            f"camera[{camera}]: what is seen of the shoulder is {off:.0f} px from where shoulder_m is (median), "
            f"expected at most {most_px:.0f} px ({100 * MOST_BESIDE_M:.0f} cm): check patches.shoulder or keypoints, "
            f"arm.shoulder_m and the camera's rotation and translation_m{_or_without(recording, camera)}"
        )


def _or_without(recording: ArmRecording, camera: int) -> str:
    """Who has a patch on the wrist needs no detector."""
    view = recording.views[camera]
    has_both = view.keypoints is not None and view.patch_box is not None
    return f"; or take camera[{camera}].keypoints out, the patch is enough" if has_both else ""


def wrist_seen(keypoints: Keypoints, side: str, film: Iterator[Frame]) -> PatchTrack:
    """A detector's wrist in place of a patch, frame by frame of the video."""
    time_s = np.array([frame.time_s for frame in film])
    people = _people(keypoints, len(time_s))
    pixel = _followed(people, side, np.full((len(time_s), 2), np.nan))[:, KEYPOINTS.index(f"{side}_wrist"), :2]
    valid = np.isfinite(pixel).all(axis=1).reshape(-1)
    unseen = ~valid & (_gap_s(time_s, valid) > BRIDGED_S)
    reason = tuple("the wrist is not among the keypoints" if so else "" for so in unseen)
    return PatchTrack(time_s, pixel, valid, reason)


def _gap_s(time_s: Array, seen: NDArray[np.bool_]) -> Array:
    """Between the frames about each `(T,)` that were seen, s; infinite before the first and after the last."""
    before = np.maximum.accumulate(np.where(seen, time_s, -np.inf))
    after = np.minimum.accumulate(np.where(seen, time_s, np.inf)[::-1])[::-1]
    return np.asarray(after - before)


def _of_keypoints(recording: ArmRecording, camera: int, patch: PatchTrack) -> dict[str, JointPixels]:
    view, side = recording.views[camera], recording.arm.side
    assert view.keypoints is not None
    people = _people(view.keypoints, len(patch.pixel))
    _check_side(recording, camera, people, patch)
    chosen = _followed(people, side, patch.pixel)
    columns = {joint: chosen[:, KEYPOINTS.index(f"{side}_{joint}")] for joint in ("shoulder", "elbow")}
    return {joint: (points[:, :2], points[:, 2]) for joint, points in columns.items()}


def _people(keypoints: Keypoints, frames: int) -> Array:
    """Everybody in every frame of the video `(T, P, 9, 3)`: u, v and standard deviation, px; NaN where not seen."""
    people = np.full((frames, *keypoints.points.shape[1:]), np.nan)
    within = keypoints.frames < frames
    people[keypoints.frames[within]] = with_spreads(keypoints)[within]
    return people


def _followed(people: Array, side: str, patch: Array) -> Array:
    """The person who wears the patch, or is nearest to where that one was, or the tallest `(T, 9, 3)`."""
    wrist, shoulder = (KEYPOINTS.index(f"{side}_{joint}") for joint in ("wrist", "shoulder"))
    chosen = np.full((len(people), *people.shape[2:]), np.nan)
    last = np.full(2, np.nan)
    for k, (those, seen) in enumerate(zip(people, patch, strict=True)):
        off = np.linalg.norm(those[:, wrist, :2] - seen, axis=1)
        off = np.where(np.isfinite(off), off, np.linalg.norm(those[:, shoulder, :2] - last, axis=1))
        who = int(np.nanargmin(off)) if np.isfinite(off).any() else None if np.isfinite(last).all() else tallest(those)
        if who is not None:
            chosen[k] = those[who]
            last = np.where(np.isfinite(chosen[k, shoulder, :2]), chosen[k, shoulder, :2], last)
    return chosen


def _check_side(recording: ArmRecording, camera: int, people: Array, patch: PatchTrack) -> None:
    """The patch must lie at the wrist of the arm that wears it."""
    side, view = recording.arm.side, recording.views[camera].camera
    other = "left" if side == "right" else "right"
    here, there = (_median_distance(people, patch.pixel, f"{which}_wrist") for which in (side, other))
    if NEARER * there < here:
        raise InputError(
            f"camera[{camera}].keypoints have the {side} wrist {here:.0f} px from the patch and the {other} one "
            f"{there:.0f} px (medians), expected the {side} one there: check arm.side, or whether the video is mirrored"
        )
    most_px = MOST_APART * recording.arm.forearm_m * float(view.px_per_m(np.array([recording.arm.shoulder_m]))[0])
    if np.isfinite(here) and here > most_px:
        raise InputError(
            f"camera[{camera}].keypoints have the {side} wrist {here:.0f} px from the patch (median), expected at most "
            f"{most_px:.0f} px: are they of this video, and of the person who wears it?"
        )


def _median_distance(people: Array, pixels: Array, keypoint: str) -> float:
    """Of the nearest person, px; infinite where it is never seen."""
    off = np.linalg.norm(people[:, :, KEYPOINTS.index(keypoint), :2] - pixels[:, None], axis=2)
    off = off[np.isfinite(off).any(axis=1)]
    return float(np.median(np.nanmin(off, axis=1))) if len(off) else np.inf
