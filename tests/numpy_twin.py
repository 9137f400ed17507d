"""The layered arm filter again, in plain vectorised NumPy: the check on the Rust core, and its peer in speed.

Written from the paper's equations, as a careful NumPy user would: particles `(N, 6)`, one draw a frame.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import pytracker as pt
from pytracker.rotation import rotate

Float = NDArray[np.float64]


def resample_residual(weights: Float, rng: np.random.Generator) -> NDArray[np.int64]:
    n = len(weights)
    expected = n * weights
    copies = np.floor(expected).astype(np.int64)
    left = n - int(copies.sum())
    cumulative = np.cumsum(expected - copies)
    extra = np.searchsorted(cumulative, rng.random(left) * cumulative[-1], side="right")
    copies += np.bincount(np.minimum(extra, n - 1), minlength=n)
    return np.repeat(np.arange(n), copies)


def weighted_band(x: Float, weights: Float) -> tuple[Float, Float]:
    order = np.argsort(x, axis=0)
    lo, hi = np.empty(3), np.empty(3)
    for d in range(3):
        cumulative = np.cumsum(weights[order[:, d]])
        at = np.minimum(np.searchsorted(cumulative, [0.025, 0.975]), len(x) - 1)
        lo[d], hi[d] = x[order[at, d], d]
    return lo, hi


class NumpyLayered:
    """`[inertial, colour] [walk, arm length]` with residual resampling after each."""

    def __init__(self, arm: pt.Arm, camera: pt.Camera, method: pt.Layered, seed: int) -> None:
        self.arm, self.camera, self.method = arm, camera, method
        self.rng = np.random.default_rng(seed)
        start = self.rng.standard_normal((method.particles, 6))
        self.x = start * ([method.position_start_sd_m] * 3 + [method.velocity_start_sd] * 3)
        self.x[:, :3] += arm.wrist_start_m
        self.reset()
        self.rotation = np.array(camera.rotation)
        self.translation = np.array(camera.translation_m)
        self.matrix = np.array(camera.matrix)

    def reset(self) -> None:
        self.a, self.u, self.q, self.elapsed = np.eye(2), np.zeros((2, 3)), np.zeros((2, 2)), 0.0

    def predict(self, dt: float, acc: Float, q_world_sensor: Float) -> None:
        """Compose `dt` seconds under one sample (eqs 4, 6)."""
        world = rotate(q_world_sensor, acc) - [0.0, 0.0, 9.80665]
        step = np.array([[1.0, dt], [0.0, 1.0]])
        noise = np.array([dt**3 / 6, dt**2]) * self.method.accel_density / dt**1.5
        self.a = step @ self.a
        self.u = step @ self.u + np.outer([dt * dt / 2, dt], world)
        self.q = step @ self.q @ step.T + np.outer(noise, noise)
        self.elapsed += dt

    def update(self, pixel: Float, q_world_sensor: Float) -> dict[str, Float]:
        n, method = len(self.x), self.method
        if self.elapsed:
            factor = np.linalg.cholesky(self.q)
            z = self.rng.standard_normal((2, n, 3))
            p, v = self.x[:, :3], self.x[:, 3:]
            self.x = np.concatenate(
                [
                    p + self.a[0, 1] * v + self.u[0] + factor[0, 0] * z[0],
                    v + self.u[1] + factor[1, 0] * z[0] + factor[1, 1] * z[1],
                ],
                axis=1,
            )
        c = self.x[:, :3] @ self.rotation.T + self.translation
        pixels = c[:, :2] / c[:, 2:] * [self.matrix[0, 0], self.matrix[1, 1]] + self.matrix[:2, 2]
        weights = self._weights(-0.5 * ((pixels - pixel) ** 2).sum(axis=1) / method.pixel_sd**2)
        self.x = self.x[resample_residual(weights, self.rng)]
        self.x[:, :3] += method.walk_density * np.sqrt(self.elapsed) * self.rng.standard_normal((n, 3))
        forearm = rotate(q_world_sensor, np.array([0.0, self.arm.forearm_m, 0.0]))
        length = np.linalg.norm(self.x[:, :3] + forearm - self.arm.shoulder_m, axis=1)
        weights = self._weights(-0.5 * ((length - self.arm.upper_arm_m) / method.arm_length_sd_m) ** 2)
        mean = weights @ self.x
        centred = self.x - mean
        covariance = (centred * weights[:, None]).T @ centred
        lo, hi = weighted_band(self.x[:, :3], weights)
        ess = np.asarray(1.0 / (weights**2).sum())
        self.x = self.x[resample_residual(weights, self.rng)]
        self.reset()
        return {"mean": mean, "covariance": covariance, "lo": lo, "hi": hi, "ess": ess}

    @staticmethod
    def _weights(log_likelihood: Float) -> Float:
        weights = np.exp(log_likelihood - log_likelihood.max())
        return np.asarray(weights / weights.sum())
