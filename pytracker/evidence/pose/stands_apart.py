"""Whether an arm may be drawn by a thing of skin's colour: one that came, stands still, and is apart from the person.

Whatever has skin's colour draws an arm: a ball, a box, wood. A hand hangs together with its arm, and that with the
person; what was there from the first frame on may be theirs, in clothes of the wall's colour.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.picture.silhouette import BodyEvidence
from pytracker.evidence.pose.ambiguity import to_line, with_hand
from pytracker.evidence.pose.pieces import pieces_of
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["STANDS_APART", "StandsApart"]

STANDS_APART = "a thing of skin's colour stands there, apart from the person"
NEAR_M = 0.06
"""A piece so near to head, trunk or shoulders is the person's, m; an arm so near to a thing may be drawn by it."""
THING_M2 = 0.004, 0.08
"""Smaller draws no arm; larger is no thing that is taken for one: a forearm with its hand has 0.04."""
OF_SKIN, NEW = 0.4, 0.2
"""So much of a thing has skin's colour, and less than this was foreground in the first frame."""
STILL_M, STILL_SHARE, STILL_S = 0.012, 0.15, 0.8
"""Its middle moves by no more, m, nor its size by such a share, for so long, s."""
SIDES = ("left", "right")
TRUNK = ("root", "head", "left_shoulder", "right_shoulder")


@dataclass(frozen=True)
class _Thing:
    """A piece of foreground: since when it is there, s, its middle `(2,)`, px, and its size, px."""

    since_s: float
    middle: Array
    size: float


class StandsApart:
    """What the frames so far say of it.

    Args:
        camera: of the pictures that evidence is found in.
    """

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._at_first: NDArray[np.bool_] | None = None
        self._things: list[_Thing] = []

    def look(self, time_s: float, joints: Mapping[str, Array], evidence: BodyEvidence) -> dict[str, str]:
        """Take a frame's key joints, `(3,)` each, world, m, and what it shows; in words what is said of either arm."""
        places = np.stack(list(joints.values()))
        pixels = dict(zip(joints, self._camera.project(places), strict=True))
        px_per_m = float(self._camera.px_per_m(joints["root"][None])[0])
        if self._at_first is None:
            self._at_first = evidence.foreground > 0
        things = [self._since(time_s, *thing, px_per_m) for thing in self._apart(pixels, evidence, px_per_m)]
        self._things = things
        still = [thing for thing in things if time_s - thing.since_s >= STILL_S]
        words: dict[str, str] = {}
        for side in SIDES:
            arm = with_hand((pixels[f"{side}_elbow"], pixels[f"{side}_wrist"]))
            reach = [np.sqrt(thing.size / np.pi) + NEAR_M * px_per_m for thing in still]
            off = [float(to_line(thing.middle[None], *arm)[0]) for thing in still]
            if any(near < far for near, far in zip(off, reach, strict=True)):
                words |= dict.fromkeys((f"{side}_elbow", f"{side}_wrist"), STANDS_APART)
        return words

    def _apart(self, pixels: Mapping[str, Array], evidence: BodyEvidence, px_per_m: float) -> list[tuple[Array, float]]:
        """The middles and sizes of pieces of skin's colour that are apart from the person, and new."""
        pieces = pieces_of(evidence.foreground, px_per_m)
        least, most = (m2 * px_per_m**2 for m2 in THING_M2)
        asked = (pieces.sizes > least) & (pieces.sizes < most)
        asked[0] = False
        if not asked.any():
            return []
        asked[pieces.about(np.array([pixels[name] for name in TRUNK]), round(NEAR_M * px_per_m))] = False
        assert self._at_first is not None
        return [
            (pieces.middles[label], float(pieces.sizes[label]))
            for label in np.flatnonzero(asked).tolist()
            if pieces.share(label, evidence.skin) > OF_SKIN and pieces.share(label, self._at_first) < NEW
        ]

    def _since(self, time_s: float, middle: Array, size: float, px_per_m: float) -> _Thing:
        """As it was, where it has not moved since; else anew."""
        for before in self._things:
            moved = float(np.linalg.norm(middle - before.middle))
            if moved < STILL_M * px_per_m and abs(size - before.size) < STILL_SHARE * before.size:
                return before
        return _Thing(time_s, middle, size)
