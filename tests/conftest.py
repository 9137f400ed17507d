"""Fixtures: the shared data where it is, simulated recordings made once."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import settings

import pytracker as pt
from pytracker.evidence import BodyEvidence
from pytracker.formats.video import Image
from pytracker.methods import ArmMethod
from pytracker.rotation import Array

if TYPE_CHECKING:
    from playwright.sync_api import Browser

IS_ACCEPTANCE = bool(os.environ.get("PYTRACKER_ACCEPTANCE"))
"""`make acceptance`: nothing may be skipped, and what takes minutes is done with every seed."""
SEGMENTS = ("left_forearm", "right_forearm", "left_upper_arm", "right_upper_arm")

SHARED = Path(__file__).parents[2] / "shared"

settings.register_profile("default", deadline=None, derandomize=True)
settings.register_profile("long", deadline=None, max_examples=5000)
settings.load_profile(os.environ.get("PYTRACKER_HYPOTHESIS", "default"))


def load_arm(folder: Path | str) -> pt.ArmRecording:
    """`pytracker.load` of a folder that holds an arm."""
    recording = pt.load(folder)
    assert isinstance(recording, pt.ArmRecording)
    return recording


def load_body(folder: Path | str) -> pt.BodyRecording:
    """The same of one that holds a body."""
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    return recording


def arm_tracker(arm: pt.Arm, cameras: pt.Camera | list[pt.Camera], method: ArmMethod, seed: int = 0) -> pt.Tracker:
    """A tracker of an arm that nobody recorded."""
    views = tuple(pt.View(camera=camera) for camera in (cameras if isinstance(cameras, list) else [cameras]))
    return pt.Tracker(pt.ArmRecording(views=views, imus=(), arm=arm), method, seed)


def estimated(tracker: pt.Tracker, frame: pt.Observation) -> pt.Estimate:
    """The estimate at a frame."""
    estimate = tracker.observe(frame)
    assert estimate is not None
    return estimate


def shown(edges: Image, blobs: Array | None = None, **more: Any) -> BodyEvidence:
    """Evidence made by hand: edges, and where they are given blobs and more."""
    empty, none = np.zeros_like(edges), np.zeros((0, 2))
    return BodyEvidence(empty, edges, empty, none if blobs is None else blobs, **more)


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """A folder that `make` fills, made by whichever worker asks first, for all of them; copy it before changing it."""
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent
    folder, made = root / name, root / f"{name}.made"
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.exists():
            make(folder)
            made.touch()
    return folder


@pytest.fixture(scope="session")
def shared() -> Callable[[str], Path]:
    """Path below the shared data; skips, or fails under `make acceptance`, where it is absent."""

    def find(path: str) -> Path:
        found = SHARED / path
        if not found.exists():
            reason = f"needs shared data that is not part of the project: {path}"
            if IS_ACCEPTANCE:
                pytest.fail(reason)
            pytest.skip(reason)
        return found

    return find


@pytest.fixture(scope="session")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short simulated recording folder; copy it before changing it."""
    folder = tmp_path_factory.mktemp("recordings") / "circle"
    return pt.simulate_arm(folder, pt.ArmScene(duration_s=3.0), seed=11)


@pytest.fixture(scope="session")
def simulated_body(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short simulated body; copy it before changing it."""
    folder = tmp_path_factory.mktemp("recordings") / "body"
    return pt.simulate_body(folder, pt.BodyScene(duration_s=2.0), seed=11)


@pytest.fixture(scope="session")
def body(simulated_body: Path) -> pt.BodyRecording:
    """The same, loaded."""
    recording = pt.load(simulated_body)
    assert isinstance(recording, pt.BodyRecording)
    return recording


@pytest.fixture(scope="session")
def gesturing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A worn arm that gestures, with everything in its recording.toml; copy it before changing it."""
    scene = pt.ArmScene(worn=True, pattern="gesture", period_s=2.0)
    return made_once(tmp_path_factory, "gesturing", lambda folder: pt.simulate_arm(folder, scene, 8))


@pytest.fixture(scope="session")
def sensed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A body with both; copy it before changing it."""
    scene = pt.BodyScene(duration_s=5.0, keypoint_sd_px=3.0, imus=SEGMENTS)
    return made_once(tmp_path_factory, "sensed", lambda folder: pt.simulate_body(folder, scene, seed=4))


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's Chromium; the page tests skip where there is none, except where CI says that there is."""
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        if os.environ.get("CI"):
            pytest.fail("no chromium on this machine")
        pytest.skip("needs chromium to look at the page")
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()
