"""What the simulated camera sees: a wall, the subject's trunk, a wooden table, an arm with a green patch.

Limbs are tapered capsules with a lit ridge, drawn from far to near; the patch is a box on the
forearm, at its offset. Blur, a slow change of light and pixel noise come last.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from pytracker.formats.video import Image
from pytracker.recording.camera import Camera
from pytracker.rotation import Array, rotate
from pytracker.simulate.arm import IMAGE_SIZE, ArmSimulation

__all__ = ["PATCH_HALF_M", "render"]

# BGR
PATCH = (70, 175, 40)
OTHER_PATCHES = {"shoulder": (150, 40, 190), "elbow": (40, 200, 225)}
SKIN = (135, 165, 215)
SLEEVE = (120, 82, 60)
HAIR = (40, 50, 62)
DISTRACTOR = (75, 165, 50)
CARD = (60, 70, 80)

LIGHT = np.array([0.3, 0.2, 0.93])
PATCH_HALF_M = np.array([0.020, 0.024, 0.010])
DISTRACTOR_HALF_M = np.array([0.035, 0.035, 0.035])
SAMPLES = 24
SHADES = 7
SOFT_PX = 16
CIRCLE = np.stack([np.cos(np.linspace(0, 2 * np.pi, 32)), np.sin(np.linspace(0, 2 * np.pi, 32))], axis=1)
NOISE_FIELDS = 16
SHIFT = 4
"""Fractional bits of OpenCV's drawing: edges move by sixteenths of a pixel, not by jumps."""


def render(simulation: ArmSimulation, camera_index: int) -> Iterator[Image]:
    """Frames of one camera, BGR `(480, 640, 3)`, one for every time in `frame_time_s`."""
    scene, camera = simulation.scene, simulation.true_cameras[camera_index]
    rng = np.random.default_rng([simulation.seed, camera_index, *b"image"])
    times = simulation.frame_time_s
    background = _background(camera, np.asarray(scene.shoulder_m), rng)
    noise = rng.standard_normal((NOISE_FIELDS, IMAGE_SIZE[1], IMAGE_SIZE[0], 3), dtype=np.float32)
    wrist, elbow, shoulder = simulation.wrist(times), simulation.elbow(times), simulation.shoulder(times)
    others = {j: (simulation.landmark(j, times), simulation.q_of_landmark(j, times)) for j in simulation.joints_seen}
    q, hidden = simulation.q_world_sensor(times), simulation.is_occluded(times)
    for k, time_s in enumerate(times):
        image = background.copy()
        _shadow(image, camera, elbow[k], wrist[k])
        if scene.distractor:
            _distractor(image, camera, float(time_s))
        _arm(image, camera, shoulder[k], elbow[k], wrist[k], q[k], np.asarray(scene.patch_offset_m))
        for joint, (centres, turns) in others.items():
            _box(image, camera, centres[k], turns[k], PATCH_HALF_M, OTHER_PATCHES[joint])
        if hidden[k]:
            _card(image, camera, simulation.patch(times[k : k + 1])[0])
        # A field of noise shifted at random is as good as a new one, and far cheaper.
        shifted = np.roll(noise[rng.integers(NOISE_FIELDS)], rng.integers(IMAGE_SIZE[0]), axis=1)
        yield _expose(image, float(time_s), scene.clutter_noise * shifted)


def _arm(image: Image, camera: Camera, shoulder: Array, elbow: Array, wrist: Array, q: Array, offset: Array) -> None:
    """Upper arm, forearm and hand; the patch where it is glued."""
    along = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    _capsule(image, camera, shoulder, elbow, 0.055, 0.045, SLEEVE)
    _capsule(image, camera, elbow, wrist, 0.042, 0.027, SKIN)
    _capsule(image, camera, wrist, wrist + 0.08 * along, 0.028, 0.036, SKIN)
    _capsule(image, camera, wrist + 0.08 * along, wrist + 0.15 * along, 0.030, 0.014, SKIN)
    _box(image, camera, wrist + rotate(q, offset), q, PATCH_HALF_M, PATCH)


