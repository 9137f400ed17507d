"""Keypoints of wrists beside all skin while a hand's is elsewhere: guesses, of a detector that does not see the hand.

Some put a hand that they do not see at the hip that is near, or where it was, as sure of it as of any other. A sleeve,
a glove or a shadow has no skin either: then no hand is elsewhere, there is less skin than was, and the point is as good
as any.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS
from pytracker.evidence.picture.silhouette import Region
from pytracker.evidence.pose.ambiguity import distance_at, to_line, with_hand
from pytracker.rotation import Array

__all__ = ["WristsOnSkin"]

BESIDE_M = 0.06
"""Points of wrists so far from skin are beside it: of seven right clips of people none is by more than 2.5 cm."""
SPREADS = 3.0
"""Nor is a detector's that is spread by a third as much."""
ON_M = 0.025
"""The other wrist's is on skin: the light has not gone out."""
REACH_M = 0.42
"""A hand is no farther from its elbow."""
ARM_M, FACE_M = 0.10, 0.16
"""What is so near to forearms with their hands, upper arms, and to face and neck is theirs,"""
HAND_M2 = 0.004
"""and what is left is a hand if it is as large: half of one."""
MOSTLY, LEAST_FRAMES = 0.5, 10
"""A wrist that was on skin in more of so many frames, at least, is bare;"""
AS_MUCH = 0.85
"""and its hand is still seen, before the other or the face, where there is so much of the skin that usually was."""
SIDES = ("left", "right")
OTHER = {"left": "right", "right": "left"}


class WristsOnSkin:
    """Frame by frame.

    Args:
        px_per_m: pixels of the picture that are a metre where the person is.
    """

    def __init__(self, px_per_m: float) -> None:
        self._px_per_m = px_per_m
        self._asked, self._area = 0, 0.0
        self._on = dict.fromkeys(SIDES, 0)
        self.left_out = 0
        """How many points were beside skin so far."""

    def beside(self, points: Array, skin: Region | None) -> list[int]:
        """Which of a person's points lie beside all skin while the other wrist's is on it, and a hand is elsewhere.

        `points` are u, v and standard deviation in the picture, px `(9, 3)`, `skin` its skin; None where it has none.
        """
        if skin is None:
            return []
        at = dict(zip(KEYPOINTS, points[:, :2], strict=True))
        off = {side: distance_at(skin[0], at[f"{side}_wrist"]) / self._px_per_m for side in SIDES}
        area = int(np.count_nonzero(skin[0] == 0.0))
        found = []
        for side in SIDES:
            wrist = KEYPOINTS.index(f"{side}_wrist")
            limit = max(BESIDE_M, SPREADS * float(points[wrist, 2]) / self._px_per_m)
            if off[side] > limit and off[OTHER[side]] < ON_M:
                is_seen = self._is_bare(side) and area > AS_MUCH * self._area / self._asked
                if is_seen or self._hand_is_elsewhere(side, at, skin[0]):
                    found.append(wrist)
        self._asked, self._area = self._asked + 1, self._area + area
        self._on = {side: count + (off[side] < ON_M) for side, count in self._on.items()}
        self.left_out += len(found)
        return found

    def _is_bare(self, side: str) -> bool:
        return self._asked >= LEAST_FRAMES and self._on[side] > MOSTLY * self._asked

    def _hand_is_elsewhere(self, side: str, at: dict[str, Array], distance_px: NDArray[np.float32]) -> bool:
        """Whether skin within reach of an elbow is no part of what the points say."""
        elbow, reach = at[f"{side}_elbow"], REACH_M * self._px_per_m
        if not np.isfinite(elbow).all():
            return False
        (left, top), (right, bottom) = (np.rint(elbow + sign * reach).astype(int).clip(0) for sign in (-1, 1))
        rows, columns = np.nonzero(distance_px[top : bottom + 1, left : right + 1] == 0.0)
        skin = np.column_stack([columns + left, rows + top]).astype(float)
        skin = skin[np.linalg.norm(skin - elbow, axis=1) < reach]
        middle = 0.5 * (at["left_shoulder"] + at["right_shoulder"])
        lines = [(middle, at["head"], FACE_M)]
        for of in SIDES:
            shoulder, bend, wrist = (at[f"{of}_{joint}"] for joint in ("shoulder", "elbow", "wrist"))
            lines += [(shoulder, bend, ARM_M), (*with_hand((bend, wrist)), ARM_M)]
        for start, end, radius_m in lines:
            # Of what is not seen nothing is known to be near.
            skin = skin[~(to_line(skin, start, end) < radius_m * self._px_per_m)]
        return len(skin) > HAND_M2 * self._px_per_m**2
