"""Pictures of the evidence of one frame, as Li & Kulić's Figs. 3 and 4, as PNG bytes."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.image import imsave

from pytracker.formats.video import Image
from pytracker.tracking.body import BodyTrack

__all__ = ["evidence_pictures", "side_by_side"]


def evidence_pictures(track: BodyTrack) -> tuple[Image, bytes, bytes]:
    """A frame about the middle; beside it what the tracker saw there: foreground (Fig. 3), edges and skin (Fig. 4)."""
    shown = track.shown
    assert shown is not None
    image = shown.image
    return image, side_by_side(image, shown.foreground), side_by_side(image, shown.edges, shown.skin)


def side_by_side(image: Image, *masks: Image) -> bytes:
    """The frame and masks, as large as it, a thin white line between them."""
    line = np.full((image.shape[0], 4, 3), 255, np.uint8)
    parts = [image]
    for mask in masks:
        rows, columns = (np.arange(n) * of // n for n, of in zip(image.shape, mask.shape, strict=False))
        parts += [line, np.repeat(mask[np.ix_(rows, columns)][..., None], 3, axis=2)]
    out = io.BytesIO()
    imsave(out, np.hstack(parts)[..., ::-1], format="png")
    return out.getvalue()
