"""JSON of landmarks that are named x and y, as scripts write what MediaPipe (or MoveNet) found, frame by frame.

A frame is a record with a list of landmarks under some name (`landmarks`, `pose_landmarks`, ...) and perhaps its number
or time, or that list alone; frames are a list, alone or under some name, or are named by their numbers or times.
There may be a list a person. Landmarks may have names or numbers of their own, in any order; else they are in a
model's.
A person may be lists of all x and all y (Ultralytics' `to_json`), or MediaPipe's 33 lists of x, y, z and visibility.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoints.by_frame import by_frame, flat
from pytracker.formats.keypoints.log import Keypoints
from pytracker.formats.keypoints.models import MODELS, name_of
from pytracker.formats.keypoints.rows import numbers_of, rows_of
from pytracker.rotation import Array

__all__ = ["as_persons", "landmarks_of", "read_landmarks"]

NO_POSE = re.compile(r"world|hand|face|3d|metric|^[lr]h$")
"""What landmarks beside those of the body in the picture are called."""
PERSON = re.compile(r"(person|people|player|subject|skeleton|id|track)?[_ -]?\d+")
"""What one of several people is called."""
SURE = ("visibility", "score", "confidence", "likelihood", "presence")
"""What says how sure a landmark is."""
NAMES = ("name", "part", "keypoint", "joint", "landmark", "id", "index", "idx", "landmark_id")
"""What names or numbers one."""
BY_NUMBER = ("coco_17", "blazepose_33")
"""Orders that numbers of landmarks may be of, where none is given: the least that has so many."""
SECONDS = re.compile(r"\d+\.\d+")
"""What a frame is called by its time."""
BLAZEPOSE = len(MODELS["blazepose_33"])
"""So many lists of numbers are MediaPipe's, x first; fewer may be MoveNet's, which gives y first."""
DEEPEST = 5
"""Lists and records of a frame, one within another: of people, of landmarks."""

Person = list[dict[str, Any]]


def read_landmarks(path: Path, data: Any, model: str) -> Keypoints | None:
    """The keypoints; None where no frame holds landmarks that are named so. Raises `InputError`."""
    frames = _frames(path, data)
    if any(_said(frame) for frame in frames):
        frames = [frame for frame in frames if frame is not None]
    people = [_people(frame) for frame in frames]
    if not any(people):
        return None
    for k, those in enumerate(people):
        if those is None:
            raise InputError(f"{path}: entry {k} of the frames holds no landmarks with x and y, expected them in each")
    found = as_persons(path, dict(enumerate(those or [] for those in people)), model)
    said = [_said(frame) for frame in frames]
    header = list(dict.fromkeys(key for record in said for key in record))
    of = rows_of(path, header, [[record.get(key, "") for key in header] for record in said], range(len(header)))
    return dataclasses.replace(found, frames=of.frames, time_s=of.time_s, warnings=of.warnings)


def landmarks_of(frame: Any) -> list[Person] | None:
    """Everybody in the record of a frame; None where it holds no landmarks."""
    return _people(frame) if isinstance(frame, list | dict) or frame is None else None


def as_persons(path: Path, people: Mapping[int, Sequence[Person]], model: str) -> Keypoints:
    """Of everybody by frame, each by its own landmarks' names, or numbers. Raises `InputError`."""
    everybody = [person for those in people.values() for person in those]
    called = [[_called(landmark) for landmark in person] for person in everybody]
    if not all(names and None not in names for names in called):
        rows = {k: [flat(path, [_values(path, one) for one in person]) for person in those]
                for k, those in people.items()}  # fmt: skip
        return by_frame(path, rows, model)
    order = _order(path, [name or "" for names in called for name in names], model)
    named = tuple(dict.fromkeys(order.values()))
    if not {*KEYPOINTS, "nose"} & {*named}:
        raise InputError(f"{path}: landmarks are called {', '.join(order)[:200]}, expected such as left_wrist")
    rows = {k: [_by_name(path, person, order, named) for person in those] for k, those in people.items()}
    return by_frame(path, rows, model, named)


def _by_name(path: Path, person: Person, order: Mapping[str, str], named: Sequence[str]) -> Array:
    """x, y and how sure it is of each `(K, 3)`; nothing of what is not there."""
    found = np.full((len(named), 3), np.nan)
    found[:, 2] = 0.0
    for landmark in person:
        found[named.index(order[_called(landmark) or ""])] = _values(path, landmark)
    return flat(path, found)


def _order(path: Path, called: Sequence[str], model: str) -> dict[str, str]:
    """Our name of each that landmarks are called; of numbers by the model's order."""
    every = dict.fromkeys(called)
    if not all(name.isdigit() for name in every):
        return {name: name_of(name[:100]) for name in every}
    most = max(int(name) for name in every) + 1
    models = BY_NUMBER if model == "auto" else (model,)
    fitting = next((MODELS[one] for one in models if one in MODELS and len(MODELS[one]) >= most), None)
    if fitting is None:
        raise InputError(f"{path}: landmarks are numbered up to {most - 1}, expected keypoint_model to say their order")
    return {name: name_of(fitting[int(name)]) for name in every}


