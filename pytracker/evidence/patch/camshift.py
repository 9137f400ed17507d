"""Following a colour patch: Camshift (Bradski 1998; Tao & Hu III-B) that knows when it is lost.

OpenCV's CamShift says nothing when it has lost the patch; here the mass, the area, the aspect and the jump of what
it found are tested, a frame that fails is reported with a reason, and the patch is looked for again over the whole
frame. While it is followed, what is of its colour (`patch_colour`) is worked out about it alone, and what else is of it
in a smaller picture.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.evidence.patch.beside import GREW, Beside
from pytracker.evidence.patch.colour import Box, CamshiftParameters, PatchColour, Piece
from pytracker.evidence.patch.standing import Standing, in_one_piece
from pytracker.evidence.picture.smaller import LEAST_PX, place_in_frame, smaller
from pytracker.formats.video import Frame, Image, as_image, frames

__all__ = ["REPEATS", "PatchSighting", "PatchTrack", "PatchTracker", "track_patch"]

REPEATS = "the frame repeats the one before"

Float = NDArray[np.float64]

ABOUT = 1.0
"""Camshift is let go so many search windows to every side; where it leads out, in all of the picture."""
REACH_PX = 12
"""Camshift looks by 10 px beyond what it found, pixels are blurred over one."""
DARK = 32.0
"""A first frame whose mean is less shows nothing: the video fades in, or begins black."""
TOGETHER = "beside something of its colour that stands there"
JOINED = "in one piece with something of its colour that goes by"
SMALLER_PX = 8.0
"""What stands beside the patch is looked for in a picture so small that the patch is no smaller than this."""


@dataclass(frozen=True)
class PatchSighting:
    """The patch in one frame.

    Attributes:
        pixel: centre (u, v), px; NaN where not valid.
        valid: whether this is the patch.
        reason: why not, else empty.
    """

    pixel: tuple[float, float]
    valid: bool
    reason: str


@dataclass(frozen=True, eq=False)
class PatchTrack:
    """The patch over a video.

    Attributes:
        time_s: container times `(T,)`, s.
        pixel: centres `(T, 2)`, px; NaN where not valid.
        valid: `(T,)`.
        reason: why not, `(T,)` of words.
    """

    time_s: Float
    pixel: Float
    valid: NDArray[np.bool_]
    reason: tuple[str, ...]


class PatchTracker:
    """Follows one patch, frame by frame; starts from the first frame and a box around the patch there.

    Raises `InputError` for a box that is not inside the frame or holds no colour that stands out.
    """

    def __init__(self, image: Image, box: Box, parameters: CamshiftParameters | None = None) -> None:
        self.parameters = parameters or CamshiftParameters()
        self._colour = PatchColour(image, box, self.parameters)
        back = self._colour.back_projection(image)
        x, y, w, h = box
        # Camshift goes on beyond the box: what is close by, of the same colour, is none of the patch.
        is_patch = in_one_piece(self._of_colour(back), (slice(y, y + h), slice(x, x + w)))
        found = self._measure(np.where(is_patch, back, np.uint8(0)), box)
        if found is None or found.mass < 9:
            mean = float(image.mean())
            hint = (
                f"the first frame is dark (mean {mean:.0f} of 255): cut the video to where the patch is seen"
                if mean < DARK
                else "choose a box on a patch of a colour of its own, or cut the video to where the patch is seen"
            )
            raise InputError(
                f"patch box {list(box)} holds {0 if found is None else found.mass:.0f} pixels of a colour that its "
                f"surroundings do not have in the first frame, expected at least 9: {hint}"
            )
        self._first, self._mass = found, found.mass
        self._size = float(np.sqrt(found.mass))
        self._times_smaller = int(max(1, min(self._size // SMALLER_PX, min(image.shape[:2]) // LEAST_PX)))
        self._standing = Standing(self._coloured(image), box, self._times_smaller)
        self._centre = found.centre
        self._velocity = np.zeros(2)
        self._box = found.box
        self._lost = False
        self._candidates: list[Float] = []
        self._beside = Beside(self._standing, self.parameters.max_jump * self._size)
        self._last_image: Image | None = None

    def update(self, image: Image) -> PatchSighting:
        """Look for the patch in the next frame, BGR `(H, W, 3)`."""
        if self._last_image is not None and np.array_equal(image, self._last_image):
            # A camera that was late shows its last image again: where the patch was then is not where it is now.
            return PatchSighting((np.nan, np.nan), False, REPEATS)
        self._last_image = image
        if self._lost:
            found, reason = self._search(image)
        else:
            found = self._follow(image)
            reason = self._fault(found)
        if found is None or reason:
            self._lost = True
            return PatchSighting((np.nan, np.nan), False, reason)
        if not self._accept(found, image):
            # By itself again it is believed at once where it was.
            self._lost, self._candidates = True, [self._centre]
            return PatchSighting((np.nan, np.nan), False, JOINED)
        if self._standing.is_covered(found.box):
            return PatchSighting((np.nan, np.nan), False, TOGETHER)
        return PatchSighting((float(found.centre[0]), float(found.centre[1])), True, "")

    def _accept(self, found: Piece, image: Image) -> bool:
        """Whether it is the patch alone, from which it goes on."""
        # What is beside the patch is not the patch: it must not be taken for it after a loss.
        back = self._colour.back_projection(smaller(image, self._times_smaller))
        pieces = self._pieces(back, self._times_smaller)
        beside = [piece for piece in pieces if not self._beside.is_near(piece.centre, found.centre)]
        joined = self._beside.joined(beside, _grown(found.box, REACH_PX))
        if joined and found.mass > GREW * self._mass:
            self._beside.follow(pieces)
            return False
        self._beside.learn(beside)
        self._mass = found.mass
        moved = found.centre - self._centre
        self._velocity = np.zeros(2) if self._lost else moved
        self._centre, self._box, self._lost = found.centre, found.box, False
        self._candidates = []
        self._standing.learn(self._of_colour(back), _grown(found.box, REACH_PX))
        return True

    def _coloured(self, image: Image) -> Image:
        """Where the smaller picture is of the patch's colour, 0 or 255."""
        return self._of_colour(self._colour.back_projection(smaller(image, self._times_smaller)))

    def _of_colour(self, back: Image) -> Image:
        return as_image(cv2.inRange(back, self.parameters.purity, 255))

    def _pieces(self, back: Image, times: int = 1) -> list[Piece]:
        """Everything of the patch's colour that is not much smaller, of a picture so many times smaller.

        Centres, masses and boxes are in pixels of the frame.
        """
        pieces = self._colour.pieces(back, self.parameters.min_mass * self._first.mass / times**2)
        return [
            replace(
                one,
                centre=place_in_frame(one.centre, times),
                mass=one.mass * times**2,
                box=(one.box[0] * times, one.box[1] * times, one.box[2] * times, one.box[3] * times),
            )
            for one in pieces
        ]

    def _window(self, image: Image) -> Box:
        """Where to look: the last window, carried on by the velocity, never smaller than the patch."""
        _, _, w, h = self._box
        side = int(2 * self._size)
        w, h = max(w, side), max(h, side)
        u, v = self._centre + self._velocity
        return _clip((round(u - w / 2), round(v - h / 2), w, h), image)

    def _follow(self, image: Image) -> Piece | None:
        """The patch from where it is expected, in the colours about there: the same as in those of all the picture."""
        window = self._window(image)
        about = _clip(_grown(window, round(ABOUT * max(window[2:])) + REACH_PX), image)
        x, y, w, h = about
        if w < 1 or h < 1:
            return None
        back = self._standing.without(self._colour.back_projection(image[y : y + h, x : x + w]), (x, y))
        found = self._measure(back, window, (x, y))
        if found is not None and not _is_within(_clip(_grown(found.box, REACH_PX), image), about):
            return self._measure(self._standing.without(self._colour.back_projection(image)), window)
        return found

    def _measure(self, back: Image, window: Box, at: tuple[int, int] = (0, 0)) -> Piece | None:
        """CamShift from `window`, then the patch pixels about what it found; `back` begins at `at` of the frame."""
        left, top = at
        x, y, w, h = window[0] - left, window[1] - top, *window[2:]
        if w < 1 or h < 1 or not back[y : y + h, x : x + w].any():
            return None
        criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1.0)
        _, (x, y, w, h) = cv2.CamShift(back, (x, y, w, h), criteria)
        if w < 1 or h < 1:
            return None
        x, y, w, h = _clip(_grown((x, y, w, h), max(2, round(0.15 * max(w, h)))), back)
        inside = cv2.inRange(back[y : y + h, x : x + w], self.parameters.purity, 255)
        moments, place = cv2.moments(inside, binaryImage=True), (x + left, y + top)
        return Piece.of(moments, moments["m00"], (*place, w, h), place) if moments["m00"] >= 1 else None

    def _fault(self, found: Piece | None) -> str:
        """Why `found` is not the patch; empty where it is."""
        p = self.parameters
        if found is None:
            return "no patch colour in the search window"
        share = found.mass / self._first.mass
        if share < p.min_mass:
            return f"patch too small ({share:.2f} of the first frame's area)"
        if share > p.max_mass:
            return f"patch too large ({share:.2f} of the first frame's area)"
        aspect = found.aspect / self._first.aspect
        if aspect > p.max_aspect:
            return f"patch too long ({aspect:.1f} times the first frame's aspect)"
        expected = self._centre + self._velocity
        off = _distance(found.centre, expected)
        if any(_distance(found.centre, thing.centre) < off for thing in self._beside.things):
            return "something else of the patch's colour"
        jump = off / self._size
        if jump > p.max_jump:
            return f"patch jumped by {jump:.1f} of its size"
        return ""

    def _search(self, image: Image) -> tuple[Piece | None, str]:
        """Look over the whole frame for the patch, passing over what already stood beside it."""
        back = self._colour.back_projection(image)
        pieces = self._pieces(back)
        self._beside.follow(pieces)
        found = [piece for piece in pieces if self._looks_right(piece) and self._is_no_other(piece, pieces)]
        if not found:
            return None, "patch not found again"
        best = max(found, key=lambda blob: blob.mass)
        return best, "" if self._agrees(best) else "patch found again, not yet believed"

    def _is_no_other(self, piece: Piece, pieces: list[Piece]) -> bool:
        """Whether it is none of what is beside the patch: by itself, or beside one that stands where it stood."""
        if self._standing.is_covered(piece.box):
            return False
        standing = [one.centre for one in pieces if one is not piece and self._standing.is_at(one.centre)]
        things = self._beside.near(piece.centre)
        return all(any(self._beside.is_near(thing.centre, one) for one in standing) for thing in things)

    def _looks_right(self, found: Piece) -> bool:
        p = self.parameters
        share, aspect = found.mass / self._first.mass, found.aspect / self._first.aspect
        return p.min_mass <= share <= p.max_mass and aspect <= p.max_aspect

    def _agrees(self, found: Piece) -> bool:
        """Whether it was already near here in the last frames: one look is not enough to believe it."""
        near = [c for c in self._candidates if self._beside.is_near(c, found.centre)]
        self._candidates = [*near, found.centre]
        return len(self._candidates) >= self.parameters.agree


