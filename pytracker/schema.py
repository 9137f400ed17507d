"""`recording.toml`, schema 1: every key, its type and default. Unknown keys are errors that name the nearest."""

from __future__ import annotations

import difflib
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pytracker._core import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = [
    "ArmEntry",
    "ArmFile",
    "BodyCameraEntry",
    "BodyFile",
    "BodyTruthEntry",
    "CameraEntry",
    "ImuEntry",
    "InitialEntry",
    "SkeletonEntry",
    "TruthEntry",
    "read_recording_file",
]

Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True)]
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
Length = Annotated[float, Field(strict=True, gt=0, le=1, allow_inf_nan=False)]
Triple = tuple[Finite, Finite, Finite]
Matrix = tuple[Triple, Triple, Triple]


SCHEMA = 1
"""The newest recording schema that this version reads."""


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class CameraEntry(_Entry):
    """`[[camera]]`: a video and the calibrated camera that took it."""

    video: str
    start_s: Finite = 0.0
    matrix: Matrix
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)
    rotation: Matrix
    translation_m: Triple
    patch_box: tuple[Whole, Whole, Whole, Whole]
    patch_offset_m: Triple = (0.0, 0.0, 0.0)


class ImuEntry(_Entry):
    """`[[imu]]`: an inertial sensor's file and how it is worn."""

    file: str
    orientation_file: str | None = None
    format: Literal["auto", "csv", "mt-manager", "mt9-log"] = "auto"
    rate_hz: Positive | None = None
    segment: str = "right_forearm"
    offset_s: Finite = 0.0
    heading_deg: Finite | None = None
    mount: tuple[Finite, Finite, Finite, Finite] = (1.0, 0.0, 0.0, 0.0)


class ArmEntry(_Entry):
    """`[arm]`: the subject's arm."""

    side: Literal["right", "left"] = "right"
    shoulder_m: Triple
    upper_arm_m: Length
    forearm_m: Length
    wrist_start_m: Triple | None = None


class TruthEntry(_Entry):
    """`[truth]`: measured joints, where there are any."""

    file: str
    markers: dict[str, str] = {}
    offset_s: Finite = 0.0


class BodyCameraEntry(_Entry):
    """`[[camera]]` of a body: a video, and a pinhole, a weak-perspective matrix, or point pairs to fit one from."""

    video: str
    start_s: Finite = 0.0
    background: str | None = None
    points: str | None = None
    affine: tuple[tuple[Finite, ...], tuple[Finite, ...]] | None = None
    matrix: Matrix | None = None
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)
    rotation: Matrix | None = None
    translation_m: Triple | None = None


class SkeletonEntry(_Entry):
    """`[skeleton]`: the subject's Acclaim skeleton, or the package's own average one, scaled."""

    file: str | None = None
    height_m: Annotated[float, Field(strict=True, ge=0.5, le=2.5)] | None = None


class InitialEntry(_Entry):
    """`[initial]`: the pose at the first frame: angles by file, or the truth's own at one of its frames."""

    angles: str | None = None
    frame: Annotated[int, Field(strict=True, ge=0)] | None = None


class BodyTruthEntry(_Entry):
    """`[truth]` of a body: an AMC motion on the same skeleton."""

    file: str
    rate_hz: Positive
    offset_s: Finite = 0.0


class BodyFile(_Entry):
    """The whole file of a body."""

    schema_: Annotated[Literal[1], Field(alias="schema")]
    kind: Literal["body"]
    camera: Annotated[tuple[BodyCameraEntry, ...], Field(min_length=1, max_length=1)]
    skeleton: SkeletonEntry
    initial: InitialEntry | None = None
    truth: BodyTruthEntry | None = None


class ArmFile(_Entry):
    """The whole file of an arm."""

    schema_: Annotated[Literal[1], Field(alias="schema")]
    kind: Literal["arm"]
    camera: Annotated[tuple[CameraEntry, ...], Field(min_length=1)]
    imu: Annotated[tuple[ImuEntry, ...], Field(min_length=1, max_length=1)]
    arm: ArmEntry
    truth: TruthEntry | None = None


def read_recording_file(path: Path) -> ArmFile | BodyFile:
    """Read and validate. Raises `InputError` naming every fault: key, value, expectation."""
    if not path.is_file():
        where = path.parent
        kind = "is no folder" if not where.is_dir() else "holds no recording.toml"
        raise InputError(f"{where}: {kind}, expected a folder with recording.toml")
    try:
        data = tomllib.loads(path.read_text("utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not TOML: {error}") from None
    schema = data.get("schema")
    if type(schema) is int and schema > SCHEMA:
        raise InputError(
            f"{path}: schema is {schema}, this version reads {SCHEMA}: the folder is newer, update pytracker"
        )
    model: type[ArmFile | BodyFile] = BodyFile if data.get("kind") == "body" else ArmFile
    if data.get("kind") not in ("arm", "body"):
        raise InputError(f"{path}: kind is {data.get('kind')!r}, expected 'arm' or 'body'")
    try:
        return model.model_validate(data)
    except ValidationError as error:
        found = error.errors()
        # A list whose item is at fault is said to be too short as well: only the item is.
        places = [fault["loc"] for fault in found]
        inner = [f for f in found if not any(len(p) > len(f["loc"]) and p[: len(f["loc"])] == f["loc"] for p in places)]
        faults = [_fault(model, fault) for fault in inner]
        raise InputError(f"{path}: " + "; ".join(faults)) from None


def _fault(model: type[BaseModel], fault: Any) -> str:
    place = _place(fault["loc"])
    if fault["type"] == "extra_forbidden":
        known = _known_keys(model, fault["loc"][:-1])
        near = difflib.get_close_matches(str(fault["loc"][-1]), known, n=1, cutoff=0.5)
        hint = f"did you mean {near[0]!r}?" if near else f"expected one of: {', '.join(known)}"
        return f"{place} is not a known key, {hint}"
    if fault["type"] == "missing":
        return f"{place} is missing"
    return f"{place} is {fault['input']!r}, expected: {fault['msg'][0].lower()}{fault['msg'][1:]}"


def _place(loc: tuple[Any, ...]) -> str:
    """`('camera', 0, 'video')` as `camera[0].video`."""
    place = ""
    for part in loc:
        place += f"[{part}]" if isinstance(part, int) else f".{part}" if place else str(part)
    return place


def _known_keys(model: type[BaseModel], loc: tuple[Any, ...]) -> list[str]:
    entries: dict[type[BaseModel], dict[str, type[BaseModel]]] = {
        ArmFile: {"camera": CameraEntry, "imu": ImuEntry, "arm": ArmEntry, "truth": TruthEntry},
        BodyFile: {
            "camera": BodyCameraEntry, "skeleton": SkeletonEntry, "initial": InitialEntry, "truth": BodyTruthEntry,
        },
    }  # fmt: skip
    entry = entries[model].get(str(loc[0]), model) if loc else model
    return [field.alias or name for name, field in entry.model_fields.items()]
