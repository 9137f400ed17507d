"""Ultralytics' YOLO (`save_txt`): a folder with a text a frame, of a person a line, in shares of the picture.

`class cx cy w h`, then `x y` or `x y visibility` of each of COCO's joints, then perhaps how sure the box is, and who it
is. Frames in which nobody was found have no file.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.keypoints.by_frame import by_frame
from pytracker.formats.keypoints.log import Keypoints
from pytracker.formats.keypoints.models import COCO
from pytracker.formats.keypoints.rows import numbers_of
from pytracker.formats.text import number, read_lines
from pytracker.rotation import Array

__all__ = ["read_yolo"]

BOX, MOST_AFTER = 5, 2
"""Numbers before a person's joints, and behind them at most."""


def read_yolo(files: Sequence[Path]) -> Keypoints:
    """The keypoints of numbered files, of which videos' frames count from 1. Raises `InputError`."""
    rows: dict[int, list[Array]] = {}
    files = [file for file in files if file.stem != "classes"]
    for file, frame in zip(files, numbers_of([file.stem for file in files]), strict=True):
        if frame is None:
            raise InputError(f"{file}: its name has no frame number, expected such as video_12.txt")
        if frame in rows:
            raise InputError(f"{file}: is a second file of frame {frame}, expected one a frame: is it another video's?")
        lines = read_lines(file) if file.stat().st_size else []
        people = [_person(file, k + 1, line) for k, line in enumerate(lines) if line.strip()]
        rows[frame] = [person for person in people if person is not None]
    first = 0 if 0 in rows else 1
    return by_frame(files[0].parent, {frame - first: people for frame, people in rows.items()}, "coco_17")


def _person(file: Path, line: int, text: str) -> Array | None:
    """x, y, confidence `(17, 3)`; None of a thing, which has a box alone."""
    values = np.array([number(cell, file, line, "a keypoint") for cell in text.split()])
    if BOX <= len(values) <= BOX + MOST_AFTER and values[0] != 0:
        return None
    for parts in (3, 2):
        if 0 <= len(values) - BOX - parts * len(COCO) <= MOST_AFTER:
            joints = values[BOX : BOX + parts * len(COCO)].reshape(len(COCO), parts)
            return joints if parts == 3 else np.concatenate([joints, np.ones((len(COCO), 1))], axis=1)
    raise InputError(
        f"{file}:{line}: a person has {len(values)} numbers, expected a box and COCO's {len(COCO)} joints, as a pose "
        "model writes them"
    )
