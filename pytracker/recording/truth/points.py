"""`[truth]` of points to joints: whichever file of markers, each joint one of them or the middle of several."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats import video as videos
from pytracker.formats.bvh import read_bvh
from pytracker.formats.c3d import read_c3d
from pytracker.formats.capture_csv import read_csv_markers
from pytracker.formats.markers import Markers, check_times
from pytracker.formats.mat import read_mat_points
from pytracker.formats.qualisys import read_qualisys
from pytracker.formats.storage import read_storage
from pytracker.formats.trc import read_trc
from pytracker.recording.recording import PAUSES, Truth
from pytracker.recording.schema import TruthEntry
from pytracker.recording.truth.filled import without_filled
from pytracker.recording.truth.names import markers_of
from pytracker.recording.upright import to_up
from pytracker.rotation import Array

__all__ = ["POINT_FORMATS", "UP", "load_points", "uncovered", "uncovered_between"]

SLACK_S = 0.1
"""Truth and video may begin and end this far apart without a word."""

SAME_RATE = 0.03
"""Frames whose steps are so near those of a rate come at it."""
ROUNDED = 0.25
"""The mean of steps that are rounded is so near the usual one, where no frames are missing."""

LEAST_GONE_S = 0.1
"""Less is not worth a word."""

UP = {"arm": "z", "body": "y"}
"""Which axis is up, by kind of recording."""

POINT_FORMATS: dict[str, Callable[[Path], Markers]] = {
    ".tsv": read_qualisys,
    ".csv": read_csv_markers,
    ".trc": read_trc,
    ".c3d": read_c3d,
    ".mat": read_mat_points,
    ".bvh": read_bvh,
    ".sto": read_storage,
    ".mot": read_storage,
}
"""Readers of markers by the file's suffix."""


def load_points(
    path: Path, file: Path, entry: TruthEntry, joints: tuple[str, ...], *, kind: str
) -> tuple[Truth, list[str]]:
    """Joints of a file of markers, in the world of a `kind` of recording; what is odd, and its gaps, in words.

    Raises `InputError`. Where `entry` names no markers those are taken that are called like joints.
    """
    markers: Mapping[str, str | tuple[str, ...]] = entry.markers
    if file.suffix.lower() not in POINT_FORMATS:
        raise InputError(f"{path}: truth.file is {file.name!r}, expected one of: {', '.join(POINT_FORMATS)}")
    found = POINT_FORMATS[file.suffix.lower()](file)
    if entry.rate_hz is not None:
        found = replace(found, time_s=at_rate(found.time_s, entry.rate_hz), rate_hz=entry.rate_hz)
    odd = (*found.warnings, *check_times(file, found))
    unknown = sorted(set(markers) - set(joints))
    if unknown:
        raise InputError(f"{path}: truth.markers.{unknown[0]} is no joint of the {kind}, expected: {', '.join(joints)}")
    wanted = dict(markers) or {name: name for name in found.positions_m if name in joints}
    if not wanted:
        raise InputError(
            f"{path}: truth.markers is missing, and {file} has {', '.join(found.positions_m)[:300]}, expected which of "
            f"them are {', '.join(joints)}{_perhaps(found, kind)}"
        )
    points: dict[str, Array] = {}
    filled: dict[str, tuple[str, ...]] = {}
    for joint, of_joint in wanted.items():
        names = _names_in(path, file, joint, (of_joint,) if isinstance(of_joint, str) else of_joint, found)
        measured = [without_filled(file, found, name) for name in names]
        filled |= {name: words for name, (_, words) in zip(names, measured, strict=True)}
        middle = np.mean([_seen_at_all(places) if len(names) > 1 else places for places, _ in measured], axis=0)
        points[joint] = middle @ to_up(entry.up or UP[kind], UP[kind]).T
    rows, unseen = len(found.time_s), {joint: int(np.isnan(places[:, 0]).sum()) for joint, places in points.items()}
    if min(unseen.values()) == rows:
        raise InputError(
            f"{file}: {', '.join(points)} {'is' if len(points) == 1 else 'are'} never seen, expected truth"
        )
    gaps = [
        f"{file}: {joint} was not seen in {count} of {rows} frames; they are left out of the scores"
        for joint, count in unseen.items()
        if count
    ]
    time_s = found.time_s + entry.offset_s
    others = [] if markers else _called_otherwise(file, found, wanted, kind)
    said = [*odd, *others, *(said for of in filled.values() for said in of), *gaps, *_missing_rows(file, time_s)]
    seen = {joint: places for joint, places in points.items() if unseen[joint] < rows}
    return Truth(time_s=time_s, joints_m=seen), said


