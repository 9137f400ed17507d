"""Frames in which a patch seems to rest while the sensor moves: the picture hung, or it is another thing of its colour.

A patch that is believed to rest there pulls the track off by what the arm moved meanwhile.
"""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.patch.camshift import REPEATS, PatchTrack
from pytracker.evidence.patch.lag import GRID_S, banded
from pytracker.recording.recording import Imu
from pytracker.rotation import Array, rotate
from pytracker.series import runs

__all__ = ["LIES_STILL", "RESTS", "rests_in_words", "without_hanging", "without_standing"]

HANGS = "the picture stands still while the sensor moves"
SAME_PX = 0.02
"""Of a picture that was taken anew no patch's centre stays so still for long, but where nothing moves."""
LEAST_S, LEAST_FRAMES = 0.2, 5
"""A shorter pause does no harm."""
ABOUT_S = 2.0
"""The sensor's way is found from so much about it."""
TREMOR_S = 0.2
"""A hand that is held trembles at some 5 Hz, by a millimetre, which is 1 m/s²: no movement."""
MOVES_M, MOVES_M_S2 = 0.02, 0.15
"""A wrist that goes so far meanwhile moves, by its sensor, and is pushed about so (RMS): a hand that trembles stays
where it is, and of one that came to rest just before only the way from there is left."""
LIES_STILL = "what is taken for the patch lies still while the sensor moves"
RESTS = {HANGS: "did camera or recorder hang", LIES_STILL: "does another thing of its colour lie there"}
"""Why a patch that rests is not believed, and what is asked."""
STANDS_PX, STANDS_S = 3.0, 1.0
"""The centre of what lies still trembles by less, over so long;"""
STRIDES_M, STRIDES_M_S2 = 0.05, 0.7
"""a wrist that goes so far, and is pushed about so (RMS), does not lie there."""
CLEARLY = 4.0
"""By so many times what lies still the patch should have moved."""
EDGE_S, EDGE_SHARE = 1.0, 0.25
"""So much of either end of a rest, at the most, is left out: a stroke that slows down is felt into what follows."""
ENDS_S = 0.15
"""When it began and ended is known to this."""
ELSEWHERE_S, ALIKE = 2.0, 0.4
"""For so long elsewhere the patch must move, by such a share as the sensor does: else it is their clocks."""


def without_hanging(track: PatchTrack, imu: Imu, start_s: float) -> PatchTrack:
    """The same, the patch not seen in frames that repeat the one before while the forearm's sensor moves."""
    pixel = track.pixel.copy()
    for k, words in enumerate(track.reason):
        if words == REPEATS and k:
            pixel[k] = pixel[k - 1]  # no other picture: the patch was not looked for
    moved = np.linalg.norm(np.diff(pixel, axis=0), axis=1)
    hung = np.zeros(len(track.time_s), dtype=bool)
    for first, last in runs(moved < SAME_PX, LEAST_FRAMES):
        from_s, to_s = track.time_s[[first, last]] + start_s
        if to_s - from_s >= LEAST_S and _moves(imu, from_s, to_s, MOVES_M, MOVES_M_S2):
            hung[first + 1 : last + 1] = True
    return _unseen(track, hung, HANGS) if hung.any() else track


def without_standing(track: PatchTrack, imu: Imu, start_s: float) -> PatchTrack:
    """The same, the patch not seen where what was taken for it lies still, while the forearm's sensor moves on."""
    stays, hidden = _stays(track), np.zeros(len(track.time_s), dtype=bool)
    moved = []
    for first, after in runs(stays):
        from_s, to_s = track.time_s[[first, after - 1]] + start_s
        edge_s = max(ENDS_S, min(EDGE_S, EDGE_SHARE * (to_s - from_s)))
        if _moves(imu, from_s + edge_s, to_s - edge_s, STRIDES_M, STRIDES_M_S2):
            moved.append((first, after))
    if not moved:
        return track
    alike, expected = _expected(track, ~stays, imu, start_s)
    for first, after in moved:
        # What was before and comes after lasts into it.
        edge = min(
            round((after - first) * EDGE_SHARE),
            int(np.searchsorted(track.time_s, track.time_s[first] + EDGE_S)) - first,
        )
        within = expected[first + edge : after - edge]
        # Towards the camera a patch stays where it is.
        if alike >= ALIKE and np.isfinite(within).all() and np.ptp(within, axis=0).max() > CLEARLY * STANDS_PX:
            hidden[first:after] = True
    return _unseen(track, hidden, LIES_STILL) if hidden.any() else track


