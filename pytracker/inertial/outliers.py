"""Single readings that no sensor can have given: left out and said. Many of them are an error, not noise.

A sample is an outlier where a number is none, where it lies beyond what sensors read, where a quaternion has no unit
length, or where it jumps away from both its neighbours, which agree with each other, by far more than its
surroundings change.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.inertial.log import ImuLog
from pytracker.rotation import without_leaps

__all__ = ["without_outliers"]

Float = NDArray[np.float64]

MOST = {"acc": (2000.0, "m/s²"), "gyr": (70.0, "rad/s")}
"""Beyond the range of any worn sensor: 200 g, 4000°/s."""
JUMP = {"acc": 15.0, "gyr": 4.0, "q_world_sensor": 0.15}
"""A jump is no less: m/s², rad/s; and of a quaternion's numbers."""
TIMES_USUAL = 12.0
"""And no less than so many times what its surroundings change from sample to sample."""
AROUND = 12
"""Samples on either side that are its surroundings."""
RETURNS = 0.35
"""Its neighbours differ by no more than this share of the jump."""
NORM_TOLERANCE = 0.02
FARTHEST = 1e6
"""What is larger is as large: squares stay numbers."""
FEW_SHARE = 0.01
"""This share of the samples may be single faults; more are a fault of the file."""
DEGREES = ": is gyr in degrees per second?"
NAMES = {"acc": "acceleration", "gyr": "turn rate", "q_world_sensor": "orientation"}


def without_outliers(log: ImuLog) -> ImuLog:
    """The log without samples that are outliers, each cause with a warning.

    Raises `InputError` where there are many.
    """
    bad, first = np.zeros(len(log.time_s), dtype=bool), ""
    for faulty, words in (_no_numbers(log), *_beyond(log), _not_unit(log), *_jumps(log)):
        if faulty.any() and not first:
            first = words
        bad |= faulty
    if not bad.any():
        return log
    count = int(bad.sum())
    if count > FEW_SHARE * len(bad):
        if first.endswith(DEGREES):  # the orientation, or gravity, tells more
            return log
        raise InputError(f"{first} ({count} of {len(bad)} samples)")
    warning = f"{first}; {count} of {len(bad)} samples are such and are left out"
    return dataclasses.replace(log.kept(~bad), warnings=(*log.warnings, warning))


def _no_numbers(log: ImuLog) -> tuple[NDArray[np.bool_], str]:
    faulty, words = np.zeros(len(log.time_s), dtype=bool), ""
    for name in ("acc", "gyr", "q_world_sensor"):
        values = getattr(log, name)
        if values is None:
            continue
        bad = ~np.isfinite(values).all(axis=1)
        if bad.any() and not words:
            k = int(np.argmax(bad))
            words = f"{log.path}:{log.lines[k]}: {name} is {values[k].tolist()}, expected finite numbers"
        faulty |= bad
    return faulty, words


def _beyond(log: ImuLog) -> list[tuple[NDArray[np.bool_], str]]:
    found = []
    for name, (most, unit) in MOST.items():
        values = getattr(log, name)
        if values is None:
            continue
        with np.errstate(invalid="ignore"):
            size = np.abs(values).max(axis=1)
            bad = size > most
        if bad.any():
            k = int(np.argmax(bad))
            hint = DEGREES if name == "gyr" else ""
            words = (
                f"{log.path}:{log.lines[k]}: the {NAMES[name]} is {size[k]:.6g}, expected at most {most:g} {unit}{hint}"
            )
            found.append((bad, words))
    return found


def _not_unit(log: ImuLog) -> tuple[NDArray[np.bool_], str]:
    if log.q_world_sensor is None:
        return np.zeros(len(log.time_s), dtype=bool), ""
    norm = np.linalg.norm(np.clip(log.q_world_sensor, -FARTHEST, FARTHEST), axis=1)
    with np.errstate(invalid="ignore"):
        bad = np.abs(norm - 1) > NORM_TOLERANCE
    k = int(np.argmax(bad))
    return bad, f"{log.path}:{log.lines[k]}: quaternion has norm {norm[k]:.4f}, expected 1 ± {NORM_TOLERANCE}"


def _jumps(log: ImuLog) -> list[tuple[NDArray[np.bool_], str]]:
    found = []
    for name, least in JUMP.items():
        values = getattr(log, name)
        if values is None or len(values) < 5 or not np.isfinite(values).all():
            continue
        values = np.clip(values, -FARTHEST, FARTHEST)
        if name == "q_world_sensor":
            values = without_leaps(values)
        bad, size = _jumping(values, least)
        if bad.any():
            k = int(np.argmax(bad))
            words = (
                f"{log.path}:{log.lines[k]}: the {NAMES[name]} {np.round(getattr(log, name)[k], 4).tolist()} is "
                f"{size[k]:.3g} from the samples before and after it, which agree, expected it near them"
            )
            found.append((bad, words))
    return found


def _jumping(values: Float, least: float) -> tuple[NDArray[np.bool_], Float]:
    """Which samples jump to and back `(M,)`, and by how much `(M,)`."""
    step = np.linalg.norm(np.diff(values, axis=0), axis=1)
    size, apart = np.zeros(len(values)), np.full(len(values), np.inf)
    size[1:-1] = np.minimum(step[:-1], step[1:])
    apart[1:-1] = np.linalg.norm(values[2:] - values[:-2], axis=1)
    # At the ends there is one neighbour; the two after it stand for the other.
    for end, a, b in ((0, 1, 2), (-1, -2, -3)):
        size[end] = np.linalg.norm(values[end] - values[a])
        apart[end] = np.linalg.norm(values[a] - values[b])
    candidates = np.flatnonzero((size > least) & (apart < RETURNS * size))
    bad = np.zeros(len(values), dtype=bool)
    for k in candidates:
        low, high = max(0, k - AROUND), min(len(step), k + AROUND)
        usual = np.median(step[low:high])
        bad[k] = size[k] > TIMES_USUAL * usual
    return bad, size
