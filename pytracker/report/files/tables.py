"""`track.csv` and `scores.json`, and a body's motion as AMC."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from functools import singledispatch
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.amc import write_amc
from pytracker.formats.asf_write import write_asf
from pytracker.formats.text import parse_table, read_lines
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.report.files.json_file import write_json
from pytracker.rotation import Array
from pytracker.scores.evaluate import Scores
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.tracks import QUANTITIES, JointTrack, Track

__all__ = [
    "TrackFile",
    "TrackRows",
    "read_rows",
    "read_track",
    "write_motion",
    "write_scores",
    "write_track",
]


def write_track(path: Path, track: Track) -> None:
    """One row a camera frame.

    `time_s, frame`, then for every joint and axis `<joint>_<axis>_m`, `_sd_m`, `_lo_m`, `_hi_m` (95 % band), for a body
    `<joint>_valid` and every tracked channel as `<bone>_<dof>_rad` (or `_m`) in the same way, then
    `ess, log_evidence, valid, reason`. A cell is empty where there is no value.
    """
    names, columns = [], []
    for joint, rows in track.joints.items():
        for suffix, quantity in QUANTITIES:
            values = getattr(rows, quantity)
            for d, axis in enumerate("xyz"):
                names.append(f"{joint}_{axis}{suffix}_m")
                columns.append(values[:, d])
        if rows.reason:
            names.append(f"{joint}_valid")
            columns.append(rows.valid)
    for channel, values in track.channels.items():
        name, unit = channel.rsplit("_", 1)
        for suffix, row in (("", 0), ("_sd", 2), ("_lo", 3), ("_hi", 4)):
            names.append(f"{name}{suffix}_{unit}")
            columns.append(values[row])
    columns += [track.ess, track.log_evidence]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time_s", "frame", *names, "ess", "log_evidence", "valid", "reason"])
        for k, time_s in enumerate(track.time_s):
            numbers = [_cell(column[k]) for column in columns]
            writer.writerow([f"{time_s:.6f}", k, *numbers, int(track.valid[k]), track.reason[k]])


@singledispatch
def write_motion(track: Track, path: Path) -> None:
    """Poses of a skeleton as AMC, and the skeleton as ASF beside it, of a track that has one.

    Frames are numbered as in the video, from 1; those that were not tracked are left out.
    """


@write_motion.register
def _(track: BodyTrack, path: Path) -> None:
    tracked, skeleton = np.isfinite(track.poses).all(axis=1), track.recording.skeleton
    rate_hz = (len(track.time_s) - 1) / np.ptp(track.time_s) if len(track.time_s) > 1 else 0.0
    note = f"{rate_hz:.6g} frames/s; the likeliest pose of each frame, {path.with_suffix('.csv').name} has the means"
    write_amc(path, skeleton, track.poses[tracked], (np.flatnonzero(tracked) + 1).tolist(), note)
    write_asf(path.with_suffix(".asf"), skeleton)


def _cell(value: np.bool_ | np.float64) -> str:
    if isinstance(value, np.bool_):
        return str(int(value))
    return "" if math.isnan(value) else f"{value:.6f}"


class TrackRows:
    """A track read back from `track.csv`.

    Attributes:
        time_s: recording time `(T,)`, s.
        joints: by name.
        valid: whether the frame was tracked and the patch seen, `(T,)`.
    """

    def __init__(self, time_s: Array, joints: dict[str, JointTrack], valid: np.ndarray) -> None:
        self.time_s, self.joints, self.valid = time_s, joints, valid


class TrackFile(TrackRows):
    """The same with what `evaluate` needs besides.

    Attributes:
        camera: the first of its recording.
    """

    def __init__(
        self, time_s: Array, joints: dict[str, JointTrack], valid: np.ndarray, camera: Camera | WeakPerspective
    ) -> None:
        super().__init__(time_s, joints, valid)
        self.camera = camera


def read_rows(path: Path) -> TrackRows:
    """Read `track.csv`. Raises `InputError`."""
    lines = read_lines(path)
    names = lines[0].split(",")
    joints = [name.removesuffix("_x_m") for name in names if name.endswith("_x_m")]
    judged = [f"{joint}_valid" for joint in joints if f"{joint}_valid" in names]
    quantity_names = [f"{j}_{a}{s}_m" for j in joints for s, _ in QUANTITIES for a in "xyz"]
    missing = sorted({"time_s", "valid", *quantity_names} - set(names))
    if missing or not joints:
        raise InputError(
            f"{path}:1: has no column {', '.join(missing) or 'wrist_x_m'}, expected a track.csv of pytracker"
        )
    # The reason is free text in the last column; no other column holds a comma.
    last = len(names) - 1
    plain = [lines[0], *(",".join([*line.split(",", last)[:last], ""]) for line in lines[1:])]
    table = parse_table(path, plain, 1, names, ",", {"time_s", "valid", *quantity_names, *judged})

    def columns(*wanted: str) -> Array:
        values = table.columns(*wanted)
        assert values is not None
        return values

    tracks = {}
    for joint in joints:
        mean, sd, lo, hi = (columns(*(f"{joint}_{a}{s}_m" for a in "xyz")) for s, _ in QUANTITIES)
        is_judged = f"{joint}_valid" in judged
        reason = tuple("" if right else "not valid" for right in columns(f"{joint}_valid")[:, 0]) if is_judged else ()
        tracks[joint] = JointTrack(mean=mean, mode=mean, sd=sd, lo=lo, hi=hi, reason=reason)
    return TrackRows(columns("time_s")[:, 0], tracks, columns("valid")[:, 0] > 0)


def read_track(path: Path, camera: Camera | WeakPerspective) -> TrackFile:
    """Read `track.csv` of a recording with that camera. Raises `InputError`."""
    rows = read_rows(path)
    return TrackFile(rows.time_s, rows.joints, rows.valid, camera)


def write_scores(path: Path, scores: Sequence[Scores | None], labels: Sequence[str]) -> None:
    """Scores by method label."""
    write_json(path, {label: s.as_dict() for label, s in zip(labels, scores, strict=True) if s is not None})
