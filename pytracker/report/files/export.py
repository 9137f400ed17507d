"""A track as other programs read it: TRC or C3D of its joints, empty where they are not to be believed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError
from pytracker.formats.markers_write import c3d_bytes, check_even, trc_text
from pytracker.output import whole_file, write_whole
from pytracker.report.files.tables import TrackRows
from pytracker.rotation import Array
from pytracker.tracking.tracks import JointTrack, Track

__all__ = ["believed", "export"]


def export(track: Track | TrackRows, path: Path | str, *, force: bool = True) -> Mapping[str, int]:
    """Write the means of a track's joints, world, mm, to `path`: `.trc`, or `.c3d` by the extra `c3d`.

    What is not valid is a gap: of a body joint by joint, of an arm all of a frame. Returns how many frames of each
    joint are gaps. Raises `InputError` for another suffix, a C3D of frames that are not even, and a file that exists,
    unless `force`.
    """
    path = Path(path)
    joints = believed(track.joints, track.valid)
    if path.suffix.lower() == ".trc":
        write_whole(path, trc_text(path.name, track.time_s, joints), force=force)
    elif path.suffix.lower() == ".c3d":
        check_even(path, track.time_s)
        with whole_file(path, force=force) as partial:
            partial.write_bytes(c3d_bytes(path, track.time_s, joints))
    else:
        raise InputError(f"{path}: expected a name that ends in .trc or .c3d")
    return {joint: int(np.isnan(places[:, 0]).sum()) for joint, places in joints.items()}


def believed(joints: Mapping[str, JointTrack], valid: NDArray[np.bool_]) -> dict[str, Array]:
    """Means by joint `(T, 3)`, NaN where it is not valid; `valid` is of joints that are not judged one by one."""
    is_right = {name: joint.valid if joint.reason else joint.valid & valid for name, joint in joints.items()}
    return {name: np.where(is_right[name][:, None], joint.mean, np.nan) for name, joint in joints.items()}
