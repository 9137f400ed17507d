"""Whether a frame bears a pose out: hands and forearms where skin is, skin that somebody wears, joints on the person.

A particle filter always has a mean. What the picture says against it is kept frame by frame and made into reasons.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from pytracker._core import KEYPOINTS
from pytracker.evidence.picture.silhouette import BodyEvidence, Region
from pytracker.evidence.points.followed import ARMS
from pytracker.evidence.pose.ambiguity import Forearm, Line, distance_at, to_line, with_hand, wrists_may_be_off
from pytracker.evidence.pose.lately import ASK_EVERY_S, Lately, mean_of_known
from pytracker.evidence.pose.pieces import pieces_of
from pytracker.formats.video import Image
from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array
from pytracker.series import runs

__all__ = ["COLUMN_M", "CROWN_M", "NOT_BARE", "BorneOut", "head_off"]

SIDES = ("left", "right")
WRISTS = tuple(f"{side}_wrist" for side in SIDES)
FAR_M = 0.10
"""A wrist this far from any skin is not where it is thought to be: half a hand's length."""
REACH_M = 0.12
"""Skin this far from head, forearms and hands is nobody's."""
ARM_M = 0.95
"""No hand of a large person is farther from between the shoulders."""
OTHER_M2 = 0.08
"""A piece of foreground that is larger and not on the trunk is somebody else: a forearm with its hand has 0.04."""
NOBODYS = 0.30
"""This share of the skin that is nobody's, and an arm is elsewhere."""
UNKNOWN_M = 0.13
"""A wrist that may be farther off, for all that the skin says, is not known."""
OFF_PERSON_M = 0.08
"""Clothes of the wall's colour leave holes in the foreground, m."""
ON_PERSON = 0.2
"""Of a detector's points more lie on the person: all of them on clips of people, 0.44 at least where the background is
a median of the clip itself, which has some of who stands still."""
FACE_M = 0.15
"""What lies so near to the head's line may be on the face's skin, or the neck's."""
ALONG = np.array([0.3, 0.5, 0.7, 0.9, 1.1, 1.3])
"""Places along forearm and hand, of the way from elbow to wrist;"""
BARE_M = 0.03
BARE = 0.2
"""such a share of those away from the face is so near to skin, in all but 1 % of the frames of clips of people. A
forearm has no place away from the face in none of them, and in all of people in sleeves whose face was taken for their
hands."""
NOT_BARE = "no skin of this arm away from the face: a wrong pose, or long sleeves?"
MOST_M = 0.5
ASKED = (
    *((wrist, UNKNOWN_M, "not known across the picture") for wrist in WRISTS),
    *((wrist, FAR_M, "no skin there") for wrist in WRISTS),
    *((wrist, 0.5 * MOST_M, NOT_BARE) for wrist in WRISTS),
    *((joint, OFF_PERSON_M, "not where the person is") for joint in ARMS),
    ("", NOBODYS, "skin that no arm explains"),
)
"""Of what, how much at most, and what is said beyond; what comes later is said instead of what came before."""

CROWN_M = 0.11
"""The crown is so far above the end of a CMU skeleton's head: 9 to 13 cm on clips of people and on simulations."""
COLUMN_M = 0.10


def head_off(camera: Camera | WeakPerspective, joints: Mapping[str, Array], evidence: BodyEvidence) -> Array:
    """How far the person's head is right of and below the skeleton's, m `(2,)`; NaN where none is seen there."""
    u, v = camera.project(joints["head"][None])[0]
    px_per_m = float(camera.px_per_m(joints["root"][None])[0])
    mask = evidence.foreground
    height, width = mask.shape
    if not (np.isfinite([u, v]).all() and v < height and 0 <= u < width):
        return np.full(2, np.nan)
    reach = round(COLUMN_M * px_per_m)
    rows = np.flatnonzero(mask[:, max(0, round(u) - reach) : round(u) + reach + 1].any(axis=1))
    # Of who reaches beyond the picture, as the skeleton does, nobody knows where the head is.
    if not len(rows) or (v < 0 and rows[0] == 0):
        return np.full(2, np.nan)
    head = rows[0] + CROWN_M * px_per_m
    # A skeleton that is too tall has its head above the person, or above the picture.
    pieces = runs(mask[min(height - 1, round(max(v, head)))] > 0)
    if not pieces:
        return np.full(2, np.nan)
    first, after = min(pieces, key=lambda piece: max(piece[0] - u, u - piece[1] + 1, 0.0))
    return np.array([0.5 * (first + after - 1) - u, head - v]) / px_per_m


