"""A study from a TOML file.

schema = 1
seeds = 10                          # 1 to 10, or a list

[[recording]]
folder = "trial03"                  # relative to the file; name = its name, unless said

[[recording]]
name = "circle"
simulate = "arm"                    # or "body"
scene = { pattern = "circle", duration_s = 20.0 }
pixel_sd = 4.0                      # arm: no video, patch centres with this noise
seed = 3                            # optional: the same recording in every run

[[method]]
name = "layered"
set = { bias = true }
grid = { particles = [100, 500], pixel_sd = [2.0, 4.0] }      # every combination
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from pytracker._core import InputError
from pytracker.formats.toml_file import Entry, Finite, Whole, read_toml, validated
from pytracker.methods.method import Method
from pytracker.methods.registry import METHODS_OF, as_tuples, make_method, nearest
from pytracker.simulate import ArmScene, BodyScene
from pytracker.study.plan import Study, StudyRecording

__all__ = ["read_study"]

SCHEMA = 1

SCENES: Mapping[str, type[ArmScene | BodyScene]] = {scene.kind: scene for scene in (ArmScene, BodyScene)}

MOST_SEEDS = 100_000
"""Of a number of seeds, and of combinations of a grid."""


class RecordingEntry(Entry):
    """`[[recording]]`: a folder, or what to simulate."""

    name: str = ""
    folder: str | None = None
    simulate: Literal["arm", "body"] | None = None
    scene: dict[str, Any] = Field(default_factory=dict)
    seed: Annotated[Whole, Field(ge=0)] | None = None
    pixel_sd: Annotated[Finite, Field(ge=0)] | None = None


class MethodEntry(Entry):
    """`[[method]]`: a name as on the command line, parameters, and parameters with several values."""

    name: str
    set: dict[str, Any] = Field(default_factory=dict)
    grid: dict[str, list[Any]] = Field(default_factory=dict)


class StudyFile(Entry):
    """The whole file."""

    schema_: Annotated[Literal[1], Field(alias="schema")]
    seeds: Any
    recording: Annotated[tuple[RecordingEntry, ...], Field(min_length=1)]
    method: Annotated[tuple[MethodEntry, ...], Field(min_length=1)]


def read_study(path: Path | str) -> Study:
    """Read a study. Raises `InputError` naming the key, the value and the expectation."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: is no file, expected a study in TOML")
    entry = validated(path, read_toml(path, SCHEMA), StudyFile)
    try:
        seeds = _seeds(entry.seeds)
        recordings = tuple(_recording(path.parent, k, item) for k, item in enumerate(entry.recording))
        kinds = {recording.kind for recording in recordings}
        methods = [method for k, item in enumerate(entry.method) for method in _methods(k, item, kinds)]
        return Study(recordings=recordings, methods=tuple(methods), seeds=seeds)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _seeds(value: Any) -> tuple[int, ...]:
    if type(value) is int and 1 <= value <= MOST_SEEDS:
        return tuple(range(1, value + 1))
    if isinstance(value, list) and value:
        return tuple(value)
    raise InputError(f"seeds is {value!r}, expected a whole number from 1 to {MOST_SEEDS}, or a list of them")


def _recording(folder: Path, number: int, entry: RecordingEntry) -> StudyRecording:
    place = f"recording[{number}]"
    if (entry.folder is None) == (entry.simulate is None):
        given = "neither" if entry.folder is None else "both"
        raise InputError(f"{place} has {given} of folder and simulate, expected one of them")
    if entry.folder is not None:
        if entry.scene:
            raise InputError(f"{place}.scene goes with simulate, not with folder")
        where = (folder / entry.folder).resolve()
        return StudyRecording(name=entry.name or where.name, folder=where, seed=entry.seed, pixel_sd=entry.pixel_sd)
    scene = SCENES[entry.simulate or ""]
    known = [field.name for field in fields(scene)]
    for key in entry.scene:
        if key not in known:
            raise InputError(f"{place}.scene.{key} is not a known key, {nearest(key, known)}")
    values = {key: as_tuples(value) for key, value in entry.scene.items()}
    for key in {"skeleton", "motion"} & values.keys():
        if isinstance(values[key], str):  # else the scene says so
            values[key] = str((folder / values[key]).resolve())
    name = entry.name or f"simulated {entry.simulate}"
    return StudyRecording(name=name, scene=scene(**values), seed=entry.seed, pixel_sd=entry.pixel_sd)


def _methods(number: int, entry: MethodEntry, kinds: set[str]) -> list[Method]:
    """Every combination of the grid, for every kind of recording that knows the name."""
    double = entry.set.keys() & entry.grid.keys()
    if double:
        raise InputError(f"method[{number}] has {sorted(double)[0]} in both set and grid, expected one of them")
    # A folder that cannot be read may be of any kind: its runs will say what is the matter.
    possible = [kind for kind in METHODS_OF if kinds & {kind, ""}]
    of_kinds = [kind for kind in possible if entry.name in METHODS_OF[kind]]
    if not of_kinds:
        known = [name for kind in possible for name in METHODS_OF[kind]]
        raise InputError(f"method[{number}].name is {entry.name!r}, {nearest(entry.name, known)}")
    count = math.prod(len(values) for values in entry.grid.values())
    if count > MOST_SEEDS:
        raise InputError(f"method[{number}].grid has {count} combinations, expected at most {MOST_SEEDS}")
    combinations = [dict(zip(entry.grid, values, strict=True)) for values in itertools.product(*entry.grid.values())]
    try:
        return [make_method(kind, entry.name, {**entry.set, **values}) for kind in of_kinds for values in combinations]
    except InputError as error:
        raise InputError(f"method[{number}]: {error}") from None
