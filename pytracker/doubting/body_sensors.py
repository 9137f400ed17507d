"""Whether sensors on a body's arms point where those arms are seen, all the way and not in the first frame only.

What a sensor says of a segment gives the way in the picture from its near joint to its far one. A detector's keypoints
of both show the same or, less well, the pictures tracked without sensors. A heading or a clock that is off puts one
beside the other, another heading or clock does not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEYPOINTS, TrackingError
from pytracker.methods.body import Partitioned
from pytracker.recording.recording import Imu
from pytracker.rotation import Array, rotate
from pytracker.tracking.body import BodyTrack, track_body
from pytracker.tracking.tracks import where_of

__all__ = ["of_sensors"]

HEADINGS_DEG = np.arange(-180.0, 180.0, 5.0)
"""By so much a sensor is tried to be turned about the vertical."""
FARTHER_S = (0.4, 0.5, 0.65, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0)
LATER_S = np.array([*(-s for s in reversed(FARTHER_S)), *np.arange(-6, 7) * 0.05, *FARTHER_S])
"""By so much its samples are tried to be of later times."""
AS_IS = int(np.argmin(np.abs(HEADINGS_DEG))), int(np.argmin(np.abs(LATER_S)))
MOST_FRAMES = 500
"""More of them, evenly over the recording, say no more."""
LEAST_FRAMES = 30
LEAST_SHARE = 0.5
"""Fewer frames say too little; another clock may lose so many of those that the given one has."""
THIRDS = 3
"""In each of these parts of the recording heading or clock may be off by something else: one drifts."""
HOLDS_S = 0.1
"""A sample says no longer how a segment is turned."""
MOST_M = 0.2
"""A joint that is farther off is somewhere else altogether."""

ALIKE_M = 0.005
"""One thing that is wrong is told in place of two, or of one that drifts, that explain so little more."""
_ENDS = {"forearm": ("elbow", "wrist"), "upper_arm": ("shoulder", "elbow")}


@dataclass(frozen=True, eq=False)
class _Seen:
    """Where joints are seen by what is no sensor.

    Attributes:
        pixels: of `KEYPOINTS` `(T, 9, 2)`; NaN where not seen.
        where: what has a joint there, in words.
        nearer_m: another heading or clock may put a far joint so much nearer to it.
        beside_m: so far right ones may lie beside it, on average.
        tells_drift: whether it is asked what of thirds of the recording is off.
    """

    pixels: Array
    where: str
    nearer_m: float
    beside_m: float
    tells_drift: bool


@dataclass(frozen=True)
class _Way:
    """From a segment's near joint to its far one, in the frames in which keypoints of both are seen.

    Attributes:
        time_s: of the frames `(K,)`.
        seen_m: in the picture, by the keypoints `(K, 2)`.
        slope: of the picture, of a movement in the world `(K, 2, 3)`.
        length_m: of the segment.
    """

    time_s: Array
    seen_m: Array
    slope: Array
    length_m: float

    def covered(self, imu: Imu) -> _Way:
        """In the frames that a sample of the sensor goes for."""
        told = self.samples(imu, 0.0)[1]
        return replace(self, time_s=self.time_s[told], seen_m=self.seen_m[told], slope=self.slope[told])

    def samples(self, imu: Imu, later_s: float) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """Which of the samples, if they are so much later, goes for each frame, and whether one does `(K,)`."""
        time_s = self.time_s - later_s
        at = np.searchsorted(imu.time_s, time_s, side="right") - 1
        return at, (at >= 0) & (time_s - imu.time_s[np.clip(at, 0, None)] <= HOLDS_S)

    def off_m(self, imu: Imu, later_s: float) -> Array:
        """How far the far joint is beside its keypoint on average, of the whole and by its thirds `(1 + THIRDS, H)`.

        Of `HEADINGS_DEG`; NaN where too few frames tell it.
        """
        at, told = self.samples(imu, later_s)
        q, slope = imu.q_world_segment[np.where(told, at, 0)], self.slope
        x, y, z = (-self.length_m * rotate(q, np.broadcast_to([0.0, 1.0, 0.0], (len(q), 3)))).T
        # About the vertical: what of the way turns with the cosine, with the sine, and not at all.
        level, turned, steep = (
            np.einsum("kij,kj->ki", slope, np.stack(part, axis=1))
            for part in ((x, 0 * y, z), (z, 0 * y, -x), (0 * x, y, 0 * z))
        )
        heading = np.radians(HEADINGS_DEG)[:, None, None]
        beside = np.cos(heading) * level + np.sin(heading) * turned + steep - self.seen_m
        off = np.minimum(np.linalg.norm(beside, axis=2), MOST_M)
        parts = [np.arange(len(told)), *np.array_split(np.arange(len(told)), THIRDS)]
        return np.array([_mean(off[:, part], told[part]) for part in parts])


def _mean(off: Array, told: NDArray[np.bool_]) -> Array:
    """Of the columns that are told; NaN where they are too few."""
    if np.count_nonzero(told) < LEAST_SHARE * len(told):
        return np.full(len(off), np.nan)
    return np.asarray(off[:, told].mean(axis=1))


def of_sensors(track: BodyTrack) -> tuple[str, ...]:
    """A warning, in words, for each sensor that does not."""
    seen = _seen(track) if track.recording.imus else None
    if seen is None:
        return ()
    said = (_of_sensor(track, seen, number, imu) for number, imu in enumerate(track.recording.imus))
    return tuple(f"{where_of(track.recording)}: {words}" for words in said if words)


def _seen(track: BodyTrack) -> _Seen | None:
    """By keypoints, else by the pictures; None where there is neither."""
    if track.recording.view.keypoints is not None:
        return _by_keypoints(track.points) if len(track.points) else None
    return _by_pictures(track) if track.recording.has_picture else None


def _by_keypoints(points: Array) -> _Seen:
    """Of right sensors, to 5° off, another set-up is 1.2 cm nearer at most, and joints are 7.4 cm beside keypoints."""
    return _Seen(pixels=points[..., :2], where="its keypoint", nearer_m=0.015, beside_m=0.12, tells_drift=True)


def _by_pictures(track: BodyTrack) -> _Seen | None:
    """Tracked again, without sensors; None where that is lost. Of right ones it is 5.6 cm nearer, and 14 cm beside."""
    recording = replace(track.recording, imus=(), imu_sds_rad=())
    try:
        alone = track_body(recording, Partitioned())
    except TrackingError:
        return None
    pixels = np.full((len(track.time_s), len(KEYPOINTS), 2), np.nan)
    for k, name in enumerate(KEYPOINTS):
        if name in alone.joints:
            rows = alone.joints[name]
            pixels[:, k] = np.where(rows.valid[:, None], recording.view.camera.project(rows.mean), np.nan)
    where = "where the pictures alone have it"
    return _Seen(pixels=pixels, where=where, nearer_m=0.06, beside_m=0.16, tells_drift=False)


def _of_sensor(track: BodyTrack, seen: _Seen, number: int, imu: Imu) -> str:
    way = _way(track, seen, imu.segment).covered(imu)
    if len(way.time_s) < LEAST_FRAMES:
        return ""
    off_m = np.stack([way.off_m(imu, later_s) for later_s in LATER_S], axis=2)
    given_m = float(off_m[0, AS_IS[0], AS_IS[1]])
    best_m, better = _explained(off_m[0], off_m[1:] if seen.tells_drift else None)
    far = _ENDS[imu.segment.split("_", 1)[1]][1]
    beside = (
        f"by imu[{number}] and the {imu.segment} that is said to wear it, the {far} is {100 * given_m:.0f} cm beside "
        f"{seen.where} on average"
    )
    other, exchanged_m = _exchanged(track, seen, number)
    if exchanged_m + ALIKE_M < best_m and given_m - exchanged_m > seen.nearer_m and exchanged_m <= seen.beside_m:
        nearer = f"{beside}, and {100 * exchanged_m:.0f} cm where {track.recording.imus[other].segment} wears it"
        return f"{nearer}: are imu[{number}] and imu[{other}] exchanged?"
    if given_m - best_m > seen.nearer_m and best_m <= seen.beside_m:
        nearer = f"{beside}, and {100 * best_m:.0f} cm with {better}"
        return f"{nearer}: check these, segment, mount and the rate of its samples"
    if given_m > seen.beside_m:
        return f"{beside}, expected {100 * seen.beside_m:.0f} at most: check segment, mount, heading_deg and offset_s"
    return ""


def _exchanged(track: BodyTrack, seen: _Seen, number: int) -> tuple[int, float]:
    """Of which other sensor's segment it fits best, with whichever heading, and how near the far joint comes, m."""
    imu, best = track.recording.imus[number], (number, np.inf)
    for other, worn in enumerate(track.recording.imus):
        way = _way(track, seen, worn.segment).covered(imu)
        if worn.segment != imu.segment and len(way.time_s) >= LEAST_FRAMES:
            off_m = way.off_m(imu, 0.0)[0]
            if np.isfinite(off_m).any():
                best = min(best, (other, float(np.nanmin(off_m))), key=lambda found: found[1])
    return best


