"""A pose fitted to what a frame shows: which channels, how people stand, from where it is tried, and by which steps.

What a frame hardly tells, such as depth, is nearest to how people usually stand; of several starts the best is taken.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from pytracker.recording.camera import Camera, WeakPerspective
from pytracker.rotation import Array, triple
from pytracker.skeleton.skeleton import Skeleton

__all__ = [
    "ARM", "CHANNELS", "HIPS_M", "MIRRORED", "SDS", "FoundPose",
    "along", "distance_sd", "faced", "fitted_from", "named", "starts", "turn_to",
]  # fmt: skip

ARM = ("humerus_rx", "humerus_ry", "humerus_rz", "radius_rx")
CHANNELS = (
    "root_tx", "root_ty", "root_tz", "root_rx", "root_ry", "root_rz", *(f"{side}{dof}" for side in "lr" for dof in ARM),
)  # fmt: skip
SDS = np.array([1.0, 1.0, 0.5, *np.radians([8.0, 30.0, 8.0]), *np.tile(np.radians([50.0, 50.0, 40.0, 45.0]), 2)])
"""How far from the prior people are, m and rad."""
STARTS_DEG = {
    "hanging": (0.0, -70.0, 0.0, 15.0),
    "bent": (20.0, -65.0, 0.0, 80.0),
    "forward": (60.0, -45.0, -60.0, 60.0),
    "raised": (0.0, 40.0, 0.0, 60.0),
    "sideways": (0.0, -10.0, 0.0, 10.0),
}
"""The left arm's humerus and radius; the right one's is its mirror."""
MIRRORED = np.array([1.0, -1.0, -1.0, 1.0])
"""What takes the angles of one arm to those of the other that mirrors it."""
HIPS_M = 0.93
"""Where the root is looked for first, above the floor."""
DISTANCE_SHARE = 0.06
"""Of two people of a height one has a trunk so much longer, and a detector's hips and shoulders are no skeleton's."""
FIRST_TURNS, TURNS = 8, 25
"""Steps from every start, and on from where the most promising came to."""
PROMISING = 10
"""So many of the starts are followed to the end."""
STEP = 1e-5
BESIDE = 0.5
"""A camera that looks farther beside the world's z axis looks across it, rad."""


@dataclass(frozen=True, eq=False)
class FoundPose:
    """A pose that was found.

    Attributes:
        angles: channels that are not zero, by name: degrees, `root_t*` in metres.
        distance_sd_m: how well it tells how far off the person is, m; None for weak perspective, which knows none.
    """

    angles: dict[str, float]
    distance_sd_m: float | None

    def channels(self, skeleton: Skeleton) -> Array:
        """The pose as the skeleton has it `(D,)`, m and rad."""
        pose = np.zeros(len(skeleton.channels))
        for name, value in self.angles.items():
            pose[skeleton.channels.index(name)] = value if name.startswith("root_t") else np.radians(value)
        return pose


Residuals = Callable[[Array, Array], Array]
"""`(K, R)` of poses `(K, D)` and the middle of their prior `(D,)`, in standard deviations."""

Found = TypeVar("Found", bound=FoundPose)


def faced(
    skeleton: Skeleton, camera: WeakPerspective | Camera, find: Callable[[WeakPerspective | Camera], Found]
) -> Found:
    """What `find` gives of the camera; where it looks across the world's z axis, in a world that is turned.

    A person who faces such a camera has a right angle about y, where turns about x and z are one.
    """
    beside = _beside(camera)
    if abs(beside) < BESIDE or not isinstance(camera, Camera):
        return find(camera)
    turn = np.array([[np.cos(beside), 0.0, np.sin(beside)], [0.0, 1.0, 0.0], [-np.sin(beside), 0.0, np.cos(beside)]])
    rows = [triple(row) for row in np.array(camera.rotation) @ turn]
    found = find(dataclasses.replace(camera, rotation=(rows[0], rows[1], rows[2])))
    pose = skeleton.core.turned(found.channels(skeleton).tolist(), turn.tolist())
    values = zip(CHANNELS, (pose[column] for column in skeleton.columns(CHANNELS)), strict=True)
    return dataclasses.replace(found, angles=named(values))


def _beside(camera: WeakPerspective | Camera) -> float:
    """How far beside the world's z axis a camera looks, seen from above, rad: 0 along it, either way."""
    if not isinstance(camera, Camera):
        return 0.0
    x, _, z = camera.rotation[2]
    return float(np.arctan(x / z)) if z else float(np.pi / 2)


def named(values: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Degrees, and metres, of channels."""
    return {name: round(float(value if name.startswith("root_t") else np.degrees(value)), 4) for name, value in values}


def turn_to(camera: WeakPerspective | Camera, place: Array) -> float:
    """About y of who stands at `place` `(3,)`, m, and looks at the camera, rad."""
    if isinstance(camera, Camera):
        to_camera = camera.position_m - place
    else:
        u, v = (row[:3] for row in np.array(camera.affine))
        to_camera = -np.cross(u, v)
    return float(np.arctan2(to_camera[0], to_camera[2]))


def distance_sd(
    camera: WeakPerspective | Camera, places: Array, focal_sd: float, share: float = DISTANCE_SHARE
) -> float | None:
    """How well the size of a person about `places` `(N, 3)` tells how far off they are, m."""
    if not isinstance(camera, Camera):
        return None
    return round(float(np.hypot(share, focal_sd)) * float(np.linalg.norm(places.mean(axis=0) - camera.position_m)), 3)


def along(camera: Camera, pixel: Array, m_per_px: float) -> Array:
    """The place that is seen there, so far off that a pixel is so much."""
    ray = camera.ray(pixel)
    depth_m = camera.matrix[1][1] * m_per_px
    return np.asarray(camera.position_m + ray * depth_m / float(ray @ np.array(camera.rotation)[2]))


def starts(stands: Array) -> list[Array]:
    """The prior's middle with arms in several ways, on either side."""
    starts = []
    for left in STARTS_DEG.values():
        for right in STARTS_DEG.values():
            starts.append(np.array([*stands, *np.radians([*left, *(MIRRORED * right)])]))
    return starts


def fitted_from(residuals: Residuals, priors: Sequence[Array]) -> list[tuple[Array, float]]:
    """From the middle of every prior some steps, from where the most promising came to on to the end: poses, costs."""
    begun = [(prior, *_fitted(residuals, prior, prior, FIRST_TURNS)) for prior in priors]
    begun.sort(key=lambda fit: fit[2])
    return [_fitted(residuals, prior, at, TURNS) for prior, at, _ in begun[:PROMISING]]


def _fitted(residuals: Residuals, prior: Array, start: Array, turns: int) -> tuple[Array, float]:
    """Levenberg-Marquardt; the pose and its squared residuals."""
    at, damping = start.copy(), 1e-2
    now = residuals(at[None], prior)[0]
    for _ in range(turns):
        moved = residuals(at + STEP * np.eye(len(at)), prior)
        slope = (moved - now).T / STEP
        square, down = slope.T @ slope, slope.T @ now
        step = np.linalg.solve(square + damping * np.diag(np.diag(square)), -down)
        tried = residuals((at + step)[None], prior)[0]
        if tried @ tried < now @ now:
            is_done = now @ now - tried @ tried < 1e-6 * (now @ now)
            at, now, damping = at + step, tried, damping / 5
            if is_done:
                break
        else:
            damping *= 5
            if damping > 1e6:
                break
    return at, float(now @ now)
