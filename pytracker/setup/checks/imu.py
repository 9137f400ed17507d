"""A check of an IMU's file: what its numbers stand for, its rate, whether it agrees with itself."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.bursts import evened
from pytracker.inertial.check import check
from pytracker.inertial.conventions import Conventions, in_our_terms
from pytracker.inertial.log import ImuLog
from pytracker.inertial.orientation import AS_GIVEN, orient
from pytracker.recording.schema import ImuEntry
from pytracker.setup.checks.findings import Finding
from pytracker.setup.conventions import find_conventions
from pytracker.setup.draft import Draft

__all__ = ["check_imu", "check_others", "read_log"]

WORDS = {
    "acc_unit": "unit of the acceleration",
    "gyr_unit": "unit of the turn rate",
    "quaternion": "order of the quaternion",
    "quaternion_takes": "direction of the quaternion",
    "earth": "earth frame",
}


def check_imu(draft: Draft, imu: str = "imu") -> tuple[list[Finding], ImuLog | None]:
    """What was found, and the log in our terms with an orientation; None where it cannot be used.

    `imu` is the table: the first, or `imu[1]`.
    """
    file = draft.file(f"{imu}.file")
    if file is None:
        return [Finding("IMU", "missing", "there is no [[imu]] with a file: an arm is tracked by one")], None
    log = read_log(draft, imu, file)
    if isinstance(log, Finding):
        return [log], None
    given = _given(draft, imu)
    if log.acc is not None and given.acc_reads == "gravity":
        log = dataclasses.replace(log, acc=-log.acc)
    found = find_conventions(log)
    findings = [_times(log)]
    findings += [
        _convention(log, f"{imu}.{name}", given, found.conventions, name in found.unknown, found.evidence.get(name, ""))
        for name in WORDS
    ]
    best = dataclasses.replace(found.conventions, **{name: getattr(given, name) for name in found.unknown})
    try:
        has_heading = draft.get(f"{imu}.heading_deg") is not None
        checked = orient(check(in_our_terms(log, best)), has_heading=has_heading)
    except InputError as error:
        return [*findings, Finding("IMU and itself", "wrong", str(error))], None
    said = "; ".join(checked.warnings)
    if any(not words.endswith(AS_GIVEN) for words in checked.warnings):
        return [*findings, Finding("IMU and itself", "doubtful", said)], checked
    agree = "gravity, turns and times agree with each other, and nothing hangs"
    return [*findings, Finding("IMU and itself", "right", "; ".join(filter(None, (agree, said))))], checked


def check_others(draft: Draft, first: int) -> list[Finding]:
    """The same of every sensor from number `first` on, each line by its table."""
    tables = [f"imu[{number}]" for number in range(first, draft.count("imu"))]
    return [
        dataclasses.replace(finding, what=f"{table}: {finding.what}")
        for table in tables
        for finding in check_imu(draft, table)[0]
    ]


def read_log(draft: Draft, imu: str, file: Path) -> ImuLog | Finding:
    """A sensor's file as it is, with even times; a line that says why not."""
    form = draft.get(f"{imu}.format") or "auto"
    try:
        log = read_imu(
            file,
            orientation_file=draft.file(f"{imu}.orientation_file"),
            form=form,
            rate_hz=draft.get(f"{imu}.rate_hz"),
            columns=draft.get(f"{imu}.columns"),
            segment=draft.get(f"{imu}.segment") or f"{draft.get('arm.side') or 'right'}_forearm",
        )
        return evened(log)
    except (InputError, OSError) as error:
        return Finding("IMU", "wrong", str(error))


def _given(draft: Draft, imu: str) -> Conventions:
    """As the file says; the usual where it says nothing."""
    said = {name: value for name in (*WORDS, "acc_reads") if (value := draft.get(f"{imu}.{name}")) is not None}
    return ImuEntry.model_validate({"file": "-", **said}).conventions


def _times(log: ImuLog) -> Finding:
    interval = np.diff(log.time_s)
    # Where most rows repeat a time and could not be put even, there is only their mean.
    rate, longest = 1.0 / (float(np.median(interval)) or float(interval.mean())), float(interval.max())
    lost = int(np.rint(interval * rate - 1.0).clip(0).sum())
    words = (
        f"{log.path.name}: {len(log.time_s)} samples from {log.time_s[0]:.2f} to {log.time_s[-1]:.2f} s at "
        f"{rate:.4g} Hz, {lost} missing, the longest gap {longest:.3f} s"
    )
    return Finding("rate and gaps", "right" if lost <= 0.01 * len(log.time_s) and longest < 0.2 else "doubtful", words)


def _convention(
    log: ImuLog, place: str, given: Conventions, found: Conventions, is_unknown: bool, evidence: str
) -> Finding:
    name = place.split(".")[1]
    what, now, best = WORDS[name], getattr(given, name), getattr(found, name)
    there = {"acc_unit": log.acc, "gyr_unit": log.gyr}.get(name, log.q_world_sensor) is not None
    if not there:
        return Finding(what, "cannot be told", "the file has none")
    if is_unknown:
        return Finding(what, "cannot be told", f"taken as {now!r}: {evidence}")
    if now == best:
        return Finding(what, "right", f"{best!r}: {evidence}")
    return Finding(what, "wrong", f"{best!r}, not {now!r}: {evidence}", {place: best})
