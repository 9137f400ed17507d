"""`disagreement(track, truth)`: a truth that would fit a track far better otherwise: turned, later, faster, exchanged.

Errors then are those of how the truth is described, and no word about the track. A track that is wrong is wrong however
its truth is turned: what is compared is the same frames, before and after, and a turn is that of the whole.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pytracker.recording.recording import Truth
from pytracker.rotation import Array
from pytracker.scores.evaluate import Scored

__all__ = ["against_truth", "beside_truth", "disagreement"]

LEAST_FRAMES, MOST_FRAMES = 50, 1500
"""Fewer say too little; of more some are looked at, evenly."""
LEAST_SHARE = 0.5
"""Of a track's frames, within the times of the truth."""
OFF_M = 0.06
"""A truth that lies nearer is left alone."""
BETTER = 0.55
"""At other times errors must be so many times as large, or less, each joint's mean error aside, which is the depth's or
the origin's: of right truths of seven clips of people and twelve worn arms none is by less than 0.88, of 84 of other
takes none by less than 0.56."""
LEFT = 0.5
"""So many of the frames must be left."""
TURNED_BETTER, TURNED_DEG = 0.35, 25.0
"""The same of a turn, which takes away errors of the depth too; and no smaller one is told."""
ELSEWHERE_M = 0.5
"""No track is off by so much, all alike."""
FLAT = 0.15
"""Places that spread along an axis by less than this share of what they do along the longest say nothing of it."""
LAGS_S = np.concatenate([-(steps := np.arange(0.1, 3.01, 0.05))[::-1], steps])
RATES_HZ = np.array([24, 25, 30, 50, 60, 90, 100, 120, 125, 150, 200, 240, 250, 300, 360, 480, 500, 1000])
"""Of cameras; those that are taken for one another give the factors of times."""
FACTORS = np.setdiff1d(np.round(np.append((RATES_HZ[:, None] / RATES_HZ).ravel(), [0.9, 1.1]), 3), [1.0])
MOVES = 0.5
"""Joints that move so much of what the liveliest does are looked at, where it is about times; and by another
description a truth must move so much of what it does as it is."""
SIDES = {"left": "right", "right": "left"}
FOREARMS = [f"{side}_{joint}" for side in SIDES for joint in ("shoulder", "elbow", "wrist")]
FORWARDS_M, BACKWARDS_M = 0.05, 0.025
"""Wrists are so far before their elbows, on average, and of right truths never so far behind: of seven clips of people
3 to 15 cm before."""
HANDICAP_M = 0.01
"""A turn must explain it better than a lag by so much: what goes round is turned as it is late."""
LEAST_HELD = 0.7
"""Bands hold a truth in more of the frames, along each axis, over all joints and over those that move most: of people
and of simulations in 0.75 at least; of a truth of another take, or 10 cm elsewhere, in less, mostly."""
MIRRORED = "it were mirrored (check its axes, truth.up)"
EXCHANGED = "left and right were exchanged (check truth.markers; is it mirrored?)"


@dataclass(frozen=True)
class _Other:
    """Another description: errors by it and as it is, of the same frames, m; whether it is believed; in words.

    Of two that explain it as well the one with less of a `handicap_m` is told.
    """

    off_m: float
    before_m: float
    is_better: bool
    words: str
    handicap_m: float = 0.0

    @property
    def is_told(self) -> bool:
        return self.before_m >= OFF_M and self.is_better


def disagreement(track: Scored, truth: Truth | None) -> tuple[str, ...]:
    """A sentence where the truth would lie on the track if it were described otherwise; none of no truth."""
    if truth is None:
        return ()
    every = 1 + len(track.time_s) // MOST_FRAMES
    joints = {name: rows.mean[::every] for name, rows in track.joints.items() if name in truth.joints_m}
    means = {name: mean for name, mean in joints.items() if np.isfinite(mean).all(axis=1).sum() >= LEAST_FRAMES / every}
    if not means:
        return ()
    found = [other for other in _others(means, truth, track.time_s[::every]) if other.is_told]
    if not found:
        return ()
    # Sides that are told by where joints are are exchanged, whatever lag makes them move alike.
    best = min(found, key=lambda other: (other.words != EXCHANGED, other.off_m + other.handicap_m))
    return (
        f"the truth would be {100 * best.off_m:.0f} cm off the track, not {100 * best.before_m:.0f}, if {best.words}: "
        "errors may be those of the truth's description",
    )


def against_truth(track: Scored, truth: Truth | None) -> tuple[str, ...]:
    """A sentence where track and truth do not agree: by which description they would, else that bands do not hold it.

    None of no truth.
    """
    return disagreement(track, truth) or (
        () if truth is None else _backwards(track, truth) or _beside_bands(track, truth)
    )


