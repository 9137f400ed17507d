"""`track.csv`, `metadata.json` and `scores.json`."""

from __future__ import annotations

import csv
import json
import math
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict
from functools import singledispatch
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError, __version__
from pytracker.digest import sha256_of
from pytracker.formats.amc import write_amc
from pytracker.formats.asf_write import write_asf
from pytracker.formats.text import parse_table, read_lines
from pytracker.formats.video import probe
from pytracker.methods.method import Method
from pytracker.methods.registry import method_of_class
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.recording.recording import Recording
from pytracker.report.contents import Contents
from pytracker.rotation import Array
from pytracker.scores.evaluate import Scores
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.found import found_by
from pytracker.tracking.tracks import JointTrack, Track

__all__ = [
    "TrackFile",
    "of_another_run",
    "plain",
    "read_run",
    "read_track",
    "write_metadata",
    "write_motion",
    "write_scores",
    "write_track",
]

WORLDS = {"arm": "right-handed, z up", "body": "the skeleton's: right-handed, y up"}

QUANTITIES = (("", "mean"), ("_sd", "sd"), ("_lo", "lo"), ("_hi", "hi"))


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


class TrackFile:
    """A track read back from `track.csv`: what `evaluate` needs of it.

    Attributes:
        time_s: recording time `(T,)`, s.
        joints: by name.
        valid: whether the frame was tracked and the patch seen, `(T,)`.
        camera: the first of its recording.
    """

    def __init__(
        self, time_s: Array, joints: dict[str, JointTrack], valid: np.ndarray, camera: Camera | WeakPerspective
    ) -> None:
        self.time_s, self.joints, self.valid, self.camera = time_s, joints, valid, camera


def read_track(path: Path, camera: Camera | WeakPerspective) -> TrackFile:
    """Read `track.csv` of a recording with that camera. Raises `InputError`."""
    lines = read_lines(path)
    names = lines[0].split(",")
    joints = [name.removesuffix("_x_m") for name in names if name.endswith("_x_m")]
    quantity_names = [f"{j}_{a}{s}_m" for j in joints for s, _ in QUANTITIES for a in "xyz"]
    missing = sorted({"time_s", "valid", *quantity_names} - set(names))
    if missing or not joints:
        raise InputError(
            f"{path}:1: has no column {', '.join(missing) or 'wrist_x_m'}, expected a track.csv of pytracker"
        )
    # The reason is free text in the last column; no other column holds a comma.
    last = len(names) - 1
    plain = [lines[0], *(",".join([*line.split(",", last)[:last], ""]) for line in lines[1:])]
    table = parse_table(path, plain, 1, names, ",", {"time_s", "valid", *quantity_names})

    def columns(*wanted: str) -> Array:
        values = table.columns(*wanted)
        assert values is not None
        return values

    tracks = {}
    for joint in joints:
        mean, sd, lo, hi = (columns(*(f"{joint}_{a}{s}_m" for a in "xyz")) for s, _ in QUANTITIES)
        tracks[joint] = JointTrack(mean=mean, mode=mean, sd=sd, lo=lo, hi=hi)
    return TrackFile(columns("time_s")[:, 0], tracks, columns("valid")[:, 0] > 0, camera)


def write_scores(path: Path, scores: Sequence[Scores | None], labels: Sequence[str]) -> None:
    """Scores by method label."""
    _json(path, {label: s.as_dict() for label, s in zip(labels, scores, strict=True) if s is not None})


def write_metadata(path: Path, contents: Contents) -> None:
    """Everything needed to run it again, and how long it took here."""
    recording = contents.tracks[0].recording
    _json(
        path,
        {
            "pytracker": __version__,
            "units": {"length": "m", "time": "s", "angle": "rad", "image": "px"},
            "frames": {"world": WORLDS[recording.kind], "bands": "2.5 % and 97.5 % quantiles per axis"},
            "recording": _recording(recording),
            "tracks": [
                {
                    "label": label,
                    "method": type(track.method).__name__,
                    "parameters": track.method.parameters(),
                    "seed": track.seed,
                    "lost": track.lost,
                    "doubts": list(said),
                    "found": [asdict(found) | {"is_told": found.is_told} for found in found_by(track)],
                    "run_time_s": {stage: round(seconds, 4) for stage, seconds in track.stage_s.items()},
                }
                for track, label, said in zip(contents.tracks, contents.labels, contents.doubts, strict=True)
            ],
            "machine": {
                "system": platform.platform(),
                "processor": platform.machine(),
                "cores": os.cpu_count(),
                "python": platform.python_version(),
                "numpy": np.__version__,
            },
        },
    )


def read_run(folder: Path, recording: Recording, number: int = 1) -> tuple[Method, int]:
    """Method and seed of a run from its `metadata.json`; `number` tells which where there are several, from 1.

    Raises `InputError` where it is none, or of a recording whose files differ from those of `recording`.
    """
    path = folder / "metadata.json"
    try:
        metadata = json.loads(path.read_text("utf-8"))
        files: dict[str, str] = dict(metadata["recording"]["files"])
        runs = [(str(of["method"]), dict(of["parameters"]), int(of["seed"])) for of in metadata["tracks"]]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{folder}: holds no metadata.json of pytracker, expected a folder that track wrote") from None
    for name, digest in _recording(recording)["files"].items():
        if files.get(name) != digest:
            raise InputError(f"{path}: {name} was another file in that run, expected the recording that was tracked")
    if not 1 <= number <= len(runs):
        raise InputError(f"{path}: has {len(runs)} tracks, expected a number from 1 to {len(runs)}, not {number}")
    method, parameters, seed = runs[number - 1]
    return method_of_class(method, parameters), seed


def of_another_run(file: Path, recording: Recording) -> tuple[str, ...]:
    """What is odd about scoring a track by this recording; other files than its video may have been added since.

    Raises `InputError` where `metadata.json` beside it is of a run on another video, of another length: one that was
    coded anew is as long.
    """
    path, video = file.with_name("metadata.json"), recording.video
    if video is None or not path.is_file() or not file.name.startswith("track"):
        return ()
    try:
        digests = set(dict(json.loads(path.read_text("utf-8"))["recording"]["files"]).values())
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return ()  # another program's
    if not digests or sha256_of(video) in digests:
        return ()
    rows, frames = len(read_lines(file)) - 1, probe(video).frame_count
    if rows != frames:
        raise InputError(
            f"{path}: is of a run on another video than {video}, {rows} frames and not {frames}, expected a track of "
            "this recording"
        )
    return (f"{path}: is of a run on another file than {video}, as long: of the same video, coded anew?",)


def _recording(recording: Recording) -> dict[str, Any]:
    return {
        "folder": None if recording.folder is None else recording.folder.name,
        "kind": recording.kind,
        "files": {_name(path, recording): sha256_of(path) for path in recording.files},
        "warnings": list(recording.warnings),
    }


def _name(path: Path, recording: Recording) -> str:
    """Relative to the recording's folder, where it lies in it."""
    folder = recording.folder
    return path.relative_to(folder).as_posix() if folder is not None and path.is_relative_to(folder) else path.name


def _json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")


def plain(value: Any) -> Any:
    """As JSON can hold it, which has no NaN: what is no number is null."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
