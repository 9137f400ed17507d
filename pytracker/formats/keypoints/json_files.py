"""Keypoints as JSON: a folder with a file a frame (OpenPose, MMPose), or one file (COCO, AlphaPose, MMPose)."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from pytracker._core import InputError
from pytracker.formats.keypoints.by_frame import by_frame, flat, names_in_order
from pytracker.formats.keypoints.landmarks import as_persons, landmarks_of, read_landmarks
from pytracker.formats.keypoints.log import Keypoints
from pytracker.formats.keypoints.rows import numbers_of
from pytracker.formats.keypoints.yolo import read_yolo
from pytracker.rotation import Array

__all__ = ["read_folder", "read_json"]

MOST_FRAMES = 10_000_000
BODIES = {"people", "bodies"}
"""Under which AlphaPose lists the people of a picture, by `--format open` and `cmu`."""
INSTANCES = ("instance_info", "instances")
"""Under which MMPose lists the people of a frame."""


def _parsed(path: Path) -> Any:
    """What is in it; of JSON Lines a list."""
    text = path.read_text("utf-8-sig", errors="replace")
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        why = f"{path}: is not JSON: {str(error)[:200] or 'too deep'}"
    try:
        lines = [json.loads(line) for line in text.splitlines() if line.strip()]
    except (ValueError, RecursionError):
        raise InputError(why) from None
    return lines


def read_folder(path: Path, model: str) -> Keypoints:
    """One file a frame, numbered in its name. Raises `InputError`."""
    files, texts = sorted(path.glob("[!.]*.json")), sorted(path.glob("[!.]*.txt"))
    if len(texts) > len(files):
        return read_yolo(texts)
    if not files:
        below = sorted({file.parent.name for kind in ("json", "txt") for file in path.glob(f"*/*.{kind}")})
        there = f" ({', '.join(below[:5])} below it do: is it one of these?)" if below else ""
        raise InputError(f"{path}: holds no .json file, expected one a frame{there}")
    found: dict[int, tuple[Path, Any]] = {}
    for file, frame in zip(files, numbers_of([file.stem for file in files]), strict=True):
        if frame is None or frame > MOST_FRAMES:
            raise InputError(f"{file}: its name has no frame number, expected such as frame_000000000012.json")
        if frame in found:
            raise InputError(f"{file}: is a second file of frame {frame}, expected one a frame: is it another clip's?")
        found[frame] = file, _parsed(file)
    landmarks = {frame: landmarks_of(data) for frame, (_, data) in found.items()}
    if any(landmarks.values()):
        for frame, people in landmarks.items():
            if people is None:
                raise InputError(f"{found[frame][0]}: holds no landmarks with x and y, expected them as in the others")
        return as_persons(path, {frame: people or [] for frame, people in landmarks.items()}, model)
    return by_frame(path, {frame: _people_of(*one) for frame, one in found.items()}, model)


def _people_of(file: Path, data: Any) -> list[Array]:
    """Everybody in a file of one frame, OpenPose's or MMPose's. Raises `InputError`."""
    people = data.get("people") if isinstance(data, dict) else None
    if isinstance(people, list):
        found = [person.get("pose_keypoints_2d") for person in people if isinstance(person, dict)]
        # Of whom only hands or a face were found.
        return [flat(file, person) for person in found if person != []]
    instances = next((data[key] for key in INSTANCES if key in data), None) if isinstance(data, dict) else data
    if not isinstance(instances, list):
        raise InputError(f"{file}: has no list of people, expected OpenPose's JSON, or MMPose's of one frame")
    return _instances(file, {"instances": instances})


def read_json(path: Path, model: str) -> Keypoints:
    """One file. Raises `InputError`."""
    data = _parsed(path)
    frames = data.get("instance_info") if isinstance(data, dict) else data
    if isinstance(frames, list) and any(isinstance(frame, dict) and "instances" in frame for frame in frames):
        return _mmpose(path, frames, data.get("meta_info") if isinstance(data, dict) else None, model)
    if isinstance(data, dict) and data and all(isinstance(of, dict) and BODIES & of.keys() for of in data.values()):
        return _by_picture(path, data, model)
    found = read_landmarks(path, data, model)
    return _coco(path, data, model) if found is None else found


def _coco(path: Path, data: Any, model: str) -> Keypoints:
    """COCO's annotations or results, and AlphaPose's, which are such. Raises `InputError`."""
    rows: dict[int, list[Array]] = {}
    files: dict[str, int] = {}
    named: tuple[str, ...] = ()
    pictures = data if isinstance(data, dict) else {}
    listed: set[str] = set()
    if isinstance(data, dict):
        files = _once(path, _files(data.get("images")))
        listed = _listed(data.get("images"))
        kinds = data.get("categories")
        of_kind = [kind.get("keypoints") for kind in kinds if isinstance(kind, dict)] if isinstance(kinds, list) else []
        named = names_in_order(of_kind[0], model) if of_kind else ()
        data = data.get("annotations")
    if not isinstance(data, list):
        raise InputError(f"{path}: is neither MMPose's, COCO's, AlphaPose's nor MediaPipe's JSON, expected one of them")
    for k, one in enumerate(data):
        if not isinstance(one, dict) or "image_id" not in one:
            raise InputError(
                f"{path}: entry {k} has no image_id, expected one and keypoints (COCO), or landmarks with x and y"
            )
        if listed and _id(one) not in listed:
            raise InputError(
                f"{path}: keypoints are of image_id {_id(one)[:80]}, which is not among those of the "
                f"{len(pictures['images'])} images of the file, expected one of them"
            )
    numbers = _numbers(path, {_id(one): one["image_id"] for one in data if _id(one) not in files}) | files
    numbers = _once(path, {name: numbers[name] for name in dict.fromkeys(_id(one) for one in data)})
    for one in data:
        people = rows.setdefault(numbers[_id(one)], [])
        if one.get("keypoints") or "bbox" not in one:  # else a box, and nothing in it
            people.append(flat(path, one.get("keypoints")))
    return by_frame(path, rows, model, named)


def _by_picture(path: Path, pictures: dict[str, Any], model: str) -> Keypoints:
    """AlphaPose's `--format open` and `cmu`: people by the name of the picture. Raises `InputError`."""
    frames = _numbers(path, {name[:200]: name[:200] for name in pictures})
    rows: dict[int, list[Array]] = {}
    for name, of in pictures.items():
        bodies = of.get("bodies")
        if isinstance(bodies, list):
            rows[frames[name[:200]]] = [flat(path, one.get("joints")) for one in bodies if isinstance(one, dict)]
        else:
            rows[frames[name[:200]]] = _people_of(path, of)
    return by_frame(path, rows, model)


