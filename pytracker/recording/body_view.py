"""A body's camera: what it is, and its video or the keypoints that stand for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker._core import InputError, check_camera
from pytracker.formats import video
from pytracker.formats.points import read_points
from pytracker.formats.video_steady import camera_moves
from pytracker.formats.video_times import counted
from pytracker.recording.camera import Camera, ProjectionFit, WeakPerspective
from pytracker.recording.keypoints.load import load_keypoints
from pytracker.recording.projection import camera_of, fit_weak_perspective
from pytracker.recording.recording import BodyView
from pytracker.recording.schema import BodyCameraEntry

__all__ = ["end_of", "rate_of", "view_of"]

POOR_FIT_PX = 15.0
"""A weak-perspective fit worse than this is no fit."""
USUAL_HZ = 30.0
"""Frames a second where nothing says it."""


def view_of(folder: Path, path: Path, entry: BodyCameraEntry) -> BodyView:
    """The camera that `entry` says, with its video and keypoints. Raises `InputError`."""
    given = [name for name in ("points", "affine", "matrix") if getattr(entry, name) is not None]
    if len(given) != 1:
        raise InputError(
            f"{path}: camera[0] has {' and '.join(given) or 'none'}, expected one of points, affine, matrix"
        )
    idle = {"distortion", "rotation", "translation_m"} & entry.model_fields_set
    if idle and entry.matrix is None:
        raise InputError(f"{path}: camera[0].{sorted(idle)[0]} goes with matrix, not with {given[0]}")
    fit: ProjectionFit | None = None
    camera: WeakPerspective | Camera
    if entry.points is not None:
        fit = _fitted(folder / entry.points)
        camera = camera_of(fit)
    elif entry.affine is not None:
        camera = _affine(path, entry.affine)
    else:
        camera = _pinhole(path, entry)
    file, info = _frames_of(folder, path, entry)
    background = folder / entry.background if entry.background else None
    if background is not None:
        size = video.probe(background, is_still=True)
        if (size.width, size.height) != (info.width, info.height):
            raise InputError(
                f"{background}: is {size.width} x {size.height} px, expected {info.width} x {info.height} as {file}"
            )
    keypoints = None
    if entry.keypoints is not None:
        keypoints = load_keypoints(
            folder / entry.keypoints, entry.keypoint_model, file, info if entry.video is None else counted(file)
        )
    return BodyView(
        camera=camera, video=None if entry.video is None else file, size_px=(info.width, info.height),
        rate_hz=entry.rate_hz or 0.0, start_s=entry.start_s, background=background, fit=fit, keypoints=keypoints,
        moves=None if entry.video is None else camera_moves(file),
    )  # fmt: skip


def _frames_of(folder: Path, path: Path, entry: BodyCameraEntry) -> tuple[Path, video.VideoInfo]:
    """The video, or the keypoints that stand for it; and how large its frames are. Raises `InputError`."""
    alone = {name: getattr(entry, name) for name in ("size_px", "rate_hz")}
    if entry.video is not None:
        idle = [name for name, value in alone.items() if value is not None]
        if idle:
            raise InputError(f"{path}: camera[0].{idle[0]} goes with keypoints alone, a video has its own")
        return folder / entry.video, video.probe(folder / entry.video)
    if entry.keypoints is None:
        raise InputError(f"{path}: camera[0] has neither, expected video or keypoints")
    missing = [name for name, value in alone.items() if value is None]
    if missing:
        raise InputError(f"{path}: camera[0].{missing[0]} is missing, expected it where there is no video")
    if entry.background is not None:
        raise InputError(f"{path}: camera[0].background goes with a video")
    assert entry.size_px is not None
    assert entry.rate_hz is not None
    return folder / entry.keypoints, video.VideoInfo(*entry.size_px, 0, entry.rate_hz)


def _fitted(path: Path) -> ProjectionFit:
    """Weak perspective fitted to a file of points. Raises `InputError` where it is poor, or sees one direction only."""
    points = read_points(path)
    try:
        fit = fit_weak_perspective(*points)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if fit.rmse.max() > POOR_FIT_PX:
        raise InputError(
            f"{path}: the points fit weak perspective to {fit.rmse[0]:.1f} and "
            f"{fit.rmse[1]:.1f} px, expected at most {POOR_FIT_PX:.0f} px: check their order and units"
        )
    if not _spans(camera_of(fit).affine):
        raise InputError(f"{path}: u and v of the points go with each other, expected pixels of different directions")
    return fit


def _affine(path: Path, rows: tuple[tuple[float, ...], tuple[float, ...]]) -> WeakPerspective:
    """2x3 (x, y, constant) or 2x4 (x, y, z, constant)."""
    widths = [len(row) for row in rows]
    if widths not in ([3, 3], [4, 4]):
        raise InputError(f"{path}: camera[0].affine has rows of {widths} numbers, expected 2 x 3 or 2 x 4")
    u, v = (row if len(row) == 4 else (row[0], row[1], 0.0, row[2]) for row in rows)
    if not _spans((u, v)):
        raise InputError(
            f"{path}: camera[0].affine is {[list(row) for row in rows]}, expected rows in px/m that are not zero and "
            "point in different directions"
        )
    return WeakPerspective(affine=(u, v))


def _spans(affine: tuple[tuple[float, ...], tuple[float, ...]]) -> bool:
    """Whether its rows are not zero and point in different directions."""
    a, b = (np.array(row[:3]) for row in affine)
    return bool(np.linalg.norm(np.cross(a, b)) > 0.1 * np.linalg.norm(a) * np.linalg.norm(b))


def _pinhole(path: Path, entry: BodyCameraEntry) -> Camera:
    if entry.matrix is None or entry.rotation is None or entry.translation_m is None:
        missing = [name for name in ("rotation", "translation_m") if getattr(entry, name) is None]
        raise InputError(f"{path}: camera[0].{missing[0]} is missing beside matrix")
    camera = Camera(
        matrix=entry.matrix, rotation=entry.rotation, translation_m=entry.translation_m, distortion=entry.distortion
    )
    try:
        check_camera(camera)
    except InputError as error:
        raise InputError(f"{path}: camera[0]: {error}") from None
    return camera


def end_of(view: BodyView) -> float:
    """Recording time at which its video, or its keypoints alone, end, s; as a container promises it."""
    if view.video is None:
        assert view.keypoints is not None
        return view.start_s + (int(view.keypoints.frames[-1]) + 1) / view.rate_hz
    info = video.probe(view.video)
    return view.start_s + (info.frame_count / info.rate_hz if info.rate_hz else 0.0)


def rate_of(view: BodyView) -> float:
    """Frames a second of its video, else of its keypoints alone."""
    return (view.rate_hz if view.video is None else video.probe(view.video).rate_hz) or USUAL_HZ
