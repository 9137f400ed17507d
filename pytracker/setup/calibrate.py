"""A camera from a video of a board; its pose in the world from points with known places, or from tape and level.

Intrinsics by Zhang's method as OpenCV has it, with standard deviations from how well every corner fits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pytracker._core import InputError
from pytracker.evidence.boards import Board, find_corners
from pytracker.formats.video import frames, probe
from pytracker.recording.camera import Camera
from pytracker.rotation import Array

__all__ = ["Intrinsics", "Pose", "calibrate_camera", "find_pose", "pose_by_level"]

LOOKED_AT = 250
"""So many frames of a video are looked at, at most."""
VIEWS = (8, 40)
"""At least, and at most as many as are taken."""
CELLS = 6
LEAST_COVERED = 0.45
"""Share of the picture, in cells, where corners must have been."""
LEAST_TILT_DEG = 12.0
"""The board must have been tilted by so much beside its mean, or the focal length is not told from the distance."""
SAME_PX = 12.0
POOR_PX = 2.0
CORRELATED = 1.5
"""Corners of a view err together: standard deviations are so many times those of independent ones."""


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """A calibrated camera.

    Attributes:
        matrix: intrinsics, px.
        distortion: k1 k2 p1 p2 k3.
        focal_sd: of the focal length, as a share of it.
        centre_sd_px: of the principal point.
        size: width, height, px.
        frames: which were used.
        rms_px: of every view `(V,)`.
    """

    matrix: Array
    distortion: Array
    focal_sd: float
    centre_sd_px: float
    size: tuple[int, int]
    frames: tuple[int, ...]
    rms_px: Array


@dataclass(frozen=True, eq=False)
class Pose:
    """A camera in the world.

    Attributes:
        rotation: world to camera `(3, 3)`.
        translation_m: `(3,)`, m.
        rms_px: of the points; 0 without any.
    """

    rotation: Array
    translation_m: Array
    rms_px: float


def calibrate_camera(video: Path | str, board: Board, progress: Callable[[str, int], None] | None = None) -> Intrinsics:
    """Intrinsics from a video in which the board is moved about.

    Raises `InputError` where too little of it was seen, with what to film.
    """
    views, size = _views(Path(video), board, progress)
    if len(views) < VIEWS[0]:
        raise InputError(
            f"{video}: the board is seen well in {len(views)} different views, expected {VIEWS[0]} at least: film it "
            "for half a minute, slowly, sharply, at several distances, tilted to all sides"
        )
    covered = _covered(views, size)
    if covered < LEAST_COVERED:
        raise InputError(
            f"{video}: corners were seen in {covered:.0%} of the picture, expected {LEAST_COVERED:.0%} at least: move "
            "the board into the corners of the picture too"
        )
    return _calibrated(str(video), views, size)


def _views(
    video: Path, board: Board, progress: Callable[[str, int], None] | None
) -> tuple[list[tuple[int, Array, Array]], tuple[int, int]]:
    """Frames in which the board is seen, each elsewhere than the others."""
    info = probe(video)
    every = max(1, info.frame_count // LOOKED_AT)
    found: list[tuple[int, Array, Array]] = []
    for frame in frames(video):
        if frame.index % every:
            continue
        corners = find_corners(board, frame.image)
        if progress is not None:
            progress("board", frame.index + 1)
        if corners is not None and all(_apart(corners, (other[1], other[2])) > SAME_PX for other in found):
            found.append((frame.index, *corners))
    if len(found) > VIEWS[1]:
        found = [found[k] for k in np.unique(np.linspace(0, len(found) - 1, VIEWS[1]).round().astype(int))]
    return found, (info.width, info.height)


def _apart(one: tuple[Array, Array], other: tuple[Array, Array]) -> float:
    """How far the corners that both see lie from each other, px, on average."""
    places = {tuple(np.round(place, 6)): k for k, place in enumerate(other[0])}
    pairs = [(k, places[key]) for k, place in enumerate(one[0]) if (key := tuple(np.round(place, 6))) in places]
    if not pairs:
        return np.inf
    a, b = np.array(pairs).T
    return float(np.linalg.norm(one[1][a] - other[1][b], axis=1).mean())


def _covered(views: list[tuple[int, Array, Array]], size: tuple[int, int]) -> float:
    pixels = np.concatenate([view[2] for view in views])
    cells = np.clip((pixels / np.array(size) * CELLS).astype(int), 0, CELLS - 1)
    return len({(int(x), int(y)) for x, y in cells}) / CELLS**2


def _calibrated(name: str, views: list[tuple[int, Array, Array]], size: tuple[int, int]) -> Intrinsics:
    on_board = [view[1].astype(np.float32) for view in views]
    seen = [view[2].astype(np.float32).reshape(-1, 1, 2) for view in views]
    guess = np.array([[size[0], 0, size[0] / 2], [0, size[0], size[1] / 2], [0, 0, 1]], dtype=np.float64)
    _, fitted, distortion, turns, _, sds, _, errors = cv2.calibrateCameraExtended(
        on_board, seen, size, guess, np.zeros(5), flags=cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3
    )
    rms = np.asarray(errors, dtype=np.float64).ravel()
    normals = np.array([cv2.Rodrigues(np.asarray(turn))[0][:, 2] for turn in turns])
    mean = normals.mean(axis=0) / np.linalg.norm(normals.mean(axis=0))
    tilt = float(np.degrees(np.percentile(np.arccos(np.clip(normals @ mean, -1.0, 1.0)), 75)))
    if tilt < LEAST_TILT_DEG:
        raise InputError(
            f"{name}: the board was tilted by {tilt:.0f}° only, expected {LEAST_TILT_DEG:g}° at least: tilt it to "
            "all sides"
        )
    if np.median(rms) > POOR_PX:
        raise InputError(
            f"{name}: corners lie {np.median(rms):.1f} px beside where the camera should see them, expected less than "
            f"{POOR_PX:g}: are --squares and --board those of the board, and is it flat?"
        )
    fx_sd, fy_sd, cx_sd, cy_sd = (CORRELATED * float(sd) for sd in np.asarray(sds).ravel()[:4])
    matrix: Array = np.asarray(fitted, dtype=np.float64)
    return Intrinsics(
        matrix=matrix,
        distortion=np.asarray(distortion, dtype=np.float64).ravel()[:5],
        focal_sd=float(max(fx_sd / matrix[0, 0], fy_sd / matrix[1, 1])),
        centre_sd_px=max(cx_sd, cy_sd),
        size=size,
        frames=tuple(view[0] for view in views),
        rms_px=rms,
    )


def find_pose(matrix: Array, distortion: Array, world_m: Array, pixels: Array) -> Pose:
    """Where a camera stands that sees points of the world `(N, 3)`, m, at `pixels` `(N, 2)`.

    Raises `InputError` for fewer than four points, or where they fit no camera.
    """
    if len(world_m) < 4 or len(world_m) != len(pixels):
        raise InputError(f"{len(world_m)} points are given, expected four or more, each with its pixel")
    world_m, pixels = np.ascontiguousarray(world_m), np.ascontiguousarray(pixels)
    flat = np.linalg.matrix_rank(world_m - world_m.mean(axis=0), tol=1e-3) < 3
    if np.linalg.matrix_rank(world_m - world_m.mean(axis=0), tol=1e-3) < 2:
        raise InputError("the points lie on one line, expected some beside it")
    method = cv2.SOLVEPNP_IPPE if flat else cv2.SOLVEPNP_SQPNP
    ok, turn, shift = cv2.solvePnP(world_m, pixels, matrix, distortion, flags=method)
    if not ok:
        raise InputError("the points fit no place of the camera: check their order, and the metres and pixels of each")
    turn, shift = cv2.solvePnPRefineLM(world_m, pixels, matrix, distortion, turn, shift)
    again = np.asarray(cv2.projectPoints(world_m, turn, shift, matrix, distortion)[0]).reshape(-1, 2)
    rotation = np.asarray(cv2.Rodrigues(turn)[0], dtype=np.float64)
    rms = float(np.sqrt(((again - pixels) ** 2).sum(axis=1).mean()))
    return Pose(rotation=rotation, translation_m=np.asarray(shift, dtype=np.float64).ravel(), rms_px=rms)


def pose_by_level(camera: Camera, pixel: Array, distance_m: float, down_deg: float, roll_deg: float) -> Pose:
    """Where `camera` stands whose lens is `distance_m` from what it sees at `pixel` `(2,)`, the origin of the world.

    It looks down by `down_deg` and is turned clockwise about its axis by `roll_deg`, as the level of a telephone says
    that is held to it. The world's z axis is up, y the way it looks, x to its right; `camera` has no pose yet.
    """
    down, roll = np.radians(down_deg), np.radians(roll_deg)
    looks = np.array([[1.0, 0.0, 0.0], [0.0, -np.sin(down), -np.cos(down)], [0.0, np.cos(down), -np.sin(down)]])
    turned = np.array([[np.cos(roll), np.sin(roll), 0.0], [-np.sin(roll), np.cos(roll), 0.0], [0.0, 0.0, 1.0]])
    return Pose(rotation=turned @ looks, translation_m=camera.ray(pixel) * distance_m, rms_px=0.0)