def _explained(whole: Array, thirds: Array | None) -> tuple[float, str]:
    """How near the joint comes to where it is seen, m, and by what: by more than one thing only where that is nearer.

    Of the whole by heading and clock `(H, L)`, and of its thirds `(THIRDS, H, L)`.
    """
    turned, later = int(np.nanargmin(whole[:, AS_IS[1]])), int(np.nanargmin(whole[AS_IS[0]]))
    both = np.unravel_index(int(np.nanargmin(whole)), whole.shape)
    ways = [
        (whole[turned, AS_IS[1]], _turned(turned), 0.0),
        (whole[AS_IS[0], later], _later(later), 0.0),
        (whole[both], f"{_turned(both[0])} and {_later(both[1])}", ALIKE_M),
    ]
    if thirds is not None:
        turns, clocks = thirds[:, :, AS_IS[1]], thirds[:, AS_IS[0]]
        drifts, runs = np.nanargmin(turns, axis=1), np.nanargmin(clocks, axis=1)
        ways += [
            (np.nanmin(turns, axis=1).mean(), f"{_turned(*drifts)} in its thirds", ALIKE_M),
            (np.nanmin(clocks, axis=1).mean(), f"{_later(*runs)} in its thirds", ALIKE_M),
        ]
    off, words, _ = min(ways, key=lambda way: float(way[0]) + way[2])
    return float(off), words


