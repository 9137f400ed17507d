"""How bad life is: what a worn IMU, a living shoulder and a hasty set-up do to a recording.

The numbers were measured on a forearm IMU with optical truth (60 Hz, a person standing and gesturing), or are what
people reach
with a tape measure and one calibration:

| what | how much | where from |
|---|---|---|
| forearm beside the sensor | 2° constant, 1° wobbling within 1.2 s, more while it turns | measured: 2.2-2.4° RMS |
| orientation | 1° constant, 0.5° and 0.4° a rad/s wobbling within 2 s | measured, and what filters state |
| acceleration | 0.13 m/s² and a tenth of it, within 0.1 s | measured: 0.13-0.18 at rest, 1.2 at 8-20 m/s² |
| shoulder | 0.12 of the wrist's way, 2 cm of its own within 0.8 s, 0.4 cm of breath | measured: 1.2-3.4 cm an axis |
| clock | 20 ms and 30 ppm | two files aligned by a clap; Xsens' own figure |
| lengths | 3 % | a tape measure |
| camera | 0.5° and 1 % of the focal length | a board at arm's length |
"""

from __future__ import annotations

import numpy as np

from pytracker.rotation import Array, rotation_vector_to_quaternion

__all__ = ["RATE_HZ", "Worn"]

RATE_HZ = 60.0
MOUNT_DEG, MOUNT_WOBBLE_DEG, MOUNT_S = 2.0, 1.0, 1.2
TILT_DEG, TILT_WOBBLE_DEG, TILT_BY_RATE_DEG, TILT_S = 1.0, 0.5, 0.4, 2.0
ACC_REST, ACC_SHARE, ACC_S = 0.13, 0.10, 0.1
FOLLOWS, SHOULDER_M, SHOULDER_S, BREATH_M, BREATH_HZ = 0.12, 0.02, 0.8, 0.004, 0.25
CLOCK_S, CLOCK_PPM = 0.020, 30.0
LENGTH_SHARE = 0.03
CAMERA_DEG, FOCAL_SHARE = 0.5, 0.01
STEP_S = 0.01
SMOOTH_SHARE = 0.2


class Worn:
    """The errors of one recording of `duration_s`, drawn from `rng` once."""

    def __init__(self, duration_s: float, rng: np.random.Generator) -> None:
        self.duration_s = duration_s
        self._grid = np.arange(-1.0, duration_s + 1.0 + STEP_S, STEP_S)
        self._shoulder, self._mount, self._tilt, self._acc = (
            self._wandering(tau_s, rng) for tau_s in (SHOULDER_S, MOUNT_S, TILT_S, ACC_S)
        )
        self._mount_axis, self._tilt_axis, camera_axis = (_direction(rng) for _ in range(3))
        self.clock_s = CLOCK_S * rng.choice([-1.0, 1.0])
        self.clock_scale = 1.0 + 1e-6 * CLOCK_PPM * rng.choice([-1.0, 1.0])
        self.lengths = 1.0 + LENGTH_SHARE * rng.uniform(-1.0, 1.0, 2)
        self.focal = 1.0 + FOCAL_SHARE * rng.choice([-1.0, 1.0])
        self.camera_turn = np.deg2rad(CAMERA_DEG) * camera_axis

    def _wandering(self, tau_s: float, rng: np.random.Generator) -> Array:
        """A Gauss-Markov process of unit variance an axis on the grid `(G, 3)`."""
        kept = np.exp(-STEP_S / tau_s)
        values = rng.standard_normal((len(self._grid), 3))
        values[1:] *= np.sqrt(1 - kept**2)
        for k in range(1, len(values)):
            values[k] += kept * values[k - 1]
        # Flesh does not jump: smoothed over a part of the time constant, and as large again.
        window = np.hanning(2 * max(1, round(SMOOTH_SHARE * tau_s / STEP_S)) + 1)
        smooth = np.stack([np.convolve(values[:, d], window / window.sum(), "same") for d in range(3)], axis=1)
        return np.asarray(smooth / np.sqrt(np.mean(smooth**2)))

    def _at(self, values: Array, time_s: Array) -> Array:
        return np.stack([np.interp(time_s, self._grid, values[:, d]) for d in range(3)], axis=1)

    def shoulder(self, time_s: Array, way: Array) -> Array:
        """How far the shoulder is from its place `(T, 3)`, m; `way` `(T, 3)` is the wrist's from its middle, m."""
        breath = BREATH_M * np.sqrt(2.0) * np.sin(2 * np.pi * BREATH_HZ * time_s)
        own = FOLLOWS * way + SHOULDER_M * self._at(self._shoulder, time_s)
        return np.asarray(own + breath[:, None] * np.array([0.0, 0.3, 0.95]))

    def mount(self, time_s: Array, rate: Array) -> Array:
        """Turn from the forearm to the sensor `(T, 4)`, where the forearm turns at `rate` `(T,)`, rad/s."""
        wobble = MOUNT_WOBBLE_DEG * (0.7 + 0.3 * rate[:, None]) * self._at(self._mount, time_s) / np.sqrt(3.0)
        return rotation_vector_to_quaternion(np.deg2rad(MOUNT_DEG * self._mount_axis + wobble))

    def tilt(self, time_s: Array, rate: Array) -> Array:
        """Error of the orientation in the world `(T, 4)`."""
        wobble = (TILT_WOBBLE_DEG + TILT_BY_RATE_DEG * rate[:, None]) * self._at(self._tilt, time_s) / np.sqrt(3.0)
        return rotation_vector_to_quaternion(np.deg2rad(TILT_DEG * self._tilt_axis + wobble))

    def acceleration(self, time_s: Array, acceleration: Array) -> Array:
        """What skin and strap add in the sensor's frame `(T, 3)`, m/s², where the wrist accelerates by `(T, 3)`."""
        size = ACC_REST + ACC_SHARE * np.linalg.norm(acceleration, axis=1, keepdims=True)
        return np.asarray(size * self._at(self._acc, time_s))

    def clock(self, time_s: Array) -> Array:
        """What the IMU's clock says at `time_s`."""
        return np.asarray(self.clock_s + self.clock_scale * time_s)


def _direction(rng: np.random.Generator) -> Array:
    v = rng.standard_normal(3)
    return np.asarray(v / np.linalg.norm(v))
