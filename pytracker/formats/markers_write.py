"""Trajectories as others read them: TRC (OpenSim, Pose2Sim) and C3D (by `ezc3d`, the extra `c3d`). A gap stays one."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.rotation import Array

__all__ = ["c3d_bytes", "check_even", "trc_text"]

UNEVEN = 0.1
"""Frames that are farther from even times, of their interval, are not of a file that holds a rate alone."""


def trc_text(name: str, time_s: Array, positions_m: Mapping[str, Array]) -> str:
    """A TRC in mm, of times `(T,)` and places `(T, 3)` by marker, NaN where there is none. `name` is the file's."""
    rate = f"{_rate_hz(time_s):.6g}"
    size = str(len(time_s))
    keys = "DataRate CameraRate NumFrames NumMarkers Units OrigDataRate OrigDataStartFrame OrigNumFrames"
    values = (rate, rate, size, str(len(positions_m)), "mm", rate, "1", size)
    axes = [f"{axis}{k + 1}" for k in range(len(positions_m)) for axis in "XYZ"]
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{name}",
        "\t".join(keys.split()),
        "\t".join(values),
        "\t".join(["Frame#", "Time", *(cell for marker in positions_m for cell in (marker, "", ""))]),
        "\t".join(["", "", *axes]),
    ]
    table = np.concatenate([1e3 * places for places in positions_m.values()], axis=1)
    for k, (at_s, row) in enumerate(zip(time_s.tolist(), table.tolist(), strict=True)):
        cells = ("" if math.isnan(number) else f"{number:.3f}" for number in row)
        lines.append("\t".join([str(k + 1), f"{at_s:.6f}", *cells]))
    return "\n".join(lines) + "\n"


def c3d_bytes(path: Path, time_s: Array, positions_m: Mapping[str, Array]) -> bytes:
    """A C3D in mm, likewise; it holds no times, only a rate (`check_even`) and the number of its first frame.

    Raises `InputError` without ezc3d.
    """
    try:
        import ezc3d  # noqa: PLC0415 - an extra, and slow to load
    except ImportError:
        raise InputError(f"{path}: writing C3D needs ezc3d: pip install ezc3d") from None
    places = np.stack([1e3 * one.T for one in positions_m.values()], axis=1)
    made = ezc3d.c3d()
    point = made["parameters"]["POINT"]
    point["RATE"]["value"] = [_rate_hz(time_s)]
    point["UNITS"]["value"] = ["mm"]
    point["LABELS"]["value"] = list(positions_m)
    made["header"]["points"]["first_frame"] = max(0, round(float(time_s[0]) * _rate_hz(time_s)))
    made["data"]["points"] = np.concatenate([places, np.ones((1, *places.shape[1:]))])
    # It writes files of that suffix only.
    with tempfile.TemporaryDirectory() as scratch:
        made.write(str(Path(scratch) / "track.c3d"))
        return (Path(scratch) / "track.c3d").read_bytes()


def check_even(path: Path, time_s: Array) -> None:
    """Raises `InputError` where frames are not evenly spaced."""
    even = np.linspace(time_s[0], time_s[-1], len(time_s))
    off = np.abs(time_s - even)
    if len(time_s) > 2 and off.max() > UNEVEN / _rate_hz(time_s):
        k = int(off.argmax())
        raise InputError(
            f"{path}: C3D holds a rate and no times, but frame {k} is at {time_s[k]:.4f} s where even ones would be at "
            f"{even[k]:.4f}, expected them within {UNEVEN:.0%} of their interval: write .trc"
        )


def _rate_hz(time_s: Array) -> float:
    return (len(time_s) - 1) / float(np.ptp(time_s)) if len(time_s) > 1 else 1.0