def _frames(path: Path, data: Any, depth: int = 0) -> list[Any]:
    """Records of the frames, those that are named by their numbers with them. Raises `InputError`."""
    if isinstance(data, list):
        # A list of frames, alone in another.
        is_nested = len(data) == 1 and isinstance(data[0], list) and any(_said(one) for one in data[0])
        return data[0] if is_nested else data
    if not isinstance(data, dict) or depth > DEEPEST:
        return []
    of_pose = {key: value for key, value in data.items() if not NO_POSE.search(key.lower())}
    lists = {key: value for key, value in of_pose.items() if isinstance(value, list) and any(map(_people, value))}
    if len(lists) == 1:
        return _frames(path, next(iter(lists.values())), depth + 1)
    if lists and all(any(_said(one) for one in value) for value in lists.values()):
        raise InputError(
            f"{path}: has several lists of frames ({', '.join(lists)[:80]}), expected one: keep a person's"
        )
    if all(SECONDS.fullmatch(str(key)) for key in of_pose):
        in_time = sorted(of_pose.items(), key=lambda pair: float(pair[0]))
        return [{"time_s": key, "landmarks": _people(one)} for key, one in in_time]
    numbers = numbers_of([str(key)[:200] for key in of_pose])
    if not any(number is None for number in numbers):
        frames = sorted(zip(numbers, of_pose.values(), strict=True), key=lambda pair: pair[0] or 0)
        return [{"frame": number, "landmarks": _people(one)} for number, one in frames]
    inner = [_frames(path, value, depth + 1) for value in of_pose.values() if isinstance(value, dict)]
    return next((frames for frames in inner if any(map(_people, frames))), [])


def _people(frame: Any, depth: int = 0) -> list[Person] | None:
    """Everybody in a frame's record; None where what it holds is none."""
    if not frame and (frame is None or isinstance(frame, list | dict)):
        return []
    if depth > DEEPEST:
        return None
    if isinstance(frame, list):
        if all(_is_landmark(one) for one in frame):
            return [frame]
        if len(frame) == BLAZEPOSE and {_numbers_in(one) for one in frame} in ({3}, {4}):
            return [_of_numbers(frame)]
        each = [_people(one, depth + 1) if isinstance(one, list | dict) else None for one in frame]
        return None if None in each else [person for people in each for person in people or []]
    return _in_record(frame, depth) if isinstance(frame, dict) else None


def _in_record(frame: dict[str, Any], depth: int) -> list[Person] | None:
    """The same of a record: landmarks by their names, people by theirs, or people under some name beside others."""
    if isinstance(frame.get("x"), list) and isinstance(frame.get("y"), list):
        return _of_columns(frame)
    named = [{**one, "name": name} for name, one in frame.items() if _is_landmark(one)]
    if len(named) > 1:
        return [named]
    held = {key: value for key, value in frame.items() if isinstance(value, list | dict) and value}
    of_pose = {key: value for key, value in held.items() if not NO_POSE.search(key.lower())}
    by_name = sorted(of_pose.items(), key=lambda item: "pose" not in item[0].lower())
    each = {key: people for key, value in by_name if (people := _people(value, depth + 1)) is not None}
    if len(each) > 1 and all(PERSON.fullmatch(key.lower()) for key in each):
        return [person for people in each.values() for person in people]
    nobody: list[Person] | None = [] if each or not of_pose else None
    return next((people for people in each.values() if people), nobody)


def _numbers_in(one: Any) -> int:
    """How many there are in a list of numbers; 0 of anything else."""
    return len(one) if isinstance(one, list) and all(isinstance(x, int | float) or x is None for x in one) else 0


def _of_numbers(rows: list[list[Any]]) -> Person:
    """MediaPipe's lists of x, y, z and visibility of each; of three numbers the last is either."""
    thirds = [one[-1] for one in rows]
    are_sure = len(rows[0]) == 4 or all(isinstance(third, int | float) and 0 <= third <= 1 for third in thirds)
    sure = thirds if are_sure else [1.0] * len(rows)
    return [{"x": one[0], "y": one[1], "visibility": third} for one, third in zip(rows, sure, strict=True)]


def _of_columns(person: dict[str, Any]) -> list[Person] | None:
    """One of whom all x, all y and how sure each is are a list each; None where these are not as long."""
    sure = next((person[key] for key in (*SURE, "visible") if isinstance(person.get(key), list)), None)
    columns = person["x"], person["y"], sure or [1.0] * len(person["x"])
    if len({len(column) for column in columns}) > 1:
        return None
    return [[{"x": x, "y": y, "score": score} for x, y, score in zip(*columns, strict=True)]]


def _is_landmark(one: Any) -> bool:
    place = one.get("position", one) if isinstance(one, dict) else None
    return isinstance(place, dict) and "x" in place and "y" in place and not isinstance(place["x"], list)


def _called(landmark: dict[str, Any]) -> str | None:
    """Its name, or its number."""
    said = next((landmark[key] for key in NAMES if landmark.get(key) is not None), None)
    return None if said is None else str(said)[:100]


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
    if not isinstance(frame, dict) or _is_landmark(frame):
        return {}
    return {key: str(value) for key, value in frame.items() if isinstance(value, int | float | str)}