def track_patch(
    video: Path | str | Iterable[Frame], box: Box, parameters: CamshiftParameters | None = None
) -> PatchTrack:
    """Follow the patch that `box` (x, y, width, height) holds in the first frame of `video`.

    `video` is a file or frames in order. Raises `InputError` for a video or box that cannot be used; a lost
    patch is no error but a `reason`.
    """
    source = frames(video) if isinstance(video, str | Path) else video
    tracker: PatchTracker | None = None
    times, sightings = [], []
    for frame in source:
        if tracker is None:
            tracker = PatchTracker(frame.image, box, parameters)
        times.append(frame.time_s)
        sightings.append(tracker.update(frame.image))
    return PatchTrack(
        time_s=np.array(times),
        pixel=np.array([s.pixel for s in sightings]).reshape(-1, 2),
        valid=np.array([s.valid for s in sightings], dtype=bool),
        reason=tuple(s.reason for s in sightings),
    )


def _distance(a: Float, b: Float) -> float:
    return float(np.linalg.norm(a - b))


def _grown(box: Box, by: int) -> Box:
    x, y, w, h = box
    return x - by, y - by, w + 2 * by, h + 2 * by


def _is_within(box: Box, other: Box) -> bool:
    return (
        box[0] >= other[0]
        and box[1] >= other[1]
        and box[0] + box[2] <= other[0] + other[2]
        and box[1] + box[3] <= other[1] + other[3]
    )


def _clip(box: Box, image: Image) -> Box:
    height, width = image.shape[:2]
    x0, y0 = min(max(box[0], 0), width - 1), min(max(box[1], 0), height - 1)
    x1, y1 = min(box[0] + box[2], width), min(box[1] + box[3], height)
    return x0, y0, max(x1 - x0, 0), max(y1 - y0, 0)
