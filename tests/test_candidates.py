"""The coloured thing that moves: what passes is not it, and what is as large as a shirt is no patch."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

import pytracker as pt
from pytracker.evidence.patch.candidates import LEAST_AREA_PX, MOST_AREA_SHARE, _largest, find_candidates
from pytracker.formats.video_write import VideoWriter
from pytracker.setup.checks.camera import check_patch
from pytracker.setup.draft import Draft

BLUE, GREEN = (200, 60, 20), (70, 175, 40)
PATCH, SHIRT = (12, 16), (44, 54)
SIZE = (320, 240)


def filmed(path: Path, *, passing: bool, patch: bool = True) -> Path:
    """A blue shirt that sways, a green patch that circles, and for a quarter of the time a large green thing."""
    with VideoWriter(path, "mp4v", 25.0, SIZE) as writer:
        for k in range(200):
            image = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
            shirt = (120 + round(8 * np.sin(k / 9)), 120)
            cv2.rectangle(image, shirt, (shirt[0] + SHIRT[0], shirt[1] + SHIRT[1]), BLUE, -1)
            if passing and 80 <= k < 130:
                cv2.rectangle(image, (6 * (k - 80), 10), (6 * (k - 80) + 60, 55), GREEN, -1)
            u, v = 160 + round(40 * np.cos(k / 10)), 140 + round(30 * np.sin(k / 10))
            if patch:
                cv2.rectangle(image, (u, v), (u + PATCH[0], v + PATCH[1]), GREEN, -1)
            writer.write(image)
    return path


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A worn arm that gestures."""
    folder = tmp_path_factory.mktemp("coloured") / "arm"
    return pt.simulate_arm(folder, pt.ArmScene(worn=True, pattern="gesture", period_s=2.0, duration_s=8.0), 8)


def test_the_patch_is_the_coloured_thing_that_moves(simulated: Path) -> None:
    draft = Draft(simulated)
    x, y, w, h = draft.get("camera.patch_box")
    found = find_candidates(simulated / "video.mp4")
    bx, by, bw, bh = found[0].box
    assert abs(bx + bw / 2 - x - w / 2) < 6
    assert abs(by + bh / 2 - y - h / 2) < 6
    assert np.isfinite(found[0].pixels).all(axis=1).mean() > 0.9


def test_what_passes_is_not_the_patch(tmp_path: Path) -> None:
    """Something larger of its colour that went by made the shirt the patch: mounts were 75 to 155° off, 44 cm."""
    (patch,) = (one for one in find_candidates(filmed(tmp_path / "video.mp4", passing=True)) if one.hue_deg < 180.0)
    (alone,) = (one for one in find_candidates(filmed(tmp_path / "alone.mp4", passing=False)) if one.hue_deg < 180.0)
    assert patch.box == alone.box
    seen = np.isfinite(patch.pixels).all(axis=1)
    assert seen.mean() == pytest.approx(0.75, abs=0.02)
    assert np.abs(patch.pixels - alone.pixels)[seen].max() < 2.0


def test_a_patch_that_begins_near_the_camera_is_itself(tmp_path: Path) -> None:
    """What is larger at first, or often, does not pass: it goes away, or turns."""
    path = tmp_path / "video.mp4"
    with VideoWriter(path, "mp4v", 25.0, SIZE) as writer:
        for k in range(200):
            image = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
            half = 13 if k < 20 else 6
            u, v = 160 + round(40 * np.cos(k / 10)), 140 + round(30 * np.sin(k / 10))
            cv2.rectangle(image, (u - half, v - half), (u + half, v + half), GREEN, -1)
            writer.write(image)
    (patch,) = find_candidates(path)
    assert np.isfinite(patch.pixels).all()


@pytest.mark.parametrize("is_known", [True, False])
def test_a_shirt_is_no_patch(is_known: bool, tmp_path: Path) -> None:
    """Where it is known how far the shoulder is, and the focal length, so is how large a thing is."""
    filmed(tmp_path / "video.mp4", passing=False, patch=False)
    pose = "matrix = [[300, 0, 160], [0, 300, 120], [0, 0, 1]]\nrotation = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]\n"
    pose += "translation_m = [0, 0, 2]\n[arm]\nshoulder_m = [0, 0, 0]\n"
    start = f'schema = 1\nkind = "arm"\n[[camera]]\nvideo = "video.mp4"\n{pose if is_known else ""}'
    (tmp_path / "recording.toml").write_text(start)
    said, box = check_patch(Draft(tmp_path), None, None)
    assert (box is None) == is_known
    assert said.verdict == "missing"
    if is_known:
        shirt = start.replace("[arm]", f"patch_box = [120, 120, {SHIRT[0]}, {SHIRT[1]}]\n[arm]")
        (tmp_path / "recording.toml").write_text(shirt)
        said, _ = check_patch(Draft(tmp_path), None, None)
        assert said.verdict == "doubtful"
        assert "0.23 m in size at least, expected at most 0.2" in said.evidence
        for odd in ("[1, 2, 3]", "[100, 100, -30, 30]"):
            (tmp_path / "recording.toml").write_text(start.replace("[arm]", f"patch_box = {odd}\n[arm]"))
            assert check_patch(Draft(tmp_path), None, None)[0].verdict == "right"  # its shape is said as it loads
    else:
        return
    (tmp_path / "recording.toml").write_text(start)
    assert "but what is larger than 0.2 m (1 such)" in check_patch(Draft(tmp_path), None, None)[0].evidence


@pytest.mark.parametrize("hue", [0, 10, 60, 170])
def test_the_largest_piece_is_that_of_the_whole_picture(hue: int) -> None:
    """Found where there is colour alone: at edges and corners, thin, of several that are as large."""
    rng = np.random.default_rng(hue)
    for _ in range(200):
        hsv = np.zeros((31, 45, 3), np.uint8)
        for _ in range(rng.integers(1, 5)):
            (u, v), (w, h) = rng.integers(-3, 40, 2), rng.integers(1, 9, 2)
            left, top = max(u, 0), max(v, 0)
            hsv[top : max(v + h, 0), left : max(u + w, 0)] = ((hue + rng.integers(-9, 10)) % 180, 200, 200)
        far = np.abs((hsv[..., 0].astype(int) - hue + 90) % 180 - 90) > 9
        mask = np.where(far | (hsv[..., 1] < 90), 0, 255).astype(np.uint8)
        opened = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        _, _, stats, centres = cv2.connectedComponentsWithStats(opened)
        sizes = stats[1:, cv2.CC_STAT_AREA]
        found = _largest(hsv, hue)
        if not sizes.size or not LEAST_AREA_PX <= sizes.max() <= MOST_AREA_SHARE * mask.size:
            assert found is None
            continue
        k = 1 + int(np.argmax(sizes))
        assert found is not None
        assert found[:2] == pytest.approx(tuple(centres[k]), abs=1e-9)
        assert (found[2], *found[3:]) == (sizes.max(), *stats[k, :4])
