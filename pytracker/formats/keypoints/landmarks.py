"""JSON of landmarks that are named x and y, as scripts write what MediaPipe (or MoveNet) found, frame by frame.

A frame is a record with a list of landmarks under some name (`landmarks`, `pose_landmarks`, ...) and perhaps its number
or time, or that list alone; frames are a list, alone or under some name, or are named by their numbers. A list may
hold one list a person; landmarks may have names, else they are in a model's order.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError
from pytracker.formats.keypoints.by_frame import by_frame, flat, names_in_order
from pytracker.formats.keypoints.log import Keypoints
from pytracker.formats.keypoints.rows import numbers_of, rows_of
from pytracker.rotation import Array

__all__ = ["landmarks_of", "read_landmarks"]

NO_POSE = ("world", "hand", "face")
"""What landmarks beside those of the body in the picture are called."""
SURE = ("visibility", "score", "confidence", "likelihood", "presence")
"""What says how sure a landmark is."""
NAMES = ("name", "part", "keypoint", "joint")
"""What names one."""

DEEPEST = 4
"""Lists and records of a frame, one within another: of people, of landmarks."""

Person = list[dict[str, Any]]


def read_landmarks(path: Path, data: Any, model: str) -> Keypoints | None:
    """The keypoints; None where no frame holds landmarks that are named so. Raises `InputError`."""
    frames = _frames(data)
    people = [_people(frame) for frame in frames]
    shown = [person for those in people for person in those or []]
    if not shown:
        return None
    for k, those in enumerate(people):
        if those is None:
            raise InputError(f"{path}: entry {k} of the frames holds no landmarks with x and y, expected them in each")
    rows = {k: _points(path, those or []) for k, those in enumerate(people)}
    called = [next((landmark[key] for key in NAMES if key in landmark), None) for landmark in shown[0]]
    found = by_frame(path, rows, model, names_in_order(called, model) if None not in called else ())
    said = [_said(frame) for frame in frames]
    header = list(dict.fromkeys(key for record in said for key in record))
    of = rows_of(path, header, [[record.get(key, "") for key in header] for record in said], range(len(header)))
    return dataclasses.replace(found, frames=of.frames, time_s=of.time_s, warnings=of.warnings)


def landmarks_of(path: Path, frame: Any) -> list[Array] | None:
    """Everybody `(K, 3)` in the record of a frame; None where it holds no landmarks. Raises `InputError`."""
    people = _people(frame) if isinstance(frame, list | dict) else None
    return None if people is None else _points(path, people)


def _frames(data: Any) -> list[Any]:
    """Records of the frames, those that are named by their numbers with them."""
    if isinstance(data, list):
        return data
    if not isinstance(data, dict):
        return []
    lists = [value for value in data.values() if isinstance(value, list) and any(_people(one) for one in value)]
    if len(lists) == 1:
        return lists[0]
    numbers = numbers_of([str(key)[:200] for key in data])
    if any(number is None for number in numbers):
        return []
    frames = sorted(zip(numbers, data.values(), strict=True), key=lambda pair: pair[0] or 0)
    return [{"frame": number, "landmarks": _people(one)} for number, one in frames]


def _people(frame: Any, depth: int = 0) -> list[Person] | None:
    """Everybody in a frame's record; None where there is none such."""
    if frame is None or frame == []:
        return []
    if depth > DEEPEST:
        return None
    if isinstance(frame, list):
        if all(_is_landmark(one) for one in frame):
            return [frame]
        each = [_people(one, depth + 1) if isinstance(one, list | dict) else None for one in frame]
        return None if None in each else [person for people in each for person in people or []]
    if not isinstance(frame, dict):
        return None
    named = [{**one, "name": name} for name, one in frame.items() if _is_landmark(one)]
    if len(named) > 1:
        return [named]
    of_pose = {key: value for key, value in frame.items() if not any(word in key.lower() for word in NO_POSE)}
    by_name = sorted(of_pose.items(), key=lambda item: "pose" not in item[0].lower())
    each = [_people(value, depth + 1) for _, value in by_name if isinstance(value, list | dict) or value is None]
    return next((people for people in each if people), [] if [] in each else None)


def _is_landmark(one: Any) -> bool:
    place = one.get("position", one) if isinstance(one, dict) else None
    return isinstance(place, dict) and "x" in place and "y" in place


def _points(path: Path, people: list[Person]) -> list[Array]:
    return [flat(path, [_values(path, landmark) for landmark in person]) for person in people]


def _values(path: Path, landmark: dict[str, Any]) -> list[float]:
    """x, y and how sure it is."""
    place = landmark.get("position", landmark)
    sure = next((landmark[key] for key in SURE if landmark.get(key) is not None), 1.0)
    values = [np.nan if value is None else value for value in (place["x"], place["y"], sure)]
    if not all(isinstance(value, int | float) for value in values):
        raise InputError(f"{path}: a landmark is {str(landmark)[:80]}, expected numbers")
    return values


def _said(frame: Any) -> dict[str, str]:
    """What a record says of its frame, beside landmarks."""
    if not isinstance(frame, dict):
        return {}
    return {key: str(value) for key, value in frame.items() if isinstance(value, int | float | str)}
