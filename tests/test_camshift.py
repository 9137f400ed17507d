"""Following a patch: where it is, when it is lost, what is not it."""

from __future__ import annotations

import itertools
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

import pytracker as pt
from pytracker.evidence import PatchSighting, PatchTracker, track_patch
from pytracker.evidence.patch import camshift
from pytracker.rotation import triple
from pytracker.simulate import ArmSimulation
from pytracker.simulate.scene import render


def render_and_track(scene: pt.ArmScene, seed: int = 4) -> tuple[ArmSimulation, list[PatchSighting]]:
    simulation = ArmSimulation(scene, seed)
    images = render(simulation, 0)
    first = next(images)
    u, v = simulation.cameras[0].project(simulation.patch(np.zeros(1)))[0]
    tracker = PatchTracker(first, (round(u) - 11, round(v) - 11, 22, 22))
    return simulation, [tracker.update(first), *(tracker.update(image) for image in images)]


def test_centre_is_within_pixels_of_the_patch() -> None:
    simulation, found = render_and_track(pt.ArmScene(duration_s=6.0, distractor=True))
    truth = simulation.cameras[0].project(simulation.patch(simulation.frame_time_s))
    error = np.array([s.pixel for s in found]) - truth
    assert all(s.valid for s in found)
    assert np.abs(error).max() < 4.0


def test_occlusion_is_reported_and_survived_beside_a_distractor() -> None:
    scene = pt.ArmScene(duration_s=6.0, distractor=True, occlusions=((2.0, 2.6),))
    simulation, found = render_and_track(scene)
    times = simulation.frame_time_s
    truth = simulation.cameras[0].project(simulation.patch(times))
    hidden = simulation.is_occluded(times)
    valid = np.array([s.valid for s in found])
    assert not valid[hidden].any()
    assert all(s.reason for s, h in zip(found, hidden, strict=True) if h)
    # Believed again after two looks.
    assert valid[times >= 2.6 + 3 / 25].all()
    error = np.linalg.norm(np.array([s.pixel for s in found]) - truth, axis=1)
    assert np.nanmax(error) < 6.0


def test_an_empty_image_is_a_loss_not_an_error() -> None:
    simulation = ArmSimulation(pt.ArmScene(duration_s=1.0), 1)
    first = next(render(simulation, 0))
    u, v = simulation.cameras[0].project(simulation.patch(np.zeros(1)))[0]
    tracker = PatchTracker(first, (round(u) - 11, round(v) - 11, 22, 22))
    for value, reason in ((0, "no patch colour in the search window"), (255, "patch not found again")):
        sighting = tracker.update(np.full_like(first, value))
        assert not sighting.valid
        assert sighting.reason == reason
        assert np.isnan(sighting.pixel).all()


@pytest.mark.parametrize("occlusions", [(), ((2.0, 2.6),)])
def test_colour_about_the_patch_is_enough(
    monkeypatch: pytest.MonkeyPatch, occlusions: tuple[tuple[float, float], ...]
) -> None:
    """To the bit as by the colour of the whole frame, beside something of the same colour that moves."""
    scene = pt.ArmScene(duration_s=4.0, distractor=True, occlusions=occlusions)
    _, found = render_and_track(scene)
    monkeypatch.setattr(camshift, "ABOUT", 100.0)
    monkeypatch.setattr(camshift, "SMALLER_PX", 1e6)
    _, by_whole = render_and_track(scene)
    assert [s.reason for s in found] == [s.reason for s in by_whole]
    assert np.array_equal([s.pixel for s in found], [s.pixel for s in by_whole], equal_nan=True)


def test_where_the_patch_leaves_what_is_about_it_the_whole_frame_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camshift, "ABOUT", 0.0)
    first, second = (np.full((120, 160, 3), 120, np.uint8) for _ in range(2))
    first[40:60, 40:60] = second[44:64, 64:84] = (40, 200, 40)
    tracker = PatchTracker(first, (38, 38, 24, 24))
    # Of the patch half is beside the window and the rim about it.
    assert tracker.update(second).pixel == pytest.approx((73.5, 53.5), abs=0.3)


def test_a_repeated_frame_is_not_news() -> None:
    simulation = ArmSimulation(pt.ArmScene(duration_s=1.0), 1)
    images = render(simulation, 0)
    first, second = next(images), next(images)
    u, v = simulation.cameras[0].project(simulation.patch(np.zeros(1)))[0]
    tracker = PatchTracker(first, (round(u) - 11, round(v) - 11, 22, 22))
    assert tracker.update(first).valid
    assert tracker.update(first).reason == "the frame repeats the one before"
    assert tracker.update(second).valid


@pytest.mark.parametrize(
    ("box", "expected"),
    [
        ((600, 10, 60, 20), r"patch box \[600, 10, 60, 20\] .* inside the first frame of 640 x 480 px"),
        ((-1, 10, 20, 20), r"patch box \[-1, 10, 20, 20\]"),
        ((10, 10, 0, 20), "expected at least 2 px wide and high"),
        (
            (40, 400, 40, 40),
            "pixels of a colour that its surroundings do not have in the first frame, expected at least 9",
        ),
    ],
)
def test_a_box_without_a_patch_is_refused(box: tuple[int, int, int, int], expected: str) -> None:
    first = next(render(ArmSimulation(pt.ArmScene(duration_s=1.0), 1), 0))
    with pytest.raises(pt.InputError, match=expected):
        PatchTracker(first, box)


