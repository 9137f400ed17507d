"""2-D keypoints of a detector, by video frame: OpenPose-style JSON folders, COCO/AlphaPose/MMPose JSON, CSV tables.

Read are the joints that the body tracker knows (`KEYPOINTS`); the others are passed over. A detector's confidence is
kept as it is: what it is worth is found from the data (`pytracker.evidence.keypoints`).

| file | as written by |
|---|---|
| folder of `*.json` with `people` | OpenPose, Pose2Sim, Sports2D, RTMLib: one file a frame, numbered in its name |
| `.json`, a list with `image_id` and `keypoints` | AlphaPose, COCO results |
| `.json` with `instance_info` | MMPose |
| `.csv` with `X_LEFT_WRIST`, ... | MediaPipe, as shares of the picture |
| `.csv` with `scorer`, `bodyparts`, `coords` | DeepLabCut |
| `.csv` with `left_wrist_x`, `left_wrist_y`[, `left_wrist_confidence`] | anybody |
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoint_models import model_of, name_of
from pytracker.formats.text import number, read_lines
from pytracker.rotation import Array

__all__ = ["Keypoints", "read_keypoints"]

FRAME = re.compile(r"frame([ _]?(id|index|no|nr|number))?#?")
"""A column that counts frames."""
TIME = re.compile(r"time(stamp)?([ _(\[]*(s|sec|ms|us|ns)[)\]]?)?")
"""A column of their times."""
UNITS_S = ((0.5, 1.0), (500.0, 1e-3), (5e5, 1e-6), (np.inf, 1e-9))
"""Frames that are less than so far apart are in this unit, s: no detector is slower than two a second."""
LONGEST_S = 24 * 3600.0
"""Times that begin later are those of a clock, not of the video."""
LARGEST_SHARE = 1.5
"""Of a picture's width or height; a point may lie somewhat outside."""
MOST_PEOPLE = 64
"""More people in a frame are noise."""
MOST_FRAMES = 10_000_000
MOST_PX = 1e6


@dataclass(frozen=True, eq=False)
class Keypoints:
    """What a detector found.

    Attributes:
        frames: video frame of every row, increasing `(T,)`.
        points: of each person u, v and confidence `(T, P, 9, 3)`, in the order of `KEYPOINTS`; px, pixel centres at
            integers, or shares of the picture; NaN where a joint was not seen.
        is_share: whether u and v are shares of the picture's width and height.
        time_s: time of every row since the video began `(T,)`, s; None where the file has none, or counts frames.
    """

    frames: NDArray[np.int64]
    points: Array
    is_share: bool = False
    time_s: Array | None = None


def read_keypoints(path: Path | str, model: str = "auto") -> Keypoints:
    """Read them. `model` names the order of the joints where a file does not (`MODELS`). Raises `InputError`."""
    path = Path(path)
    if path.is_dir():
        return _folder(path, model)
    if not path.is_file():
        raise InputError(f"{path}: no such file or folder, expected keypoints")
    if path.suffix.lower() == ".csv":
        return _table(path)
    if path.suffix.lower() == ".json":
        return _json(path, model)
    beside = " (deeplabcut.analyze_videos_converth5_to_csv writes one)" if path.suffix == ".h5" else ""
    raise InputError(
        f"{path}: keypoints as {path.suffix or 'such a file'} are not read, expected a folder, .json, .csv{beside}"
    )


