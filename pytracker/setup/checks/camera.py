"""A check of a video, its camera, and the patch in it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pytracker._core import InputError, check_camera
from pytracker.evidence.ahead import ahead
from pytracker.evidence.patch.camshift import track_patch
from pytracker.evidence.patch.candidates import Candidate, find_candidates
from pytracker.evidence.patch.lag import find_lags
from pytracker.evidence.patch.landmarks import wrist_seen
from pytracker.evidence.sightings import Sightings
from pytracker.formats.keypoints.read import Keypoints
from pytracker.formats.video import frames, probe
from pytracker.formats.video_times import counted
from pytracker.recording.camera import Camera
from pytracker.recording.keypoints.load import load_keypoints
from pytracker.recording.truth.points import UP
from pytracker.rotation import Array
from pytracker.setup.checks.findings import Finding
from pytracker.setup.draft import Draft
from pytracker.setup.upright import axis_up

__all__ = ["camera_of", "check_patch", "check_pose", "check_up", "check_video", "follow"]

POSE = ("camera.matrix", "camera.rotation", "camera.translation_m")
FEW_SEEN = 0.8
MOST_PATCH_M = 0.2
"""What is larger, as near as the arm may bring it, is worn elsewhere than at a wrist: a shirt moves along too."""
REACH_M = 0.6
"""Of an arm whose lengths are not given."""


def check_video(draft: Draft) -> Finding:
    """Whether it can be read, and its times."""
    file = draft.file("camera.video")
    if file is None and draft.get("camera.keypoints") is not None:
        return Finding("video", "cannot be told", "there is none, but keypoints of one: no picture is used")
    if file is None:
        return Finding("video", "missing", "there is no [[camera]] with a video")
    try:
        info = probe(file)
        times = np.array([frame.time_s for frame in frames(file)])
    except (InputError, OSError) as error:
        return Finding("video", "wrong", str(error))
    if len(times) < 2:
        return Finding("video", "wrong", f"{file.name}: has {len(times)} frame, expected a movement")
    steps = np.diff(times)
    usual, longest = float(np.median(steps)), float(steps.max())
    words = (
        f"{file.name}: {len(times)} frames of {info.width} x {info.height} px over {times[-1]:.2f} s, usually "
        f"{1 / usual:.4g} a second, the longest wait {longest:.3f} s"
    )
    return Finding("video", "right" if longest < 2.5 * usual else "doubtful", words)


def check_pose(draft: Draft) -> Finding:
    """Whether the camera is known."""
    lacks = draft.lacks(*POSE)
    if lacks:
        words = f"{', '.join(lacks)} not given: pytracker calibrate says how to find them"
        return Finding("camera", "missing", words)
    try:
        check_camera(camera_of(draft))
    except (InputError, TypeError, ValueError) as error:
        return Finding("camera", "wrong", str(error))
    return Finding("camera", "right", "intrinsics and pose are those of a camera; whether of this one, the track tells")


def check_up(draft: Draft) -> list[Finding]:
    """Whether the world's vertical is up in the picture; nothing where the camera is not known."""
    if check_pose(draft).verdict != "right":
        return []
    wanted, found = UP[draft.kind], axis_up(np.array(draft.get("camera.rotation"), dtype=float))
    if found == wanted:
        return []
    whose = {"arm": "an arm", "body": "a body"}[draft.kind]
    if not found:
        words = (
            f"looks up, down or askew: whether the {wanted} axis of its world is up, as {whose} needs, it does not say"
        )
        return [Finding("camera's world", "cannot be told", words)]
    words = (
        f"its world's {found} axis is up in the picture, and {whose} is in a world whose {wanted} axis is: is the "
        "calibration's another (then turn rotation, and all places given in it), or is the camera held on its side?"
    )
    return [Finding("camera's world", "doubtful", words)]


def camera_of(draft: Draft) -> Camera:
    """As the draft has it; everything that it needs must be there."""
    matrix, rotation, translation = (draft.get(place) for place in POSE)
    return Camera(
        matrix=matrix,
        rotation=rotation,
        translation_m=translation,
        distortion=tuple(draft.get("camera.distortion") or (0.0,) * 5),
        patch_offset_m=(0.0, 0.0, 0.0),
    )


