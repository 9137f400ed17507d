"""Following a colour patch: Camshift (Bradski 1998; Tao & Hu III-B) that knows when it is lost.

The patch's histogram over hue and saturation is weighed against its surroundings, so that skin and table in
the first box count for nothing. OpenCV's CamShift says nothing when it has lost the patch; here the mass, the
area, the aspect and the jump of what it found are tested, a frame that fails is reported with a reason, and
the patch is looked for again over the whole frame.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.video import Frame, Image, frames

__all__ = ["CamshiftParameters", "PatchSighting", "PatchTrack", "PatchTracker", "track_patch"]

Box = tuple[int, int, int, int]
Float = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class CamshiftParameters:
    """Thresholds of the patch tracker.

    Attributes:
        hue_bins: histogram cells over hue (180).
        saturation_bins: histogram cells over saturation (256).
        hue_width: how far from the patch's main hue a pixel of it may be, in OpenCV's half degrees.
        min_saturation: greyer pixels say nothing about hue, 0-255.
        min_value: darker pixels say nothing about hue, 0-255.
        ring: width of the surroundings that the histogram is weighed against, in box sizes.
        purity: back-projection from which a pixel counts as patch, 0-255.
        min_mass: smallest share of the first frame's mass that is still the patch.
        max_mass: largest.
        max_aspect: largest ratio of the long to the short axis, relative to the first frame's.
        max_jump: farthest the centre may move between frames, in patch sizes, beyond its own velocity.
        agree: frames in which a patch found again must hold still enough before it is believed.
    """

    hue_bins: int = 45
    saturation_bins: int = 16
    hue_width: float = 15.0
    min_saturation: int = 60
    min_value: int = 40
    ring: float = 1.0
    purity: int = 128
    min_mass: float = 0.25
    max_mass: float = 3.0
    max_aspect: float = 3.0
    max_jump: float = 1.5
    agree: int = 2


@dataclass(frozen=True)
class PatchSighting:
    """The patch in one frame.

    Attributes:
        pixel: centre (u, v), px; NaN where not valid.
        valid: whether this is the patch.
        reason: why not, else empty.
        mass: patch pixels found, relative to the first frame.
        box: x, y, width, height of the search window, px.
    """

    pixel: tuple[float, float]
    valid: bool
    reason: str
    mass: float
    box: Box


@dataclass(frozen=True, eq=False)
class PatchTrack:
    """The patch over a video.

    Attributes:
        time_s: container times `(T,)`, s.
        pixel: centres `(T, 2)`, px; NaN where not valid.
        valid: `(T,)`.
        reason: why not, `(T,)` of words.
        mass: patch pixels found, relative to the first frame `(T,)`.
        box: search windows `(T, 4)`, px.
    """

    time_s: Float
    pixel: Float
    valid: NDArray[np.bool_]
    reason: tuple[str, ...]
    mass: Float
    box: NDArray[np.int64]


class PatchTracker:
    """Follows one patch, frame by frame; starts from the first frame and a box around the patch there.

    Raises `InputError` for a box that is not inside the frame or holds no colour that stands out.
    """

    def __init__(self, image: Image, box: Box, parameters: CamshiftParameters | None = None) -> None:
        self.parameters = parameters or CamshiftParameters()
        _check_box(image, box)
        self._histogram = _contrast_histogram(_hsv(image), box, self.parameters)
        found = self._measure(self._back_projection(image), box)
        if found is None or found.mass < 9:
            raise InputError(
                f"patch box {list(box)} holds {0 if found is None else found.mass:.0f} pixels of a colour that its "
                "surroundings do not have, expected at least 9: choose a box on a patch of a colour of its own"
            )
        self._first = found
        self._size = float(np.sqrt(found.mass))
        self._centre = found.centre
        self._velocity = np.zeros(2)
        self._box = found.box
        self._lost = False
        self._candidates: list[Float] = []
        self._others: list[Float] = []
        self._last_image: Image | None = None

    def update(self, image: Image) -> PatchSighting:
        """Look for the patch in the next frame, BGR `(H, W, 3)`."""
        if self._last_image is not None and np.array_equal(image, self._last_image):
            # A camera that was late shows its last image again: where the patch was then is not where it is now.
            return PatchSighting((np.nan, np.nan), False, "the frame repeats the one before", 1.0, self._box)
        self._last_image = image
        back = self._back_projection(image)
        if self._lost:
            found, reason = self._search(back)
        else:
            found = self._measure(back, self._window(image))
            reason = self._fault(found)
        share = 0.0 if found is None else found.mass / self._first.mass
        if found is None or reason:
            self._lost = True
            return PatchSighting((np.nan, np.nan), False, reason, share, self._box)
        self._accept(found, back)
        return PatchSighting((float(found.centre[0]), float(found.centre[1])), True, "", share, found.box)

    def _accept(self, found: _Found, back: Image) -> None:
        moved = found.centre - self._centre
        self._velocity = np.zeros(2) if self._lost else moved
        self._centre, self._box, self._lost = found.centre, found.box, False
        self._candidates = []
        # What stands beside the patch is not the patch: it must not be taken for it after a loss.
        self._others = [other.centre for other in self._blobs(back) if not self._near(other.centre, found.centre)]

    def _back_projection(self, image: Image) -> Image:
        p = self.parameters
        hsv = _hsv(image)
        back = cv2.calcBackProject([hsv], [0, 1], self._histogram, [0, 180, 0, 256], 1)
        coloured = cv2.inRange(hsv, (0, p.min_saturation, p.min_value), (180, 255, 255))
        return np.asarray(cv2.bitwise_and(back, coloured), dtype=np.uint8)

    def _window(self, image: Image) -> Box:
        """Where to look: the last window, carried on by the velocity, never smaller than the patch."""
        _, _, w, h = self._box
        side = int(2 * self._size)
        w, h = max(w, side), max(h, side)
        u, v = self._centre + self._velocity
        return _clip((round(u - w / 2), round(v - h / 2), w, h), image)

    def _measure(self, back: Image, window: Box) -> _Found | None:
        """CamShift from `window`, then the centroid of the patch pixels about what it found."""
        x, y, w, h = window
        if w < 1 or h < 1 or not back[y : y + h, x : x + w].any():
            return None
        criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1.0)
        _, (x, y, w, h) = cv2.CamShift(back, window, criteria)
        if w < 1 or h < 1:
            return None
        margin = max(2, round(0.15 * max(w, h)))
        x, y, w, h = _clip((x - margin, y - margin, w + 2 * margin, h + 2 * margin), back)
        inside = cv2.inRange(back[y : y + h, x : x + w], self.parameters.purity, 255)
        m = cv2.moments(inside, binaryImage=True)
        if m["m00"] < 1:
            return None
        centre = np.array([x + m["m10"] / m["m00"], y + m["m01"] / m["m00"]])
        return _Found(centre, float(m["m00"]), _aspect(m), (x, y, w, h))

    def _fault(self, found: _Found | None) -> str:
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
        if any(_distance(found.centre, o) < _distance(found.centre, expected) for o in self._others):
            return "something else of the patch's colour"
        jump = _distance(found.centre, expected) / self._size
        if jump > p.max_jump:
            return f"patch jumped by {jump:.1f} of its size"
        return ""

    def _search(self, back: Image) -> tuple[_Found | None, str]:
        """Look over the whole frame for the patch, passing over what already stood beside it."""
        best: _Found | None = None
        others = []
        for blob in self._blobs(back):
            if any(self._near(blob.centre, other) for other in self._others):
                others.append(blob.centre)
            elif self._looks_right(blob) and (best is None or blob.mass > best.mass):
                best = blob
        # Those that were hidden for now stay known; those that moved are followed.
        hidden = [other for other in self._others if not any(self._near(other, seen) for seen in others)]
        self._others = others + hidden
        if best is None:
            return None, "patch not found again"
        return best, "" if self._agrees(best) else "patch found again, not yet believed"

    def _blobs(self, back: Image) -> list[_Found]:
        """Everything in the frame of the patch's colour that is not much smaller."""
        patch = cv2.inRange(back, self.parameters.purity, 255)
        contours, _ = cv2.findContours(patch, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        found = []
        for contour in contours:
            m = cv2.moments(contour)
            if m["m00"] >= self.parameters.min_mass * self._first.mass:
                centre = np.array([m["m10"] / m["m00"], m["m01"] / m["m00"]])
                x, y, w, h = cv2.boundingRect(contour)
                found.append(_Found(centre, float(m["m00"]), _aspect(m), (x, y, w, h)))
        return found

    def _near(self, a: Float, b: Float) -> bool:
        return _distance(a, b) < self.parameters.max_jump * self._size

    def _looks_right(self, found: _Found) -> bool:
        p = self.parameters
        share, aspect = found.mass / self._first.mass, found.aspect / self._first.aspect
        return p.min_mass <= share <= p.max_mass and aspect <= p.max_aspect

    def _agrees(self, found: _Found) -> bool:
        """Whether it was already near here in the last frames: one look is not enough to believe it."""
        near = [c for c in self._candidates if self._near(c, found.centre)]
        self._candidates = [*near, found.centre]
        return len(self._candidates) >= self.parameters.agree


@dataclass(frozen=True, eq=False)
class _Found:
    centre: Float
    mass: float
    aspect: float
    box: Box


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
        mass=np.array([s.mass for s in sightings]),
        box=np.array([s.box for s in sightings], dtype=np.int64).reshape(-1, 4),
    )


