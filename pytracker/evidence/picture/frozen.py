"""Frames in which the picture hung: it shows for a while what was before, and then something else at once.

Who holds still trembles as a camera's noise does, and begins to move little by little; a picture that hangs is still,
but for what coding makes of it, and ends in a leap.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.formats.video import Image
from pytracker.series import runs

__all__ = ["HANGS", "HUNG", "Frozen"]

HUNG = "the picture hung: what follows is elsewhere at once"
HANGS = "the picture hangs: it has not changed at all for a second"
LONGER_PX = 128
"""Of the pictures that are compared: noise and blocks are averaged."""
NOTHING = 0.02
"""Grey levels, squared: no change at all, of frames that repeat the one before. They are not usual, however many."""
STILL, LEAPS = 0.5, 15.0
"""Times the usual change from frame to frame (its mean square). Of 31 videos of people, each also at a third and a
sixth of its frames, none that holds still ends in 12; of seven that were made to hang for 0.4 to 2 s, coded in three
ways, 186 of 189 are found by that."""
CODED_ANEW = 2
"""A picture that is coded by itself changes a little, and so may the one after it: so many frames are no end."""
LIGHT, EVERYWHERE, ONE_WAY = 2.0, 0.5, 0.8
"""Where so much of the picture changes by so many grey levels, and nearly all one way, it is the light that did."""
LEAST_S, LEAST_FRAMES = 0.3, 5
"""A shorter one does no harm."""
SURE_S = 1.0
"""So long no camera and no coder gives the very same, of a person."""


def _is_light(by: NDArray[np.float32]) -> bool:
    """Whether the light is what changed a picture by so many grey levels `(H, W)`."""
    one_way = abs(float(np.mean(by))) > ONE_WAY * float(np.mean(np.abs(by)))
    everywhere = float(np.mean(np.abs(by) > LIGHT)) > EVERYWHERE
    return one_way and everywhere


class Frozen:
    """How much pictures change, frame by frame."""

    def __init__(self) -> None:
        self._before: NDArray[np.float32] | None = None
        self._time_s: list[float] = []
        self._changes: list[float] = []
        self._is_light: list[bool] = []

    def look(self, time_s: float, image: Image) -> None:
        """Take a frame, BGR `(H, W, 3)`."""
        scale = min(1.0, LONGER_PX / max(image.shape[:2]))
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32)
        small = np.asarray(cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), dtype=np.float32)
        by = None if self._before is None else small - self._before
        changed = np.nan if by is None else np.mean(np.square(by))
        self._before = small
        self._time_s.append(time_s)
        self._changes.append(float(changed))
        self._is_light.append(by is not None and _is_light(by))

    def hangs(self) -> bool:
        """Whether the last frame and all for a second before it are the very same."""
        same = 0
        while same < len(self._changes) and self._changes[-1 - same] <= NOTHING:
            same += 1
        return same >= LEAST_FRAMES and self._time_s[-1] - self._time_s[-1 - same] >= SURE_S

    def hung(self) -> NDArray[np.bool_]:
        """Which of the frames `(T,)` show what was before, though it had gone on; not the first of them."""
        found = np.zeros(len(self._changes), dtype=bool)
        if len(found) < LEAST_FRAMES:
            return found
        changes = np.array(self._changes)
        if not (changes > NOTHING).any():
            return found
        times_usual = changes / np.median(changes[changes > NOTHING])
        still = times_usual < STILL
        for first, after in runs(~still):
            if after - first <= CODED_ANEW and first > 0 and after < len(still):
                still[first:after] = times_usual[first:after].max() < LEAPS
        for first, after in runs(still):
            is_long = after - first >= LEAST_FRAMES and self._time_s[after - 1] - self._time_s[first - 1] >= LEAST_S
            # Who stood still before the light went on trembled; of what is the very same any leap is an end.
            is_same = float(np.median(changes[first:after])) <= NOTHING
            ends = slice(after, after + CODED_ANEW)
            leaps = (times_usual[ends] > LEAPS) & (is_same | ~np.array(self._is_light[ends], dtype=bool))
            if is_long and leaps.any():
                found[first:after] = True
        return found
