"""Methods by name: what the command line, a study's file and a run's metadata call them."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from pytracker._core import InputError
from pytracker.methods.arm import METHODS
from pytracker.methods.body import BODY_METHODS
from pytracker.methods.method import Method

__all__ = ["METHODS_OF", "as_tuples", "make_method", "method_of_class", "nearest"]

METHODS_OF: dict[str, Mapping[str, type[Method]]] = {"arm": METHODS, "body": BODY_METHODS}
"""By kind of recording, then by name."""


def make_method(kind: str, name: str, values: Mapping[str, Any]) -> Method:
    """The method `name` for recordings of a kind, with some parameters set. Raises `InputError`."""
    methods = METHODS_OF[kind]
    if name not in methods:
        raise InputError(f"the method is {name!r}, expected one of: {', '.join(methods)} (kind {kind!r})")
    return _made(methods[name], values)


def method_of_class(class_name: str, values: Mapping[str, Any]) -> Method:
    """The method whose class has this name, as `metadata.json` tells it. Raises `InputError`."""
    classes = {cls.__name__: cls for methods in METHODS_OF.values() for cls in methods.values()}
    if class_name not in classes:
        raise InputError(f"the method is {class_name!r}, expected one of: {', '.join(classes)}")
    return _made(classes[class_name], values)


def nearest(word: str, known: list[str]) -> str:
    """What to say of a word that is not known."""
    near = difflib.get_close_matches(word, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"expected one of: {', '.join(known)}"


def _made(cls: type[Method], values: Mapping[str, Any]) -> Method:
    known = [field.name for field in fields(cls)]
    for key in values:
        if key not in known:
            raise InputError(f"{key}: {cls.__name__} has no such parameter, {nearest(key, known)}")
    return cls(**{key: as_tuples(value) for key, value in values.items()})


def as_tuples(value: Any) -> Any:
    """Lists within lists as tuples: JSON and TOML know nothing else."""
    return tuple(as_tuples(v) for v in value) if isinstance(value, list | tuple) else value
