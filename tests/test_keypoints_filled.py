"""Keypoints that no detector found: held, or filled in by lines and cubics, and low-passed after."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, UnivariateSpline
from scipy.signal import butter, savgol_filter, sosfiltfilt

from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import Keypoints, read_keypoints
from pytracker.recording.keypoints.filled import without_filled, without_repeats


def test_keypoints_that_were_held_are_left_out() -> None:
    """A detector that hung: wrists were 41 cm off, and valid."""
    rng = np.random.default_rng(0)
    points = rng.uniform(0.0, 100.0, (40, 1, len(KEYPOINTS), 3))
    points[13:30] = points[12]
    points[35:37] = points[34]
    kept, said = without_repeats(Path("k.csv"), Keypoints(np.arange(40), points))
    assert np.isnan(kept.points[13:30]).all()
    assert np.isfinite(kept.points[[*range(13), *range(30, 40)]]).all()
    assert "in 17 frames the keypoints repeat" in said[0]
    assert "longest in frames 13 to 29" in said[0]
    assert without_repeats(Path("k.csv"), Keypoints(np.arange(40), np.rint(points)))[1] == ()


def test_keypoints_that_were_filled_in_are_left_out() -> None:
    """Pipelines fill gaps by straight lines, joint by joint, and detectors hold one joint."""
    rng = np.random.default_rng(0)
    walk = 100.0 + np.cumsum(rng.normal(0.0, 1.0, (60, 1, len(KEYPOINTS), 3)), axis=0)
    frames, line, hold, short, still = np.arange(60), 3, 4, 5, 6
    points = walk.copy()
    points[20:41, 0, line, :2] = np.linspace(walk[20, 0, line, :2], walk[40, 0, line, :2], 21)
    points[20:41, 0, hold, :2] = walk[20, 0, hold, :2]
    points[20:31, 0, short, :2] = np.linspace(walk[20, 0, short, :2], walk[30, 0, short, :2], 11)
    points[:, 0, still, :2] = 50.0 + 0.02 * rng.normal(size=(60, 2))
    kept, said = without_filled(Path("k.csv"), Keypoints(frames, points))
    gone = np.isnan(kept.points[:, 0, :, 0])
    assert np.flatnonzero(gone[:, line]).tolist() == list(range(21, 40))
    assert np.flatnonzero(gone[:, hold]).tolist() == list(range(21, 41))
    assert gone.sum() == 19 + 20
    assert "39 keypoints lie on a straight line or a cubic" in said[0]
    assert "most in a row of the right elbow in frames 21 to 40" in said[0]
    # Digits that are rounded; and a frame that was left out is no neighbour.
    kept, said = without_filled(Path("k.csv"), Keypoints(frames, np.round(points, 2)))
    assert (np.isnan(kept.points[:, 0, :, 0]) == gone).all()
    assert without_filled(Path("k.csv"), Keypoints(frames, np.rint(points)))[1] == ()
    assert without_filled(Path("k.csv"), Keypoints(2 * frames, points))[1] == ()


def test_a_joint_that_never_moves_while_others_do_is_held() -> None:
    """A hand that hung from the first frame to the last: wrists were 10 to 13 cm off, up to 62 % valid."""
    rng = np.random.default_rng(1)
    points = 100.0 + rng.normal(0.0, 0.5, (60, 2, len(KEYPOINTS), 3))
    points[:, 1, 5, :2] = (50.25, 60.75)
    points[7, 1, 5] = np.nan
    kept, said = without_filled(Path("k.csv"), Keypoints(np.arange(60), points))
    assert np.argwhere(np.isnan(kept.points[..., 0]).all(axis=0)).tolist() == [[1, 5]]
    assert "59 keypoints lie on a straight line" in said[0]
    # Whole pixels stay the same where somebody stands still; who stands as a whole is no joint that hangs.
    assert without_filled(Path("k.csv"), Keypoints(np.arange(60), np.rint(points)))[1] == ()
    points[:, 1] = points[:1, 1]
    assert not np.isnan(without_filled(Path("k.csv"), Keypoints(np.arange(60), points))[0].points[:, 0]).any()


@pytest.mark.parametrize(("fill", "cutoff_hz"), [("line", 8.0), ("line", 6.0), ("cubic", None)])
def test_gaps_that_were_filled_and_low_passed_are_left_out(fill: str, cutoff_hz: float | None) -> None:
    """As Pose2Sim does: filled first, then a Butterworth filter; 14 cm off, and valid."""
    rng, time_s = np.random.default_rng(4), np.arange(300) / 60.0
    gap = np.arange(120, 180)
    moves = 60.0 * np.sin(2 * np.pi * 0.7 * time_s[:, None] + np.arange(2)) + [300.0, 200.0]
    pixels = moves + rng.normal(0.0, 1.0, moves.shape)
    known = np.setdiff1d(np.arange(300), gap)
    about = known if fill == "line" else np.array([117, 119, 180, 182])
    pixels[gap] = np.stack(
        [
            np.interp(gap, known, column[known]) if fill == "line" else CubicSpline(about, column[about])(gap)
            for column in pixels.T
        ],
        axis=1,
    )
    if cutoff_hz is not None:
        pixels = sosfiltfilt(butter(4, cutoff_hz, fs=60.0, output="sos"), pixels, axis=0)
    points = np.full((300, 1, len(KEYPOINTS), 3), np.nan)
    points[:, 0, 3] = np.column_stack([pixels, np.ones(300)])
    kept, said = without_filled(Path("k.csv"), Keypoints(np.arange(300), points))
    gone = np.isnan(kept.points[:, 0, 3, 0])
    assert gone[gap].mean() > 0.65
    assert gone[known].sum() <= 6
    assert "filled in or held" in said[0]


@pytest.mark.parametrize("window", [None, 31])
def test_points_that_were_smoothed_are_no_fillings(window: int | None) -> None:
    """By a spline, which is made of cubics, or a long Savitzky-Golay filter: 13 and 55 % were taken out."""
    rng, time_s = np.random.default_rng(6), np.arange(400) / 60.0
    moves = 60.0 * np.sin(2 * np.pi * np.array([0.4, 0.7]) * time_s[:, None]) + [300.0, 200.0]
    noisy = moves + rng.normal(0.0, 0.7, moves.shape)
    points = np.full((400, 1, len(KEYPOINTS), 3), np.nan)
    for k, column in enumerate(noisy.T):
        smoothed = UnivariateSpline(time_s, column, s=0.5 * len(time_s)) if window is None else None
        points[:, 0, 3, k] = savgol_filter(column, window, 3) if smoothed is None else smoothed(time_s)
    points[:, 0, 3, 2] = 1.0
    assert without_filled(Path("k.csv"), Keypoints(np.arange(400), points))[1] == ()


def test_no_detectors_points_look_filled_in(shared: Callable[[str], Path]) -> None:
    folders = {file.parent for file in shared("data/people/pose2sim_truth").rglob("*_json/*.json")}
    for file in [*shared("data/people/gestures").glob("*mediapipe*.csv"), *folders]:
        found = read_keypoints(file)
        pixels = found.points[..., :2] * ([270, 480] if found.is_share else 1.0)
        points = np.concatenate([pixels, found.points[..., 2:]], axis=-1)
        assert without_filled(file, Keypoints(found.frames, points))[1] == ()