def _backwards(track: Scored, truth: Truth) -> tuple[str, ...]:
    """A sentence where a body's forearms go backwards, as in a truth one of whose axes is negated, and in nobody."""
    if not all(name in truth.joints_m and name in track.joints for name in FOREARMS):
        return ()
    ours = _forwards({name: track.joints[name].mean for name in FOREARMS})
    theirs = _forwards({name: truth.at(name, track.time_s) for name in FOREARMS})
    if not (ours > FORWARDS_M and theirs < -BACKWARDS_M):
        return ()
    return (
        f"the truth's forearms go backwards from their elbows, by {-100 * theirs:.0f} cm on average, and the track's "
        f"forwards, by {100 * ours:.0f}: is one of its axes negated, or the truth mirrored (check its axes, truth.up)?",
    )


def _forwards(joints: Mapping[str, Array]) -> float:
    """How far wrists are before their elbows, as the shoulders face with y up, on average, m; NaN if never known."""
    front = np.cross(joints["left_shoulder"] - joints["right_shoulder"], np.array([0.0, 1.0, 0.0]))
    front = front / np.maximum(np.linalg.norm(front, axis=1, keepdims=True), 1e-9)
    each = [((joints[f"{side}_wrist"] - joints[f"{side}_elbow"]) * front).sum(axis=1) for side in SIDES]
    known = np.concatenate(each)
    known = known[np.isfinite(known)]
    return float(known.mean()) if len(known) >= LEAST_FRAMES else np.nan


def _beside_bands(track: Scored, truth: Truth) -> tuple[str, ...]:
    """A sentence where the truth lies beside the 95 % bands of the valid frames too often, along an axis.

    Over all joints, or over the liveliest: those that hardly move are where they are, whoever's truth it is.
    """
    held: dict[str, Array] = {}
    for name, rows in track.joints.items():
        at = truth.at(name, track.time_s) if name in truth.joints_m else np.full_like(rows.mean, np.nan)
        known = track.valid & rows.valid & np.isfinite(at + rows.lo + rows.hi).all(axis=1)
        if known.sum() >= LEAST_FRAMES:
            held[name] = ((at >= rows.lo) & (at <= rows.hi))[known].mean(axis=0)
    if not held:
        return ()
    lively = _liveliest({name: truth.joints_m[name] for name in held})
    over = {f"{len(held)} joints": list(held), f"the {len(lively)} that move most": list(lively)}
    shares = {words: np.mean([held[name] for name in names], axis=0) for words, names in over.items()}
    worst = min(shares, key=lambda words: float(shares[words].min()))
    axis = int(shares[worst].argmin())
    if shares[worst][axis] >= LEAST_HELD:
        return ()
    return (
        f"the bands of valid frames hold the truth in {shares[worst][axis]:.0%} of them along {'xyz'[axis]} (over "
        f"{worst}), expected 95%: the track is wrong and does not know it, or the truth is of another take, "
        "place or time (check truth.file, its origin and axes)",
    )


def _liveliest(joints: Mapping[str, Array]) -> list[str]:
    """The names of joints `(T, 3)` that move: what hardly does is where it is, whenever that was."""
    known = {name: places[np.isfinite(places).all(axis=1)] for name, places in joints.items()}
    moves = {name: float(np.linalg.norm(places.std(axis=0))) for name, places in known.items() if len(places)}
    return [name for name in moves if moves[name] >= MOVES * max(moves.values())]


def beside_truth(track: Scored, truth: Truth | None) -> tuple[str, ...]:
    """A sentence where most of a track's frames lie beyond the truth's times: scores are of the few that do not."""
    if truth is None or not len(track.time_s):
        return ()
    first_s, last_s = float(truth.time_s[0]), float(truth.time_s[-1])
    inside = int(((track.time_s >= first_s) & (track.time_s <= last_s)).sum())
    if inside >= LEAST_SHARE * len(track.time_s):
        return ()
    return (
        f"{inside} of {len(track.time_s)} frames, from {track.time_s[0]:g} to {track.time_s[-1]:g} s, lie within the "
        f"truth's times, {first_s:.3f} to {last_s:.3f} s: scores are of these alone; are its times in seconds?",
    )