def _trunk(image: Image, camera: Camera, shoulder: Array) -> None:
    """Trunk, head and the other shoulder, which stay where they are."""
    neck = shoulder + np.array([-0.18, -0.02, 0.04])
    for start, end, radius_start, radius_end, colour in (
        ((0.0, 0.0, 0.02), (0.0, 0.01, 0.10), 0.05, 0.05, SKIN),
        ((0.0, 0.01, 0.16), (0.0, 0.02, 0.23), 0.072, 0.080, SKIN),
        ((0.0, -0.03, 0.24), (0.0, -0.01, 0.27), 0.085, 0.080, HAIR),
        ((0.0, 0.0, -0.40), (0.0, 0.0, -0.10), 0.15, 0.16, SLEEVE),
        ((-0.18, 0.0, -0.05), (0.16, 0.0, -0.05), 0.065, 0.065, SLEEVE),
        ((-0.20, 0.0, -0.06), (-0.24, 0.04, -0.33), 0.055, 0.045, SLEEVE),
    ):
        _capsule(image, camera, neck + np.array(start), neck + np.array(end), radius_start, radius_end, colour)


def _capsule(
    image: Image,
    camera: Camera,
    start: Array,
    end: Array,
    radius_start: float,
    radius_end: float,
    colour: tuple[int, ...],
) -> None:
    """A tapered limb: the hull of its two end balls, drawn from the whole limb to its lit ridge."""
    centres, radius = np.stack([start, end]), np.array([radius_start, radius_end])
    depth = centres @ np.array(camera.rotation)[2] + camera.translation_m[2]
    size = camera.matrix[0][0] * radius / depth
    light = LIGHT / np.linalg.norm(LIGHT)
    shares = np.linspace(1.0, 0.25, SHADES)
    towards_light = ((1.0 - shares)[:, None] * radius)[:, :, None] * light
    middles = camera.project((centres + towards_light).reshape(-1, 3)).reshape(SHADES, 2, 2)
    for share, middle in zip(shares, middles, strict=True):
        rim = middle[:, None] + (share * size)[:, None, None] * CIRCLE
        outline = cv2.convexHull(np.rint(rim.reshape(-1, 2) * (1 << SHIFT)).astype(np.int32))
        shade = 1.10 - 0.45 * share**2
        cv2.fillConvexPoly(image, outline, tuple(min(255.0, shade * c) for c in colour), cv2.LINE_AA, SHIFT)


def _box(image: Image, camera: Camera, centre: Array, q: Array, half: Array, colour: tuple[int, ...]) -> None:
    """A box seen from outside: its faces towards the camera, shaded by their turn to the light."""
    axes = rotate(np.broadcast_to(q, (3, 4)), np.eye(3))
    light = LIGHT / np.linalg.norm(LIGHT)
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = sign * axes[axis]
            middle = centre + normal * half[axis]
            if normal @ (camera.position_m - middle) <= 0:
                continue
            b, c = (axis + 1) % 3, (axis + 2) % 3
            turns = ((-1, -1), (-1, 1), (1, 1), (1, -1))
            corners = np.stack([middle + i * half[b] * axes[b] + j * half[c] * axes[c] for i, j in turns])
            shade = 0.62 + 0.38 * max(0.0, float(normal @ light))
            pixels = np.rint(camera.project(corners) * (1 << SHIFT)).astype(np.int32)
            cv2.fillConvexPoly(image, pixels, tuple(shade * k for k in colour), cv2.LINE_AA, SHIFT)


def _distractor(image: Image, camera: Camera, time_s: float) -> None:
    """A cube of nearly the patch's colour that slides along the far edge of the table."""
    centre = np.array([-0.35 + 0.12 * np.sin(0.7 * time_s), 0.55, 0.035])
    _box(image, camera, centre, np.array([1.0, 0.0, 0.0, 0.0]), DISTRACTOR_HALF_M, DISTRACTOR)


