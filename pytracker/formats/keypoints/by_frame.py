"""Everybody by frame, as one log: joints in our order, people each in one place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import KEYPOINTS, InputError
from pytracker.formats.keypoints.log import Keypoints, are_shares, in_range, ours, require_seen
from pytracker.formats.keypoints.models import model_of, name_of
from pytracker.formats.keypoints.people import in_order
from pytracker.rotation import Array

__all__ = ["by_frame", "flat", "names_in_order"]

MOST_PEOPLE = 64
"""More people in a frame are noise."""


def flat(path: Path, values: Any) -> Array:
    """x, y, confidence of one person `(K, 3)`."""
    try:
        found = np.array(values, dtype=np.float64).reshape(-1, 3)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{path}: keypoints are {str(values)[:60]}, expected x, y and confidence of each") from None
    return in_range(path, found)


def names_in_order(said: Any, model: str) -> tuple[str, ...]:
    """Ours of the joints that a file names in order; none where it names none of ours, or the order is given."""
    if model != "auto" or not isinstance(said, list):
        return ()
    names = tuple(name_of(str(name)[:100]) for name in said)
    return names if {*KEYPOINTS, "nose"} & set(names) else ()


def by_frame(path: Path, rows: Mapping[int, Sequence[Array]], model: str, named: tuple[str, ...] = ()) -> Keypoints:
    """Frames in order, each person in one place, joints as ours: of a model, or as they are `named`.

    Raises `InputError` where nobody is seen, or not everybody has as many.
    """
    counts = {len(person) for people in rows.values() for person in people}
    if not counts:
        raise InputError(f"{path}: nobody is seen in any of {len(rows)} frames, expected keypoints of a person")
    if len(counts) > 1:
        raise InputError(f"{path}: people have {sorted(counts)} keypoints, expected the same of each")
    count = counts.pop()
    if named and len(named) != count:
        raise InputError(f"{path}: people have {count} keypoints, expected {len(named)} as it names joints")
    order = named or model_of(path, model, count, [person for people in rows.values() for person in people])
    frames = sorted(rows)
    people = min(MOST_PEOPLE, max(len(rows[frame]) for frame in frames))
    points = np.full((len(frames), people, len(KEYPOINTS), 3), np.nan)
    for row, frame in enumerate(frames):
        for p, person in enumerate(rows[frame][:people]):
            points[row, p] = ours(person, order)
    found = np.concatenate([person for people in rows.values() for person in people])
    seen = require_seen(path, in_order(points), found[:, 2])
    return Keypoints(np.array(frames), seen, is_share=are_shares(found[found[:, 2] > 0, :2]))
