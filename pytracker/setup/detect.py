"""`detect(folder)`: 2-D keypoints found in a recording's video, once, and named in its recording.toml."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.evidence.points.detector import Detector
from pytracker.evidence.sightings import Progress
from pytracker.formats.keypoints.models import COCO
from pytracker.formats.keypoints.write import keypoints_text
from pytracker.formats.toml_file import faults_of, read_toml
from pytracker.formats.video import frames
from pytracker.output import write_whole
from pytracker.recording.schema import SCHEMA
from pytracker.setup.draft import Draft

__all__ = ["Detected", "detect"]


@dataclass(frozen=True)
class Detected:
    """What was found.

    Attributes:
        path: the table that was written.
        detector: what found it.
        frames: of the video.
        seen: frames in which somebody was seen.
    """

    path: Path
    detector: str
    frames: int
    seen: int


def detect(folder: Path | str, camera: int = 0, *, force: bool = False, progress: Progress | None = None) -> Detected:
    """Write `keypoints.csv` beside recording.toml, of which nothing but the video needs to be there, and name it there.

    The joints are those of COCO, one person; of another camera than the first the file is called `keypoints_1.csv`.
    Raises `InputError` where MediaPipe is not installed, there is no such video, nobody is seen in it, or keypoints
    are there already, unless `force`.
    """
    draft = Draft(Path(folder))
    data = read_toml(draft.path, SCHEMA)
    if faults := faults_of(data, draft.schema):
        raise InputError(f"{draft.path}: {faults[0]}")
    if not draft.count("camera"):
        raise InputError(f"{draft.path}: there is no [[camera]], expected one with a video")
    if not 0 <= camera < draft.count("camera"):
        raise InputError(f"camera is {camera}, expected 0 to {draft.count('camera') - 1}: {draft.path}")
    entry = f"camera[{camera}]"
    video = draft.file(f"{entry}.video")
    if video is None:
        raise InputError(f"{draft.path}: {entry}.video is missing, expected a video to find keypoints in")
    path = draft.folder / ("keypoints.csv" if camera == 0 else f"keypoints_{camera}.csv")
    if not force and (path.exists() or draft.get(f"{entry}.keypoints") is not None):
        raise InputError(f"{path}: keypoints are there already, expected none (or --force to replace them)")
    found = []
    with Detector() as detector:
        for frame in frames(video):
            found.append(detector.found(frame))
            if progress is not None:
                progress("detect", len(found))
    seen = sum(bool(np.isfinite(points).any()) for points in found)
    if not seen:
        raise InputError(f"{video}: {detector.name} sees nobody in any of {len(found)} frames, expected a person")
    write_whole(path, keypoints_text(COCO, found), force=force)
    draft.set(f"{entry}.keypoints", path.name, note=f"by {detector.name}")
    draft.save()
    return Detected(path, detector.name, len(found), seen)