def _card(image: Image, camera: Camera, patch: Array) -> None:
    """Something held between camera and patch."""
    u, v = camera.project(patch[None])[0]
    corners = np.array([[u - 60, v - 45], [u + 60, v - 55], [u + 70, v + 45], [u - 55, v + 55]])
    cv2.fillConvexPoly(image, np.rint(corners).astype(np.int32), CARD, cv2.LINE_AA)


def _shadow(image: Image, camera: Camera, elbow: Array, wrist: Array) -> None:
    """The forearm's shadow on the table."""
    mask = np.zeros(image.shape[:2], dtype=np.uint8)
    light = LIGHT / LIGHT[2]

    def on_table(point: Array) -> Array:
        return np.asarray(point - light * max(point[2], 0.0))

    u = np.linspace(0, 1, SAMPLES)[:, None]
    ground = on_table(elbow) + u * (on_table(wrist) - on_table(elbow))
    for (x, y), r in zip(camera.project(ground), np.linspace(15, 10, SAMPLES), strict=True):
        if np.isfinite(x):
            cv2.circle(mask, (round(x), round(y)), round(r), 255, -1)
    x, y, w, h = cv2.boundingRect(mask)
    # All that the blur reaches; beyond it nothing is dark.
    rows, columns = (slice(max(first - SOFT_PX, 0), last + SOFT_PX) for first, last in ((y, y + h), (x, x + w)))
    dark = cv2.GaussianBlur(mask[rows, columns], (0, 0), 5).astype(np.float32)[:, :, None] / 255 * 0.35
    image[rows, columns] = (image[rows, columns] * (1 - dark)).astype(np.uint8)


def _background(camera: Camera, shoulder: Array, rng: np.random.Generator) -> Image:
    """Wall, the subject's trunk, and before it a table with grain and a front edge, by the camera's geometry."""
    width, height = IMAGE_SIZE
    v, u = np.mgrid[0:height, 0:width].astype(np.float64)
    normal = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(np.array(camera.matrix)).T
    direction = normal @ np.array(camera.rotation)
    room = np.empty((height, width, 3))
    room[:] = np.array([196.0, 200.0, 198.0]) * (0.80 + 0.20 * (v / height))[..., None]
    room += cv2.GaussianBlur(rng.normal(0, 30, room.shape[:2]), (0, 0), 6)[..., None]
    image = np.clip(room, 0, 255).astype(np.uint8)
    _trunk(image, camera, shoulder)
    for height_m, shade in ((-0.03, 0.55), (0.0, 1.0)):
        with np.errstate(divide="ignore", invalid="ignore"):
            plane = camera.position_m + direction * ((height_m - camera.position_m[2]) / direction[..., 2:])
        x, y = plane[..., 0], plane[..., 1]
        on_table = (direction[..., 2] < 0) & (np.abs(x - 0.05) < 0.65) & (y > 0.06) & (y < 0.75)
        grain = 5 * np.sin(55 * y + 1.5 * np.sin(4 * x)) + 3 * np.sin(230 * y + 4 * np.sin(5 * x))
        wood = np.array([95.0, 140.0, 178.0]) + grain[..., None] * np.array([0.7, 0.9, 1.0])
        image[on_table] = np.clip(shade * wood, 0, 255).astype(np.uint8)[on_table]
    return image


def _expose(image: Image, time_s: float, noise: NDArray[np.float32]) -> Image:
    """Blur, a slow change of light, pixel noise."""
    light = 1.0 + 0.03 * np.sin(0.8 * time_s)
    soft = cv2.GaussianBlur(image, (0, 0), 0.7).astype(np.float32) * np.float32(light) + noise
    return np.asarray(np.clip(soft, 0, 255).astype(np.uint8))
