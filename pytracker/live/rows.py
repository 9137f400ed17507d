"""Estimates as rows of a table, one a frame, as they come: named as in `track.csv`."""

from __future__ import annotations

import csv
from typing import Any, TextIO

from pytracker._core import Estimate

__all__ = ["Rows"]

QUANTITIES = (("", "mean"), ("_sd", "sd"), ("_lo", "lo"), ("_hi", "hi"))


class Rows:
    """Writes estimates to `file`, each at once.

    `time_s`, then of every joint and axis `<joint>_<axis>_m`, `_sd_m`, `_lo_m`, `_hi_m` (95 % band), then
    `valid, reason`. Times are seconds since the beginning.
    """

    def __init__(self, file: TextIO) -> None:
        self._file, self._writer = file, csv.writer(file, lineterminator="\n")
        self._has_header = False

    def write(self, estimate: Estimate, reason: str) -> None:
        """A row; `reason` says what speaks against it."""
        names: list[str] = ["time_s"]
        cells: list[Any] = [f"{estimate.time_s:.6f}"]
        for joint, place in estimate.places.items():
            for suffix, quantity in QUANTITIES:
                for axis, value in zip("xyz", getattr(place, quantity), strict=True):
                    names.append(f"{joint}_{axis}{suffix}_m")
                    cells.append(f"{value:.6f}")
        if not self._has_header:
            self._writer.writerow([*names, "valid", "reason"])
            self._has_header = True
        self._writer.writerow([*cells, int(not reason), reason])
        self._file.flush()
