"""`disagreement(track, truth)`: a truth that would fit a track far better otherwise: turned, later, faster, exchanged.

Errors then are those of how the truth is described, and no word about the track.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from pytracker.recording.recording import Truth
from pytracker.rotation import Array
from pytracker.scores.evaluate import Scored

__all__ = ["disagreement"]

LEAST_FRAMES = 50
"""Fewer say too little."""
OFF_M = 0.06
"""A truth that lies nearer is left alone."""
BETTER = 0.5
"""By another description errors must be so many times as large, or less."""
TURNED_BETTER, TURNED_DEG = 0.35, 25.0
"""The same of a turn, which takes away errors of the depth too; and no smaller one is told."""
LAGS_S = np.concatenate([-(steps := np.arange(0.1, 3.01, 0.05))[::-1], steps])
FACTORS = np.array([0.25, 0.4, 0.5, 0.6, 0.667, 0.8, 0.833, 0.9, 0.96, 1.04, 1.1, 1.2, 1.25, 1.5, 1.667, 2.0, 2.5, 4.0])
"""Of times: rates that are taken for one another."""
MOVES = 0.5
"""Joints that move so much of what the liveliest does are looked at."""
SIDES = {"left": "right", "right": "left"}
EXCHANGED = "left and right were exchanged (check truth.markers; is it mirrored?)"
MIRRORED = "it were mirrored (check its axes, truth.up)"


def disagreement(track: Scored, truth: Truth | None) -> tuple[str, ...]:
    """A sentence where the truth would lie on the track if it were described otherwise; none of no truth."""
    if truth is None:
        return ()
    means = {joint: track.joints[joint].mean for joint in track.joints if joint in truth.joints_m}
    # What hardly moves is where it is, whenever that was.
    moves = {joint: float(np.linalg.norm(np.nanstd(mean, axis=0))) for joint, mean in means.items()}
    means = {joint: mean for joint, mean in means.items() if moves[joint] >= MOVES * max(moves.values())}
    off = _off(means, _at(truth, means, track.time_s))
    if not np.isfinite(off) or off < OFF_M:
        return ()
    found = [(of, words) for of, words, better in _others(means, truth, track.time_s) if of < better * off]
    if not found:
        return ()
    best, words = min(found)
    return (
        f"the truth's {', '.join(means).replace('_', ' ')} would be {100 * best:.0f} cm off the track, not "
        f"{100 * off:.0f}, if {words}: errors may be those of the truth's description",
    )


def _others(means: Mapping[str, Array], truth: Truth, time_s: Array) -> Iterator[tuple[float, str, float]]:
    """Errors, m, by truths that are described otherwise; how, in words; and how much smaller they must be to tell."""
    first_s = truth.time_s[0]
    for lag_s in LAGS_S:
        later = replace(truth, time_s=truth.time_s + lag_s)
        yield _off(means, _at(later, means, time_s)), f"it came {lag_s:+.2f} s later (check truth.offset_s)", BETTER
    for factor in FACTORS:
        slower = replace(truth, time_s=first_s + factor * (truth.time_s - first_s))
        words = f"its times were {factor:g} times as far apart (check its rate, truth.rate_hz)"
        yield _off(means, _at(slower, means, time_s)), words, BETTER
    at = _at(truth, means, time_s)
    yield _off(means, {joint: at.get(_other_side(joint), of) for joint, of in at.items()}), EXCHANGED, BETTER
    for of, words, better in _turned(means, at):
        # What is mirrored has its sides exchanged.
        if words != MIRRORED or not any(joint.startswith(tuple(SIDES)) for joint in means):
            yield of, words, better


def _turned(means: Mapping[str, Array], at: Mapping[str, Array]) -> Iterator[tuple[float, str, float]]:
    """By the turn, and the mirror image, that lay the truth's points on the track's best."""
    track, truth = (np.concatenate([of[joint] for joint in means]) for of in (means, at))
    known = np.isfinite(track + truth).all(axis=1)
    track, truth = (points[known] - points[known].mean(axis=0) for points in (track, truth))
    left, _, right = np.linalg.svd(truth.T @ track)
    sign = np.sign(np.linalg.det(left @ right))
    for is_mirrored in (False, True):
        turn = left @ np.diag([1.0, 1.0, -sign if is_mirrored else sign]) @ right
        of = float(np.sqrt(((truth @ turn - track) ** 2).sum(axis=1).mean()))
        deg = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))))
        if is_mirrored:
            yield of, MIRRORED, TURNED_BETTER
        elif deg > TURNED_DEG:
            yield of, f"it were turned by {deg:.0f}° and moved (check its axes, truth.up)", TURNED_BETTER


def _other_side(joint: str) -> str:
    side, _, of = joint.partition("_")
    return f"{SIDES.get(side, side)}_{of}"


def _at(truth: Truth, joints: Iterable[str], time_s: Array) -> dict[str, Array]:
    return {joint: truth.at(joint, time_s) for joint in joints}


def _off(means: Mapping[str, Array], at: Mapping[str, Array]) -> float:
    """Root mean square distance, m; infinite where too few frames have both."""
    squares = np.concatenate([((means[joint] - at[joint]) ** 2).sum(axis=1) for joint in means])
    known = np.isfinite(squares)
    if known.sum() < LEAST_FRAMES * max(1, len(means)) or known.mean() < BETTER:
        return np.inf
    return float(np.sqrt(squares[known].mean()))
