"""What `--help` says of `--set`: every parameter with its default, its unit and what it is, from the docstrings."""

from __future__ import annotations

import inspect
import json
import re
import textwrap
from collections.abc import Iterator
from dataclasses import MISSING, fields
from typing import Any

from pytracker.methods.method import Method
from pytracker.methods.registry import METHODS_OF

__all__ = ["of_methods", "of_scene"]

WRAP = textwrap.TextWrapper(76, initial_indent=6 * " ", subsequent_indent=6 * " ", break_on_hyphens=False)
ATTRIBUTE = re.compile(r"^    (\w+): ")


def of_methods() -> str:
    """Parameters of all methods, by the methods that have them."""
    sections = []
    for kind, methods in METHODS_OF.items():
        for cls in _ancestors(methods.values()):
            names = [name for name, method in methods.items() if issubclass(method, cls)]
            of = "every method" if len(names) == len(methods) else ", ".join(names)
            sections.append(_section(f"Parameters of {kind}, {of}", cls, [methods[name] for name in names]))
    return "\n\n".join(section for section in sections if section)


def of_scene(cls: type[Any]) -> str:
    """Parameters of a scene to simulate."""
    return _section("Parameters", cls, [cls])


def _ancestors(methods: Any) -> Iterator[type[Method]]:
    """Every class that methods of a kind are made of, the common ones first, each once."""
    seen: set[type] = {Method, object}
    for method in methods:
        for cls in reversed(method.__mro__):
            if cls not in seen:
                seen.add(cls)
                yield cls


def _section(title: str, cls: type[Any], of: list[type[Any]]) -> str:
    """Parameters that the class adds, and those of its ancestors that it sets otherwise; empty without any.

    A default that none of the classes `of` it keeps is not shown.
    """
    words = dict(_attributes(cls))
    own = inspect.get_annotations(cls)
    lines = []
    for field in fields(cls):
        if field.name in own and field.default is not MISSING:
            kept = any(getattr(leaf, field.name) == field.default for leaf in of)
            lines.append(f"  {field.name}={_as_typed(field.default) if kept else '...'}")
            lines += WRAP.wrap(words.get(field.name, ""))
    # The mark keeps the lines as they are.
    return "\n".join(["\b", f"{title} (--set):", *lines]) if lines else ""


def _attributes(cls: type[Any]) -> Iterator[tuple[str, str]]:
    """The entries below `Attributes:` of the class's own docstring."""
    _, found, below = inspect.cleandoc(cls.__dict__.get("__doc__") or "").partition("Attributes:\n")
    name, words = "", ""
    for line in below.splitlines() if found else ():
        entry = ATTRIBUTE.match(line)
        if entry:
            if name:
                yield name, words
            name, words = entry[1], line[entry.end() :]
        else:
            words += " " + line.strip()
    if name:
        yield name, words


def _as_typed(value: Any) -> str:
    """A default as `--set` takes it."""
    return value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
