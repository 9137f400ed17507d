"""An arm's recording before it is tracked: its sensor, its camera and its patch, and how they go together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytracker._core import InputError
from pytracker.doubting.clocks import clocks_in_words
from pytracker.evidence.patch.camshift import PatchTrack
from pytracker.evidence.patch.hanging import LIES_STILL, rests_in_words, without_standing
from pytracker.evidence.patch.lag import GRID_S, Lag, banded, find_lags
from pytracker.evidence.sightings import Sightings
from pytracker.formats.video import probe
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.recording.recording import Arm, ArmRecording, Imu, View
from pytracker.rotation import Array, rotate, triple
from pytracker.setup.checks.camera import camera_of, check_patch, check_pose, check_up, check_video, follow
from pytracker.setup.checks.down import seems_down, which_is_down
from pytracker.setup.checks.findings import Examined, Finding
from pytracker.setup.checks.imu import check_imu, check_others
from pytracker.setup.checks.worn import check_clock, check_worn, given_axis
from pytracker.setup.draft import Draft
from pytracker.setup.worn import Worn

__all__ = ["check_arm"]

ARM = ("arm.shoulder_m", "arm.upper_arm_m", "arm.forearm_m")


def check_arm(draft: Draft) -> Examined:
    """Sensor, camera and patch each by itself, then together: clock, and heading and mount where the rest is known."""
    video = check_video(draft)
    imu_findings, log = check_imu(draft)
    found = [video, *imu_findings, *check_others(draft, 1), check_pose(draft), *check_up(draft)]
    lacks = draft.lacks(*ARM)
    if lacks:
        found.append(Finding("arm", "missing", f"{', '.join(lacks)} not given: measure them with a tape"))
    if video.verdict in ("missing", "wrong"):
        return found, None, None
    imu_s, acceleration = (None, None) if log is None else (log.time_s, _acceleration(log))
    patch, box = check_patch(draft, imu_s, acceleration)
    found.append(patch)
    if box is None and patch.verdict != "right":
        return found, None, None
    followed, sightings = follow(draft, box)
    found.append(followed)
    if log is None or sightings is None or acceleration is None:
        return found, None, box
    offset_s = draft.get("imu.offset_s")
    px_per_m = _px_per_m(draft)
    wrong, lags = _together(log, acceleration, sightings, px_per_m)
    if lags:
        standing, moving = _without_standing(sightings, log, lags[0].offset_s)
        if standing and wrong:
            wrong, lags = _together(log, acceleration, moving, px_per_m)
        found += standing
        sightings = moving
    if wrong:
        return [*found, Finding("video and IMU", "wrong", wrong)], None, box
    found, told = _turned_up(draft, found, log, sightings)
    if told is None:
        found.append(check_clock(lags, offset_s))
        best_s = lags[0].offset_s if lags else None
    else:
        worn_findings, worn = _worn(draft, told, sightings)
        found += [*worn_findings, *_as_first(draft, worn_findings)]
        best_s = None if worn is None else worn.offset_s
    if best_s is None:
        return found, None, box
    return found, _laid_over(sightings, log.time_s + best_s, acceleration), box


def _together(log: ImuLog, acceleration: Array, sightings: Sightings, px_per_m: float) -> tuple[str, tuple[Lag, ...]]:
    """Why they do not go together, in words, at another rate or of another take; and by which offsets they do.

    By any offset: whether one is given, and right, is looked at next.
    """
    frame_s, pixels = sightings.time_s, sightings.pixels[:, 0]
    wrong = clocks_in_words(frame_s, pixels, log.time_s, acceleration, px_per_m, near_s=np.inf)
    return wrong, find_lags(frame_s, pixels, log.time_s, acceleration)


def _px_per_m(draft: Draft) -> float:
    """How large a metre is where the shoulder is; beyond any bounds where camera or shoulder are not known."""
    shoulder = draft.get("arm.shoulder_m")
    if shoulder is None or check_pose(draft).verdict != "right":
        return np.inf
    return float(camera_of(draft).px_per_m(np.array([shoulder], dtype=float))[0])


def _acceleration(log: ImuLog) -> Array:
    assert log.acc is not None
    assert log.q_world_sensor is not None
    return np.asarray(rotate(log.q_world_sensor, log.acc) - np.array([0.0, 0.0, GRAVITY]))


def _without_standing(sightings: Sightings, log: ImuLog, offset_s: float) -> tuple[list[Finding], Sightings]:
    """The same without what lies still while the sensor, by a clock so much later, moves; a line where it does."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    imu = Imu(time_s=log.time_s + offset_s, acc=log.acc, q_world_segment=log.q_world_sensor)
    pixels = sightings.pixels[:, 0]
    whole = PatchTrack(sightings.time_s, pixels, sightings.valid, sightings.reasons)
    rest = without_standing(whole, imu, 0.0)
    said = rests_in_words(rest, LIES_STILL)
    if not said:
        return [], sightings
    return [Finding("patch, where it rests", "doubtful", said)], Sightings.of(sightings.time_s, rest.pixel)


