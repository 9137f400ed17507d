"""`metadata.json`: all that is needed to run it again, written and read."""

from __future__ import annotations

import json
import os
import platform
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError, __version__
from pytracker.digest import sha256_of
from pytracker.formats.text import read_lines
from pytracker.formats.video import probe
from pytracker.methods.method import Method
from pytracker.methods.registry import method_of_class
from pytracker.recording.recording import Recording
from pytracker.report.contents import Contents
from pytracker.report.files.json_file import write_json
from pytracker.tracking.found import found_by

__all__ = ["of_another_run", "read_run", "write_metadata"]

WORLDS = {"arm": "right-handed, z up", "body": "the skeleton's: right-handed, y up"}


def write_metadata(path: Path, contents: Contents) -> None:
    """Everything needed to run it again, and how long it took here."""
    recording = contents.tracks[0].recording
    write_json(
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
