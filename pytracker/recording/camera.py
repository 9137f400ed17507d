"""Cameras: a calibrated pinhole, and weak perspective with how well it was fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pytracker.rotation import Array, Matrix, Triple

__all__ = ["Camera", "ProjectionFit", "WeakPerspective"]

OFF_MIDDLE = 0.1
"""A principal point lies in the middle of the picture, but for this share of its width and height,"""
SCALED, ALIKE = 0.05, 0.01
"""or for this share of both, where it is off by the same of either but for so much: of a picture that was scaled."""
UNLIKE = 0.05
"""Pixels are as wide as high, but for this share."""
MOST_TANGENTIAL = 0.03
"""Lenses are set askew by a third of this at the most."""
WIDEST = 3.0
"""Tangent of the widest angle from its axis at which a pinhole is looked at."""
FOLDS = 0.8
"""So much of the way to the edge, at least, a distortion must go on outwards."""
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A calibrated pinhole camera (OpenCV: x right, y down, z forward).

    Attributes:
        matrix: intrinsics, px.
        rotation: world to camera.
        translation_m: world to camera, m.
        distortion: k1 k2 p1 p2 k3.
        patch_offset_m: centre of the patch that it follows, in the segment's frame, m from the wrist.
    """

    matrix: Matrix
    rotation: Matrix = IDENTITY
    translation_m: Triple = (0.0, 0.0, 0.0)
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    patch_offset_m: Triple = (0.0, 0.0, 0.0)

    def oddities(self, size_px: tuple[int, int]) -> tuple[str, ...]:
        """A word each where no lens is so.

        A principal point far from the middle of such pictures, focal lengths that differ, and a distortion that is
        askew or folds the picture over.
        """
        (fx, _, cx), (_, fy, cy), _ = self.matrix
        width, height = size_px
        off, exchanged = (
            max(abs((a + 0.5) / width - 0.5), abs((b + 0.5) / height - 0.5)) for a, b in ((cx, cy), (cy, cx))
        )
        is_scaled = off > SCALED and abs((cx + 0.5) / width - (cy + 0.5) / height) < ALIKE
        words = []
        if off > OFF_MIDDLE or is_scaled:
            of = f"of about {2 * round(cx)} x {2 * round(cy)} px" if min(cx, cy) > 0 else "of another size"
            why = (
                "are cx and cy exchanged?" if exchanged < UNLIKE else f"was it calibrated on pictures {of}, or cut out?"
            )
            words.append(
                f"matrix has its principal point at ({cx:g}, {cy:g}), {off:.0%} off the middle of pictures of "
                f"{width} x {height} px, expected at most {SCALED if is_scaled else OFF_MIDDLE:.0%}: {why}"
            )
        if abs(fx / fy - 1.0) > UNLIKE:
            words.append(
                f"matrix has focal lengths of {fx:g} and {fy:g} px, expected the same but for {UNLIKE:.0%}: pixels are "
                "as wide as high but in old video formats; was it calibrated at another size?"
            )
        return (*words, *self._oddities_of_lens(size_px))

    def _oddities_of_lens(self, size_px: tuple[int, int]) -> list[str]:
        (fx, _, cx), (_, fy, cy), _ = self.matrix
        _, _, p1, p2, _ = self.distortion
        if max(abs(p1), abs(p2)) > MOST_TANGENTIAL:
            return [
                f"distortion has p1 = {p1:g} and p2 = {p2:g}, expected at most {MOST_TANGENTIAL:g}, in the order k1, "
                "k2, p1, p2, k3: are they a fisheye's four, or in another order?"
            ]
        x, y = np.linspace(0.0, WIDEST, 1000), np.zeros(1000)
        seen = np.maximum.accumulate(out := self._distorted(x, y)[0])
        widest = max(cx / fx, cy / fy, (size_px[0] - cx) / fx, (size_px[1] - cy) / fy)
        folds = int(np.argmax(out < seen)) if np.any(out < seen) else len(out) - 1
        if seen[folds] >= min(FOLDS * widest, WIDEST):
            return []
        # Wide lenses are calibrated by what is seen well inside their pictures.
        return [
            f"distortion folds the picture over {seen[folds] * fx:.0f} px from its middle, expected beyond its edge at "
            f"{widest * fx:.0f} px: are k1, k2, p1, p2, k3 in this order, and OpenCV's?"
        ]

    def project(self, points: Array) -> Array:
        """Pixels `(T, 2)` of world points `(T, 3)`; NaN behind the camera."""
        matrix, rotation, translation = self._arrays
        p = points @ rotation.T + translation
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
        if any(self.distortion):
            x, y = self._distorted(x, y)
        homogeneous = np.stack([x, y, np.ones_like(x)], axis=1) @ matrix.T
        homogeneous[p[:, 2] <= 0] = np.nan
        return np.ascontiguousarray(homogeneous[:, :2])

    @cached_property
    def _arrays(self) -> tuple[Array, Array, Array]:
        """Intrinsics, rotation and translation."""
        return np.array(self.matrix), np.array(self.rotation), np.array(self.translation_m)

    def _distorted(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Where its lens puts what a pinhole has at these places of the normalised picture, each `(T,)`."""
        k1, k2, p1, p2, k3 = self.distortion
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return xd, yd

    def px_per_m(self, points: Array) -> Array:
        """Pixels per metre across the viewing direction at world points `(T, 3)`, `(T,)`."""
        depth = points @ self._arrays[1][2] + self.translation_m[2]
        return np.asarray(0.5 * (self.matrix[0][0] + self.matrix[1][1]) / depth)

    def viewing_directions(self, points: Array) -> Array:
        """Unit vectors `(T, 3)` from the camera to world points `(T, 3)`."""
        rays = points - self.position_m
        return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

    def of_smaller(self, times: int) -> Camera:
        """The camera of its pictures made so many times smaller; centres of pixels are at integers in both."""
        (fx, skew, cx), (below, fy, cy), last = self.matrix
        rows = (
            (fx / times, skew / times, (cx + 0.5) / times - 0.5),
            (below / times, fy / times, (cy + 0.5) / times - 0.5),
        )
        return replace(self, matrix=(*rows, last))

    def ray(self, pixel: Array) -> Array:
        """Unit vector in the world, `(3,)`, from the camera through a pixel `(2,)`."""
        normal = np.linalg.solve(np.array(self.matrix), np.array([pixel[0], pixel[1], 1.0]))[:2]
        undistorted = normal.copy()
        # The inverse of the distortion has no closed form; this fixed point is OpenCV's own.
        k1, k2, p1, p2, k3 = self.distortion
        for _ in range(20):
            x, y = undistorted
            r2 = x * x + y * y
            radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
            shift = np.array([2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y])
            undistorted = (normal - shift) / radial
        ray = np.array(self.rotation).T @ np.array([*undistorted, 1.0])
        return np.asarray(ray / np.linalg.norm(ray))

    @property
    def position_m(self) -> Array:
        """Where the camera stands, world, m `(3,)`."""
        _, rotation, translation = self._arrays
        return np.asarray(-rotation.T @ translation)


@dataclass(frozen=True, kw_only=True)
class WeakPerspective:
    """A camera far away: Li & Kulić eq. (3).

    Attributes:
        affine: rows u and v: px per metre along x, y, z, and px.
    """

    affine: tuple[tuple[float, float, float, float], tuple[float, float, float, float]]

    def project(self, points: Array) -> Array:
        """Pixels `(T, 2)` of world points `(T, 3)`."""
        rows = np.array(self.affine)
        return np.asarray(points @ rows[:, :3].T + rows[:, 3])

    def px_per_m(self, points: Array) -> Array:
        """Pixels per metre at world points `(T, 3)`: the same everywhere, `(T,)`."""
        return np.full(len(points), float(np.linalg.norm(np.array(self.affine)[:, :3], axis=1).mean()))

    def of_smaller(self, times: int) -> WeakPerspective:
        """The camera of its pictures made so many times smaller; centres of pixels are at integers in both."""
        u, v = ((x / times, y / times, z / times, (at + 0.5) / times - 0.5) for x, y, z, at in self.affine)
        return WeakPerspective(affine=(u, v))

    def viewing_directions(self, points: Array) -> Array:
        """Unit vectors `(T, 3)` along which it sees world points `(T, 3)`: the same everywhere."""
        away = np.cross(*np.array(self.affine)[:, :3])
        return np.tile(away / np.linalg.norm(away), (len(points), 1))


@dataclass(frozen=True, kw_only=True, eq=False)
class ProjectionFit:
    """How well a weak-perspective matrix fits point pairs; Li & Kulić Table II. One row for u, one for v.

    Attributes:
        matrix: px per metre along x, y, z, and px `(2, 4)`; columns that were not fitted are zero.
        low: lower 95 % bound of every coefficient `(2, 4)`.
        high: upper bound.
        sse: sum of squared residuals, px² `(2,)`.
        r2: coefficient of determination `(2,)`.
        adjusted_r2: the same for the number of coefficients `(2,)`.
        rmse: sqrt(sse / (n - coefficients)), px `(2,)`.
        points_m: the world points `(n, 3)`.
        pixels: the image points `(n, 2)`.
    """

    matrix: Array
    low: Array
    high: Array
    sse: Array
    r2: Array
    adjusted_r2: Array
    rmse: Array
    points_m: Array
    pixels: Array
