"""The border to the compiled core: forks, threads, memory, saved states and absurd numbers; no panic crosses it."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import resource
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import arm_tracker, estimated, shown
from test_cli import run

import pytracker as pt
from pytracker._core import missed_edges
from pytracker.skeleton import Bone
from pytracker.tracking import resample

ARM = pt.Arm(shoulder_m=(0.1, 0.0, 0.25), upper_arm_m=0.3, forearm_m=0.25, wrist_start_m=(0.2, 0.3, 0.0))
CAMERA = pt.Camera(matrix=((700.0, 0.0, 320.0), (0.0, 700.0, 240.0), (0.0, 0.0, 1.0)), translation_m=(0.0, 0.0, 2.0))
UP, LEVEL = (0.0, 0.0, 9.81), (1.0, 0.0, 0.0, 0.0)


def tracker(method: Any = None) -> pt.Tracker:
    made = arm_tracker(ARM, CAMERA, method or pt.Layered(particles=100), 3)
    made.observe(pt.Observation.inertial(0.0, UP, LEVEL))
    made.observe(pt.Observation.patch(0.0, (390.0, 345.0)))
    return made


def test_smoothing_while_another_thread_tracks_is_an_error() -> None:
    """Not a panic, which nothing but a bare `except` would catch; afterwards all goes on."""
    busy = tracker(pt.Layered(particles=100_000))
    observed = []
    for time_s in np.arange(1, 60) / 25:
        observed += [pt.Observation.inertial(time_s, UP, LEVEL), pt.Observation.patch(time_s, (390.0, 345.0))]
    thread = threading.Thread(target=busy.run, args=(observed,))
    thread.start()
    refused: list[str] = []
    while thread.is_alive() and not refused:
        try:
            next(busy.smoothed(), None)
        except RuntimeError as error:
            refused.append(str(error))
    thread.join()
    assert refused == ["Already mutably borrowed"]
    assert next(busy.smoothed(), None) is None


@pytest.mark.parametrize(
    "as_given",
    [
        np.array,
        lambda row: np.array(row, np.float32).tolist(),
        lambda row: np.array(row, np.float32),
        lambda row: np.repeat(np.array(row), 2)[::2],
        lambda row: np.repeat(np.array(row), 2).reshape(-1, 2)[:, 0],
        lambda row: np.array(row).astype(">f8"),
        lambda row: np.array([row])[0],
    ],
)
def test_numbers_come_as_any_sequence(as_given: Callable[[tuple[float, ...]], Any]) -> None:
    """An array of floats is read as it lies in memory, whatever its strides; all else by element."""
    plain, other = tracker(), tracker()
    up, turn, pixel = (0.5, -0.25, 9.75), (0.125, 0.25, -0.5), (390.0, 345.5)
    plain.observe(pt.Observation.inertial(0.01, up, LEVEL, turn))
    other.observe(pt.Observation.inertial(0.01, as_given(up), as_given(LEVEL), as_given(turn)))
    expected = estimated(plain, pt.Observation.patch(0.02, pixel)).places["wrist"]
    found = estimated(other, pt.Observation.patch(0.02, as_given(pixel))).places["wrist"]
    np.testing.assert_array_equal(found.mean, expected.mean)
    np.testing.assert_array_equal(found.hi, expected.hi)


@pytest.mark.parametrize("wrong", [(0.0, 9.81), (0.0, 0.0, 9.81, 1.0), np.zeros(2), np.zeros((1, 3)), "abc", None])
def test_too_few_or_other_numbers_are_refused(wrong: Any) -> None:
    with pytest.raises((TypeError, ValueError)):
        pt.Observation.inertial(0.0, wrong, LEVEL)


def work_of_a_child(method: Any) -> float:
    made = tracker(method)
    for k in range(1, 5):
        made.observe(pt.Observation.inertial(0.01 * k, UP, LEVEL))
        estimate = estimated(made, pt.Observation.patch(0.01 * k, (390.0, 345.0)))
    return float(estimate.places["wrist"].mean[0])


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("method", [pt.Layered(particles=100), pt.Joint(particles=50_000)], ids=["serial", "threaded"])
def test_a_fork_after_use_does_not_wait_for_ever(method: Any) -> None:
    expected = work_of_a_child(method)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        found = pool.map_async(work_of_a_child, [method] * 4).get(timeout=60)
    assert found == [expected] * 4


def test_threads_have_bounds(simulated_body: Path) -> None:
    body = pt.load(simulated_body)
    for threads in (0, 257, 3000, 10**12):
        with pytest.raises(pt.InputError, match=f"threads is {threads}, expected 1 to 256"):
            pt.track(body, pt.BodyPlain(particles=5), threads=threads)


def test_a_changed_state_is_refused() -> None:
    made = tracker()
    saved = made.save()
    assert estimated(pt.Tracker.restore(saved), pt.Observation.patch(0.04, None)).time_s == 0.04
    pick = np.random.default_rng(5)
    for _ in range(2000):
        changed = bytearray(saved)
        for _ in range(int(pick.integers(1, 4))):
            changed[int(pick.integers(len(changed)))] ^= int(pick.integers(1, 256))
        with pytest.raises(pt.InputError, match="saved tracker state cannot be read"):
            pt.Tracker.restore(bytes(changed))
    for end in range(0, len(saved), 97):
        with pytest.raises(pt.InputError, match="saved tracker state cannot be read"):
            pt.Tracker.restore(saved[:end])
    with pytest.raises(pt.InputError, match=r"of another kind or version"):
        pt.Tracker.restore(saved.replace(b"pytracker tracker 0", b"pytracker tracker 9"))
    assert estimated(pickle.loads(pickle.dumps(made)), pt.Observation.patch(0.04, None)).time_s == 0.04  # noqa: S301 - our own


@pytest.mark.skipif(sys.platform == "win32", reason="limits as Unix has them")
def test_what_cannot_be_held_is_refused_before_it_is_tried(simulated: Path, tmp_path: Path) -> None:
    def limited(code: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(  # noqa: S603
            [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (4 * 2**30, 4 * 2**30)),
        )  # fmt: skip

    done = limited(f"""
        import sys
        from pytracker.cli import main
        sys.argv = ["pytracker", "track", {str(simulated)!r}, "--out", {str(tmp_path / "out")!r}, "--method", "joint",
                    "--particles", "100000000"]
        main()
    """)
    assert done.returncode == 2, done.stderr
    assert "particles: no memory for " in done.stderr
    done = limited("""
        import numpy as np, pytracker as pt
        from pytracker.tracking import resample
        for n in (2**30, 2**40, 2**63):
            try:
                resample("residual", np.ones(3), n)
            except pt.InputError as error:
                print(error)
    """)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("expected") == 3


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1e300, 1e300, 1e12])
@pytest.mark.parametrize("method", [pt.Layered(particles=50), pt.Ekf(bias=True)], ids=lambda m: m.name)
def test_absurd_numbers_are_refused_and_change_no_estimate(method: Any, value: float) -> None:
    made, untouched = tracker(method), tracker(method)
    take, inertial = made.observe, pt.Observation.inertial
    refused: list[Callable[[], object]] = [
        lambda: take(inertial(0.01, (value, 0.0, 9.81), LEVEL)),
        lambda: take(inertial(0.01, UP, (value, 0.0, 0.0, 0.0))),
        lambda: take(inertial(0.01, UP, LEVEL, (0.0, value, 0.0))),
        lambda: take(inertial(value if abs(value) != 1e12 else 1e13, UP, LEVEL)),
        lambda: take(pt.Observation.patch(0.01, (value, value if value == value else 0.0))),
        lambda: arm_tracker(ARM, CAMERA, type(method)(pixel_sd=value)),
        lambda: arm_tracker(ARM, CAMERA, type(method)(accel_density=value)),
        lambda: arm_tracker(pt.Arm(**{**vars(ARM), "shoulder_m": (value, 0, 0)}), CAMERA, method),
        lambda: arm_tracker(ARM, pt.Camera(**{**vars(CAMERA), "translation_m": (0, 0, value)}), method),
    ]
    for call in refused:
        with pytest.raises(pt.InputError, match="expected"):
            call()
    ends = []
    for one in (made, untouched):
        one.observe(pt.Observation.inertial(0.02, UP, LEVEL))
        ends.append(estimated(one, pt.Observation.patch(0.03, (320.0, 240.0))))
    for name, place in ends[1].places.items():
        assert np.array_equal(ends[0].places[name].mean, place.mean)
        assert np.array_equal(ends[0].places[name].sd, place.sd)


def test_an_estimate_far_ahead_is_finite_or_refused() -> None:
    for method in (pt.Layered(particles=50), pt.Joint(particles=50), pt.Ekf(bias=True)):
        made = tracker(method)
        for time_s in (0.5, 1e3, 1e6, 1e9, 9e10):
            try:
                estimate = made.estimate(time_s)
            except pt.TrackingError:
                continue
            wrist, elbow = estimate.places["wrist"], estimate.places["elbow"]
            for numbers in (wrist.mean, elbow.mean, wrist.sd, wrist.lo, estimate.covariance):
                assert np.isfinite(numbers).all()


def test_weights_that_are_almost_nothing_are_drawn_all_the_same() -> None:
    for scheme in ("multinomial", "stratified", "systematic", "residual"):
        drawn = resample(scheme, np.array([1e-320, 3e-320, 0.0]), 400, 1)
        assert 60 < (drawn == 0).sum() < 140
        assert (drawn < 2).all()


def test_many_blobs_are_no_more_work(body: pt.BodyRecording) -> None:
    made = pt.Tracker(body, pt.Partitioned(particles=50, gate_m=5.0))
    blobs = np.random.default_rng(1).uniform(0, 240, (500, 2))
    began = time.monotonic()
    for k in range(3):
        made.observe(pt.Observation.picture(k / 30, shown(np.zeros((240, 320), np.uint8), blobs)))
    assert time.monotonic() - began < 5.0  # 54 before
    with pytest.raises(pt.InputError, match="blob at"):
        made.observe(pt.Observation.picture(1.0, shown(np.zeros((240, 320), np.uint8), np.array([[np.nan, 1.0]]))))


def test_a_panic_is_an_error_of_ours(body: pt.BodyRecording) -> None:
    """Whatever goes wrong within the core comes out as `InputError` or `TrackingError`."""
    ours = (pt.InputError, pt.TrackingError)
    bone = Bone(
        name="root", parent=None, reach_m=(0, 0, 0), frame=((1, 0, 0), (0, 1, 0), (0, 0, 1)), order=(0, 5, 9),
        channels=("rx",), limits_rad=((-1.0, 1.0),),
    )  # fmt: skip
    from pytracker._core import Skeleton  # noqa: PLC0415

    with pytest.raises(pt.InputError, match="axes that are not x, y and z"):
        Skeleton([bone])
    for outlines in (np.full((2, 8), np.nan), np.full((1, 8), 1e300), np.full((1, 8), -1e308), np.zeros((0, 8))):
        try:
            missed_edges(np.zeros((0, 0), np.uint8), outlines)
            missed_edges(np.ones((3, 4), np.uint8), outlines)
        except ours:
            pass
    made = pt.Tracker(body, pt.Partitioned(particles=20))
    for states in (np.full((2, 11), 1e300), np.full((1, 11), np.nan), np.zeros((0, 11)), np.zeros((1, 3))):
        for call in (made.pose, made.channels):
            with contextlib.suppress(*ours):
                call(states)


def test_numbers_and_brackets_without_end(simulated: Path, tmp_path: Path) -> None:
    for setting in ("pixel_sd=" + "9" * 5000, "pixel_sd=" + "[" * 100_000):
        done = run("track", simulated, "--out", tmp_path / "out", "--set", setting)
        assert done.returncode == 2
        assert "internal error" not in done.stderr
    for text in (
        "schema = " + "9" * 5000,
        "schema = " + "[" * 20_000,
        "\x00",
        "schema = 1\nkind = 'arm'\n" + "a" * 10**6,
    ):
        (tmp_path / "recording.toml").write_text(text)
        done = run("track", tmp_path, "--out", tmp_path / "out")
        assert done.returncode == 2
        assert "recording.toml" in done.stderr
        assert "internal error" not in done.stderr
