"""Student's t distribution, as far as confidence intervals need it."""

from __future__ import annotations

from statistics import NormalDist

__all__ = ["student_975"]

FEW = (12.706204736, 4.302652730, 3.182446305, 2.776445105, 2.570581836, 2.446911851)
"""97.5 % quantiles for 1 to 6 degrees of freedom, where the expansion is not good enough."""


def student_975(freedom: int) -> float:
    """97.5 % quantile of Student's t: tabled for few, else Abramowitz & Stegun 26.7.5."""
    if freedom <= len(FEW):
        return FEW[freedom - 1]
    z, n = NormalDist().inv_cdf(0.975), float(freedom)
    g1 = (z**3 + z) / 4
    g2 = (5 * z**5 + 16 * z**3 + 3 * z) / 96
    g3 = (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384
    g4 = (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / 92160
    return z + g1 / n + g2 / n**2 + g3 / n**3 + g4 / n**4
