"""A folder on disk to a recording: read, converted to world and recording time, and checked."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping
from pathlib import Path

from pytracker.recording.arm import load_arm
from pytracker.recording.body import load_body
from pytracker.recording.recording import ArmRecording, BodyRecording
from pytracker.recording.schema import read_recording_file

__all__ = ["load"]

LOADERS: Mapping[str, Callable[..., ArmRecording | BodyRecording]] = {"arm": load_arm, "body": load_body}
"""By kind: folder, path of recording.toml and what it says to a recording."""


def load(folder: Path | str) -> ArmRecording | BodyRecording:
    """Read the recording in `folder` (`docs/recording.md` says what one holds).

    Everything that would give a wrong answer raises `InputError` naming file, line or key, value and expectation;
    what is odd but usable is in `Recording.warnings`, with files named relative to the folder.
    """
    folder = Path(folder)
    path = folder / "recording.toml"
    entry = read_recording_file(path)
    recording = LOADERS[entry.kind](folder, path, entry)
    # Where a folder lies is nobody's business: warnings are kept with what is made of it.
    inside = tuple(warning.replace(f"{folder}{os.sep}", "") for warning in recording.warnings)
    return dataclasses.replace(recording, warnings=inside)