def _stays(track: PatchTrack) -> NDArray[np.bool_]:
    """Frames of stretches in which the patch's centre stays where it is."""
    stays = np.zeros(len(track.time_s), dtype=bool)
    for first in range(len(stays)):
        after = int(np.searchsorted(track.time_s, track.time_s[first] + STANDS_S))
        seen = track.pixel[first:after]
        if after < len(stays) and np.isfinite(seen).all() and np.ptp(seen, axis=0).max() < STANDS_PX:
            stays[first:after] = True
    return stays


def _expected(track: PatchTrack, moves: NDArray[np.bool_], imu: Imu, start_s: float) -> tuple[float, Array]:
    """The patch's way as a linear map of the sensor's has it in every frame `(T, 2)`, px.

    And the share of its way that this explains where the patch `moves`; 0 of too little.
    """
    frame_s, nowhere = track.time_s + start_s, np.full((len(track.time_s), 2), np.nan)
    is_seen = np.isfinite(track.pixel).all(axis=1)
    if is_seen.sum() < LEAST_FRAMES:
        return 0.0, nowhere
    camera_s, seen = banded(frame_s, track.pixel)
    imu_s, way = banded(imu.time_s, rotate(imu.q_world_segment, imu.acc), integrations=2)
    grid_s = camera_s + GRID_S * np.arange(len(seen))
    at = np.rint((grid_s - imu_s) / GRID_S).astype(int)
    frame = np.clip(np.searchsorted(frame_s, grid_s), 0, len(frame_s) - 1)
    is_felt = (at >= 0) & (at < len(way))
    used = is_felt & (moves & is_seen)[frame]
    if used.sum() * GRID_S < ELSEWHERE_S:
        return 0.0, nowhere
    went, seen = way[at[used]], seen[used]
    linear = np.linalg.lstsq(went, seen, rcond=None)[0]
    explained = 1.0 - ((seen - went @ linear) ** 2).sum() / max((seen**2).sum(), 1e-9)
    expected = np.where(is_felt[:, None], way[np.clip(at, 0, len(way) - 1)] @ linear, np.nan)
    return float(explained), np.stack([np.interp(frame_s, grid_s, column) for column in expected.T], axis=1)


def _moves(imu: Imu, from_s: float, to_s: float, goes_m: float, pushed_m_s2: float) -> bool:
    """Whether the sensor goes so far between two times, and what it felt in between varies.

    By what it felt, integrated twice, without what is slow and drifts.
    """
    some = (imu.time_s >= from_s - ABOUT_S) & (imu.time_s <= to_s + ABOUT_S)
    within = (imu.time_s >= from_s) & (imu.time_s <= to_s)
    if within.sum() < LEAST_FRAMES:
        return False
    felt = rotate(imu.q_world_segment[some], imu.acc[some])
    if np.linalg.norm(_without_tremor(felt, imu.time_s[some])[within[some]].std(axis=0)) < pushed_m_s2:
        return False
    start_s, way = banded(imu.time_s[some], felt, integrations=2)
    time_s = start_s + GRID_S * np.arange(len(way))
    inside = way[(time_s >= from_s) & (time_s <= to_s)]
    return bool(len(inside) and np.linalg.norm(np.ptp(inside, axis=0)) > goes_m)


def _without_tremor(felt: Array, time_s: Array) -> Array:
    """Of rows `(T, 3)` what is slower: means over some period of it."""
    count = max(1, round(TREMOR_S / float(np.median(np.diff(time_s)))))
    return np.asarray(cv2.blur(felt, (1, count), borderType=cv2.BORDER_REPLICATE))


def rests_in_words(track: PatchTrack, why: str) -> str:
    """Of frames that are not seen for that reason, one of `RESTS`: how many, when, and what is asked; empty of none."""
    rests = [words == why for words in track.reason]
    if not any(rests):
        return ""
    first, end = max(runs(rests), key=lambda run: run[1] - run[0])
    from_s, to_s = track.time_s[first], track.time_s[end - 1]
    return (
        f"in {sum(rests)} frames, longest from {from_s:.3f} to {to_s:.3f} s of its video, {why}: they are not used, "
        f"{RESTS[why]}?"
    )


def _unseen(track: PatchTrack, hidden: NDArray[np.bool_], why: str) -> PatchTrack:
    reason = tuple(why if hides else words for hides, words in zip(hidden, track.reason, strict=True))
    pixel = np.where(hidden[:, None], np.nan, track.pixel)
    return dataclasses.replace(track, pixel=pixel, valid=track.valid & ~hidden, reason=reason)