def _mmpose(path: Path, frames: list[Any], about: Any, model: str) -> Keypoints:
    """Frames with instances; what is said about them may name their joints in order."""
    rows: dict[int, list[Array]] = {}
    for k, frame in enumerate(frames):
        found = _instances(path, frame)
        number = _whole(path, frame.get("frame_id", k))
        if number in rows:
            raise InputError(f"{path}: frame {number} is there twice, expected each once: is one of another clip?")
        rows[number] = found
    named = about.get("keypoint_id2name") if isinstance(about, dict) else None
    if not isinstance(named, dict) or not all(str(k).isdigit() for k in named):
        return by_frame(path, rows, model)
    return by_frame(path, rows, model, names_in_order([named[k] for k in sorted(named, key=int)], model))


def _instances(path: Path, frame: Any) -> list[Array]:
    """Everybody in one of MMPose's frames. Raises `InputError`."""
    return [
        flat(path, [[*xy, score] for xy, score in zip(one["keypoints"], one["keypoint_scores"], strict=True)])
        for one in _records(path, frame, "instances")
    ]


def _files(images: Any) -> dict[str, int]:
    """Frames of COCO's pictures by their ids, which number them anyhow: their files' names say which they are."""
    listed = [one for one in images if isinstance(one, dict) and "file_name" in one] if isinstance(images, list) else []
    numbers = numbers_of([str(one["file_name"])[:200] for one in listed])
    return {_key(one.get("id")): number for one, number in zip(listed, numbers, strict=True) if number is not None}


def _listed(images: Any) -> set[str]:
    """What keypoints may call COCO's pictures: their ids, and their files' names; nothing where they have no ids."""
    some = [one for one in images if isinstance(one, dict)] if isinstance(images, list) else []
    ids = {_key(one["id"]) for one in some if "id" in one}
    return ids | {_key(one["file_name"]) for one in some if "file_name" in one} if ids else set()


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


def _id(one: dict[str, Any]) -> str:
    return _key(one["image_id"])


def _key(value: Any) -> str:
    """The same of 7, "7", "007" and 7.0."""
    words = str(value)[:200]
    whole = words.removesuffix(".0")
    return str(int(whole)) if whole.isascii() and whole.isdigit() else words


def _numbers(path: Path, images: dict[str, Any]) -> dict[str, int]:
    """Frames of the pictures of these ids, of which some say more than a number. Raises `InputError`."""
    found = {}
    for (name, said), number in zip(images.items(), numbers_of(list(images)), strict=True):
        found[name] = _whole(path, said if number is None or not isinstance(said, str) else number)
    return _once(path, found)


def _once(path: Path, frames: dict[str, int]) -> dict[str, int]:
    """The same. Raises `InputError` for two pictures of one frame."""
    names: dict[int, str] = {}
    for name, frame in frames.items():
        if names.setdefault(frame, name) != name:
            raise InputError(
                f"{path}: pictures {names[frame][:80]!r} and {name[:80]!r} are both of frame {frame}, expected one a "
                "frame: is one of another clip?"
            )
    return frames


def _whole(path: Path, value: Any) -> int:
    """The frame that `12`, `"12"` or `"000012.jpg"` means."""
    digits = re.findall(r"\d+", str(value)[:200])
    if not digits or isinstance(value, float) or int(digits[-1]) > MOST_FRAMES:
        raise InputError(f"{path}: a frame is {str(value)[:40]!r}, expected a frame number")
    return int(digits[-1])
