"""Weak perspective from point pairs, by least squares, with what Li & Kulić report in Table II."""

from __future__ import annotations

import numpy as np

from pytracker._core import InputError
from pytracker.recording.camera import ProjectionFit, WeakPerspective
from pytracker.rotation import Array
from pytracker.student import student_975

__all__ = ["camera_of", "fit_weak_perspective"]

COEFFICIENTS = 3
"""Of a row of eq. (3): along x, along y, constant."""

MOST = {"point": 1e6, "pixel": 1e6}
"""No place is farther, not even in millimetres, and no picture larger, px."""


def fit_weak_perspective(points_3d: Array, points_2d: Array) -> ProjectionFit:
    """Fit eq. (3), `pixel = A (x, y) + c`, to world points `(n, 3)`, m, and pixels `(n, 2)`.

    Raises `InputError` for fewer than four pairs, numbers that are not finite, or points that lie on a line.
    """
    points, pixels = np.asarray(points_3d, dtype=float), np.asarray(points_2d, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or pixels.shape != (len(points), 2):
        raise InputError(f"point pairs have shapes {points.shape} and {pixels.shape}, expected (n, 3) and (n, 2)")
    if len(points) <= COEFFICIENTS:
        raise InputError(f"there are {len(points)} point pairs, expected at least {COEFFICIENTS + 1}")
    for name, values in (("point", points), ("pixel", pixels)):
        bad = np.argwhere(~(np.abs(values) <= MOST[name]))
        if bad.size:
            raise InputError(
                f"{name} {bad[0][0]} is {values[bad[0][0]]}, expected finite numbers within ±{MOST[name]:g}"
            )
    design = np.column_stack([points[:, :2], np.ones(len(points))])
    scale = np.ptp(points[:, :2], axis=0).max()
    if np.linalg.matrix_rank(design - [*points[:, :2].mean(axis=0), 0.0], tol=1e-6 * max(scale, 1e-9)) < COEFFICIENTS:
        raise InputError("the points lie on one line of the image plane, expected them to spread in x and y")
    coefficients, *_ = np.linalg.lstsq(design, pixels, rcond=None)
    residual = pixels - design @ coefficients
    freedom = len(points) - COEFFICIENTS
    sse = (residual**2).sum(axis=0)
    spread = ((pixels - pixels.mean(axis=0)) ** 2).sum(axis=0)
    flat = np.flatnonzero(spread <= 0)
    if flat.size:
        raise InputError(
            f"{'uv'[flat[0]]} is {pixels[0, flat[0]]:g} in every pair, expected points all over the picture"
        )
    r2 = 1 - sse / spread
    covariance = np.linalg.inv(design.T @ design)
    half = student_975(freedom) * np.sqrt(np.outer(sse / freedom, np.diag(covariance)))

    def rows(values: Array) -> Array:
        """`(2, 3)` as `(2, 4)`: nothing along z."""
        return np.insert(values, 2, 0.0, axis=1)

    return ProjectionFit(
        matrix=rows(coefficients.T),
        low=rows(coefficients.T - half),
        high=rows(coefficients.T + half),
        sse=sse,
        r2=r2,
        adjusted_r2=1 - (1 - r2) * (len(points) - 1) / freedom,
        rmse=np.sqrt(sse / freedom),
        points_m=points,
        pixels=pixels,
    )


def camera_of(fit: ProjectionFit) -> WeakPerspective:
    """The camera that was fitted."""
    u, v = (tuple(float(x) for x in row) for row in fit.matrix)
    return WeakPerspective(affine=(u, v))  # type: ignore[arg-type]  # four numbers each
