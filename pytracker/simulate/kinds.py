"""Whether a scene's parameter is of the kind that it should be: a number, a word, pairs of times."""

from __future__ import annotations

import numpy as np

from pytracker._core import InputError

__all__ = ["check_kind"]


def check_kind(name: str, value: object, default: object) -> None:
    """`value` must be of the kind of its default; numbers must be finite. Raises `InputError`."""
    if isinstance(default, bool):
        ok, expected = isinstance(value, bool), "true or false"
    elif isinstance(default, int):
        ok, expected = isinstance(value, int) and not isinstance(value, bool), "a whole number"
    elif isinstance(default, float):
        ok, expected = _is_number(value), "a finite number"
    elif isinstance(default, str):
        ok, expected = isinstance(value, str), "a word"
    elif name in ("occlusions", "hidden"):
        ok = isinstance(value, tuple) and all(
            isinstance(pair, tuple) and len(pair) == 2 and all(map(_is_number, pair)) for pair in value
        )
        expected = "pairs (from, to) in s"
    elif name in ("imus", "senses"):
        ok, expected = isinstance(value, tuple) and all(isinstance(word, str) for word in value), "names in a tuple"
    else:
        ok, expected = (
            isinstance(value, tuple) and len(value) == 3 and all(map(_is_number, value)),
            "three finite numbers",
        )
    if not ok:
        raise InputError(f"{name} is {value!r}, expected {expected}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))
