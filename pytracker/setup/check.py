"""`check(folder)`: a recording looked at as a doctor would, line by line, with what to write where something is found.

Every line says what was looked at, the verdict, and why. What is not there yet stops only what needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pytracker._core import InputError, TrackingError
from pytracker.doubting.doubts import is_unusable, unbelieved
from pytracker.formats.toml_file import faults_of, read_toml
from pytracker.output import write_whole
from pytracker.recording.load import load
from pytracker.recording.schema import SCHEMA
from pytracker.rotation import Array
from pytracker.setup.checks.arm import check_arm
from pytracker.setup.checks.body import check_body
from pytracker.setup.checks.camera import check_up, check_video
from pytracker.setup.checks.findings import Examined, Finding, Verdict
from pytracker.setup.checks.imu import check_others
from pytracker.setup.draft import Draft
from pytracker.tracking.found import CLOCK, Found, found_by
from pytracker.tracking.track import default_method, track
from pytracker.tracking.tracks import Track

__all__ = ["Checkup", "check"]

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


def _body(draft: Draft) -> Examined:
    return [check_video(draft), *check_others(draft, 0), *check_up(draft), *check_body(draft)], None, None


EXAMINE: Mapping[str, Callable[[Draft], Examined]] = {"arm": check_arm, "body": _body}
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
