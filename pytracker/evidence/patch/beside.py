"""What else of a patch's colour goes about: another's sleeve, a ball, the other arm's patch.

While the patch is followed, what is seen besides is known not to be it. After a loss each such thing goes on as it went
and is what is seen nearest to there: one thing, so that where it and the patch were one piece for a while, the patch is
not taken for it once they are apart. What is hidden stays known where it was: it comes back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pytracker.evidence.patch.colour import Box, Piece
from pytracker.evidence.patch.standing import Standing
from pytracker.rotation import Array

__all__ = ["GREW", "Beside", "Thing"]

NEWER = 0.3
"""The last step counts for so much of a thing's velocity."""
GREW = 1.3
"""What another thing has come to is so much larger than it was."""
KNOWN_FRAMES = 5
"""What was seen for fewer may be coming in at the picture's rim, and is larger from frame to frame;"""
JOINED_FRAMES = 30
"""what is so much larger for so long is no more than itself."""


@dataclass(frozen=True, eq=False)
class Thing:
    """Something of the patch's colour that is not the patch.

    Attributes:
        centre: where it was seen last, or has gone on to since, px `(2,)`.
        mass: of how many pixels it was at most: behind an arm or at the picture's rim it is smaller for a while.
        velocity: px a frame `(2,)`.
        frames: for how many it was seen, by itself.
        joined: for how many it is in one piece with another.
    """

    centre: Array
    mass: float
    velocity: Array = field(default_factory=lambda: np.zeros(2))
    frames: int = 1
    joined: int = 0

    @property
    def expected(self) -> Array:
        """Where it is in the next frame, px `(2,)`."""
        return self.centre + self.velocity

    def seen_as(self, piece: Piece) -> Thing:
        """A frame later."""
        grew = piece.mass > GREW * self.mass
        if grew and self.frames >= KNOWN_FRAMES and self.joined < JOINED_FRAMES:
            # In one piece with another it goes on as it went, within that piece.
            x, y, w, h = piece.box
            centre = np.clip(self.expected, (x, y), (x + w, y + h))
            return replace(self, centre=centre, joined=self.joined + 1)
        velocity = self.velocity + NEWER * (piece.centre - self.expected)
        return Thing(piece.centre, max(self.mass, piece.mass), velocity, self.frames + 1)


class Beside:
    """All that was seen beside the patch.

    Args:
        standing: what of the colour stands where it is.
        reach_px: nothing goes farther from one frame to the next.
    """

    def __init__(self, standing: Standing, reach_px: float) -> None:
        self._standing, self._reach_px = standing, reach_px
        self.things: tuple[Thing, ...] = ()

    def learn(self, seen: Sequence[Piece]) -> None:
        """All that is seen beside the patch while it is followed."""
        self.things = tuple(self._gone_on(piece) for piece in seen)

    def follow(self, seen: Sequence[Piece]) -> None:
        """All that is seen, the patch among them or not, while it is lost."""
        # What stands and is seen there is not followed to what is beside it: that may be the patch.
        standing = [piece.centre for piece in seen if self._standing.is_at(piece.centre)]
        still = [thing for thing in self.things if any(self.is_near(thing.centre, centre) for centre in standing)]
        left, followed = list(seen), []
        for thing in (thing for thing in self.things if thing not in still):
            nearest = _nearest(thing.expected, left)
            if nearest is None or not self.is_near(nearest.centre, thing.centre):
                followed.append(thing)
                continue
            left = [piece for piece in left if piece is not nearest]
            followed.append(thing.seen_as(nearest))
        self.things = (*still, *followed)

    def joined(self, seen: Sequence[Piece], box: Box) -> tuple[Thing, ...]:
        """What went about and is seen no more, but was to be in a box of the frame."""
        x, y, w, h = box
        centres = [piece.centre for piece in seen]
        gone = [thing for thing in self.things if not any(self.is_near(thing.centre, centre) for centre in centres)]
        return tuple(
            thing
            for thing in gone
            if x <= thing.expected[0] < x + w
            and y <= thing.expected[1] < y + h
            and not self._standing.is_at(thing.centre)
        )

    def near(self, centre: Array) -> tuple[Thing, ...]:
        """Those that something at a centre, px `(2,)`, may be."""
        return tuple(thing for thing in self.things if self.is_near(thing.centre, centre))

    def is_near(self, a: Array, b: Array) -> bool:
        """Whether something at one place, px `(2,)`, may be at the other a frame later."""
        return float(np.linalg.norm(a - b)) < self._reach_px

    def _gone_on(self, piece: Piece) -> Thing:
        """What was nearest there a frame ago, if anything was."""
        before = min(
            self.near(piece.centre), key=lambda thing: float(np.linalg.norm(thing.centre - piece.centre)), default=None
        )
        return Thing(piece.centre, piece.mass) if before is None else before.seen_as(piece)


def _nearest(place: Array, pieces: Sequence[Piece]) -> Piece | None:
    return min(pieces, key=lambda piece: float(np.linalg.norm(piece.centre - place)), default=None)
