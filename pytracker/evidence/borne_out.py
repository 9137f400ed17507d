"""Whether a frame bears a pose out: hands and forearms where skin is, skin that somebody wears, joints on the person.

A particle filter always has a mean. What the picture says against it is kept frame by frame and made into reasons.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.silhouette import BodyEvidence
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array

__all__ = ["WINDOW_S", "BorneOut", "head_off"]

SIDES = ("left", "right")
FAR_M = 0.10
"""A wrist this far from any skin is not where it is thought to be: half a hand's length."""
REACH_M = 0.12
"""Skin this far from head, forearms and hands is nobody's."""
BEYOND_WRIST = 1.35
"""A hand goes on from the forearm by so much of it."""
NOBODYS = 0.30
"""This share of the skin that is nobody's, and an arm is elsewhere."""
UNKNOWN_M = 0.125
"""A wrist whose standard deviation across the picture is larger may be anywhere.

On people whose hand was lost it is 0.11 to 0.16 m,
else 0.06 to 0.1."""
OFF_PERSON_M = 0.08
"""Clothes of the wall's colour leave holes in the foreground, m."""
WINDOW_S = 0.25
"""Reasons are of this much time: one frame's mask may be wrong."""
MOST_M = 0.5


CROWN_M = 0.11
"""The crown is so far above the end of a CMU skeleton's head: 9 to 13 cm on clips of people and on simulations."""
COLUMN_M = 0.10


def head_off(camera: Camera | WeakPerspective, joints: Mapping[str, Array], evidence: BodyEvidence) -> Array:
    """How far the person's head is right of and below the skeleton's, m `(2,)`; NaN where none is seen there."""
    u, v = camera.project(joints["head"][None])[0]
    px_per_m = float(camera.px_per_m(joints["root"][None])[0])
    mask = evidence.foreground
    height, width = mask.shape
    if not (np.isfinite([u, v]).all() and 0 <= v < height and 0 <= u < width):
        return np.full(2, np.nan)
    reach = round(COLUMN_M * px_per_m)
    rows = np.flatnonzero(mask[:, max(0, round(u) - reach) : round(u) + reach + 1].any(axis=1))
    on = np.flatnonzero(mask[min(height - 1, round(v))])
    if not len(rows) or not len(on):
        return np.full(2, np.nan)
    runs = np.split(on, np.flatnonzero(np.diff(on) > 1) + 1)
    nearest = min(runs, key=lambda run: float(np.abs(run - u).min()))
    return np.array([0.5 * (nearest[0] + nearest[-1]) - u, rows[0] + CROWN_M * px_per_m - v]) / px_per_m


class BorneOut:
    """What the frames so far say of the pose."""

    def __init__(self, camera: Camera | WeakPerspective) -> None:
        self._camera = camera
        self._time_s: list[float] = []
        self._off_skin: list[list[float]] = []
        self._nobodys: list[float] = []
        self._off_person: list[list[float]] = []
        self._spread: list[list[float]] = []

    def look(
        self, time_s: float, joints: Mapping[str, Array], sds: Mapping[str, Array], evidence: BodyEvidence
    ) -> None:
        """Take a frame's mean joints and their standard deviations, `(3,)` each, world, m, and what it shows."""
        names = list(joints)
        places = np.stack([joints[name] for name in names])
        pixels = dict(zip(names, self._camera.project(places), strict=True))
        px_per_m = float(self._camera.px_per_m(places[:1])[0])
        self._time_s.append(time_s)
        skin, person = evidence.skin_region, evidence.foreground_region
        wrists = [pixels[f"{side}_wrist"] for side in SIDES]
        self._off_skin.append([np.nan] * 2 if skin is None else [_distance(skin[0], at) / px_per_m for at in wrists])
        arms = [pixels[f"{side}_{joint}"] for side in SIDES for joint in ("elbow", "wrist")]
        self._off_person.append(
            [np.nan] * 4 if person is None else [_distance(person[0], at) / px_per_m for at in arms]
        )
        across = _across(self._camera)
        self._spread.append([float(np.sqrt(np.sum(across**2 @ sds[f"{side}_wrist"] ** 2))) for side in SIDES])
        self._nobodys.append(0.0 if skin is None else _nobodys(skin[1], pixels, REACH_M * px_per_m))

    def reasons(self) -> list[str]:
        """Of every frame, in words; empty where nothing speaks against it."""
        time_s = np.array(self._time_s)
        off_skin = _recent(time_s, np.minimum(np.array(self._off_skin), MOST_M))
        off_person = _recent(time_s, np.minimum(np.array(self._off_person), MOST_M))
        spread = _recent(time_s, np.array(self._spread))
        nobodys = _recent(time_s, np.array(self._nobodys)[:, None])[:, 0]
        reasons = []
        for k in range(len(time_s)):
            words = [
                f"{side} arm: not where the person is"
                for s, side in enumerate(SIDES)
                if np.nanmax([*off_person[k, 2 * s : 2 * s + 2], 0.0]) > OFF_PERSON_M
            ]
            words += [f"{side} hand: no skin there" for s, side in enumerate(SIDES) if off_skin[k, s] > FAR_M]
            words += [
                f"{side} wrist: not known across the picture"
                for s, side in enumerate(SIDES)
                if spread[k, s] > UNKNOWN_M
            ]
            if nobodys[k] > NOBODYS:
                words.append("skin that no arm explains")
            reasons.append("; ".join(words))
        return reasons


def _across(camera: Camera | WeakPerspective) -> Array:
    """Unit vectors across the picture, `(2, 3)`."""
    rows = np.array(camera.rotation)[:2] if isinstance(camera, Camera) else np.array(camera.affine)[:, :3]
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


def _distance(distance_px: NDArray[np.float32], at: Array) -> float:
    """Of a pixel from a mask, px; NaN outside the picture, where nothing is known."""
    if not np.isfinite(at).all():
        return float("nan")
    u, v = (round(float(x)) for x in at)
    height, width = distance_px.shape
    return float(distance_px[v, u]) if 0 <= u < width and 0 <= v < height else float("nan")


def _nobodys(points: Array, pixels: Mapping[str, Array], reach_px: float) -> float:
    """Share of points on skin that are far from the head's line and from those of forearms and hands."""
    shoulders = 0.5 * (pixels["left_shoulder"] + pixels["right_shoulder"])
    lines = [(shoulders, pixels["head"])]
    for side in SIDES:
        elbow, wrist = pixels[f"{side}_elbow"], pixels[f"{side}_wrist"]
        lines.append((elbow, elbow + BEYOND_WRIST * (wrist - elbow)))
    nearest = np.full(len(points), np.inf)
    for start, end in lines:
        along = end - start
        share = np.clip((points - start) @ along / max(float(along @ along), 1e-9), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(points - start - share[:, None] * along, axis=1))
    return float((nearest > reach_px).mean()) if len(points) else 0.0


def _recent(time_s: Array, values: Array) -> Array:
    """Mean of what is known over the last `WINDOW_S` `(T, K)`; NaN where nothing is."""
    known = np.isfinite(values)
    sums = np.cumsum(np.vstack([np.zeros((1, values.shape[1])), np.where(known, values, 0.0)]), axis=0)
    counts = np.cumsum(np.vstack([np.zeros((1, values.shape[1])), known]), axis=0)
    first = np.searchsorted(time_s, time_s - WINDOW_S, side="right")
    last = np.arange(1, len(time_s) + 1)
    with np.errstate(invalid="ignore"):
        return np.asarray((sums[last] - sums[first]) / (counts[last] - counts[first]))
