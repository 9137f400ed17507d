"""Whether a person is as tall in the foreground as at first: who comes nearer leaves the model behind.

What `trunk` asks of keypoints, of a video alone: from the crown above the tracked head down to the feet. Arms that are
raised do not count; feet that the picture cuts off tell nothing.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytracker.evidence.pose.borne_out import COLUMN_M, CROWN_M
from pytracker.evidence.pose.lately import AtFirst, Lately, median_of_known
from pytracker.evidence.pose.trunk import NEARER
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array
from pytracker.series import runs

__all__ = ["StatureSeen"]

RIM_PX = 2
"""A foreground that ends so near the rim of the picture goes on beyond it."""
FARTHER = "bends, squats or goes farther off than is tracked"
FARTHER_OR_HELD = f"{FARTHER}, or the background, a median, holds a part of the person: give one without"
ASIDE_M = 0.6
"""Feet are no farther to the side of the head: what differs from the background there is something else."""
ABOVE_M, BELOW_M = 0.15, 0.3
"""Hair of the wall's colour parts a person, and legs of the floor's; what is farther off is a thing above or behind."""
TALLER = 1.10
SHORTER = 0.82
"""Of people who stand where they are it is 0.90 to 1.05 times as tall as at first."""


class StatureSeen:
    """How tall the foreground shows a person, against the pose.

    Args:
        camera: what sees it.
        first: ends of all bones in the first pose `(B, 3)`, world, m.
        head: end of the head there `(3,)`.
        is_median: whether the background is the video's median, which may hold a part of the person.
    """

    def __init__(self, camera: Camera | WeakPerspective, first: Array, head: Array, *, is_median: bool = False) -> None:
        self._farther = FARTHER_OR_HELD if is_median else FARTHER
        self._camera = camera
        lowest, top = float(camera.project(first)[:, 1].max()), float(camera.project(head[None])[0, 1])
        self._model_m = (lowest - top) / float(camera.px_per_m(head[None])[0]) + CROWN_M
        self._lately, self._first = Lately(), AtFirst()

    def look(self, time_s: float, joints: Mapping[str, Array], foreground: Image | None) -> str:
        """Take a frame's mean joints, `(3,)` each, world, m, and its foreground `(H, W)`, 255 where the person is.

        None where that is no person, as where the light has changed. What lately speaks against it, in words; empty
        where nothing does, and where feet were not seen at first.
        A background that holds a part of the person shows them shorter than the model at first: they are nearer where
        they are taller than that.
        """
        row = np.array([np.nan if foreground is None else self._tall(joints, foreground)])
        self._first.take(time_s, row)
        (tall_m,), (first_m,) = median_of_known(self._lately.take(time_s, row)), self._first.median
        held = self._model_m / first_m
        if tall_m / first_m > TALLER * (held if held > TALLER else 1.0):
            return NEARER
        return self._farther if tall_m / first_m < SHORTER else ""

    def _tall(self, joints: Mapping[str, Array], foreground: Image) -> float:
        """From crown to feet, m as of the tracked distance; NaN where either is not seen."""
        (u, v), px_per_m = self._camera.project(joints["head"][None])[0], self._camera.px_per_m(joints["root"][None])[0]
        if not np.isfinite([u, v, px_per_m]).all() or px_per_m <= 0.0:
            return float("nan")
        (crown, _), (_, feet) = (
            _piece_of(foreground[:, max(0, round(u - m * px_per_m)) : max(0, round(u + m * px_per_m) + 1)], v, gap)
            for m, gap in ((COLUMN_M, ABOVE_M * px_per_m), (ASIDE_M, BELOW_M * px_per_m))
        )
        if crown < RIM_PX or feet >= len(foreground) - RIM_PX:
            return float("nan")
        return float((feet - crown) / px_per_m) if feet > crown else float("nan")


def _piece_of(columns: Image, v: float, gap_px: float) -> tuple[int, int]:
    """First and last row of what differs from the background about row `v`, over such gaps; outside if none."""
    pieces: list[tuple[int, int]] = []
    for begins, after in runs(columns.any(axis=1)):
        goes_on = bool(pieces) and begins - pieces[-1][1] < gap_px
        pieces.append((pieces.pop()[0] if goes_on else begins, after))
    first, after = min(pieces, key=lambda piece: max(piece[0] - v, v - piece[1] + 1, 0.0), default=(-1, len(columns)))
    return first, after - 1
