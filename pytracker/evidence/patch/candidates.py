"""Coloured things that move in a video: one of them is the patch.

Each band of hues is looked at by itself: its largest connected piece must be there in most frames, keep its size, and
move; what passes and is much larger is not it. Which of them is the patch is told by what moves with the IMU
(`pytracker.evidence.patch.lag`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pytracker.formats.video import Image, as_image, frames
from pytracker.rotation import Array

__all__ = ["Candidate", "find_candidates"]

HUES = range(0, 180, 10)
"""Middles of the bands, in OpenCV's half degrees."""
HALF_BAND = 9
LEAST_SATURATION, LEAST_VALUE = 90, 50
MOST_FRAMES = 1500
LONG_SIDE_PX = 320
"""Larger pictures are looked at at this size."""
LEAST_AREA_PX, MOST_AREA_SHARE = 10, 0.04
SEEN_SHARE = 0.6
STEADY = 0.8
"""Standard deviation of the area as a share of its mean."""
ANOTHER = 4.0
"""A piece that is larger than the usual by so much is something else of that colour, which passes."""
MOVES_PX = 3.0
SAME_PX = 8.0


@dataclass(frozen=True, eq=False)
class Candidate:
    """A coloured thing that moves.

    Attributes:
        hue_deg: of its colour, 0 to 360.
        box: x, y, width, height in the first frame.
        time_s: of the frames that were looked at, by the video's clock `(T,)`.
        pixels: its centre `(T, 2)`, NaN where it was not seen.
        area_px: its median area.
    """

    hue_deg: float
    box: tuple[int, int, int, int]
    time_s: Array
    pixels: Array
    area_px: float


def find_candidates(video: Path) -> tuple[Candidate, ...]:
    """The most compact first. Only what is in the first frame too can be followed from there."""
    times: list[float] = []
    pieces: dict[int, list[tuple[float, float, float, int, int, int, int] | None]] = {hue: [] for hue in HUES}
    factor = 1.0
    for frame in frames(video):
        if frame.index >= MOST_FRAMES:
            break
        factor = min(1.0, LONG_SIDE_PX / max(frame.image.shape[:2]))
        small = cv2.resize(frame.image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        hsv = as_image(cv2.cvtColor(small, cv2.COLOR_BGR2HSV))
        times.append(frame.time_s)
        counts = _pixels_of_hues(hsv)
        for hue in HUES:
            # Most bands hold next to nothing: no piece of them is large enough.
            is_worth = counts[np.arange(hue - HALF_BAND, hue + HALF_BAND + 1) % 180].sum() >= LEAST_AREA_PX
            pieces[hue].append(_largest(hsv, hue) if is_worth else None)
    found = [c for hue in HUES if (c := _candidate(hue, np.array(times), pieces[hue], factor)) is not None]
    found.sort(key=_looseness)
    kept: list[Candidate] = []
    for one in found:
        # Neighbouring bands see the same thing.
        if all(np.nanmedian(np.linalg.norm(one.pixels - other.pixels, axis=1)) > SAME_PX for other in kept):
            kept.append(one)
    return tuple(kept)


def _pixels_of_hues(hsv: Image) -> Array:
    """How many pixels that are coloured are of each hue `(180,)`."""
    coloured = cv2.inRange(hsv, (0, LEAST_SATURATION, LEAST_VALUE), (179, 255, 255))
    return np.asarray(cv2.calcHist([hsv], [0], coloured, [180], [0, 180]), dtype=np.float64).ravel()


def _largest(hsv: Image, hue: int) -> tuple[float, float, float, int, int, int, int] | None:
    """Centre, area and box of a band's largest piece."""
    low, high = hue - HALF_BAND, hue + HALF_BAND
    mask = cv2.inRange(hsv, (max(low, 0), LEAST_SATURATION, LEAST_VALUE), (min(high, 179), 255, 255))
    if low < 0:
        mask = cv2.bitwise_or(mask, cv2.inRange(hsv, (180 + low, LEAST_SATURATION, LEAST_VALUE), (179, 255, 255)))
    x, y, w, h = cv2.boundingRect(mask)
    # With a rim of nothing, which it is opened against; from even places, as OpenCV counts pieces by blocks of two, and
    # of those that are as large the first is taken.
    left, top = max(x - 1, 0) // 2 * 2, max(y - 1, 0) // 2 * 2
    inside = cv2.morphologyEx(mask[top : y + h + 1, left : x + w + 1], cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, _, stats, centres = cv2.connectedComponentsWithStats(inside)
    if count < 2:
        return None
    k = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    x, y, w, h, area = (int(value) for value in stats[k])
    if area < LEAST_AREA_PX or area > MOST_AREA_SHARE * mask.size:
        return None
    u, v = centres[k]
    return left + float(u), top + float(v), float(area), left + x, top + y, w, h


def _candidate(
    hue: int, times: Array, pieces: list[tuple[float, float, float, int, int, int, int] | None], factor: float
) -> Candidate | None:
    rows = np.array([piece if piece is not None else (np.nan,) * 7 for piece in pieces])
    if not np.isfinite(rows).any():
        return None
    passes = rows[:, 2] > ANOTHER * np.nanmedian(rows[:, 2])
    # What is as large at first, or often, is the thing itself, which goes away or turns.
    if not passes[0] and np.isfinite(rows[~passes, 2]).sum() >= SEEN_SHARE * len(rows):
        rows[passes] = np.nan
    area, centres = rows[:, 2], rows[:, :2] / factor
    if pieces[0] is None or np.isfinite(area).mean() < SEEN_SHARE:
        return None
    if np.nanstd(area) > STEADY * np.nanmean(area) or np.nanstd(centres, axis=0).max() < MOVES_PX / factor:
        return None
    x, y, w, h = (round(value / factor) for value in pieces[0][3:])
    box = (x, y, max(2, w), max(2, h))
    return Candidate(2.0 * hue, box, times, centres, float(np.nanmedian(area)) / factor**2)


def _looseness(one: Candidate) -> float:
    """How much it jumps from frame to frame, beside how far it goes."""
    steps = np.linalg.norm(np.diff(one.pixels, axis=0), axis=1)
    return float(np.nanpercentile(steps, 95) / max(1e-9, np.nanstd(one.pixels, axis=0).max()))
