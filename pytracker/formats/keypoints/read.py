"""2-D keypoints of a detector, by video frame, of any file that is known.

Read are the joints that the body tracker knows (`KEYPOINTS`); the others are passed over. A detector's confidence is
kept as it is: what it is worth is found from the data (`pytracker.recording.keypoints.spreads`).

| file | as written by | reader |
|---|---|---|
| folder of `*.json` with `people` | OpenPose, Pose2Sim, Sports2D, RTMLib: a numbered file a frame | `json_files` |
| `.json`, a list with `image_id` and `keypoints` | AlphaPose, COCO results; COCO's annotations | `json_files` |
| `.json` with `instance_info` | MMPose | `json_files` |
| `.json`, frames of landmarks with `x`, `y` | MediaPipe, MoveNet, by scripts | `landmarks` |
| folder of numbered `.txt` | YOLO | `yolo` |
| `.csv` with `X_LEFT_WRIST`, ... | MediaPipe, as shares of the picture | `table` |
| `.csv` with `scorer`, `bodyparts`, `coords` | DeepLabCut | `deeplabcut` |
| `.csv` with `left_wrist_x`, `left_wrist_y`[, `left_wrist_confidence`] | anybody | `table` |
| `.h5`, a table of pandas' | DeepLabCut | `h5` |
| `.trc` in pixels | Sports2D | `table` |
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.keypoints.deeplabcut import is_deeplabcut, read_deeplabcut
from pytracker.formats.keypoints.h5 import read_h5
from pytracker.formats.keypoints.json_files import read_folder, read_json
from pytracker.formats.keypoints.log import Keypoints
from pytracker.formats.keypoints.table import read_table, read_trc_keypoints

__all__ = ["Keypoints", "read_keypoints"]

PER_CENT, SUREST = 20.0, 0.95
"""The surest points are surer than this only where a confidence is per cent: heights of heat maps reach to some 10."""


def read_keypoints(path: Path | str, model: str = "auto") -> Keypoints:
    """Read them. `model` names the order of the joints where a file does not (`MODELS`). Raises `InputError`."""
    return _in_shares_of_one(Path(path), _read(Path(path), model))


def _read(path: Path, model: str) -> Keypoints:
    if path.is_dir():
        return read_folder(path, model)
    if not path.is_file():
        raise InputError(f"{path}: no such file or folder, expected keypoints")
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return read_deeplabcut(path) if is_deeplabcut(path) else read_table(path)
    if suffix == ".json":
        return read_json(path, model)
    if suffix == ".trc":
        return read_trc_keypoints(path)
    if suffix in (".h5", ".hdf5"):
        return read_h5(path)
    raise InputError(
        f"{path}: keypoints as {path.suffix or 'such a file'} are not read, expected a folder, .json, .csv, .h5, .trc"
    )


def _in_shares_of_one(path: Path, keypoints: Keypoints) -> Keypoints:
    """The same, confidences that are per cent over 100; and a word on that."""
    sure = keypoints.points[..., 2]
    sure = sure[np.isfinite(sure)]
    if not sure.size or not PER_CENT < float(np.quantile(sure, SUREST)) <= 100.0:
        return keypoints
    points = keypoints.points.copy()
    points[..., 2] /= 100.0
    words = f"{path}: confidences reach to {float(sure.max()):g}: taken as per cent"
    return dataclasses.replace(keypoints, points=points, warnings=(*keypoints.warnings, words))
