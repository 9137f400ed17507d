"""What of a patch's colour stands where it is: a mug, a poster, the other arm's patch on a table.

When the patch passes it both are one piece, and Camshift may stay with it. While the patch is followed, pixels
elsewhere that keep its colour are learned; what was learned is no patch any more. Under the patch nothing is learned: a
patch that rests stays what it is, and what patch or arm hide for a while stays known.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.patch.colour import Box
from pytracker.formats.video import Image
from pytracker.rotation import Array

__all__ = ["Standing", "in_one_piece"]

EVERY = 5
"""Frames between two looks."""
LEARNS = 0.2
"""A look counts for so much: what comes to stand is known after some four,"""
KEEPS = 0.99
"""what is not seen there any more forgotten after some seventy: an arm lies before it for seconds."""
STANDS = 0.5
COVERED = 0.1
"""A patch that has so much of its box in common with what stands is seen in part, or together with it."""


def in_one_piece(is_coloured: Image, rows: tuple[slice, slice]) -> NDArray[np.bool_]:
    """What of it `(H, W)` is in one piece with something of it in a box: its rows and columns."""
    _, labels = cv2.connectedComponents(is_coloured)
    pieces = np.unique(np.asarray(labels)[rows])
    return np.isin(labels, pieces[pieces > 0])


class Standing:
    """Learned from the places of the colour, in a picture that is so many `times` smaller than the frames.

    `is_coloured`, 0 or more `(H, W)`, is that of the first frame, in which the patch is what is in one piece with some
    of `box` of the frame.
    """

    def __init__(self, is_coloured: Image, box: Box, times: int) -> None:
        self._times = times
        self._lately = (is_coloured > 0).astype(np.float32)
        self._lately[in_one_piece(is_coloured, self._rows(box))] = 0.0
        self._share = self._lately.copy()
        self._frames = 0
        self._decide()

    def learn(self, is_coloured: Image, box: Box) -> None:
        """From the next frame, with the patch in `box` of it; a look now and then is enough."""
        self._frames += 1
        if self._frames % EVERY:
            return
        patch = self._rows(box)
        kept = self._lately[patch].copy(), self._share[patch].copy()
        cv2.accumulateWeighted((is_coloured > 0).astype(np.float32), self._lately, LEARNS)
        np.maximum(self._lately, KEEPS * self._share, out=self._share)
        self._lately[patch], self._share[patch] = kept
        self._decide()

    def without(self, back: Image, at: tuple[int, int] = (0, 0)) -> Image:
        """A back-projection, which begins at `at` of the frame, without what stands."""
        if not self._any:
            return back
        stands = self._of(back.shape[:2], at)
        return np.where(stands, np.uint8(0), back)

    def is_at(self, centre: Array) -> bool:
        """Whether something stands at a pixel (u, v) of the frame."""
        u, v = (round(float(value)) for value in centre)
        return self._any and bool(self._is[self._rows((u, v, 1, 1))].all())

    def is_covered(self, box: Box) -> bool:
        """Whether a patch in `box` of the frame has some of it in common with what stands."""
        return self._any and bool(self._is[self._rows(box)].mean() > COVERED)

    def _decide(self) -> None:
        stands = (self._share > STANDS).astype(np.uint8)
        self._any = bool(stands.any())
        # With its rim, whose colour comes and goes.
        self._is: NDArray[np.bool_] = cv2.dilate(stands, np.ones((3, 3), np.uint8)) > 0

    def _rows(self, box: Box) -> tuple[slice, slice]:
        """Rows and columns of the smaller picture that a box of the frame lies in, at least one of either."""
        x, y, w, h = box
        height, width = self._lately.shape

        def span(first: int, length: int, size: int) -> slice:
            low = min(max(first // self._times, 0), size - 1)
            return slice(low, max(low + 1, min(-(-(first + length) // self._times), size)))

        return span(y, h, height), span(x, w, width)

    def _of(self, shape: tuple[int, ...], at: tuple[int, int]) -> NDArray[np.bool_]:
        """Whether each pixel of such a part of the frame shows what stands."""
        places = []
        for axis, size in enumerate(self._is.shape):
            pixel = at[1 - axis] + np.arange(shape[axis])
            places.append(np.minimum(pixel // self._times, size - 1))
        stands: NDArray[np.bool_] = self._is[places[0][:, None], places[1]]
        return stands