def _others(means: Mapping[str, Array], truth: Truth, time_s: Array) -> Iterator[_Other]:
    lively = {name: means[name] for name in _liveliest(means)}
    track, as_is, first_s = np.stack(list(lively.values())), _at(truth, lively, time_s), truth.time_s[0]
    for lag_s in LAGS_S:
        later = _at(replace(truth, time_s=truth.time_s + lag_s), lively, time_s)
        yield _other(
            track,
            as_is,
            later,
            f"it came {abs(lag_s):.2f} s {'later' if lag_s > 0 else 'earlier'} (check truth.offset_s)",
        )
    for factor in FACTORS:
        slower = _at(replace(truth, time_s=first_s + factor * (truth.time_s - first_s)), lively, time_s)
        words = f"its times were {factor:g} times as far apart (check its rate, truth.rate_hz)"
        yield _other(track, as_is, slower, words)
    for names in (list(lively), [name for name in means if _other_side(name) != name]):
        if names and all(_other_side(name) in truth.joints_m for name in names):
            ours = np.stack([means[name] for name in names])
            yield _exchanged(ours, *(_at(truth, of, time_s) for of in (names, [_other_side(name) for name in names])))
    is_sided = any(name.startswith(tuple(SIDES)) for name in means)
    yield from _moved(np.stack(list(means.values())), _at(truth, means, time_s), is_sided=is_sided)


def _moved(track: Array, truth: Array, *, is_sided: bool) -> Iterator[_Other]:
    """By the shift, turn and mirror image that lay the truth's points on the track's best."""
    known = np.isfinite(track + truth).all(axis=-1)
    if known.sum() < LEAST_FRAMES:
        return
    before = float(np.sqrt(((track - truth)[known] ** 2).sum(axis=1).mean()))
    shift = (track[known] - truth[known]).mean(axis=0)
    track, truth = (points[known] - points[known].mean(axis=0) for points in (track, truth))
    shifted = float(np.sqrt(((track - truth) ** 2).sum(axis=1).mean()))
    if (far := float(np.linalg.norm(shift))) > ELSEWHERE_M:
        words = f"it lay {100 * far:.0f} cm elsewhere (check its origin, its unit)"
        yield _turned(shifted, before, words, 0.0)
    left, _, right = np.linalg.svd(truth.T @ track)
    sign = float(np.sign(np.linalg.det(left @ right)))
    spreads = [np.linalg.svd(points, compute_uv=False) for points in (track, truth)]
    flat = np.any([spread < FLAT * spread[0] for spread in spreads], axis=0)
    for mirrored in (1.0, -1.0):
        turn = left @ np.diag([1.0, 1.0, sign * mirrored]) @ right
        off = float(np.sqrt(((truth @ turn - track) ** 2).sum(axis=1).mean()))
        deg = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))))
        if mirrored > 0 and deg > TURNED_DEG and not flat[1]:
            words = f"it were turned by {deg:.0f}° and moved (check its axes, truth.up)"
            yield _turned(off, min(before, shifted), words)
        if mirrored < 0 and not flat[2] and not is_sided:
            yield _turned(off, min(before, shifted), MIRRORED)


def _turned(off_m: float, before_m: float, words: str, handicap_m: float = HANDICAP_M) -> _Other:
    return _Other(off_m, before_m, off_m < TURNED_BETTER * before_m, words, handicap_m)


def _other(track: Array, as_is: Array, other: Array, words: str) -> _Other:
    """Of the frames in which all three are known; nothing where these are few, or it hardly moves in them.

    A truth that stands still is in the middle of any track, and a track that does in that of any truth.
    """
    known = np.asarray(np.isfinite(track + as_is).all(axis=-1))
    both = known & np.isfinite(other).all(axis=-1)
    if both.sum() < max(1.0, LEFT * known.sum()) or _moves(other, both) < MOVES * _moves(as_is, both):
        return _Other(np.inf, 0.0, False, words)
    if _moves(track, both) < MOVES * _moves(other, both):
        return _Other(np.inf, 0.0, False, words)
    off, before = (_moves(track - at, both) for at in (other, as_is))
    return _Other(off, before, off < BETTER * before, f"{words}, each joint's mean error aside")


def _exchanged(track: Array, as_is: Array, exchanged: Array) -> _Other:
    """Of left and right: sides are told by where they are, and not by how they move, which may be alike."""
    known = np.isfinite(track + as_is + exchanged).all(axis=-1)
    if not known.any():
        return _Other(np.inf, 0.0, False, EXCHANGED)
    off, before = (float(np.sqrt(np.square(track - at)[known].sum(axis=-1).mean())) for at in (exchanged, as_is))
    return _Other(off, before, off < BETTER * before, EXCHANGED)


def _moves(places: Array, known: NDArray[np.bool_]) -> float:
    """How far joints `(J, T, 3)` are from where each is on average, RMS over known frames `(J, T)`, m."""
    spreads = [np.var(of[these], axis=0).sum() for of, these in zip(places, known, strict=True) if these.any()]
    return float(np.sqrt(np.mean(spreads)))


def _other_side(name: str) -> str:
    side, _, of = name.partition("_")
    return f"{SIDES.get(side, side)}_{of}"


def _at(truth: Truth, joints: Mapping[str, Array] | list[str], time_s: Array) -> Array:
    """`(J, T, 3)`."""
    return np.stack([truth.at(joint, time_s) for joint in joints])
