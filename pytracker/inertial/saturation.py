"""A sensor whose range is too small for the movement: it stands at its end for some samples, and the rest is lost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker.inertial.log import ImuLog
from pytracker.series import runs

__all__ = ["saturates"]

STANDS = 3
"""So many samples on end at the largest value that an axis has are no peak."""
LEAST = {"acceleration": (18.0, "m/s²"), "turn rate": (4.0, "rad/s")}
"""Smaller values may stand because nothing moves."""
SMALLEST, NEAR = np.radians(125.0), 0.01
"""A range of gyroscopes that is smaller, rad/s, and what is as large but for its scale."""
SAME = 1e-6


def saturates(log: ImuLog) -> list[str]:
    """A word on every axis that does."""
    measured = (("acceleration", log.acc), ("turn rate", log.gyr))
    return [words for what, values in measured if values is not None for words in _of(log, what, values)]


def _of(log: ImuLog, what: str, values: NDArray[np.float64]) -> list[str]:
    least, unit = LEAST[what]
    found = []
    for axis, of_axis in zip("xyz", values.T, strict=True):
        for end in (np.nanmax(of_axis), np.nanmin(of_axis)):
            standing = runs(np.abs(of_axis - end) <= SAME * abs(end), STANDS)
            is_range = what == "turn rate" and abs(abs(end) / SMALLEST - 1.0) < NEAR
            if (abs(end) < least and not is_range) or not standing:
                continue
            lengths = [after - first for first, after in standing]
            found.append(
                f"{log.path}:{log.lines[standing[0][0]]}: the {what} along {axis} stands at {end:.4g} {unit} for "
                f"{max(lengths)} samples, {sum(lengths)} in all, expected a sensor whose range "
                "holds the movement: what was beyond it is lost"
            )
    return found
