"""`check(folder)`: a recording looked at as a doctor would, line by line, with what to write where something is found.

Every line says what was looked at, the verdict, and why. What is not there yet stops only what needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pytracker._core import InputError, TrackingError
from pytracker.doubting.clocks import clocks_in_words
from pytracker.doubting.doubts import is_unusable, unbelieved
from pytracker.evidence.patch.camshift import PatchTrack
from pytracker.evidence.patch.hanging import LIES_STILL, rests_in_words, without_standing
from pytracker.evidence.patch.lag import GRID_S, Lag, banded, find_lags
from pytracker.evidence.sightings import Sightings
from pytracker.formats.toml_file import faults_of, read_toml
from pytracker.formats.video import probe
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.output import write_whole
from pytracker.recording.load import load
from pytracker.recording.recording import Arm, ArmRecording, Imu, View
from pytracker.recording.schema import SCHEMA
from pytracker.rotation import Array, rotate, triple
from pytracker.setup.checks.body import check_body
from pytracker.setup.checks.camera import camera_of, check_patch, check_pose, check_up, check_video, follow
from pytracker.setup.checks.down import seems_down, which_is_down
from pytracker.setup.checks.findings import Finding, Verdict
from pytracker.setup.checks.imu import check_imu, check_others
from pytracker.setup.checks.worn import check_clock, check_worn, given_axis
from pytracker.setup.draft import Draft
from pytracker.setup.worn import Worn
from pytracker.tracking.found import CLOCK, Found, found_by
from pytracker.tracking.track import default_method, track
from pytracker.tracking.tracks import Track

__all__ = ["Checkup", "check"]

ARM = ("arm.shoulder_m", "arm.upper_arm_m", "arm.forearm_m")
Examined = tuple[list[Finding], tuple[Array, Array, Array] | None, tuple[int, ...] | None]
"""Line by line, both signals laid over each other, and the patch's box: as a `Checkup` has them."""

ODD = 2.0
"""A constant that differs by more standard deviations is doubtful."""


@dataclass(frozen=True, eq=False)
class Checkup:
    """What was found.

    Attributes:
        folder: of the recording.
        findings: line by line.
        laid_over: picture's and IMU's way on one clock, to be looked at: time, s `(G,)`, and both `(G,)`; None where
            nothing could be compared.
        patch_box: the patch in the first frame, where there is one.
        track: of the whole recording, where it could be tracked.
    """

    folder: Path
    findings: tuple[Finding, ...]
    laid_over: tuple[Array, Array, Array] | None = None
    patch_box: tuple[int, ...] | None = None
    track: Track | None = None

    @property
    def is_ready(self) -> bool:
        """Whether nothing is missing or wrong."""
        return all(finding.verdict not in ("missing", "wrong") for finding in self.findings)


def check(folder: Path | str, *, write: bool = False) -> Checkup:
    """Look at the recording in `folder`, complete or not; with `write` put what was found into its recording.toml.

    Raises `InputError` only where there is no recording.toml that is TOML.
    """
    draft = Draft(Path(folder))
    data = read_toml(draft.path, SCHEMA)
    if faults := faults_of(data, draft.schema):
        return Checkup(draft.folder, tuple(Finding("recording.toml", "wrong", fault) for fault in faults))
    found, laid_over, box = EXAMINE[draft.kind](draft)
    changes = {place: value for finding in found for place, value in finding.writes.items()}
    tracked = None
    if write or not changes:
        before = draft.path.read_text("utf-8") if write and changes and not _why_not(draft.folder) else ""
        if write and changes:
            _write(draft, found, changes)
        if before and (refused := _why_not(draft.folder)):
            # What does not go together is not to spoil a recording that is there.
            write_whole(draft.path, before)
            found = [_taken_back(one, refused) for one in found]
        tracked, said = _whole(draft.folder)
        found += said if _is_clock_told(found) else [_as_open(one) for one in said]
    else:
        words = "is tracked and looked at once what is found above is written (--write)"
        found.append(Finding("the whole recording", "cannot be told", words))
    return Checkup(draft.folder, tuple(found), laid_over, box, tracked)


def _write(draft: Draft, found: Sequence[Finding], changes: Mapping[str, object]) -> None:
    for finding in found:
        for name, text in finding.files.items():
            write_whole(draft.folder / name, text)
    for place, value in changes.items():
        draft.set(place, value)
    draft.save()


def _why_not(folder: Path) -> str:
    """Why the recording is not loaded; empty where it is."""
    try:
        load(folder)
    except (InputError, OSError) as error:
        return str(error)
    return ""


def _taken_back(finding: Finding, refused: str) -> Finding:
    """The same, of what would have been written, and with which the recording is refused."""
    if not finding.writes:
        return finding
    words = f"{finding.evidence}; it is not written: with what was found the recording is refused ({refused})"
    return replace(finding, verdict="cannot be told", evidence=words, writes={})


def _is_clock_told(findings: Sequence[Finding]) -> bool:
    """Whether the clock was found or stands, of an arm; that of a body is not asked for."""
    return not any(one.what.startswith("clock") and one.verdict == "cannot be told" for one in findings)


def _as_open(finding: Finding) -> Finding:
    """The same, the clock not called right by who takes it as given but for milliseconds."""
    if finding.what != CLOCK or finding.verdict != "right":
        return finding
    return replace(finding, verdict="cannot be told", evidence=f"taken as it is given; {finding.evidence}")


def _arm(draft: Draft) -> Examined:
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


def _body(draft: Draft) -> Examined:
    return [check_video(draft), *check_others(draft, 0), *check_up(draft), *check_body(draft)], None, None


EXAMINE: Mapping[str, Callable[[Draft], Examined]] = {"arm": _arm, "body": _body}
"""By kind of recording."""


def _whole(folder: Path) -> tuple[Track | None, list[Finding]]:
    """The recording, loaded and tracked by the default method."""
    try:
        recording = load(folder)
    except (InputError, OSError) as error:
        lacks: Verdict = "missing" if " is missing" in str(error) else "wrong"
        return None, [Finding("the whole recording", lacks, str(error))]
    found = [Finding("as it is loaded", "doubtful", words) for words in recording.warnings]
    try:
        result = track(recording, default_method(recording))
    except (InputError, TrackingError) as error:
        return None, [*found, Finding("the whole recording", "wrong", str(error))]
    found += _constants(found_by(result))
    not_valid = unbelieved(result)
    verdict: Verdict = "wrong" if is_unusable(result) else "doubtful"
    found += [Finding("the track", verdict, words) for words in not_valid]
    found += [Finding("the track", "doubtful", words) for words in result.doubts]
    if not (not_valid or result.doubts):
        words = f"{float(result.valid.mean()):.0%} of {len(result.valid)} frames are valid"
        words += ", if what is doubtful above is as it is given" if recording.warnings else ""
        found.append(Finding("the track", "right", words))
    return result, found


def _constants(found: Sequence[Found]) -> list[Finding]:
    """What was measured once: a line for each that the data tell, one for all others."""
    told = [Finding(f.what, "doubtful" if f.surprise > ODD else "right", f.words) for f in found if f.is_told]
    others = ", ".join(f"{f.what} ± {f.given_sd:.2g} {f.unit}" for f in found if not f.is_told)
    if others:
        words = f"what is given stands, as well as it is known: {others}"
        told.append(Finding("lengths, shoulder, mount and camera", "cannot be told", words))
    return told