def test_a_black_first_frame_is_named() -> None:
    """A video that fades in: its patch was said to have no colour of its own."""
    first = next(render(ArmSimulation(pt.ArmScene(duration_s=1.0), 1), 0))
    with pytest.raises(pt.InputError, match=r"the first frame is dark \(mean 1[0-9] of 255\): cut the video"):
        PatchTracker(np.asarray(0.1 * first, dtype=np.uint8), (300, 200, 30, 30))


def test_bottle_cap_leaves_and_returns(shared: Callable[[str], Path]) -> None:
    """A hand takes the left bottle out of the picture twice; two more caps of the same blue stay in view."""
    track = track_patch(shared("data/video/bottle-detection.mp4"), (82, 106, 30, 22))
    runs = [(bool(v), len(list(g))) for v, g in itertools.groupby(track.valid)]
    assert [v for v, _ in runs] == [True, False, True, False, True]
    edges = np.cumsum([n for _, n in runs])
    # Seen on contact sheets: gone by frame 240, back at 345, gone by 540, back at 822.
    assert 195 <= edges[0] <= 240
    assert 330 <= edges[1] <= 360
    assert 490 <= edges[2] <= 540
    assert 805 <= edges[3] <= 840
    assert all(reason for reason, valid in zip(track.reason, track.valid, strict=True) if not valid)
    # Never on another bottle: their caps stand at u = 315 and 536.
    assert np.nanmax(track.pixel[:, 0]) < 200


CAP_BOXES = ((438, 333, 94, 78), (495, 396, 72, 76), (553, 416, 102, 98), (208, 486, 112, 100))


def qualisys_cameras(path: Path) -> list[pt.Camera]:
    cameras = []
    for camera in ET.parse(path).getroot().iter("camera"):  # noqa: S314 - a file of our own choosing
        t, i = camera.find("transform"), camera.find("intrinsic")
        assert t is not None
        assert i is not None
        r = np.array([[float(t.attrib[f"r{a}{b}"]) for b in (1, 2, 3)] for a in (1, 2, 3)])
        rotation = np.diag([1.0, -1.0, -1.0]) @ r
        translation = -rotation @ np.array([float(t.attrib[k]) for k in "xyz"]) / 1000
        f = {key: float(value) for key, value in i.attrib.items() if key != "model"}
        cameras.append(
            pt.Camera(
                matrix=(
                    (f["focalLengthU"] / 64, 0.0, f["centerPointU"] / 64),
                    (0.0, f["focalLengthV"] / 64, f["centerPointV"] / 64),
                    (0.0, 0.0, 1.0),
                ),
                rotation=(triple(rotation[0]), triple(rotation[1]), triple(rotation[2])),
                translation_m=triple(translation),
                distortion=(
                    f["radialDistortion1"],
                    f["radialDistortion2"],
                    f["tangentalDistortion1"],
                    f["tangentalDistortion2"],
                    f["radialDistortion3"],
                ),
            )
        )
    return cameras


def triangulate(pixels: list[np.ndarray], cameras: list[pt.Camera]) -> np.ndarray:
    """The point nearest to all rays."""
    a, b = np.zeros((3, 3)), np.zeros(3)
    for pixel, camera in zip(pixels, cameras, strict=True):
        ray = camera.ray(pixel)
        across = np.eye(3) - np.outer(ray, ray)
        a, b = a + across, b + across @ camera.position_m
    return np.asarray(np.linalg.solve(a, b))


def test_teal_cap_agrees_with_the_other_cameras(shared: Callable[[str], Path]) -> None:
    folder = shared("data/video/pose2sim_single")
    cameras = qualisys_cameras(folder / "Calib.qca.txt")
    tracks = [track_patch(folder / f"cam0{k + 1}.mp4", box) for k, box in enumerate(CAP_BOXES)]
    pixels = [track.pixel.copy() for track in tracks]
    for k in (0, 1):
        pixels[k][:, 0] *= 1088 / 1080  # these two were stored narrower than they were calibrated
    assert all(track.valid.all() for track in tracks)
    distance = []
    for frame in range(100):
        others = [k for k in range(4) if k != 1]
        point = triangulate([pixels[k][frame] for k in others], [cameras[k] for k in others])
        distance.append(np.linalg.norm(cameras[1].project(point[None])[0] - pixels[1][frame]))
        assert 1.4 < point[2] < 1.7
    assert max(distance) <= 20.0


def test_ray_undoes_projection(rng: np.random.Generator) -> None:
    camera = pt.Camera(
        matrix=((700.0, 0.0, 320.0), (0.0, 710.0, 240.0), (0.0, 0.0, 1.0)),
        translation_m=(0.0, 0.0, 2.0),
        distortion=(-0.2, 0.05, 0.001, -0.002, 0.01),
    )
    points = rng.uniform(-0.4, 0.4, (50, 3))
    pixels = camera.project(points)
    expected, _ = cv2.projectPoints(
        points, np.zeros(3), np.array([0, 0, 2.0]), np.array(camera.matrix), np.array(camera.distortion)
    )
    assert np.allclose(pixels, expected.reshape(-1, 2), atol=1e-9)
    for point, pixel in zip(points, pixels, strict=True):
        toward = point - camera.position_m
        assert np.allclose(camera.ray(pixel), toward / np.linalg.norm(toward), atol=1e-8)
