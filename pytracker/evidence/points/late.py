"""Whether a detector's keypoints are of the frames they are given for: wrists lie on skin, sooner, later, mirrored not.

Keypoints of a clip that was cut, converted or counted otherwise than the video are some frames early or late, or of
every second frame; where rows are missing, or frames of the video are, all that come after. What moves then lies beside
its points, by more the farther off the count is; where nothing moves, nothing is told. Those of a mirrored picture
look, exchanged, like the person's, whose arms then do what the other one does; those of a picture that was padded to a
square, as shares of which some networks give them, lie too near its middle along the shorter side.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.evidence.picture.silhouette import BodyEvidence
from pytracker.evidence.picture.smaller import place_in_smaller
from pytracker.formats.keypoints.read import Keypoints
from pytracker.recording.body_view import rate_of
from pytracker.recording.recording import BodyView
from pytracker.rotation import Array

__all__ = ["LATE", "MIRRORED", "PADDED", "Counted", "PointsLate", "points_late_of"]

FARTHER_S = (0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0)
LATE_S = np.array([*(-s for s in reversed(FARTHER_S)), *np.arange(-12, 13) * 0.05, *FARTHER_S])
"""So late keypoints are tried to be, s."""
EVERY = (2, 3, 4, 5)
"""Keypoints are tried to be of one frame in so many."""
MOST_M = 0.15
"""A point that is farther from skin is somewhere else altogether."""
NEAR_M, NEARER = 0.015, 0.45
"""On average wrists are no farther from skin when they are of the right frames, or by so small a share of what they are
as counted, below long sleeves. Points of another video are neither."""
NEARER_M = 0.002
"""Keypoints at other frames may lie so much nearer to skin; of right ones none are by 0.1 mm, a tenth of a second gives
3 to 13."""
PART_M, SPLIT = 0.003, 1.2
"""From some frame on they may lie so much nearer on average over all: of right ones, with a detector's noise and wild
rows, at any rate and cut anywhere, 26 of 5278 do; of those that lack a third of a second or more 53 of 63. That
explains more than one count of all, by so much, or it is one."""
LEAST_PART = 0.15
"""Of so many of the frames it is told at the least."""
LATE = "the keypoints are of other frames"
MIRRORED = "the keypoints are of a mirrored picture"
MIRRORED_M = 0.005
"""So much nearer to skin, on average, they may lie if the picture is mirrored; right ones never do."""
PADDED = "the keypoints are of a padded picture"
PADDED_M = 0.002
"""The same if it was padded to a square: right ones lie farther off then, by 3 mm and more; of 14 padded ones 12 are
nearer by 2 to 35 mm."""
LEAST_SHARE = 0.5
"""Of so many of the frames it must be told how they fare."""
_WRISTS = [KEYPOINTS.index(f"{side}_wrist") for side in ("left", "right")]


@dataclass(frozen=True)
class Counted:
    """How keypoints may have been counted otherwise, `first` of them rightly.

    Row `first + (index - first) // every + late` is of the video's frame `index`.

    Attributes:
        late: by how many frames they come late; less than 0: early.
        every: they are of one frame in so many.
        since: from about this frame on; those before are counted rightly.
    """

    late: int = 0
    every: int = 1
    since: int = 0


class PointsLate:
    """What the frames so far say.

    Args:
        keypoints: of everyone in the video, in its frames and pixels.
        rate_hz: of the video.
        shrunk: how many times smaller its pictures are made.
    """

    def __init__(self, keypoints: Keypoints, rate_hz: float, shrunk: int = 1) -> None:
        late = np.unique(np.rint(LATE_S * rate_hz).astype(int))
        self.tried = [*(Counted(int(by)) for by in late), *(Counted(every=every) for every in EVERY)]
        """How they are tried to be counted, `L` ways."""
        self._late, self._every = np.array([(one.late, one.every) for one in self.tried]).T
        self._as_counted = self.tried.index(Counted())
        self._frames = keypoints.frames
        self._wrists = place_in_smaller(keypoints.points[:, :, _WRISTS, :2], shrunk)
        self._looked: list[int] = []
        self._off_m: list[Array] = []
        self._otherwise_m: list[Array] = []

    def look(self, index: int, evidence: BodyEvidence, px_per_m: float) -> None:
        """Take what frame `index` shows, at so many pixels a metre of the smaller picture."""
        if evidence.skin_region is None:
            return
        distance_px = evidence.skin_region[0]
        first = int(self._frames[0]) if len(self._frames) else 0
        at = first + (index - first) // self._every + self._late
        rows = np.clip(np.searchsorted(self._frames, at), 0, len(self._frames) - 1)
        wrists = np.where((self._frames[rows] == at)[:, None, None, None], self._wrists[rows], np.nan)
        self._looked.append(index)
        self._off_m.append(_off_skin(distance_px, wrists, px_per_m))
        height, width = distance_px.shape
        otherwise = (place(wrists[[self._as_counted]], width, height) for place in (_mirrored, _without_padding))
        self._otherwise_m.append(np.concatenate([_off_skin(distance_px, one, px_per_m) for one in otherwise]))

    @property
    def are_mirrored(self) -> bool:
        """Whether they lie on skin if the picture that they were found in is taken to be mirrored, and not else.

        Nor as near, if they are taken to be late.
        """
        return self._nearer_otherwise_m(0) > MIRRORED_M

    @property
    def nearer_without_padding_m(self) -> float:
        """How much nearer to skin they lie if that picture is taken to have been padded to a square; 0 of right ones.

        And of such that lie as near if they are taken to be late.
        """
        nearer_m = self._nearer_otherwise_m(1)
        return nearer_m if nearer_m > PADDED_M else 0.0

    def _nearer_otherwise_m(self, way: int) -> float:
        """How much nearer to skin they lie if they are of such another picture, m; 0 where nothing tells it."""
        off = self._off()[:, self._as_counted]
        otherwise = np.array(self._otherwise_m).reshape(-1, 2)[:, way]
        told = np.isfinite(off) & np.isfinite(otherwise)
        if told.sum() <= LEAST_SHARE * max(1, len(off)) or otherwise[told].mean() >= NEAR_M:
            return 0.0
        _, later_m = self._as_a_whole()
        nearer_m = float(off[told].mean() - otherwise[told].mean())
        return nearer_m if nearer_m > later_m else 0.0

    def off_skin(self) -> tuple[float, float]:
        """How far wrists lie from skin in the frames that they are counted as, on average, and its spread, m.

        NaN where too few frames tell.
        """
        off = self._off()[:, self._as_counted]
        told = off[np.isfinite(off)]
        if len(told) <= LEAST_SHARE * max(1, len(off)):
            return np.nan, np.nan
        return float(told.mean()), float(told.std())

    def found(self) -> tuple[Counted, float]:
        """How they are counted otherwise, where that is told, and by how much nearer to skin they are then, m."""
        whole, nearer_m = self._as_a_whole()
        part, nearer_in_part_m, on_average_m = self._from_some_frame_on()
        if on_average_m >= max(PART_M, SPLIT * nearer_m):
            return part, nearer_in_part_m
        return (whole, nearer_m) if nearer_m >= NEARER_M else (Counted(), 0.0)

    def _from_some_frame_on(self) -> tuple[Counted, float, float]:
        """The same if those before some frame are counted rightly, and how much nearer that is over all frames."""
        off = self._off()
        if not len(off):
            return Counted(), 0.0, 0.0
        as_counted = off[:, [self._as_counted]]
        told = np.isfinite(as_counted - off)
        gains, count, are_off, were_off = (
            np.cumsum(np.where(told, values, 0.0)[::-1], axis=0)[::-1]
            for values in (as_counted - off, told, off, as_counted)
        )
        left = np.arange(len(off), 0, -1)[:, None]
        # Those of another take are not right before, either.
        seen = np.isfinite(as_counted)
        before_m = _sum_before(np.where(seen, as_counted, 0.0)) / np.maximum(1, _sum_before(seen))
        is_near = (are_off <= np.maximum(NEAR_M * count, NEARER * were_off)) & (before_m <= NEAR_M)
        asked = (count > LEAST_SHARE * left) & (left >= LEAST_PART * len(off)) & (self._every == 1)
        gains = np.where(is_near & asked, gains, 0.0)
        row, way = np.unravel_index(int(np.argmax(gains)), gains.shape)
        gained = float(gains[row, way])
        if gained <= 0.0:
            return Counted(), 0.0, 0.0
        part = replace(self.tried[way], since=self._looked[row])
        return part, gained / float(count[row, way]), gained / len(off)

    def _as_a_whole(self) -> tuple[Counted, float]:
        """How all of them fit best, and by how much better than as they are counted, m."""
        off = self._off()
        as_counted = off[:, [self._as_counted]]
        better = as_counted - off
        told = np.isfinite(better)
        # As they are counted, those of every second frame are only of the first half.
        enough = told.sum(axis=0) > LEAST_SHARE * max(1, len(off)) / self._every
        gains = np.where(enough, np.where(told, better, 0.0).sum(axis=0) / np.maximum(1, told.sum(axis=0)), 0.0)
        counted = np.where(told, as_counted, 0.0).sum(axis=0)
        is_near = np.where(told, off, 0.0).sum(axis=0) <= np.maximum(NEAR_M * told.sum(axis=0), NEARER * counted)
        best = int(np.argmax(np.where(is_near, gains, 0.0)))
        return (self.tried[best], float(gains[best])) if is_near[best] and gains[best] > 0.0 else (Counted(), 0.0)

    def _off(self) -> Array:
        """From skin by every way that was tried, of every frame so far `(T, L)`, m."""
        return np.array(self._off_m).reshape(-1, len(self.tried))


def _mirrored(places: Array, width: int, height: int) -> Array:
    """Places `(..., 2)`, px, of a mirrored picture."""
    return np.stack([width - 1.0 - places[..., 0], places[..., 1]], axis=-1)


def _without_padding(places: Array, width: int, height: int) -> Array:
    """Places `(..., 2)`, px, that are shares of a square about the picture, which were taken for shares of its own."""
    longer, size = max(width, height), np.array([width, height])
    return np.asarray((places / size - 0.5) * longer + 0.5 * size)


def _sum_before(values: Array | NDArray[np.bool_]) -> Array:
    """Of the rows before each `(T, 1)`."""
    return np.asarray(np.cumsum(values, axis=0) - values.astype(float))


def _off_skin(distance_px: NDArray[np.float32], wrists: Array, px_per_m: float) -> Array:
    """How far from skin are both wrists of the nearest of people, on average, m `(L,)`, of `(L, P, 2, 2)`, px."""
    height, width = distance_px.shape
    known = np.asarray(np.isfinite(wrists).all(axis=-1))
    u, v = np.rint(np.where(known[..., None], wrists, -1.0)).astype(int).transpose(3, 0, 1, 2)
    known &= (u >= 0) & (u < width) & (v >= 0) & (v < height)
    from_skin = distance_px[np.where(known, v, 0), np.where(known, u, 0)] / px_per_m
    off, count = np.where(known, np.minimum(from_skin, MOST_M), 0.0), known.sum(axis=-1)
    each = np.where(count > 0, off.sum(axis=-1) / np.maximum(count, 1), np.inf)
    nearest = each.min(axis=-1)
    return np.where(np.isfinite(nearest), nearest, np.nan)


def points_late_of(view: BodyView, shrunk: int) -> PointsLate | None:
    """What looks whether keypoints are of the video's frames, made smaller; None where there are not both."""
    if view.keypoints is None or view.video is None:
        return None
    return PointsLate(view.keypoints, rate_of(view), shrunk)