def _turned_up(
    draft: Draft, findings: list[Finding], log: ImuLog, sightings: Sightings
) -> tuple[list[Finding], ImuLog | None]:
    """The same findings, and the log if it is told which way is up, by the camera where z seems to be down.

    No log where camera or arm are not known yet.
    """
    if draft.lacks(*ARM) or check_pose(draft).verdict != "right":
        return findings, None
    if not seems_down(draft, findings):
        return findings, log
    earth, told = which_is_down(draft, log, lambda of: _recording(draft, of), sightings)
    return [earth if earth and finding.what == earth.what else finding for finding in findings], told


def _recording(draft: Draft, log: ImuLog) -> ArmRecording:
    """Of what is given, the sensor as its file has it."""
    assert log.acc is not None
    assert log.q_world_sensor is not None
    shoulder, upper_arm, forearm = (draft.get(place) for place in ARM)
    arm = Arm(
        shoulder_m=triple(np.array(shoulder, dtype=float)),
        upper_arm_m=float(upper_arm),
        forearm_m=float(forearm),
        wrist_start_m=(0.0, 0.0, 0.0),
    )
    imu = Imu(time_s=log.time_s, acc=log.acc, q_world_segment=log.q_world_sensor, gyr=log.gyr)
    return ArmRecording(views=(View(camera=camera_of(draft)),), imus=(imu,), arm=arm)


def _worn(draft: Draft, log: ImuLog, sightings: Sightings) -> tuple[list[Finding], Worn | None]:
    recording = _recording(draft, log)
    has = tuple(draft.get(place) is not None for place in ("imu.offset_s", "imu.heading_deg", "imu.mount"))
    try:
        axis = given_axis(draft.get("imu.mount"))
    except InputError as error:
        return [Finding("mount", "wrong", str(error))], None
    offset_s, heading_deg = (float(draft.get(place) or 0.0) for place in ("imu.offset_s", "imu.heading_deg"))
    given = Worn(offset_s, float(np.radians(heading_deg)), axis)
    video = draft.file("camera.video")
    assert video is not None
    return check_worn(recording, sightings, given, (has[0], has[1], has[2]), probe(video).width)


def _as_first(draft: Draft, findings: Sequence[Finding]) -> list[Finding]:
    """Clock and earth of a second sensor are those of the first, unless it is given its own.

    Its heading, where it is not given, is found from the arm at the first frame when the recording is loaded.
    """
    found = {place: value for finding in findings for place, value in finding.writes.items()}
    lines = []
    for what, key in (("clock", "offset_s"), ("heading", "heading_deg")):
        now, first = draft.get(f"imu[1].{key}"), draft.get(f"imu.{key}") or 0.0
        is_found = now is None and key == "heading_deg"
        if draft.count("imu") < 2 or f"imu.{key}" not in found or is_found or now not in (None, first):
            continue
        writes = {f"imu[1].{key}": found[f"imu.{key}"]}
        lines.append(Finding(f"imu[1]: {what}", "missing", "taken to be that of the first sensor", writes))
    return lines


def _laid_over(sightings: Sightings, imu_s: Array, acceleration: Array) -> tuple[Array, Array, Array] | None:
    """The way in the picture along which it goes farthest, and the IMU's movement that explains it best."""
    (a_s, seen), (b_s, moved) = (
        banded(sightings.time_s, sightings.pixels[:, 0]),
        banded(imu_s, acceleration, integrations=2),
    )
    skip = round((a_s - b_s) / GRID_S)
    a, b = max(0, -skip), max(0, skip)
    count = min(len(seen) - a, len(moved) - b)
    if count < 2:
        return None
    seen, moved = seen[a : a + count], moved[b : b + count]
    along = np.linalg.svd(seen, full_matrices=False)[2][0]
    way = seen @ along
    by_imu = moved @ np.linalg.lstsq(moved, way, rcond=None)[0]
    time_s: Array = np.asarray(a_s + GRID_S * (a + np.arange(count)), dtype=np.float64)
    return time_s, np.asarray(way), np.asarray(by_imu)
