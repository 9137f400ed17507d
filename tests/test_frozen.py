"""A picture that hangs is told from a person who holds still."""

from __future__ import annotations

import numpy as np
import pytest

from pytracker.evidence.frozen import Frozen

RATE_HZ = 30.0


def hung(at_px: np.ndarray, *, noise: float = 3.0, stays: tuple[int, int] = (0, 0)) -> list[int]:
    """Frames that are said to hang, of a hand at `at_px` `(T,)`, of which some show the first of them."""
    rng = np.random.default_rng(1)
    frozen, shown = Frozen(), np.zeros(0, np.uint8)
    for k, x in enumerate(at_px):
        if not stays[0] < k < stays[1]:
            image = np.full((96, 128, 3), 90.0)
            image[40:60, round(x) : round(x) + 32] = 190.0
            shown = np.clip(image + noise * rng.standard_normal(image.shape), 0, 255).astype(np.uint8)
        # As a coder leaves it, which sends a whole picture now and then.
        coded = shown.astype(int) + (k % 15 == 0) * (rng.random(shown.shape) < 0.2)
        frozen.look(k / RATE_HZ, np.clip(coded, 0, 255).astype(np.uint8))
    return np.flatnonzero(frozen.hung()).tolist()


GOES = 50.0 + 24.0 * np.sin(2.0 * np.pi * 0.25 * np.arange(120) / RATE_HZ)


def test_a_picture_that_hangs_and_leaps_is_told() -> None:
    assert hung(GOES, stays=(55, 80)) == list(range(56, 80))


@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_who_holds_still_and_goes_on_is_not(noise: float) -> None:
    """Without a camera's noise as with it: it begins little by little."""
    slows = np.concatenate([GOES[:31], np.full(60, GOES[30]), GOES[30:]])
    assert hung(slows, noise=noise) == []


def test_a_moment_does_no_harm() -> None:
    assert hung(GOES, stays=(55, 61)) == []
    assert hung(GOES[:3]) == []