def _turned(*which: np.intp | int) -> str:
    return f"heading_deg turned by {', '.join(f'{HEADINGS_DEG[k]:+.0f}' for k in which)}"


def _later(*which: np.intp | int) -> str:
    return f"offset_s greater by {', '.join(f'{LATER_S[k]:+.2f}' for k in which)}"


def _way(track: BodyTrack, seen: _Seen, segment: str) -> _Way:
    side, part = segment.split("_", 1)
    near, far = (f"{side}_{end}" for end in _ENDS[part])
    recording, camera = track.recording, track.recording.view.camera
    first = recording.skeleton.joints(recording.initial[None])
    seen_px = seen.pixels[:, KEYPOINTS.index(far)] - seen.pixels[:, KEYPOINTS.index(near)]
    from_m = track.joints[near].mean
    step = 0.05
    aside = [camera.project(from_m + step * axis) - camera.project(from_m - step * axis) for axis in np.eye(3)]
    slope = np.stack(aside, axis=2) / (2.0 * step * camera.px_per_m(from_m)[:, None, None])
    # Nothing is told where a point is not seen, or the joint would be behind the camera.
    known = np.flatnonzero(np.isfinite(seen_px).all(axis=1) & np.isfinite(slope).all(axis=(1, 2)))
    some = known[np.unique(np.linspace(0, len(known) - 1, min(len(known), MOST_FRAMES)).astype(int))]
    return _Way(
        time_s=track.time_s[some],
        seen_m=seen_px[some] / camera.px_per_m(from_m[some])[:, None],
        slope=slope[some],
        length_m=float(np.linalg.norm(first[far] - first[near])),
    )
