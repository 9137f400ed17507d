"""Trajectories of markers, whatever file they are of."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.rotation import Array
from pytracker.series import runs

__all__ = ["UNITS_M", "Markers", "check_times", "without_fillers"]

UNITS_M = {
    **dict.fromkeys(("mm", "millimeters", "millimetres"), 0.001),
    **dict.fromkeys(("cm", "centimeters", "centimetres"), 0.01),
    **dict.fromkeys(("m", "meters", "metres"), 1.0),
}
"""What files call their unit, in small letters."""
SLOWEST_S = 0.5
"""No cameras take fewer pictures."""
RATE_TOLERANCE = 0.05
FARTHEST_M = 9.0
"""No camera sees a person's marker farther off, along all three axes alike."""
JUMP_M = 0.05
"""Nothing goes farther from row to row."""


@dataclass(frozen=True, eq=False)
class Markers:
    """Trajectories of markers.

    Attributes:
        time_s: `(T,)`, increasing; the first frame at 0 where the file has no times.
        positions_m: by name, m `(T, 3)`; NaN where not seen.
        rate_hz: frames a second, as the file says; None where it does not.
        warnings: what is odd about the file.
    """

    time_s: Array
    positions_m: dict[str, Array]
    rate_hz: float | None
    warnings: tuple[str, ...] = ()

    @property
    def gaps(self) -> dict[str, int]:
        """How many frames each was not seen in."""
        return {name: int(np.isnan(points[:, 0]).sum()) for name, points in self.positions_m.items()}


def without_fillers(points: Array) -> Array:
    """Places `(T, 3)` without rows that say "not seen": (0, 0, 0), or one far number thrice such as -9999 mm.

    A joint may lie in the world's origin: zeros are places where the rows before or after them lead there.
    """
    far = np.abs(points[:, 0]) > FARTHEST_M
    is_filler = (points[:, :1] == points).all(axis=1) & (far | (points[:, 0] == 0))
    out = points.copy()
    for first, after in runs(is_filler):
        beside = [k for k in (first - 1, after) if 0 <= k < len(points)]
        steps = np.linalg.norm(points[beside] - points[first], axis=1)
        if far[first] or ((np.nan_to_num(steps, nan=np.inf) > JUMP_M).all() and beside):
            out[first:after] = np.nan
    return out


def check_times(path: Path, markers: Markers) -> tuple[str, ...]:
    """A word where the times are not at the rate that the file says. Raises `InputError` where they are no seconds."""
    steps = np.diff(markers.time_s)
    if not len(steps):
        return ()
    usual_s, mean_s = float(np.median(steps)), float(np.mean(steps))
    if usual_s > SLOWEST_S:
        counted = "are they frame numbers (then truth.rate_hz says their rate)?"
        unit = "micro" if usual_s > 1000 * SLOWEST_S else "milli"
        raise InputError(
            f"{path}: its frames are {usual_s:g} s apart, expected at most {SLOWEST_S} s: "
            + (counted if usual_s == 1.0 else f"are the times in {unit}seconds?")
        )
    # Rounded to milliseconds each step is off, and their mean is not; where frames are missing it is the other way.
    off = [abs(step_s * markers.rate_hz - 1.0) if markers.rate_hz else 0.0 for step_s in (usual_s, mean_s)]
    if min(off) <= RATE_TOLERANCE:
        return ()
    return (
        f"{path}: says {markers.rate_hz:g} Hz, and its times are at {1.0 / usual_s:.4g} Hz: the times are taken, from "
        f"{markers.time_s[0]:.3f} to {markers.time_s[-1]:.3f} s",
    )