def _perhaps(found: Markers, kind: str) -> str:
    """What to write where points are called nearly as joints are."""
    others = markers_of(found.positions_m, kind)
    if not others:
        return ""
    return f": perhaps markers = {{ {', '.join(f'{joint} = {json.dumps(name)}' for joint, name in others.items())} }}"


def _names_in(path: Path, file: Path, joint: str, names: tuple[str, ...], found: Markers) -> tuple[str, ...]:
    """Markers of the file whose middle is the joint. Raises `InputError` for none, and one that is not there."""
    if not names:
        raise InputError(f"{path}: truth.markers.{joint} is empty, expected a marker, or those it is the middle of")
    # As some files have them, below the name of a subject.
    plain = tuple(name if name in found.positions_m else name.rpartition(":")[2] for name in names)
    for name, marker in zip(names, plain, strict=True):
        if marker not in found.positions_m:
            raise InputError(
                f"{path}: truth.markers.{joint} is {name!r}, expected a marker of {file}: "
                f"{', '.join(found.positions_m)[:300]}"
            )
    return plain


def _called_otherwise(file: Path, found: Markers, wanted: Mapping[str, object], kind: str) -> list[str]:
    """A word where some points are called as joints are, and others nearly so, which are not taken."""
    others = markers_of((name for name in found.positions_m if name not in wanted), kind)
    left = {joint: names for joint, names in others.items() if joint not in wanted}
    if not left:
        return []
    points = [name for names in left.values() for name in ([names] if isinstance(names, str) else names)]
    return [
        f"{file}: {', '.join(wanted)} {'is' if len(wanted) == 1 else 'are'} taken for truth, as joints are called; "
        f"{', '.join(points)} {'is' if len(points) == 1 else 'are'} not: truth.markers says which joints they are"
    ]


def _seen_at_all(places: Array) -> Array:
    """One of several markers: what is at (0, 0, 0) in all rows was in none; a joint may be the world's origin."""
    return places if places.any() else np.full_like(places, np.nan)


def _missing_rows(file: Path, time_s: Array) -> list[str]:
    """A word where rows are missing: between those about them nothing is scored (`Truth.at`)."""
    steps = np.diff(time_s)
    if len(steps) < 2:
        return []
    k = int(np.argmax(steps))
    gone_s = float(steps[steps > PAUSES * np.median(steps)].sum())
    if gone_s < LEAST_GONE_S:
        return []
    return [
        f"{file}: has no rows for {gone_s:.2f} s in all, longest from {time_s[k]:.3f} to {time_s[k + 1]:.3f} s; frames "
        "between are left out of the scores"
    ]


def at_rate(time_s: Array, rate_hz: float) -> Array:
    """Times `(T,)`, s, of frames that are said to come at a rate; as they are where they come at it.

    Written times are rounded and frames may be missing: an even mean, or the usual step, is that of the rate.
    """
    steps = np.diff(time_s)
    if not len(steps):
        return time_s
    usual_s, mean_s = float(np.median(steps)), float(steps.mean())
    if any(abs(step_s * rate_hz - 1.0) < SAME_RATE for step_s in (usual_s, mean_s, float(np.quantile(steps, 0.1)))):
        return time_s
    # Where few frames are missing the mean tells the step, whatever the times are rounded to.
    step_s = mean_s if abs(mean_s / usual_s - 1.0) < ROUNDED else usual_s
    return np.asarray(time_s / (step_s * rate_hz))


def uncovered(file: Path, truth: Truth, video: Path, start_s: float) -> tuple[str, ...]:
    """A word where the truth of `file` covers only a part of a video that starts at `start_s`.

    Raises `InputError` where it covers nothing of it.
    """
    info = videos.probe(video)
    if not info.rate_hz:
        return ()
    return uncovered_between(file, truth, f"the video {video}", start_s, start_s + info.frame_count / info.rate_hz)


def uncovered_between(file: Path, truth: Truth, of: str, start_s: float, end_s: float) -> tuple[str, ...]:
    """The same of what covers `start_s` to `end_s` of recording time."""
    first_s, last_s = float(truth.time_s[0]), float(truth.time_s[-1])
    covers = f"{file}: the truth covers {first_s:.3f} to {last_s:.3f} s and {of} {start_s:.3f} to {end_s:.3f} s"
    if last_s < start_s or first_s > end_s:
        raise InputError(f"{covers} of recording time, expected them to overlap: check its rate and truth.offset_s")
    if first_s <= start_s + SLACK_S and last_s >= end_s - SLACK_S:
        return ()
    return (f"{covers}; frames without truth are not scored: check its rate and truth.offset_s",)
