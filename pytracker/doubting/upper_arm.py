"""Whether a sensor on the upper arm points where the arm is, and when it does."""

from __future__ import annotations

import numpy as np

from pytracker.methods.arm import Mixture
from pytracker.recording import ArmRecording
from pytracker.rotation import Array, rotate
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.tracks import where_of

__all__ = ["of_unused_senses", "of_upper_arm"]

MOST_OFF_DEG = 12.0
"""A sensor may point so far beside it, in the median: right ones that are worn do by 7° at most."""
HOLDS_S = 0.1
"""A sample says no longer where the upper arm points."""
ALONG = np.array([0.0, 1.0, 0.0])

LAGS_S = np.linspace(-3.0, 3.0, 61)
"""By how much its clock may be off, s."""
LEAST_LAG_S = 0.2
"""Less takes the wrist nowhere where the arm goes slowly, and is seen where it goes fast."""
BETTER = 1.2
"""So many times nearer it points with another clock, where that is wrong: 1.3 to 4.6 with 1 s; 1.02 at most where it
is right."""
MOST_TURNED_DEG = 20.0
"""Right headings come out up to 11° beside, and 19° where the first frame told them."""
LEAST_FRAMES, LEAST_SHARE = 50, 0.5
"""Fewer tell nothing, nor does a smaller share of those that the given clock has."""


def of_unused_senses(track: ArmTrack) -> tuple[str, ...]:
    """A warning, in words, where the method uses neither that sensor nor what else is seen."""
    recording = track.recording
    there = [*recording.landmarks, *(["the upper arm's sensor"] if recording.has_upper_arm else [])]
    if not there or isinstance(track.method, Mixture):
        return ()
    words = f"there is {' and '.join(there)}, which {track.method.name} does not use; mixture and smooth do"
    return (f"{where_of(recording)}: {words}",)


def of_upper_arm(track: ArmTrack, alone: ArmTrack | None) -> tuple[str, ...]:
    """A warning, in words, where it points elsewhere.

    `alone` is the track without it, which it has not drawn to where it points; None where there is none.
    """
    recording = track.recording
    if not recording.has_upper_arm or not isinstance(track.method, Mixture):
        return ()
    if alone is not None and (words := _described_otherwise(recording, alone)):
        return (f"{where_of(recording)}: {words}",)
    off_deg = _angles_deg(*_directions(recording, track, 0.0))
    off_deg = off_deg[np.isfinite(off_deg)]
    if len(off_deg) < 1 or np.median(off_deg) <= MOST_OFF_DEG:
        return ()
    words = (
        f"the upper arm's sensor points {np.median(off_deg):.0f}° beside where the track has the upper arm (median), "
        f"expected at most {MOST_OFF_DEG:.0f}°: check heading_deg, mount and offset_s of imu[1], and shoulder_m"
    )
    return (f"{where_of(recording)}: {words}",)


def _described_otherwise(recording: ArmRecording, alone: ArmTrack) -> str:
    """With which other clock or heading it points where the arm is that was tracked without it; else empty."""
    as_it_is = _directions(recording, alone, 0.0)
    _, turn_deg = _fit(*as_it_is)
    fits = []
    for other_s in LAGS_S:
        later = _directions(recording, alone, float(other_s))
        # Where a sensor rests it fits whatever its clock: both are asked of the same frames.
        known, both = (np.isfinite(pointing[:, 0]) for pointing in (as_it_is[0], as_it_is[0] + later[0]))
        if np.count_nonzero(both) < max(LEAST_FRAMES, LEAST_SHARE * np.count_nonzero(known)):
            continue
        (given, _), (found, _) = (_fit(pointing[both], arm[both]) for pointing, arm in (as_it_is, later))
        fits.append((given / max(found, 1e-9), float(other_s), given, found))
    better, lag_s, given_deg, best_deg = max(fits, default=(0.0, 0.0, 0.0, 0.0))
    if better > BETTER and abs(lag_s) >= LEAST_LAG_S:
        return (
            f"the upper arm's sensor points {best_deg:.0f}° beside the arm that patch and forearm have with offset_s "
            f"of imu[1] changed by {-lag_s:+.1f} s, and {given_deg:.0f}° as it is: check its clock"
        )
    if abs(turn_deg) > MOST_TURNED_DEG:
        return (
            f"the upper arm's sensor points where the arm is that patch and forearm have with heading_deg of imu[1] "
            f"turned by {turn_deg:+.0f}°, expected at most {MOST_TURNED_DEG:.0f}°: check its heading and mount"
        )
    return ""


def _directions(recording: ArmRecording, track: ArmTrack, lag_s: float) -> tuple[Array, Array]:
    """Where the sensor points `lag_s` after every frame, NaN where not known, and the track's upper arm: `(T, 3)`."""
    imu, elbow = recording.imus[1], track.joints["elbow"].mean
    time_s = track.time_s + lag_s
    at = np.searchsorted(imu.time_s, time_s, side="right") - 1
    pointing = rotate(imu.q_world_segment[np.clip(at, 0, None)], np.broadcast_to(ALONG, (len(at), 3)))
    upper_arm = np.array(recording.arm.shoulder_m) - elbow
    upper_arm /= np.linalg.norm(upper_arm, axis=1, keepdims=True)
    is_known = (at >= 0) & (time_s - imu.time_s[np.clip(at, 0, None)] <= HOLDS_S) & np.isfinite(upper_arm).all(axis=1)
    return np.where(is_known[:, None], pointing, np.nan), upper_arm


def _fit(pointing: Array, upper_arm: Array) -> tuple[float, float]:
    """How far they are apart (root mean square) once turned about the vertical to fit, and that turn, degrees."""
    is_known = np.isfinite(pointing).all(axis=1)
    pointing, upper_arm = pointing[is_known], upper_arm[is_known]
    across = (pointing[:, 0] - 1j * pointing[:, 1]) * (upper_arm[:, 0] + 1j * upper_arm[:, 1])
    turn = float(np.angle(across.sum())) if len(across) >= LEAST_FRAMES else 0.0
    cos, sin = np.cos(turn), np.sin(turn)
    turned = pointing @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return float(np.sqrt(np.mean(_angles_deg(turned, upper_arm) ** 2))) if len(turned) else 0.0, float(np.degrees(turn))


def _angles_deg(one: Array, other: Array) -> Array:
    return np.asarray(np.degrees(np.arccos(np.clip((one * other).sum(axis=1), -1.0, 1.0))))
