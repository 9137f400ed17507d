"""Whether patch and sensor move alike: where they do not, what was followed is not on the wrist that wears the sensor.

A filter bends its track to a patch that moves in another way than its sensor does, a little in each frame, and nothing
of it stands out: not one innovation is odd, they are so in a row. Here both ways are laid over each other for some
seconds, across the camera's line of sight: the patch's in the picture, the sensor's integrated twice. Where either
begins, how fast, and a steady acceleration are left out, which an integration does not know; what is left differs by
what a sensor that is worn is off by, or by more.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from pytracker._core import ARM_ALIKE, ARM_UNLIKE
from pytracker.evidence.patch.clocks import FIRST_S, SPIKE_PX, clock_as_given
from pytracker.evidence.sightings import Sightings
from pytracker.inertial.gravity import GRAVITY
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array, multiply, rotate, rotation_vector_to_quaternion
from pytracker.series import runs, without_spikes

__all__ = ["UNLIKE", "moves_otherwise"]

UNLIKE = ARM_UNLIKE
"""The reason of a frame where this is so."""

GRID_S, EVERY = 0.02, 5
WINDOW_S = ARM_ALIKE["window_s"]
"""In less a slow arm hardly moves, over more the sensor drifts by as much. What comes as a stream is judged by the same
limits, one and all of the core's."""
STEADY = 2
"""The way of what is driven steadily is of this order in time."""
CHUNK = 1000

SEEN_GAP_S, SENSOR_GAP_S = ARM_ALIKE["seen_gap_s"], ARM_ALIKE["sensor_gap_s"]
"""Between frames, and samples, that are farther apart there is no way to lay over the other."""
LEAST_PX, PATCH_M = 1.0, ARM_ALIKE["centre_m"]
"""A centre is known no better than this, and wanders by as much over a wrist that turns."""

LEAST_SHARE = ARM_ALIKE["least_share"]
"""So much of the larger way, as squares, must be left."""
CERTAIN, LIKELY = ARM_ALIKE["certain"], ARM_ALIKE["likely"]
"""What is left, over what is expected (RMS). Of 36 right arms, worn, captured and of others, 2.5 at most where so large
a share is left; what lies about something certain needs less."""
CERTAIN_IN_ALL = 1.75
"""The same, of half of the whole recording, of two windows' length at least; of right ones 1.5 at most. Of shorter ones
all windows are nearly one: captured arms of 3 to 4 s have 2.3, and one of 61 more."""
STRANGE = 0.35
"""No smaller share of the patch's way in the first minute is explained by some map of the sensor's, whatever camera,
heading and mount are: of right ones 0.74 and more, of those that are followed for half of the time 0.42."""
ABOUT_S = 0.5
"""What is said of a window is said of its middle, and as much on either side."""


def moves_otherwise(
    recording: ArmRecording, sightings: Sightings, wrist_m: Array, turn_rad: Array
) -> NDArray[np.bool_]:
    """Which frames `(T,)` are about a stretch where some camera's patch moves otherwise than the forearm's sensor.

    `wrist_m` `(T, 3)` is the track, which says how far away the patch is; by `turn_rad` `(3,)`, in the world, the
    sensor's orientation was found to be off.
    """
    imu = recording.imus[0]
    turn = np.broadcast_to(rotation_vector_to_quaternion(turn_rad), imu.q_world_segment.shape)
    turned = np.ascontiguousarray(multiply(turn, imu.q_world_segment))
    acceleration = rotate(turned, imu.acc) - np.array([0.0, 0.0, GRAVITY])
    clock = clock_as_given(sightings.time_s, sightings.pixels[:, 0], imu.time_s, acceleration)
    px_per_m = float(np.nanmedian(recording.camera.px_per_m(wrist_m)))
    is_strange = clock is not None and clock.is_strange(px_per_m, STRANGE)
    of_strange = is_strange & (sightings.time_s <= sightings.time_s[0] + FIRST_S)
    found = [_of_camera(recording, sightings, camera, wrist_m, turned) for camera in range(len(recording.views))]
    return np.asarray(np.any([of_strange, *found], axis=0))


