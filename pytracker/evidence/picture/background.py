"""The scene without the person: as it was filmed, or the median of the video, without what it holds of them.

Who stands still is in the median. Where they are in the first frame is known by the first pose: GrabCut (Rother et al.
2004) finds their pixels about it, and by the colours of both which pixels of the median are theirs too. What is behind
them nobody saw: it is filled in from around.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.evidence.picture.left_behind import draw, left_behind
from pytracker.evidence.picture.thresholds import SilhouetteParameters
from pytracker.formats.video import Frame, Image, as_image, frames
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["median_background", "median_of", "read_background", "sampled", "without_person"]

MEDIAN_FRAMES = 61
"""Frames, evenly chosen, that a median background is made of."""
WIDTHS_M = ((0.45, cv2.GC_PR_BGD), (0.2, cv2.GC_PR_FGD), (0.04, cv2.GC_FGD))
"""About the bones of the first pose: how wide is what may be the person, is likely to be, and is."""
NEAR_M = 1.5
"""About the bones: what is farther away says nothing of the colours behind the person."""
REACH_M = 1.5
"""So far about the bones what moves is taken for theirs."""
RIM_M = 0.08
"""The person's rim, of mixed pixels, hair and clothes: what is filled in must begin outside it."""
ROUNDS = 4
INPAINT_PX = 3.0

Mask = NDArray[np.bool_]


def sampled(source: Iterable[Frame], wanted: int = MEDIAN_FRAMES) -> list[Image]:
    """Evenly chosen frames, up to twice as many as are wanted. Raises `InputError` where there is none."""
    kept: list[Image] = []
    step = 1
    for frame in source:
        if frame.index % step == 0:
            kept.append(frame.image.copy())
        if len(kept) >= 2 * wanted:
            # A clip of unknown length: keep every second one, and take half as many from here on.
            kept, step = kept[::2], 2 * step
    if not kept:
        raise InputError("median_background was given no frame, expected at least one")
    return kept


def median_of(samples: list[Image]) -> Image:
    """Pixel by pixel `(H, W, 3)`."""
    return np.asarray(np.median(np.stack(samples), axis=0), dtype=np.uint8)


def median_background(source: Iterable[Frame], wanted: int = MEDIAN_FRAMES) -> Image:
    """The median of evenly chosen frames `(H, W, 3)`: the background, where the person moves enough."""
    return median_of(sampled(source, wanted))


def read_background(path: Path) -> Image:
    """An image, or the median of a clip. Raises `InputError`."""
    return median_background(frames(path))


def without_person(
    samples: list[Image], first: Image, camera: Camera | WeakPerspective, bones: Array, hands: Mask
) -> Image:
    """The median of a video's `samples` `(H, W, 3)`, filled in where it holds the person who is in its first frame.

    `bones` `(B, 2, 3)` are the ends of theirs there, world, m; `hands` `(2, B)` says which of them are either forearm
    with its hand. As it is where they are not in the picture.
    """
    median = median_of(samples)
    px_per_m = float(camera.px_per_m(bones[:1, 0])[0])
    if not np.isfinite(px_per_m) or px_per_m <= 0.0:
        return median
    about = np.full(first.shape[:2], cv2.GC_BGD, np.uint8)
    for width_m, label in WIDTHS_M:
        draw(about, camera, bones, width_m, label)
    near = _near(camera, bones, first)
    if not (about[near] == cv2.GC_FGD).any() or not (about[near] == cv2.GC_BGD).any():
        return median
    behind, person = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.setRNGSeed(0)
    cv2.grabCut(first[near], about[near], (0, 0, 1, 1), behind, person, ROUNDS, cv2.GC_INIT_WITH_MASK)
    rim = np.ones((2 * max(2, round(RIM_M * px_per_m)) + 1,) * 2, np.uint8)
    at_first = _widened(_is_person(about), rim)
    differs = cv2.absdiff(cv2.blur(first, (3, 3)), cv2.blur(median, (3, 3))).max(axis=2)
    came = (differs >= SilhouetteParameters().foreground_level) & _within(camera, bones, first)
    about = np.where(at_first | came, cv2.GC_PR_FGD, cv2.GC_BGD).astype(np.uint8)
    cv2.grabCut(median, about, (0, 0, 1, 1), behind, person, 1, cv2.GC_EVAL_FREEZE_MODEL)
    stays = left_behind(samples, first, at_first, camera, bones, hands)
    held = _widened(_is_person(about) & ~stays, rim) & ~stays
    # Where they came later, and stayed, the first frame shows what is behind them.
    out = np.where((held & ~at_first)[..., None], first, median)
    return as_image(cv2.inpaint(out, (held & at_first).astype(np.uint8), INPAINT_PX, cv2.INPAINT_TELEA))


def _near(camera: Camera | WeakPerspective, bones: Array, image: Image) -> tuple[slice, slice]:
    """Rows and columns about the person, whose colours are those of what is behind them: a door's are not."""
    mask = np.zeros(image.shape[:2], np.uint8)
    draw(mask, camera, bones, NEAR_M, 1)
    left, top, width, height = cv2.boundingRect(mask)
    return slice(top, top + height), slice(left, left + width)


def _within(camera: Camera | WeakPerspective, bones: Array, image: Image) -> Mask:
    mask = np.zeros(image.shape[:2], np.uint8)
    draw(mask, camera, bones, REACH_M, 1)
    return np.asarray(mask > 0)


def _is_person(labels: Image) -> Mask:
    return np.asarray((labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD))


def _widened(mask: Mask, rim: Image) -> Mask:
    return np.asarray(cv2.dilate(mask.astype(np.uint8), rim) > 0)