class BorneOut:
    """What the frames so far say of the pose.

    Args:
        camera: what sees it.
        joints: key joints of the first pose, `(3,)` each, world, m: how long forearms are.
        sensed: segments whose direction a sensor tells.
    """

    def __init__(
        self, camera: Camera | WeakPerspective, joints: Mapping[str, Array], sensed: Collection[str] = ()
    ) -> None:
        self._camera = camera
        self._is_sensed = [f"{side}_forearm" in sensed for side in SIDES]
        self._forearm_m = [float(np.linalg.norm(joints[f"{s}_wrist"] - joints[f"{s}_elbow"])) for s in SIDES]
        self._across = _across(camera)
        self._ask_s = -np.inf
        self._lately = Lately()

    def look(
        self,
        time_s: float,
        joints: Mapping[str, Array],
        sds: Mapping[str, Array],
        evidence: BodyEvidence,
        points: Array | None = None,
    ) -> dict[str, str]:
        """Take a frame's mean joints and their standard deviations, `(3,)` each, world, m, and what it shows.

        `points` are a detector's of who is followed `(9, 2)`, px of the evidence; None where there are none.
        In words what lately speaks against joints, by joint; `""` is the frame. Those are left out that nothing speaks
        against.
        """
        names = list(joints)
        places = np.stack([joints[name] for name in names])
        pixels = dict(zip(names, self._camera.project(places), strict=True))
        px_per_m = float(self._camera.px_per_m(places[:1])[0])
        skin, person = evidence.skin_region, evidence.foreground_region
        told, is_on = _by_points(points, px_per_m, pixels), _are_on(person, points, px_per_m)
        # Where a joint's own point is, masks tell nothing more of it.
        is_there = {joint for joint, off in told.items() if is_on and off < FAR_M}
        off_skin, off_person = (
            [
                0.0 if joint in is_there else np.nan if mask is None else distance_at(mask[0], pixels[joint]) / px_per_m
                for joint in joints_of
            ]
            for mask, joints_of in ((skin, WRISTS), (person, ARMS))
        )
        spread = [float(np.sqrt(np.sum(self._across**2 @ sds[wrist] ** 2))) for wrist in WRISTS]
        may_be_off = spread if skin is None else self._by_skin(time_s, skin, px_per_m, pixels, is_there)
        may_be_off = [told.get(wrist, off) for wrist, off in zip(WRISTS, may_be_off, strict=True)]
        is_told = is_there >= set(WRISTS)
        nobodys = 0.0 if skin is None or is_told else _nobodys(skin[1], pixels, px_per_m)
        if skin is not None and nobodys > NOBODYS:
            nobodys = _nobodys(_without_others(skin[1], evidence.foreground, pixels, px_per_m), pixels, px_per_m)
        not_bare = [MOST_M * (not self._is_bare(side, skin, px_per_m, pixels, is_there)) for side in SIDES]
        row = np.minimum([*may_be_off, *off_skin, *not_bare, *off_person, nobodys], MOST_M)
        lately = mean_of_known(self._lately.take(time_s, row))
        return {joint: why for off, (joint, limit, why) in zip(lately, ASKED, strict=True) if off > limit}

    def _is_bare(
        self, side: str, skin: Region | None, px_per_m: float, pixels: Mapping[str, Array], is_there: Collection[str]
    ) -> bool:
        """Whether a forearm or its hand is on skin that is not the face's, or a point or a sensor tells where it is."""
        elbow, wrist = (pixels[f"{side}_{joint}"] for joint in ("elbow", "wrist"))
        if skin is None or f"{side}_wrist" in is_there or self._is_sensed[SIDES.index(side)]:
            return True
        along = elbow + (wrist - elbow) * ALONG[:, None]
        away = along[to_line(along, *_head(pixels)) > FACE_M * px_per_m]
        off = np.array([distance_at(skin[0], at) for at in away])
        # Where all of it is outside the picture nothing is known.
        known = off[np.isfinite(off)]
        return bool(len(off) and (not len(known) or (known < BARE_M * px_per_m).mean() >= BARE))

    def _by_skin(
        self, time_s: float, skin: Region, px_per_m: float, pixels: Mapping[str, Array], is_there: Collection[str]
    ) -> list[float]:
        """How far off either wrist may be for all that the skin says, m; nothing where a sensor or a point tells more.

        NaN between the times at which it is asked.
        """
        if time_s < self._ask_s:
            return [np.nan] * len(WRISTS)
        self._ask_s = time_s + ASK_EVERY_S
        left, right = (
            Forearm(pixels[f"{side}_elbow"], pixels[wrist], m * px_per_m, is_known=sensed or wrist in is_there)
            for side, wrist, m, sensed in zip(SIDES, WRISTS, self._forearm_m, self._is_sensed, strict=True)
        )
        return [off / px_per_m for off in wrists_may_be_off(skin, px_per_m, (left, right), _head(pixels))]


