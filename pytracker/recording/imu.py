"""`[[imu]]` to an `Imu`: read, checked, oriented, in recording time and in the frame of the segment that wears it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker._core import InputError
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.check import check
from pytracker.inertial.conventions import in_our_terms
from pytracker.inertial.orientation import orient
from pytracker.recording.recording import Imu, Worn
from pytracker.recording.schema import ImuEntry
from pytracker.rotation import rotation_vector_to_quaternion

__all__ = ["load_imu"]


def load_imu(
    folder: Path, place: str, entry: ImuEntry, segments: tuple[str, ...], *, needs_heading: bool = True
) -> tuple[Imu, tuple[str, ...]]:
    """What `entry`, at `place` of the file, says; worn by one of `segments`, the first where it says none.

    A sensor without orientation has no heading but the one that is given (`needs_heading`) or found later. Raises
    `InputError`.
    """
    segment = entry.segment or segments[0]
    if segment not in segments:
        raise InputError(f"{place}.segment is {segment!r}, expected one of: {', '.join(segments)}")
    if entry.offset_sd_s is not None and not needs_heading:
        raise InputError(
            f"{place}.offset_sd_s is {entry.offset_sd_s}, but its clock is taken as it is given: only that of an arm's "
            "first sensor is estimated"
        )
    worn = _worn_as(place, entry)
    orientation = folder / entry.orientation_file if entry.orientation_file else None
    log = read_imu(
        folder / entry.file,
        orientation_file=orientation,
        form=entry.format,
        rate_hz=entry.rate_hz,
        columns={ours: theirs for ours, theirs in entry.columns.items()},
        segment=segment,
    )
    log = check(in_our_terms(log, entry.conventions))
    is_computed = log.q_world_sensor is None and log.gyr is not None
    if is_computed and entry.heading_deg is None and needs_heading:
        raise InputError(
            f"{place}.heading_deg is missing; {folder / entry.file} has no orientation, and one computed from "
            "its gyroscope has no heading, expected the turn about the vertical to the world in degrees"
        )
    log = orient(log, has_heading=entry.heading_deg is not None)
    assert log.acc is not None
    assert log.q_world_sensor is not None
    # Its clock goes faster or slower than the video's from its first sample on.
    drifted_s = 1e-6 * entry.drift_ppm * (log.time_s - log.time_s[0])
    imu = Imu(
        time_s=log.time_s + entry.offset_s + drifted_s,
        acc=worn.of_segment(log.acc),
        q_world_segment=worn.q_world_segment(log.q_world_sensor),
        gyr=None if log.gyr is None else worn.of_segment(log.gyr),
        segment=segment,
        worn=worn,
    )
    return imu, log.warnings


def _worn_as(place: str, entry: ImuEntry) -> Worn:
    """What `entry`, at `place` of the file, says. Raises `InputError` where its mount is no unit quaternion."""
    mount = np.array(entry.mount)
    if abs(np.linalg.norm(mount) - 1) > 0.02:
        raise InputError(f"{place}.mount has norm {np.linalg.norm(mount):.4f}, expected a unit quaternion")
    heading = rotation_vector_to_quaternion(np.array([0.0, 0.0, np.deg2rad(entry.heading_deg or 0.0)]))
    return Worn(mount / np.linalg.norm(mount), heading)