def _parsed(path: Path) -> Any:
    try:
        return json.loads(path.read_text("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not JSON: {str(error)[:200] or 'too deep'}") from None


def _folder(path: Path, model: str) -> Keypoints:
    files = sorted(path.glob("*.json"))
    if not files:
        raise InputError(f"{path}: holds no .json file, expected one a frame")
    rows: dict[int, list[Array]] = {}
    for file in files:
        digits = re.findall(r"\d+", re.sub(r"_keypoints$", "", file.stem))
        if not digits or int(digits[-1]) > MOST_FRAMES:
            raise InputError(f"{file}: its name ends in no frame number, expected such as frame_000000000012.json")
        frame = int(digits[-1])
        if frame in rows:
            raise InputError(f"{file}: is a second file of frame {frame}, expected one a frame: is it another clip's?")
        data = _parsed(file)
        people = data.get("people") if isinstance(data, dict) else None
        if not isinstance(people, list):
            raise InputError(f"{file}: has no list of people, expected OpenPose's JSON")
        rows[frame] = [_flat(file, person.get("pose_keypoints_2d")) for person in people if isinstance(person, dict)]
    return _ordered(path, rows, model)


def _json(path: Path, model: str) -> Keypoints:
    data = _parsed(path)
    rows: dict[int, list[Array]] = {}
    if isinstance(data, dict) and isinstance(data.get("instance_info"), list):
        for k, frame in enumerate(data["instance_info"]):
            found = [
                _flat(path, [[*xy, score] for xy, score in zip(one["keypoints"], one["keypoint_scores"], strict=True)])
                for one in _records(path, frame, "instances")
            ]
            rows[_whole(path, frame.get("frame_id", k))] = found
        return _ordered(path, rows, model)
    if isinstance(data, dict):
        data = data.get("annotations")
    if not isinstance(data, list):
        raise InputError(f"{path}: is neither MMPose's nor COCO's nor AlphaPose's JSON, expected one of them")
    for one in data:
        if not isinstance(one, dict) or "image_id" not in one:
            raise InputError(f"{path}: an entry has no image_id, expected one and keypoints")
        rows.setdefault(_whole(path, one["image_id"]), []).append(_flat(path, one.get("keypoints")))
    return _ordered(path, rows, model)


def _records(path: Path, frame: Any, key: str) -> list[Any]:
    found = frame.get(key) if isinstance(frame, dict) else None
    usable = isinstance(found, list) and all(
        isinstance(one, dict)
        and isinstance(one.get("keypoints"), list)
        and isinstance(one.get("keypoint_scores"), list)
        and len(one["keypoints"]) == len(one["keypoint_scores"])
        and all(isinstance(xy, list) for xy in one["keypoints"])
        for one in found
    )
    if not usable or not isinstance(found, list):
        raise InputError(f"{path}: a frame has no {key} with keypoints and as many keypoint_scores, expected MMPose's")
    return found


def _whole(path: Path, value: Any) -> int:
    """The frame that `12`, `"12"` or `"000012.jpg"` means."""
    digits = re.findall(r"\d+", str(value)[:200])
    if not digits or isinstance(value, float) or int(digits[-1]) > MOST_FRAMES:
        raise InputError(f"{path}: a frame is {str(value)[:40]!r}, expected a frame number")
    return int(digits[-1])


def _flat(path: Path, values: Any) -> Array:
    """x, y, confidence of one person `(K, 3)`."""
    try:
        found = np.array(values, dtype=np.float64).reshape(-1, 3)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{path}: keypoints are {str(values)[:60]}, expected x, y and confidence of each") from None
    return _in_range(path, found)


def _in_range(path: Path, found: Array) -> Array:
    """The same. Raises `InputError` for what no picture holds."""
    far = np.abs(found) > MOST_PX
    if far.any():
        raise InputError(f"{path}: keypoints hold {found[far][0]:g}, expected pixels within ±{MOST_PX:g}")
    return found


def _ordered(path: Path, rows: dict[int, list[Array]], model: str) -> Keypoints:
    """Frames in order, joints as ours."""
    counts = {len(person) for people in rows.values() for person in people}
    if not counts:
        raise InputError(f"{path}: nobody is seen in any of {len(rows)} frames, expected keypoints of a person")
    if len(counts) > 1:
        raise InputError(f"{path}: people have {sorted(counts)} keypoints, expected the same of each")
    order = model_of(path, model, counts.pop(), [person for people in rows.values() for person in people])
    frames = sorted(rows)
    people = min(MOST_PEOPLE, max(len(rows[frame]) for frame in frames))
    points = np.full((len(frames), people, len(KEYPOINTS), 3), np.nan)
    for row, frame in enumerate(frames):
        for p, person in enumerate(rows[frame][:people]):
            points[row, p] = _ours(person, order)
    return Keypoints(np.array(frames), points)


def _ours(person: Array, order: Sequence[str]) -> Array:
    """The joints of `KEYPOINTS` `(9, 3)`; a head is the middle of both ears, else the nose."""
    found = {name: person[k] for k, name in enumerate(order)}
    out = np.full((len(KEYPOINTS), 3), np.nan)
    for k, name in enumerate(KEYPOINTS):
        if name in found:
            out[k] = found[name]
    ears = [found[ear] for ear in ("left_ear", "right_ear") if ear in found]
    seen = [ear for ear in ears if ear[2] > 0 and np.isfinite(ear).all()]
    if len(seen) == 2:
        out[0] = np.mean(seen, axis=0)
    elif "head" not in found and "nose" in found:
        out[0] = found["nose"]
    # What was not found is written as zero, or with no confidence.
    none = ~(out[:, 2] > 0) | ((out[:, 0] == 0) & (out[:, 1] == 0)) | ~np.isfinite(out).all(axis=1)
    out[none] = np.nan
    return out


def _table(path: Path) -> Keypoints:
    lines = read_lines(path)
    cells = [cell.strip() for cell in lines[0].split(",")]
    if cells[0].lower() == "scorer":
        return _deeplabcut(path, lines)
    named = [(k, *split) for k, cell in enumerate(cells) if (split := _column(cell)) is not None]
    joints = sorted({joint for _, joint, _ in named if all((joint, axis) in {n[1:] for n in named} for axis in "xy")})
    if not set(joints) & set(KEYPOINTS):
        raise InputError(f"{path}:1: header names no joint, expected such as left_wrist_x and left_wrist_y")
    is_mediapipe = any(cell.startswith("X_") for cell in cells)
    table = _cells(path, lines, 1, len(cells))
    counts, times = ([k for k, cell in enumerate(cells) if of.fullmatch(cell.lower())] for of in (FRAME, TIME))
    frames = _frames(path, table[:, counts[0]]) if counts else np.arange(len(table), dtype=np.int64)
    time_s = _times(table[:, times[0]]) if times and not counts else None
    places = table[:, [k for k, joint, axis in named if axis != "confidence"]]
    # No person is one pixel large.
    is_share = is_mediapipe or bool(np.nanmax(np.abs(places), initial=0.0) <= LARGEST_SHARE)
    found = _from_columns(path, table, named, joints, is_share=is_share)
    return dataclasses.replace(found, frames=frames, time_s=time_s)


def _times(column: Array) -> Array | None:
    """Seconds, whichever unit they are in; None where they do not increase, or are those of a clock."""
    steps = np.diff(column)
    if not len(steps) or not np.isfinite(column).all() or not (steps > 0).all() or column[0] < 0:
        return None
    unit_s = next(unit for limit, unit in UNITS_S if np.median(steps) < limit)
    return None if column[0] * unit_s > LONGEST_S else np.asarray(column * unit_s)


def _frames(path: Path, column: Array) -> NDArray[np.int64]:
    """Numbers of frames, as a column of the table has them. Raises `InputError`."""
    whole = np.isfinite(column) & (column == np.rint(column)) & (column >= 0)
    if not whole.all() or not (np.diff(column) > 0).all():
        k = int(np.argmin(np.concatenate([whole[:1], whole[1:] & (np.diff(column) > 0)])))
        raise InputError(f"{path}: the frame of its row {k + 1} is {column[k]:g}, expected whole numbers that increase")
    return column.astype(np.int64)


def _deeplabcut(path: Path, lines: list[str]) -> Keypoints:
    head = [[cell.strip() for cell in line.split(",")] for line in lines[:4]]
    rows = {
        cells[0].lower(): cells
        for cells in head
        if cells[0].lower() in ("scorer", "individuals", "bodyparts", "coords")
    }
    if "individuals" in rows:
        raise InputError(f"{path}: has several individuals, expected DeepLabCut's table of one")
    if "bodyparts" not in rows or "coords" not in rows or len(rows["bodyparts"]) != len(rows["coords"]):
        raise InputError(f"{path}: has no rows of bodyparts and coords below scorer, expected DeepLabCut's table")
    parts = zip(rows["bodyparts"], rows["coords"], strict=True)
    axes = {"x": "x", "y": "y", "likelihood": "confidence"}
    named = [(k, name_of(part), axes[axis]) for k, (part, axis) in enumerate(parts) if axis in axes]
    joints = sorted({joint for _, joint, _ in named})
    if not set(joints) & set(KEYPOINTS):
        raise InputError(f"{path}: its bodyparts name no joint of ours, expected such as left_wrist")
    return _from_columns(path, _cells(path, lines, len(rows), len(rows["coords"])), named, joints, is_share=False)


def _column(cell: str) -> tuple[str, str] | None:
    """Joint and axis that a column's name means."""
    words = cell.lower()
    for pattern in (
        r"(?P<axis>x|y|visibility)_(?P<joint>.+)",
        r"(?P<joint>.+)_(?P<axis>x|y|confidence|likelihood|score)",
    ):
        match = re.fullmatch(pattern, words)
        if match:
            axis = match["axis"] if match["axis"] in "xy" else "confidence"
            return name_of(match["joint"]), axis
    return None


def _cells(path: Path, lines: list[str], first: int, columns: int) -> Array:
    rows = []
    # A row of commas is a frame in which nobody was found, but after the last.
    end = max((k + 1 for k in range(first, len(lines)) if lines[k].strip(" ,")), default=first)
    for k in range(first, end):
        if not lines[k].strip():
            continue
        cells = lines[k].split(",")
        if len(cells) != columns:
            raise InputError(f"{path}:{k + 1}: row has {len(cells)} cells, expected {columns} as the header has")
        rows.append([number(cell, path, k + 1, "a keypoint") if _is_number(cell) else np.nan for cell in cells])
    if not rows:
        raise InputError(f"{path}: has a header but no rows, expected one a frame")
    return np.array(rows)


def _is_number(cell: str) -> bool:
    """DeepLabCut's first column may hold a picture's name."""
    return not re.search(r"\.(png|jpe?g)$", cell.strip(), re.IGNORECASE)


def _from_columns(
    path: Path, table: Array, named: Iterable[tuple[int, str, str]], joints: Sequence[str], *, is_share: bool
) -> Keypoints:
    order = list(joints)
    people = np.full((len(table), len(order), 3), np.nan)
    people[:, :, 2] = 1.0
    _in_range(path, table[:, [k for k, joint, _ in named if joint in order]])
    for k, joint, axis in named:
        if joint in order:
            people[:, order.index(joint), ("x", "y", "confidence").index(axis)] = table[:, k]
    points = np.stack([_ours(row, order) for row in people])[:, None]
    if not np.isfinite(points).any():
        raise InputError(f"{path}: no joint is seen in any of {len(table)} rows, expected keypoints of a person")
    return Keypoints(np.arange(len(table)), points, is_share)
