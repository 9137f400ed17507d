"""C3D files of 3-D markers, by `ezc3d` (the extra `c3d`)."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.markers import UNITS_M, Markers, without_fillers

__all__ = ["read_c3d"]


def read_c3d(path: Path | str) -> Markers:
    """Read it; a point with a negative residual, or that jumps to (0, 0, 0), was not seen. Raises `InputError`."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        import ezc3d  # noqa: PLC0415 - an extra, and slow to load
    except ImportError:
        raise InputError(f"{path}: reading C3D needs ezc3d: pip install ezc3d") from None
    try:
        data = ezc3d.c3d(str(path))
        parameters = data["parameters"]["POINT"]
        # A parameter has 255 values at most: further ones are in LABELS2, LABELS3, ...
        numbered = (f"LABELS{number}" for number in itertools.chain([""], itertools.count(2)))
        there = itertools.takewhile(parameters.__contains__, numbered)
        labels = [label for name in there for label in parameters[name]["value"]]
        unit = " ".join(map(str, parameters["UNITS"]["value"])).strip().lower()
        header = data["header"]["points"]
        rate_hz, began = float(header["frame_rate"]), int(header["first_frame"])
        points = np.asarray(data["data"]["points"], dtype=np.float64)
        residuals = np.asarray(data["data"]["meta_points"]["residuals"], dtype=np.float64)
    except (OSError, RuntimeError, ValueError, KeyError, IndexError) as error:
        raise InputError(f"{path}: is not a C3D file of points: {str(error)[:200]}") from None
    if unit not in UNITS_M or not rate_hz > 0 or not points.shape[2]:
        raise InputError(
            f"{path}: has units {unit!r}, {rate_hz} Hz and {points.shape[2]} frames, expected points in mm, cm or m"
        )
    seen = (residuals[0] >= 0) & np.isfinite(points[:3]).all(axis=0)
    names = [str(label).strip() for label in labels[: points.shape[1]]]
    # `Subject:Marker` is the marker, where there is one subject.
    short = [name.rsplit(":", 1)[-1] for name in names]
    names = _numbered(short if len(set(short)) == len(short) else names)
    placed = [np.where(seen[k][:, None], points[:3, k].T * UNITS_M[unit], np.nan) for k in range(len(names))]
    positions = {name: without_fillers(rows) for name, rows in zip(names, placed, strict=True)}
    said = []
    if began > 0:
        said.append(f"{path}: its first frame is number {began + 1} of what was recorded: times are counted from it on")
    if len(labels) < points.shape[1]:
        said.append(f"{path}: has {points.shape[1]} points and {len(labels)} labels: those without one are left out")
    return Markers(np.arange(points.shape[2]) / rate_hz, positions, rate_hz, tuple(said))


def _numbered(names: list[str]) -> list[str]:
    """The same, those that stand more than once told apart: `wrist (1 of 2)`, so that none is taken for the other."""
    return [
        name if names.count(name) == 1 else f"{name} ({names[:k].count(name) + 1} of {names.count(name)})"
        for k, name in enumerate(names)
    ]