def _of_camera(
    recording: ArmRecording, sightings: Sightings, number: int, wrist_m: Array, q_world_segment: Array
) -> NDArray[np.bool_]:
    imu, camera = recording.imus[0], recording.views[number].camera
    frame_s, pixels = sightings.time_s, without_spikes(sightings.pixels[:, number], SPIKE_PX)
    to_patch = rotate(q_world_segment, np.array(camera.patch_offset_m))
    patch_m = wrist_m + _on(frame_s, imu.time_s, to_patch)
    off_px = pixels - camera.project(patch_m)
    known = np.isfinite(off_px).all(axis=1) & (frame_s >= imu.time_s[0]) & (frame_s <= imu.time_s[-1])
    seen_s = frame_s[known]
    if len(seen_s) < 2 or np.ptp(seen_s) < WINDOW_S + GRID_S:
        return np.zeros(len(frame_s), dtype=bool)
    grid = np.arange(seen_s[0], seen_s[-1], GRID_S)
    px_per_m = camera.px_per_m(patch_m[known])
    across = np.array(camera.rotation)[:2].T
    seen = _on(grid, seen_s, patch_m[known] @ across + off_px[known] / px_per_m[:, None])
    acceleration = rotate(q_world_segment, imu.acc) - np.array([0.0, 0.0, GRAVITY])
    driven_m = _integrated(imu.time_s, _integrated(imu.time_s, acceleration)) + to_patch
    # Sampled as the patch is: what is lost between frames is lost of both.
    driven = _on(grid, seen_s, _on(seen_s, imu.time_s, driven_m @ across))
    density = ARM_ALIKE["accel_density"] * (1.0 + ARM_ALIKE["accel_growth"] * np.linalg.norm(acceleration, axis=1))
    middle, left, larger, expected = _compared(seen, driven, np.interp(grid, imu.time_s, np.square(density)))
    centre_px = max(float(np.nan_to_num(sightings.jitter_px)), LEAST_PX)
    expected += 2.0 * (np.square(centre_px / np.median(px_per_m)) + PATCH_M**2)
    is_one = ~(_in_gaps(grid, seen_s, SEEN_GAP_S) | _in_gaps(grid, imu.time_s, SENSOR_GAP_S))
    whole = sliding_window_view(is_one, _samples())[::EVERY].all(axis=1)
    otherwise = _is_otherwise(left[whole], larger[whole], expected[whole])
    return _about(frame_s, grid[middle[whole]], otherwise)


def _is_otherwise(left: Array, larger: Array, expected: Array) -> NDArray[np.bool_]:
    """Which windows `(W,)`, by the squares of what is left, of the larger of both ways, and of what is expected."""
    is_large = left > LEAST_SHARE * larger
    is_long = len(left) * EVERY * GRID_S >= WINDOW_S
    if is_long and np.median(is_large * left / expected) > CERTAIN_IN_ALL**2:
        return np.ones(len(left), dtype=bool)
    certain = is_large & (left > CERTAIN**2 * expected)
    found = np.zeros(len(left), dtype=bool)
    for first, after in runs(is_large & (left > LIKELY**2 * expected)):
        found[first:after] = certain[first:after].any()
    return found


def _compared(seen: Array, driven: Array, density2: Array) -> tuple[NDArray[np.intp], Array, Array, Array]:
    """Of every window the middle, and mean squares `(W,)`, m², of what is left, of the larger way, and as expected."""
    samples = _samples()
    steady, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, samples), STEADY + 1))
    since = GRID_S * np.arange(samples)
    # A kick of the velocity at each sample: how far it leads from a steady way, as a mean square.
    kicks = np.maximum(since[:, None] - since, 0.0)
    kicks -= steady @ (steady.T @ kicks)
    by_kick = np.square(kicks).mean(axis=0)

    def bent(way: Array) -> Array:
        """What is not steady of `(W, samples, 2)`."""
        return np.asarray(way - steady @ (steady.T @ way))

    def windows(values: Array) -> Array:
        return np.moveaxis(sliding_window_view(values, samples, axis=0)[::EVERY], -1, 1)

    found = []
    of_seen, of_driven, of_density = windows(seen), windows(driven), windows(density2)
    for first in range(0, len(of_seen), CHUNK):
        part = slice(first, first + CHUNK)
        ways = bent(of_seen[part]), bent(of_driven[part])
        squares = [np.square(way).sum(axis=2).mean(axis=1) for way in (ways[0] - ways[1], *ways)]
        expected = 2.0 * GRID_S * of_density[part] @ by_kick
        found.append((squares[0], np.maximum(squares[1], squares[2]), expected))
    left, larger, expected = (np.concatenate(values) for values in zip(*found, strict=True))
    return EVERY * np.arange(len(left)) + samples // 2, left, larger, expected


def _about(frame_s: Array, at_s: Array, is_so: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which frames `(T,)` are about the middle of such a window; those before the first and behind the last as they."""
    if not is_so.any():
        return np.zeros(len(frame_s), dtype=bool)
    within = np.clip(frame_s, at_s[0], at_s[-1])
    middles = at_s[is_so]
    after = np.clip(np.searchsorted(middles, within), 1, len(middles)) - 1
    before = np.clip(after + 1, 0, len(middles) - 1)
    nearest = np.minimum(np.abs(within - middles[after]), np.abs(within - middles[before]))
    return np.asarray(nearest <= ABOUT_S)


def _integrated(time_s: Array, values: Array) -> Array:
    """From nothing, over time `(M, 3)`."""
    steps = 0.5 * np.diff(time_s)[:, None] * (values[1:] + values[:-1])
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)])


def _in_gaps(grid: Array, time_s: Array, longest_s: float) -> NDArray[np.bool_]:
    """Which of the grid's times lie between two that are farther apart, and than is usual."""
    step_s = np.diff(time_s)
    after = np.clip(np.searchsorted(time_s, grid, side="right"), 1, len(time_s) - 1)
    return np.asarray(step_s[after - 1] > max(longest_s, 2.5 * float(np.median(step_s))))


def _on(at_s: Array, time_s: Array, values: Array) -> Array:
    return np.stack([np.interp(at_s, time_s, column) for column in values.T], axis=1)


def _samples() -> int:
    return round(WINDOW_S / GRID_S)
