"""A body's first pose from the outline and the skin of its first frame, where no keypoints are.

What the foreground shows lies on some limb, and every limb on the foreground; what skin shows on head, forearms and
hands, and hands on skin. Who stands is as tall as they are, which tells how far off they are if the feet are in the
picture; and looks at the camera: an outline does not tell front from back. Depth is as people usually stand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytracker.evidence.picture.largest import Box, largest_person
from pytracker.evidence.picture.silhouette import BodyEvidence
from pytracker.evidence.pose.ambiguity import to_line
from pytracker.evidence.pose.borne_out import CROWN_M
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array
from pytracker.setup.poses.fit import (
    ARM,
    CHANNELS,
    HIPS_M,
    MIRRORED,
    SDS,
    FoundPose,
    along,
    distance_sd,
    faced,
    fitted_from,
    named,
    starts,
    turn_to,
)
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["Outlined", "first_outline"]

HIPS_SHARE = 0.53
"""Of the height, from the floor up."""
USUAL_M = 1.70
"""Of whom the half-widths of limbs are."""
POINTS = 160
"""So many points of the foreground are asked, and half as many of the skin."""
SD_M, MOST_M = 0.03, 0.10
"""A point that is explained lies beside its limb by so much; and farther off than this is as bad as any."""
FOREGROUND_WEIGHT, SKIN_WEIGHT, ON_WEIGHT = 60.0, 40.0, 0.36
"""All points of a mask count as so many that are independent, and every place on a limb as so much of one."""
ON_LIMB = (0.0, 0.5, 1.0)
"""Where on a limb it is looked for foreground."""
RIM_PX = 3
"""A foreground that ends so near the lower rim goes on beyond it: feet are not seen."""
PLACE_SD_M = 0.06
"""Sideways and in height, where the outline is whole."""
MIRRORED_SD = np.radians(50.0)
"""Of one arm's angles against the other's."""
LEAN_RAD = np.radians(-4.0)
"""Who stands at ease has the shoulders behind the hips' joints: by 3 to 8 degrees on filmed people."""
TURN_SDS = np.radians([5.0, 8.0, 5.0])
"""An outline hardly tells that the trunk leans or turns."""
SHARES = (0.95, 0.75, 0.55)
"""Of a person's height that may be seen where the feet are not."""
SIZE_SHARE = 0.05
"""An outline is so much taller or smaller than a skeleton: hair, shoes, a shadow at the feet."""
DISTANCE_SHARE = 0.08
"""That, and that a skeleton of a height is not the person of that height."""
EXPLAINED, ON_PERSON = 0.85, 0.85
"""Shares of the foreground's points within 5 cm of a limb, and of the limbs' places on the foreground, of what fits."""
NEAR_M = 0.05

Limb = tuple[Array, Array, float]
"""Ends `(K, 3)`, m, and half-width, m."""
SKINNED = slice(3, 10)
"""Of the limbs: head, then forearm, hand and the bare part of the upper arm of either side."""
HANDS = (5, 8)
SLEEVE = 0.6
"""So much of the upper arm, from the elbow up, may be bare."""


@dataclass(frozen=True, eq=False)
class Outlined(FoundPose):
    """A pose that fits an outline.

    Attributes:
        explained: share of the foreground that lies on a limb.
        on_person: share of the limbs that lie on the foreground.
        is_whole: whether the feet are seen.
    """

    explained: float
    on_person: float
    is_whole: bool

    @property
    def fits(self) -> bool:
        """Whether outline and limbs agree."""
        return self.explained >= EXPLAINED and self.on_person >= ON_PERSON


def first_outline(
    skeleton: Skeleton, camera: WeakPerspective | Camera, image: Image, background: Image, focal_sd: float = 0.0
) -> Outlined:
    """From the first frame and the scene without the person, BGR `(H, W, 3)`; `focal_sd` of the camera is a share.

    Raises `InputError` where nobody is seen.
    """
    evidence, box = largest_person(image, background, _height_m(skeleton))
    return faced(skeleton, camera, lambda seen_by: _Fit(skeleton, seen_by, evidence, box).found(focal_sd))


def _height_m(skeleton: Skeleton) -> float:
    """From crown to sole of who stands straight."""
    near, ends, _ = skeleton.core.pose(np.zeros((1, len(skeleton.channels))))
    return float(ends[0, skeleton.bone("head"), 1] + CROWN_M - np.minimum(near, ends)[0, :, 1].min())