def _distance(a: Float, b: Float) -> float:
    return float(np.linalg.norm(a - b))


def _hsv(image: Image) -> Image:
    return np.asarray(cv2.cvtColor(cv2.GaussianBlur(image, (3, 3), 0), cv2.COLOR_BGR2HSV), dtype=np.uint8)


def _check_box(image: Image, box: Box) -> None:
    x, y, w, h = box
    height, width = image.shape[:2]
    if w < 2 or h < 2 or x < 0 or y < 0 or x + w > width or y + h > height:
        raise InputError(
            f"patch box {list(box)} (x, y, width, height), expected at least 2 px wide and high and inside the "
            f"first frame of {width} x {height} px"
        )


def _contrast_histogram(hsv: Image, box: Box, p: CamshiftParameters) -> NDArray[np.float32]:
    """Per cell of hue and saturation, the chance (0-255) that a pixel of it belongs to the patch.

    From how often the cell occurs in the box and in the ring around it, equally weighed.
    """
    x, y, w, h = box
    coloured = cv2.inRange(hsv, (0, p.min_saturation, p.min_value), (180, 255, 255))
    inside = np.zeros(hsv.shape[:2], dtype=np.uint8)
    inside[y : y + h, x : x + w] = 255
    reach_x, reach_y = round(w * (0.5 + p.ring)), round(h * (0.5 + p.ring))
    ring = np.zeros_like(inside)
    ring[max(0, y - reach_y) : y + h + reach_y, max(0, x - reach_x) : x + w + reach_x] = 255
    ring[inside > 0] = 0
    if (ring > 0).sum() < 0.5 * w * h:
        raise InputError(
            f"patch box {list(box)} leaves {int((ring > 0).sum())} px around it in the frame, expected half "
            f"its own {w * h} px: draw it around the patch alone"
        )

    def share(mask: Image) -> NDArray[np.float32]:
        counts = cv2.calcHist(
            [hsv], [0, 1], cv2.bitwise_and(mask, coloured), [p.hue_bins, p.saturation_bins], [0, 180, 0, 256]
        )
        # A patch seen later is lit a little differently: let each cell speak for its neighbours. Hue wraps.
        padded = np.concatenate([counts[-2:], counts, counts[:2]])
        smooth = cv2.GaussianBlur(padded, (3, 3), 0.8)[2:-2]
        return np.asarray(smooth / max(1, int((mask > 0).sum())), dtype=np.float32)

    patch, around = share(inside), share(ring)
    # Cells that hold next to nothing of the box are not its colour, whatever the ring holds.
    enough = patch > 0.004
    chance = np.where(enough, patch / (patch + around + 1e-9), 0.0)
    # A patch has one hue: cells far from it are edges, where patch and skin mix.
    hue = (np.arange(p.hue_bins) + 0.5) * 180 / p.hue_bins
    main = hue[np.argmax((patch * chance).sum(axis=1))]
    chance[np.abs((hue - main + 90) % 180 - 90) > p.hue_width] = 0.0
    # Twice as common inside as around is where belief begins.
    return np.asarray(255 * np.clip((chance - 0.5) / 0.4, 0.0, 1.0), dtype=np.float32)


def _clip(box: Box, image: Image) -> Box:
    height, width = image.shape[:2]
    x0, y0 = min(max(box[0], 0), width - 1), min(max(box[1], 0), height - 1)
    x1, y1 = min(box[0] + box[2], width), min(box[1] + box[3], height)
    return x0, y0, max(x1 - x0, 0), max(y1 - y0, 0)


def _aspect(m: dict[str, float]) -> float:
    """Ratio of the long to the short axis of the pixels with moments `m`."""
    xx, yy, xy = m["mu20"] / m["m00"], m["mu02"] / m["m00"], m["mu11"] / m["m00"]
    mean, spread = 0.5 * (xx + yy), float(np.hypot(0.5 * (xx - yy), xy))
    # A twelfth is the variance of one pixel: keeps lines of one pixel finite.
    return float(np.sqrt((mean + spread + 1 / 12) / (max(mean - spread, 0.0) + 1 / 12)))
