"""TOML files that people write: read, validated, every fault named with its key, value and expectation."""

from __future__ import annotations

import difflib
import sys
import typing
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from pytracker._core import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = [
    "Entry",
    "FileName",
    "Finite",
    "Length",
    "Positive",
    "Whole",
    "faults_of",
    "parse_toml",
    "read_toml",
    "validated",
]

Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True)]
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
FILE_BYTES = 255
"""No file system takes a longer name of a file or a folder."""


def _is_file_name(name: str) -> str:
    if not name or "\0" in name or any(len(part.encode()) > FILE_BYTES for part in name.split("/")):
        raise ValueError(f"the name of a file, of 1 to {FILE_BYTES} bytes, without NUL")  # pydantic's way to refuse
    return name


FileName = Annotated[str, AfterValidator(_is_file_name)]
Length = Annotated[float, Field(strict=True, gt=0, le=1, allow_inf_nan=False)]


class Entry(BaseModel):
    """A table of such a file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


Model = TypeVar("Model", bound=BaseModel)


def parse_toml(path: Path) -> dict[str, Any]:
    """What is in the file. Raises `InputError` where it is no TOML, or nothing that can be read."""
    try:
        return tomllib.loads(path.read_text("utf-8-sig"))
    except (
        ValueError,
        RecursionError,
    ) as error:  # no TOML, no text, a number of thousands of digits, brackets too deep
        raise InputError(f"{path}: is not TOML: {error or type(error).__name__}") from None


def read_toml(path: Path, newest: int) -> dict[str, Any]:
    """What is in the file. Raises `InputError` where it is no TOML, or of a schema newer than `newest`."""
    data = parse_toml(path)
    schema = data.get("schema")
    if type(schema) is int and schema > newest:
        raise InputError(
            f"{path}: schema is {schema}, this version reads {newest}: the file is newer, update pytracker"
        )
    return data


def validated(path: Path, data: dict[str, Any], model: type[Model]) -> Model:
    """`data` as `model`. Raises `InputError` naming every fault."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise InputError(f"{path}: " + "; ".join(_fault(model, fault) for fault in _inner(error))) from None


def faults_of(data: dict[str, Any], model: type[BaseModel]) -> list[str]:
    """What is wrong of what is there; that something is missing is no fault."""
    try:
        model.model_validate(data)
    except ValidationError as error:
        return [_fault(model, fault) for fault in _inner(error) if fault["type"] != "missing"]
    return []


def _inner(error: ValidationError) -> list[Any]:
    """A list whose item is at fault is said to be too short as well: only the item is."""
    found = error.errors()
    places = [fault["loc"] for fault in found]
    return [f for f in found if not any(len(p) > len(f["loc"]) and p[: len(f["loc"])] == f["loc"] for p in places)]


def _fault(model: type[BaseModel], fault: Any) -> str:
    place = _place(fault["loc"])
    if fault["type"] == "extra_forbidden":
        known = _known_keys(model, fault["loc"][:-1])
        near = difflib.get_close_matches(str(fault["loc"][-1]), known, n=1, cutoff=0.5)
        hint = f"did you mean {near[0]!r}?" if near else f"expected one of: {', '.join(known)}"
        return f"{place} is not a known key, {hint}"
    if fault["type"] == "missing":
        return f"{place} is missing"
    message = fault["msg"].removeprefix("Value error, ")
    return f"{place} is {repr(fault['input'])[:200]}, expected: {message[0].lower()}{message[1:]}"


def _place(loc: tuple[Any, ...]) -> str:
    """`('camera', 0, 'video')` as `camera[0].video`."""
    place = ""
    for part in loc:
        place += f"[{part}]" if isinstance(part, int) else f".{part}" if place else str(part)
    return place


def _known_keys(model: type[BaseModel], loc: tuple[Any, ...]) -> list[str]:
    """Keys of the table at `loc`."""
    for part in loc:
        if not isinstance(part, int):
            model = next(_tables(model.model_fields[part].annotation), model)
    return [field.alias or name for name, field in model.model_fields.items()]


def _tables(annotation: Any) -> typing.Iterator[type[BaseModel]]:
    """Models within an annotation such as `list[CameraEntry] | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in typing.get_args(annotation):
        yield from _tables(inner)