def check_patch(
    draft: Draft, imu_s: Array | None, acceleration: Array | None
) -> tuple[Finding, tuple[int, ...] | None]:
    """The box that is given, or the coloured thing that moves most as the IMU does."""
    file = draft.file("camera.video")
    assert file is not None
    box = draft.get("camera.patch_box")
    if box is None and draft.get("camera.keypoints") is not None:
        return Finding("patch", "right", "none is needed: the wrist is among the keypoints"), None
    if box is not None:
        size_m = _size_m(draft, box)
        large = f"is {size_m:.2f} m in size at least, expected at most {MOST_PATCH_M:g}: is it the patch?"
        words = f"patch_box is {box}; " + (large if size_m > MOST_PATCH_M else "how well it is followed is said below")
        return Finding("patch", "doubtful" if size_m > MOST_PATCH_M else "right", words), tuple(box)
    found = find_candidates(file)
    candidates = [one for one in found if _size_m(draft, one.box) <= MOST_PATCH_M]
    if not candidates:
        left_out = f" but what is larger than {MOST_PATCH_M:g} m ({len(found)} such)" if found else ""
        words = (
            f"nothing coloured is there in the first frame, keeps its size and moves{left_out}: pytracker frame, and "
            "patch_box"
        )
        return Finding("patch", "missing", words), None

    def worth(one: Candidate) -> float:
        if imu_s is None or acceleration is None:
            return 0.0
        lags = find_lags(one.time_s, one.pixels, imu_s, acceleration)
        return lags[0].worth if lags else 0.0

    ranked = sorted(candidates, key=lambda one: -worth(one))
    best = ranked[0]
    x, y, w, h = best.box
    words = (
        f"of {len(candidates)} coloured things that move, the one of hue {best.hue_deg:.0f}°, {best.area_px:.0f} px, "
        f"at ({x + w / 2:.0f}, {y + h / 2:.0f}) moves most as the IMU does"
    )
    close = len(ranked) > 1 and worth(ranked[1]) > 0.9 * worth(best)
    if close:
        bx, by, bw, bh = ranked[1].box
        words += f"; one at ({bx + bw / 2:.0f}, {by + bh / 2:.0f}) nearly as much: look at it with pytracker frame"
    return Finding("patch", "doubtful" if close else "missing", words, {"camera.patch_box": list(best.box)}), best.box


def _size_m(draft: Draft, box: Sequence[int]) -> float:
    """How large what is in a box is at least, as near as the arm may bring it, m; 0 where that is not known."""
    shoulder = draft.get("arm.shoulder_m")
    if shoulder is None or len(shoulder) != 3 or len(box) != 4 or check_pose(draft).verdict != "right":
        return 0.0
    camera = camera_of(draft)
    lengths = [draft.get(f"arm.{bone}") for bone in ("upper_arm_m", "forearm_m")]
    reach_m = sum(lengths) if all(isinstance(length, float) for length in lengths) else REACH_M
    distance_m = float(np.linalg.norm(np.asarray(camera.position_m) - np.array(shoulder, dtype=float)))
    return float(np.sqrt(max(0, box[2] * box[3]))) * max(0.0, distance_m - reach_m) / camera.matrix[0][0]


def _keypoints(draft: Draft, video: Path) -> Keypoints:
    file = draft.file("camera.keypoints")
    assert file is not None
    return load_keypoints(file, str(draft.get("camera.keypoint_model") or "auto"), video, counted(video))


def follow(draft: Draft, box: tuple[int, ...] | None) -> tuple[Finding, Sightings | None]:
    """The patch, followed through the whole video; or the wrist by its keypoints, where there is no box."""
    file = draft.file("camera.video")
    assert file is not None
    try:
        film = ahead(frames(file))
        if box is None:
            track = wrist_seen(_keypoints(draft, file), str(draft.get("arm.side") or "right"), film)
        else:
            x, y, w, h = box
            track = track_patch(film, (x, y, w, h))
    except (InputError, OSError, ValueError) as error:
        return Finding("patch, followed", "wrong", str(error)), None
    sightings = Sightings.of(track.time_s + float(draft.get("camera.start_s") or 0.0), track.pixel)
    seen = float(sightings.valid.mean())
    why = sorted({reason for reason in track.reason if reason})
    words = f"seen in {seen:.0%} of {len(track.time_s)} frames" + (
        f"; otherwise: {', '.join(why)[:200]}" if why else ""
    )
    return Finding("patch, followed", "right" if seen > FEW_SEEN else "doubtful", words), sightings
