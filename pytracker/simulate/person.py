"""What the simulated camera sees of a body: a wall with posters and a cast shadow, a clothed person, blur and noise.

Limbs are tapered capsules with a lit ridge, drawn from far to near at twice the size.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.formats.video import Image
from pytracker.recording.camera import Camera
from pytracker.rotation import Array
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["Clothes", "Limb", "Painter", "limbs"]

SCALE = 2
"""Drawn at so many times the size."""
SHIFT = 4
"""Fractional bits of OpenCV's drawing."""
SHADES = 5
CIRCLE = np.stack([np.cos(np.linspace(0, 2 * np.pi, 24)), np.sin(np.linspace(0, 2 * np.pi, 24))], axis=1)
RIMS = [(1 - k / SHADES) * CIRCLE + k / SHADES * np.array([-0.25, -0.45]) for k in range(SHADES)]
"""Of the shades of a limb's end, each within the one before and nearer to the light; of radius one."""
NOISE_FIELDS = 8
SOFT_PX = 9

Colour = tuple[int, int, int]
SKIN: Colour = (125, 158, 214)
HAIR: Colour = (32, 38, 48)
SHOES: Colour = (50, 50, 55)


@dataclass(frozen=True)
class Clothes:
    """BGR colours of pullover, sleeves' cuffs and trousers."""

    pullover: Colour
    trousers: Colour


@dataclass(frozen=True)
class Limb:
    """A capsule between two places of the skeleton: (bone, 0 start or 1 end), radii in m at either end."""

    start: tuple[str, int]
    end: tuple[str, int]
    radii_m: tuple[float, float]
    wear: str


@dataclass(frozen=True)
class Capsule:
    """A limb as it is painted: radii in m at either end, and a colour, or a grey level that is not lit."""

    radii_m: tuple[float, float]
    colour: Colour | int


def limbs() -> tuple[Limb, ...]:
    """The body, in no order."""
    body = [
        Limb(("root", 0), ("lowerback", 1), (0.150, 0.135), "pullover"),
        Limb(("lowerback", 1), ("thorax", 1), (0.135, 0.155), "pullover"),
        Limb(("lowerneck", 1), ("upperneck", 1), (0.050, 0.050), "skin"),
        Limb(("upperneck", 0), ("head", 1), (0.070, 0.085), "head"),
    ]
    for s in "lr":
        body += [
            Limb(("thorax", 1), (f"{s}clavicle", 1), (0.085, 0.070), "pullover"),
            Limb((f"{s}humerus", 0), (f"{s}humerus", 1), (0.062, 0.047), "pullover"),
            Limb((f"{s}radius", 0), (f"{s}wrist", 1), (0.046, 0.034), "pullover"),
            Limb((f"{s}hand", 0), (f"{s}fingers", 1), (0.034, 0.026), "skin"),
            Limb((f"{s}hipjoint", 1), (f"{s}femur", 1), (0.095, 0.062), "trousers"),
            Limb((f"{s}tibia", 0), (f"{s}tibia", 1), (0.060, 0.045), "trousers"),
            Limb((f"{s}foot", 0), (f"{s}toes", 1), (0.045, 0.035), "shoes"),
        ]
    return tuple(body)


