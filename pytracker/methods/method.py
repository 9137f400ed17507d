"""What all methods share: a kind of recording, a name, parameters of the right kind."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, ClassVar, TypeVar

from pytracker._core import InputError

__all__ = ["Method"]

OfMethod = TypeVar("OfMethod", bound="Method")


def _unlike(value: Any, default: Any) -> str:
    """What was expected where `value` is not of the kind of `default`; empty where it is."""
    if isinstance(default, bool) or isinstance(value, bool):
        return "" if isinstance(value, bool) and isinstance(default, bool) else _kind(default)
    if isinstance(default, int):
        return "" if isinstance(value, Integral) and 0 <= int(value) < 2**63 else _kind(default)
    if isinstance(default, float):
        return "" if isinstance(value, Real) else _kind(default)
    if isinstance(default, str):
        return "" if isinstance(value, str) else "a word"
    if default and isinstance(default[0], tuple):
        alike = isinstance(value, tuple | list) and all(_is_like(layer, default[0]) for layer in value)
        return "" if alike else f"layers such as {default!r}"
    return "" if _is_words(value) else 'words such as ("colour", "arm_length")'


def _is_like(value: Any, like: Any) -> bool:
    """Whether a part of a layer is built as another; of words there may be any number."""
    if not isinstance(like, tuple):
        return not _unlike(value, like)
    if _is_words(like):
        return _is_words(value)
    return (
        isinstance(value, tuple | list)
        and len(value) == len(like)
        and all(_is_like(part, other) for part, other in zip(value, like, strict=True))
    )


def _kind(default: Any) -> str:
    return {bool: "true or false", int: "a whole number, 0 or more", float: "a number"}.get(
        type(default), "no truth value"
    )


def _is_words(value: Any) -> bool:
    return isinstance(value, tuple | list) and all(isinstance(word, str) for word in value)


@dataclass(frozen=True, kw_only=True)
class Method:
    """What all methods share: a kind of recording, a name, parameters of the right kind."""

    kind: ClassVar[str]

    def __post_init__(self) -> None:
        """Check that every number is one; ranges are checked where they are used, once."""
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            expected = _unlike(value, field.default)
            if expected:
                raise InputError(f"{type(self).__name__}.{field.name} is {value!r}, expected {expected}")

    @property
    def needs_picture(self) -> bool:
        """Whether it is of no use without a video, or what was found in one."""
        return True

    @property
    def needs_one_of(self) -> tuple[str, ...] | None:
        """Cues of which there must be one, of `Recording.points`; None where there is something else."""
        return None

    @property
    def sample_size(self) -> int | None:
        """How many particles it has; None where it has none."""
        return None

    def layers_in_words(self) -> list[tuple[str, str]]:
        """What moves the particles in each layer, and what weighs them. Raises `InputError` where there are none."""
        raise InputError(f"{type(self).__name__} has no particles, expected a particle method")

    @property
    def name(self) -> str:
        """The name that the command line knows it by."""
        return type(self).__name__.lower()

    def parameters(self) -> dict[str, Any]:
        """Every parameter by name."""
        return dataclasses.asdict(self)

    def known_by(self: OfMethod, spreads: Mapping[str, float]) -> OfMethod:
        """The same, with how well things are known where a recording says so; of others it says nothing here."""
        names = {field.name for field in dataclasses.fields(self)}
        return dataclasses.replace(self, **{name: sd for name, sd in spreads.items() if name in names})
