"""Numbers that the papers print, in their units."""

from __future__ import annotations

__all__ = ["FIG_5_CM", "RATE_HZ", "TABLE_II", "TABLE_I_CM", "TIME_PER_FRAME_S", "WORST_AT_80_CM"]

TABLE_I_CM = {
    "Inertial only": ((21.31, 37.70), (-12.41, 16.0), (6.74, 5.23)),
    "EKF": ((0.4, 3.30), (10.56, 9.39), (7.83, 5.72)),
    "PF": ((1.8, 2.67), (10.08, 6.55), (6.84, 4.15)),
    "PF with constraint": ((-0.68, 2.0), (1.14, 5.47), (1.77, 3.27)),
}
"""Tao & Hu, Table I: mean error and standard deviation along x, y, z, cm."""

WORST_AT_80_CM = {
    "EKF": ("10", "60", "40"),
    "PF": ("–", "up to 40", "up to 20"),
    "PF with constraint": ("5 (70 frames)", "5 (70 frames)", "5 (70 frames)"),
}
"""Tao & Hu, IV-A on Fig. 7: how far the error goes within 80 frames (70 with the constraint), cm."""

TIME_PER_FRAME_S = 0.17
"""Tao & Hu, IV-A: 500 particles on a Pentium 4 at 2.8 GHz."""

FIG_5_CM: dict[float, float] = {10: 18.0, 300: 7.0, 3000: 6.9}
"""Li & Kulić, V-B: overall average error against the number of particles, as the text gives it."""

FIG_5_SD_CM = 6.07
"""Li & Kulić, V-B: its standard deviation with 300 particles."""

RATE_HZ = 20
"""Li & Kulić, V-A: frames a second with 300 particles."""

TABLE_II = {
    "a, along x": (7.789, 7.617, 7.96),
    "a, along y": (0.0955, -0.1555, 0.3465),
    "a, constant": (159.4, 153.5, 165.3),
    "b, along x": (-0.2756, -0.5472, -0.003997),
    "b, along y": (-8.802, -9.199, -8.405),
    "b, constant": (336.0, 326.7, 345.3),
}
"""Li & Kulić, Table II: coefficients of eq. (3) with 95 % bounds; pixels per Acclaim unit, pixels."""

TABLE_II_GOODNESS = {
    "SSE": (327.7, 818.1),
    "R²": (0.9954, 0.981),
    "adjusted R²": (0.9951, 0.9801),
    "RMSE, px": (2.899, 4.58),
}
"""The same: goodness of fit of both rows."""

ACCLAIM_UNIT_M = 0.0254 / 0.45
"""A CMU skeleton's unit of length, m."""
