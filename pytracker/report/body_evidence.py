"""Pictures of the evidence of one frame: Li & Kulić's Figs. 3 and 4, as PNG bytes."""

from __future__ import annotations

import dataclasses
import io

import numpy as np
from matplotlib.image import imsave

from pytracker.evidence.senses import senses_of
from pytracker.evidence.silhouette import Silhouette
from pytracker.formats.video import Image, frames
from pytracker.tracking.body import BodyTrack

__all__ = ["evidence_pictures"]


def evidence_pictures(track: BodyTrack, index: int) -> tuple[Image, bytes, bytes]:
    """Frame `index`; foreground in grey and in colour (Fig. 3); edges and skin (Fig. 4)."""
    view = track.recording.view
    assert view.video is not None
    image = next(frame.image for frame in frames(view.video) if frame.index == index)
    extract = senses_of(track.recording).silhouette
    assert extract is not None
    grey = Silhouette(
        extract.background, extract.px2_per_m2**0.5, dataclasses.replace(extract.parameters, colour=False)
    )
    found, in_grey = extract(image), grey(image)
    return (
        image,
        _side_by_side(image, in_grey.foreground, found.foreground),
        _side_by_side(image, found.edges, found.skin),
    )


def _side_by_side(image: Image, *masks: Image) -> bytes:
    """The frame and two masks, a thin white line between them."""
    line = np.full((image.shape[0], 4, 3), 255, np.uint8)
    parts = [image]
    for mask in masks:
        parts += [line, np.repeat(mask[..., None], 3, axis=2)]
    out = io.BytesIO()
    imsave(out, np.hstack(parts)[..., ::-1], format="png")
    return out.getvalue()
