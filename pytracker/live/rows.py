"""Estimates as rows of a table, one a frame, as they come: named as in `track.csv`."""

from __future__ import annotations

import csv
from typing import Any, TextIO

from pytracker.live.following import Estimated
from pytracker.tracking.tracks import QUANTITIES

__all__ = ["Rows"]


class Rows:
    """Writes estimates to `file`, each at once.

    `time_s, frame`, then of every joint and axis `<joint>_<axis>_m`, `_sd_m`, `_lo_m`, `_hi_m` (95 % band), of a body
    `<joint>_valid`, then `valid, reason`. Times are seconds since the beginning; frames are numbered as the camera
    gives them, those that were left out too.
    """

    def __init__(self, file: TextIO) -> None:
        self._file, self._writer = file, csv.writer(file, lineterminator="\n")
        self._has_header = False

    def write(self, found: Estimated) -> None:
        """A row."""
        names: list[str] = ["time_s", "frame"]
        cells: list[Any] = [f"{found.estimate.time_s:.6f}", found.frame]
        for joint, place in found.estimate.places.items():
            for suffix, quantity in QUANTITIES:
                for axis, value in zip("xyz", getattr(place, quantity), strict=True):
                    names.append(f"{joint}_{axis}{suffix}_m")
                    cells.append(f"{value:.6f}")
            if joint in found.words:
                names.append(f"{joint}_valid")
                cells.append(int(not (found.words[joint] or found.words[""])))
        if not self._has_header:
            self._writer.writerow([*names, "valid", "reason"])
            self._has_header = True
        self._writer.writerow([*cells, int(not found.reason), found.reason])
        self._file.flush()