def _are_on(person: Region | None, points: Array | None, px_per_m: float) -> bool:
    """Whether a detector's points lie where the person is, those in the picture: else they bear nothing out."""
    if person is None or points is None:
        return True
    off = np.array([distance_at(person[0], at) for at in points[:, :2]])
    off = off[np.isfinite(off)]
    return not len(off) or float((off < OFF_PERSON_M * px_per_m).mean()) >= ON_PERSON


def _by_points(points: Array | None, px_per_m: float, pixels: Mapping[str, Array]) -> dict[str, float]:
    """How far from its own point every joint of the arms is, m; those left out that have none."""
    if points is None:
        return {}
    apart = {joint: float(np.linalg.norm(points[KEYPOINTS.index(joint), :2] - pixels[joint])) for joint in ARMS}
    return {joint: off / px_per_m for joint, off in apart.items() if np.isfinite(off)}


def _across(camera: Camera | WeakPerspective) -> Array:
    """Unit vectors across the picture, `(2, 3)`."""
    rows = np.array(camera.rotation)[:2] if isinstance(camera, Camera) else np.array(camera.affine)[:, :3]
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


def _head(pixels: Mapping[str, Array]) -> Line:
    return 0.5 * (pixels["left_shoulder"] + pixels["right_shoulder"]), pixels["head"]


def _nobodys(points: Array, pixels: Mapping[str, Array], px_per_m: float) -> float:
    """Share of points on skin that are far from the head's line and from those of forearms and hands.

    What no arm of this person can reach is another's.
    """
    head = _head(pixels)
    points = points[to_line(points, *head) < ARM_M * px_per_m]
    arms = [with_hand((pixels[f"{side}_elbow"], pixels[f"{side}_wrist"])) for side in SIDES]
    nearest = np.min([to_line(points, *line) for line in (head, *arms)], axis=0)
    return float((nearest > REACH_M * px_per_m).mean()) if len(points) else 0.0


def _without_others(points: Array, foreground: Image, pixels: Mapping[str, Array], px_per_m: float) -> Array:
    """Points on skin that are not on another person: a piece of foreground as large as one, and not on this one."""
    pieces = pieces_of(foreground, px_per_m)
    own = np.array([pixels["root"], pixels["head"], *_head(pixels)])
    is_other = pieces.sizes > OTHER_M2 * px_per_m**2
    is_other[0] = False
    is_other[pieces.about(own, round(OFF_PERSON_M * px_per_m))] = False
    return np.asarray(points[~is_other[pieces.at(points)]])
