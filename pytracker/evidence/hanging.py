"""Frames in which a picture hung, as a camera's driver or a recorder does: the same one again, while the sensor moves.

A patch that is believed to rest there pulls the track off by what the arm moved meanwhile.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.camshift import REPEATS, PatchTrack
from pytracker.evidence.lag import GRID_S, banded
from pytracker.recording.recording import Imu
from pytracker.rotation import rotate
from pytracker.series import runs

__all__ = ["HANGS", "without_hanging"]

HANGS = "the picture stands still while the sensor moves"
SAME_PX = 0.02
"""Of a picture that was taken anew no patch's centre stays so still for long, but where nothing moves."""
LEAST_S, LEAST_FRAMES = 0.2, 5
"""A shorter pause does no harm."""
ABOUT_S = 2.0
"""The sensor's way is found from so much about it."""
MOVES_M = 0.02
"""A wrist that goes so far meanwhile moves, by its sensor; a hand that trembles stays where it is."""


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
        if to_s - from_s >= LEAST_S and _goes_m(imu, from_s, to_s) > MOVES_M:
            hung[first + 1 : last + 1] = True
    return _unseen(track, hung) if hung.any() else track


def _goes_m(imu: Imu, from_s: float, to_s: float) -> float:
    """How far the sensor goes between two times, m: what it felt, integrated twice, without what is slow and drifts."""
    some = (imu.time_s >= from_s - ABOUT_S) & (imu.time_s <= to_s + ABOUT_S)
    if some.sum() < LEAST_FRAMES:
        return 0.0
    start_s, way = banded(imu.time_s[some], rotate(imu.q_world_segment[some], imu.acc[some]), integrations=2)
    time_s = start_s + GRID_S * np.arange(len(way))
    inside = way[(time_s >= from_s) & (time_s <= to_s)]
    return float(np.linalg.norm(np.ptp(inside, axis=0))) if len(inside) else 0.0


def _unseen(track: PatchTrack, hung: NDArray[np.bool_]) -> PatchTrack:
    reason = tuple(HANGS if hangs else words for hangs, words in zip(hung, track.reason, strict=True))
    pixel = np.where(hung[:, None], np.nan, track.pixel)
    return dataclasses.replace(track, pixel=pixel, valid=track.valid & ~hung, reason=reason)
