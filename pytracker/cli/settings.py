"""`--method` and `--set`: from words to methods and scenes, and back to what `--help` says of them."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

import pytracker as pt
from pytracker.methods.method import Method
from pytracker.methods.registry import METHODS_OF, as_tuples, make_method, nearest

__all__ = ["METHOD_WORDS", "chosen_method", "chosen_scene"]

METHOD_WORDS = " ".join(f"{kind.capitalize()}: {', '.join(methods)}." for kind, methods in METHODS_OF.items())
"""The names of all methods."""

LONGEST = 1000
"""No word that is meant is longer."""


def chosen_method(
    kind: str, name: str, particles: int | None, settings: list[str], best: Method | None = None
) -> Method:
    """A method for a kind of recording from what the command line says, else as in `best`. Raises `InputError`."""
    values = _parse(settings)
    if particles is not None:
        if "particles" in values:
            raise pt.InputError("--particles and --set particles are both given, expected one of them")
        values["particles"] = particles
    methods = METHODS_OF[kind]
    if name not in methods:
        raise pt.InputError(f"--method is {name!r}, expected one of: {', '.join(methods)} (kind {kind!r})")
    if particles is not None and methods[name]().sample_size is None:
        raise pt.InputError(f"--particles does not go with --method {name}, which has none")
    try:
        return make_method(kind, name, (best.parameters() if best else {}) | values)
    except pt.InputError as error:
        raise pt.InputError(f"--set {error}") from None


def chosen_scene(cls: type[Any], settings: list[str]) -> Any:
    """A scene to simulate from `--set`. Raises `InputError`."""
    values, known = _parse(settings), [field.name for field in fields(cls)]
    for key in values:
        if key not in known:
            raise pt.InputError(f"--set {key}: {cls.__name__} has no such parameter, {nearest(key, known)}")
    return cls(**values)


def _parse(settings: list[str]) -> dict[str, Any]:
    """`key=value` pairs; values are JSON, or words as they stand."""
    values: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise pt.InputError(f"--set {setting!r}, expected KEY=VALUE")
        try:
            values[key] = as_tuples(json.loads(text))
        except (ValueError, RecursionError):
            if len(text) > LONGEST:
                raise pt.InputError(f"--set {key}: a value of {len(text)} letters, expected one that is read") from None
            values[key] = text
    return values
