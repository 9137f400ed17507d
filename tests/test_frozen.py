"""A picture that hangs is told from a person who holds still."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import load_body

import pytracker as pt
from pytracker.evidence.picture.frozen import HUNG, Frozen
from pytracker.formats.video import frames
from pytracker.formats.video_write import VideoWriter

RATE_HZ = 30.0


def hung(
    at_px: np.ndarray, *, noise: float = 3.0, stays: tuple[int, int] = (0, 0), dark: tuple[int, int] = (0, 0)
) -> list[int]:
    """Frames that are said to hang, of a hand at `at_px` `(T,)`, of which some show the first of them, or are dark."""
    rng = np.random.default_rng(1)
    frozen, shown = Frozen(), np.zeros(0, np.uint8)
    for k, x in enumerate(at_px):
        if not stays[0] < k < stays[1]:
            image = np.full((96, 128, 3), 90.0)
            image[40:60, round(x) : round(x) + 32] = 190.0
            shown = np.clip(image + noise * rng.standard_normal(image.shape), 0, 255).astype(np.uint8)
        if dark[0] <= k < dark[1]:
            shown = (0.45 * shown).astype(np.uint8)
        # As a coder leaves it, which sends a whole picture now and then.
        coded = shown.astype(int) + (k % 15 == 0) * (rng.random(shown.shape) < 0.2)
        frozen.look(k / RATE_HZ, np.clip(coded, 0, 255).astype(np.uint8))
    return np.flatnonzero(frozen.hung()).tolist()


GOES = 50.0 + 24.0 * np.sin(2.0 * np.pi * 0.25 * np.arange(120) / RATE_HZ)


def test_a_picture_that_hangs_and_leaps_is_told() -> None:
    assert hung(GOES, stays=(55, 80)) == list(range(56, 80))


@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_who_holds_still_and_goes_on_is_not(noise: float) -> None:
    """Without a camera's noise as with it: it begins little by little."""
    slows = np.concatenate([GOES[:31], np.full(60, GOES[30]), GOES[30:]])
    assert hung(slows, noise=noise) == []


def test_a_light_that_is_switched_on_is_no_leap() -> None:
    """Of who stood still in the dark 39 and 48 right frames were not valid."""
    still = np.concatenate([np.full(60, GOES[0]), GOES])
    assert hung(still, dark=(0, 60)) == []
    assert hung(still, dark=(60, 180)) == []
    assert hung(GOES, stays=(55, 80), dark=(0, 20)) == list(range(56, 80))
    # What hung ends in another light, too: cameras go on setting theirs.
    brighter = hung(GOES, noise=0.0, stays=(55, 80), dark=(80, 120))
    assert brighter == list(range(56, 80))


def test_a_moment_does_no_harm() -> None:
    assert hung(GOES, stays=(55, 61)) == []
    assert hung(GOES[:3]) == []


def test_frames_of_a_body_that_hang_are_not_valid(sensed: Path, tmp_path: Path) -> None:
    """They were, tens of centimetres off where the hands had moved on."""
    folder = tmp_path / "hung"
    shutil.copytree(sensed, folder)
    images = [frame.image for frame in frames(folder / "video.mp4")]
    height, width = images[0].shape[:2]
    with VideoWriter(folder / "hung.mp4", "mp4v", RATE_HZ, (width, height)) as writer:
        for image in [*images[:50], *[images[50]] * 25, *images[75:]]:
            writer.write(image)
    text = (folder / "recording.toml").read_text("utf-8").replace("video.mp4", "hung.mp4")
    (folder / "recording.toml").write_text(text, "utf-8")
    recording = load_body(folder)
    recording = replace(recording, view=replace(recording.view, keypoints=None), imus=(), imu_sds_rad=())
    track = pt.track(recording, pt.Partitioned(particles=50), 1)
    said = np.flatnonzero([HUNG in words for words in track.reason])
    assert said.tolist() == list(range(51, 75))
    assert not track.valid[said].any()