class Painter:
    """Paints frames of one scene: its wall, its clothes and its noise stay.

    Args:
        camera: pinhole, at the size of the finished image.
        size: width and height of the finished image, px.
        clothes: what the person wears.
        wall_z_m: where the wall stands behind the person, world z, m.
        noise: standard deviation of the image noise, grey levels.
        rng: of this scene.
    """

    def __init__(
        self, camera: Camera, size: tuple[int, int], clothes: Clothes, wall_z_m: float, noise: float,
        rng: np.random.Generator,
    ) -> None:  # fmt: skip
        """Paint the wall."""
        self.camera, self.size, self.rng, self.noise = camera, size, rng, noise
        self.wall_z_m = wall_z_m
        self.colours: dict[str, Colour] = {
            "pullover": clothes.pullover, "trousers": clothes.trousers, "skin": SKIN, "head": SKIN, "shoes": SHOES,
        }  # fmt: skip
        self.wall = _wall((SCALE * size[0], SCALE * size[1]), rng)
        shape = (NOISE_FIELDS, size[1], size[0], 3)
        self.fields: NDArray[np.float32] = rng.standard_normal(shape, dtype=np.float32)

    def background(self) -> Image:
        """The scene without the person, as the camera would take it, noise and all."""
        return self._finish(self.wall.copy())

    def frames(self, skeleton: Skeleton, poses: Array, hidden: NDArray[np.bool_] | None = None) -> Iterator[Image]:
        """One image a pose; where `hidden`, a board is held before both forearms."""
        starts, ends, _ = skeleton.core.pose(np.ascontiguousarray(poses))
        index = {bone.name: k for k, bone in enumerate(skeleton.bones)}
        for k in range(len(poses)):
            places = {name: (starts[k, b], ends[k, b]) for name, b in index.items()}
            image = self._shadowed(places)
            self._person(image, places)
            if hidden is not None and hidden[k]:
                for s in "lr":
                    self._board(image, places[f"{s}radius"][0], places[f"{s}hand"][1])
            yield self._finish(image)

    def _shadowed(self, places: dict[str, tuple[Array, Array]]) -> Image:
        """The wall with the person's soft shadow, thrown down and to the side."""
        mask: Image = np.zeros(self.wall.shape[:2], np.uint8)
        ends = np.array([[places[bone][end] for bone, end in (limb.start, limb.end)] for limb in limbs()])
        behind = ends[:, :, 2:] - self.wall_z_m
        on_wall = np.concatenate(
            [ends[:, :, :2] - np.array([0.55, 0.45]) * behind, np.full_like(behind, self.wall_z_m)], 2
        )
        self._capsules(mask, on_wall, [Capsule(limb.radii_m, 255) for limb in limbs()], RIMS[:1])
        x, y, w, h = cv2.boundingRect(mask)
        # All that the blur reaches; beyond it nothing is dark.
        rows, columns = (slice(max(first - SOFT_PX, 0), last + SOFT_PX) for first, last in ((y, y + h), (x, x + w)))
        soft = np.asarray(cv2.GaussianBlur(mask[rows, columns], (0, 0), 2.5), dtype=np.float32)
        image = self.wall.copy()
        image[rows, columns] = image[rows, columns] * (1.0 - 0.35 * soft[..., None] / 255)
        return image

    def _person(self, image: Image, places: dict[str, tuple[Array, Array]]) -> None:
        """Limbs from far to near."""
        forward = np.array(self.camera.rotation)[2]
        drawn = [(limb, places[limb.start[0]][limb.start[1]], places[limb.end[0]][limb.end[1]]) for limb in limbs()]
        ends, capsules = [], []
        for limb, a, b in sorted(drawn, key=lambda item: -float(forward @ (item[1] + item[2]))):
            ends.append((a, b))
            capsules.append(Capsule(limb.radii_m, self.colours[limb.wear]))
            if limb.wear == "head":
                # Hair on the top and the back of it.
                up = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
                ends.append((b + 0.035 * up, b + 0.055 * up))
                capsules.append(Capsule((0.080, 0.070), HAIR))
        self._capsules(image, np.array(ends), capsules, RIMS)

    def _board(self, image: Image, a: Array, b: Array) -> None:
        pixels = SCALE * self.camera.project(np.stack([a, b]))
        low, high = pixels.min(axis=0) - 12 * SCALE, pixels.max(axis=0) + 12 * SCALE
        corners = np.rint(np.array([low, [high[0], low[1]], high, [low[0], high[1]]])).astype(np.int32)
        cv2.fillConvexPoly(image, corners, (96, 110, 104), cv2.LINE_AA)

    def _capsules(self, image: Image, ends: Array, capsules: list[Capsule], rims: list[Array]) -> None:
        """Between `ends` `(N, 2, 3)`, m, one after the other, lit from above: narrower and lighter ones on top."""
        points = ends.reshape(-1, 3)
        pixels = (SCALE * self.camera.project(points)).reshape(-1, 2, 2)
        scales = (SCALE * self.camera.px_per_m(points)).reshape(-1, 2)
        for (start, end), scale, capsule in zip(pixels, scales, capsules, strict=True):
            if not (np.isfinite(start).all() and np.isfinite(end).all()) or (scale <= 0).any():
                continue
            start_px, end_px = np.array(capsule.radii_m) * scale
            for shade, rim in enumerate(rims):
                outline = np.concatenate([start + start_px * rim, end + end_px * rim])
                hull = cv2.convexHull(np.rint(outline * (1 << SHIFT)).astype(np.int32))
                light = 0.62 + 0.38 * (shade + 1) / len(rims)
                paint = capsule.colour
                lit = paint if isinstance(paint, int) else tuple(min(255.0, light * c) for c in paint)
                cv2.fillConvexPoly(image, hull, lit, cv2.LINE_AA, SHIFT)

    def _finish(self, image: Image) -> Image:
        """To the camera's size, with the lens's blur and the sensor's noise."""
        small = cv2.GaussianBlur(cv2.resize(image, self.size, interpolation=cv2.INTER_AREA), (0, 0), 0.6)
        field = self.fields[self.rng.integers(NOISE_FIELDS)]
        # A field of noise shifted at random is as good as a new one, and far cheaper.
        shifted = np.roll(
            field, (int(self.rng.integers(self.size[1])), int(self.rng.integers(self.size[0]))), axis=(0, 1)
        )
        return np.asarray(np.clip(small + self.noise * shifted, 0, 255), dtype=np.uint8)


def _wall(size: tuple[int, int], rng: np.random.Generator) -> Image:
    """A mottled wall with a poster and a floor line."""
    width, height = size
    base = np.array([rng.uniform(115, 165)] * 3) + rng.uniform(-9, 9, 3)
    mottle = cv2.resize(rng.standard_normal((12, 16, 3)).astype(np.float32), size, interpolation=cv2.INTER_CUBIC)
    grain = cv2.GaussianBlur(rng.standard_normal((height, width, 3)).astype(np.float32), (0, 0), 1.5)
    light = np.linspace(1.06, 0.94, width, dtype=np.float32)[None, :, None]
    wall = np.clip((base + 4.0 * mottle + 5.0 * grain) * light, 0, 255).astype(np.uint8)
    colour = tuple(float(c) for c in rng.uniform(40, 200, 3))
    left = int(rng.uniform(0.0, 0.06) * width)
    cv2.rectangle(wall, (left, int(0.06 * height)), (left + int(0.12 * width), int(0.45 * height)), colour, cv2.FILLED)
    cv2.line(wall, (0, int(0.985 * height)), (width, int(0.985 * height)), (60, 62, 66), 4)
    return np.asarray(wall, dtype=np.uint8)