class _Fit:
    """What a frame says of poses."""

    def __init__(
        self,
        skeleton: Skeleton,
        camera: WeakPerspective | Camera,
        evidence: BodyEvidence,
        box: Box,
    ) -> None:
        assert evidence.foreground_region is not None
        self.skeleton, self.camera, self.box = skeleton, camera, box
        self.height_m = _height_m(skeleton)
        self.is_whole = box[3] < len(evidence.foreground) - RIM_PX
        self._columns = skeleton.columns(CHANNELS)
        self._person = evidence.foreground_region[0]
        self._on_person = _some_of(evidence.foreground, box, POINTS)
        self._skin = None if evidence.skin_region is None else evidence.skin_region[0]
        self._on_skin = _some_of(evidence.skin, box, POINTS // 2)
        self._sds = SDS.copy()
        self._sds[3:6] = TURN_SDS

    def found(self, focal_sd: float) -> Outlined:
        """The best pose from all starts."""
        priors = []
        for share in (1.0,) if self.is_whole else SHARES:
            stands = self._stands(share)
            if self.is_whole:
                self._sds[:3] = self._place_sds(stands)
            priors += starts(stands)
        best, _ = min(fitted_from(self.residuals, priors), key=lambda fit: fit[1] + _lopsided(fit[0]))
        beside, on = self._beside(best[None])
        share = DISTANCE_SHARE if self.is_whole else 2.0 * DISTANCE_SHARE
        distance_sd_m = distance_sd(self.camera, best[None, :3], focal_sd, share)
        return Outlined(
            named(zip(CHANNELS, best.tolist(), strict=True)),
            distance_sd_m,
            float((beside[0] < NEAR_M).mean()),
            float((on[0] < NEAR_M).mean()),
            self.is_whole,
        )

    def residuals(self, values: Array, prior: Array) -> Array:
        """`(K, R)` of `(K, D)`: points of masks, places on limbs, and the prior, in standard deviations."""
        limbs, pixels, px_per_m = self._posed(values)
        beside, on = self._apart(limbs, pixels, px_per_m)
        rows = [_capped(beside) * np.sqrt(FOREGROUND_WEIGHT / beside.shape[1]), _capped(on) * np.sqrt(ON_WEIGHT)]
        if self._skin is not None and len(self._on_skin):
            off = _beside_limbs(self._on_skin, limbs, pixels, px_per_m, range(len(limbs))[SKINNED])
            rows.append(_capped(off) * np.sqrt(SKIN_WEIGHT / off.shape[1]))
            hands = np.stack([pixels[:, 2 * k + end] for k in HANDS for end in (0, 1)], axis=1)
            rows.append(_capped(_off_mask(self._skin, hands) / px_per_m[:, None]) * np.sqrt(ON_WEIGHT))
        return np.concatenate([*rows, (values - prior) / self._sds], axis=1)

    def _beside(self, values: Array) -> tuple[Array, Array]:
        return self._apart(*self._posed(values))

    def _apart(self, limbs: list[Limb], pixels: Array, px_per_m: Array) -> tuple[Array, Array]:
        """How far points of the foreground are from limbs, and places on limbs from the foreground, m."""
        beside = _beside_limbs(self._on_person, limbs, pixels, px_per_m, range(len(limbs)))
        ends = pixels.reshape(len(pixels), -1, 2, 2)
        on = np.concatenate([ends[:, :, 0] + share * (ends[:, :, 1] - ends[:, :, 0]) for share in ON_LIMB], axis=1)
        return beside, _off_mask(self._person, on) / px_per_m[:, None]

    def _posed(self, values: Array) -> tuple[list[Limb], Array, Array]:
        """Limbs, their ends in the picture `(K, 2 L, 2)`, px, and px/m `(K,)`."""
        poses = np.zeros((len(values), len(self.skeleton.channels)))
        poses[:, self._columns] = values
        limbs = _limbs(self.skeleton, poses, self.height_m / USUAL_M)
        ends = np.stack([end for a, b, _ in limbs for end in (a, b)], axis=1)
        pixels = self.camera.project(ends.reshape(-1, 3)).reshape(len(values), -1, 2)
        px_per_m = self.camera.px_per_m(ends[:, 0])
        return limbs, np.nan_to_num(pixels, nan=1e5), np.maximum(np.nan_to_num(px_per_m), 1e-3)

    def _stands(self, share: float) -> Array:
        """Where a person stands of whom so much is seen, and that they look at the camera: root_tx .. root_rz."""
        left, top, right, bottom = self.box
        tall = (bottom - top) / share
        hips = np.array(
            [0.5 * (left + right), bottom - HIPS_SHARE * tall if share == 1.0 else top + (1 - HIPS_SHARE) * tall]
        )
        if isinstance(self.camera, Camera):
            place = along(self.camera, hips, self.height_m / tall)
        else:
            affine = np.array(self.camera.affine)
            start = np.array([0.0, HIPS_M, 0.0])
            x, y = np.linalg.lstsq(affine[:, :2], hips - self.camera.project(start[None])[0], rcond=None)[0]
            place = start + np.array([x, y, 0.0])
        return np.array([*place, LEAN_RAD, turn_to(self.camera, place), 0.0])

    def _place_sds(self, stands: Array) -> Array:
        if not isinstance(self.camera, Camera):
            return np.array([2 * PLACE_SD_M, 2 * PLACE_SD_M, SDS[2]])
        ray = stands[:3] - self.camera.position_m
        return np.maximum(PLACE_SD_M, np.abs(ray) * SIZE_SHARE)


def _limbs(skeleton: Skeleton, poses: Array, wide: float) -> list[Limb]:
    """Sides and middle of the trunk, head and what may be bare of the arms, then upper arms, legs and feet."""
    near, ends, _ = skeleton.core.pose(poses)

    def at(bone: str, of: Array = ends) -> Array:
        return np.asarray(of[:, skeleton.bone(bone)])

    shoulders, hips = ([at(f"{side}{bone}", near) for side in "lr"] for bone in ("humerus", "femur"))
    inner = [0.88 * one + 0.12 * other for one, other in (shoulders, shoulders[::-1])]
    neck, head = at("upperneck", near), at("head")
    up = (head - neck) / np.linalg.norm(head - neck, axis=1, keepdims=True)
    trunk = [(hips[0], inner[0], 0.09), (hips[1], inner[1], 0.09), (at("lowerback", near), at("thorax"), 0.11)]
    bare: list[Limb] = [(neck, head + 0.03 * up, 0.085)]
    others: list[Limb] = []
    for side, shoulder, hip in zip("lr", shoulders, hips, strict=True):
        elbow, wrist = at(f"{side}humerus"), at(f"{side}wrist")
        bare += [
            (elbow, wrist, 0.04),
            (wrist, wrist + 0.9 * (at(f"{side}hand") - wrist), 0.045),
            (elbow + SLEEVE * (shoulder - elbow), elbow, 0.05),
        ]
        others += [
            (shoulder, elbow, 0.05),
            (hip, at(f"{side}femur"), 0.08),
            (at(f"{side}femur"), at(f"{side}tibia"), 0.06),
            (at(f"{side}tibia"), at(f"{side}toes"), 0.04),
        ]
    return [(a, b, wide * radius) for a, b, radius in (*trunk, *bare, *others)]


def _lopsided(values: Array) -> float:
    """How unlike arms are that mirror each other: of what explains a frame as well, hands that meet do."""
    left, right = (values[[CHANNELS.index(f"{side}{dof}") for dof in ARM]] for side in "lr")
    return float((((left - MIRRORED * right) / MIRRORED_SD) ** 2).sum())


def _some_of(mask: Image, box: Box, count: int) -> Array:
    """Pixels of a mask within a box, evenly over its area `(P, 2)`."""
    left, top, right, bottom = box
    rows, columns = np.nonzero(mask[top:bottom, left:right])
    # A golden section of the pixels, row by row, is even in both directions.
    picked = np.floor(len(rows) * ((np.arange(count) * 0.6180339887) % 1.0)).astype(int) if len(rows) else []
    return np.stack([columns[picked] + left, rows[picked] + top], axis=1).astype(float)


def _beside_limbs(points: Array, limbs: list[Limb], pixels: Array, px_per_m: Array, which: range) -> Array:
    """How far points `(P, 2)` are from the nearest of some limbs, m `(K, P)`; less than nothing inside one."""
    apart = [
        to_line(points, pixels[:, None, 2 * k], pixels[:, None, 2 * k + 1]) / px_per_m[:, None] - limbs[k][2]
        for k in which
    ]
    return np.asarray(np.min(apart, axis=0))


def _off_mask(distance: NDArray[np.float32], places: Array) -> Array:
    """Of places `(K, N, 2)` from a mask, px; outside the picture nothing is known, and nothing is missed."""
    height, width = distance.shape
    columns, rows = np.rint(places[..., 0]), np.rint(places[..., 1])
    is_inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    at = np.clip(rows, 0, height - 1).astype(int), np.clip(columns, 0, width - 1).astype(int)
    return np.where(is_inside, distance[at], 0.0)


def _capped(apart_m: Array) -> Array:
    return np.clip(apart_m, 0.0, MOST_M) / SD_M
