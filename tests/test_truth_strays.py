"""Rows of a truth that nobody measured, where bones would be as long as none is; and joints that were never seen."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.qualisys import read_qualisys
from pytracker.formats.truth_csv import read_truth_csv
from pytracker.recording.truth.strays import without_strays
from pytracker.rotation import Array
from pytracker.simulate.arm import ArmSimulation

FILE = Path("truth.csv")
TIME_S = np.arange(0.0, 6.0, 0.01)


def arm() -> dict[str, Array]:
    simulation = ArmSimulation(pt.ArmScene(pattern="gesture", duration_s=6.0), 5)
    return {joint: getattr(simulation, joint)(TIME_S) for joint in ("shoulder", "elbow", "wrist")}


@pytest.mark.parametrize(
    ("to", "rows"),
    [
        (lambda at: at["wrist"] + [0.6, 0.0, 0.0], slice(100, 115)),
        (lambda at: at["elbow"], slice(100, 115)),
        (lambda at: np.full_like(at["wrist"], -1.0), slice(100, 160)),
        (lambda at: at["wrist"] * [1.0, 1.0, 0.0] + [0.0, 0.0, 9.999], slice(100, 160)),
    ],
)
def test_rows_of_a_wrist_elsewhere_are_left_out(to: Callable[[dict[str, Array]], Array], rows: slice) -> None:
    """Scored as the tracker's error: 10 cm of 3, 41 of 10 where 4 rows of 232 leapt by 3 m."""
    joints = arm()
    moved = joints | {"wrist": joints["wrist"].copy()}
    moved["wrist"][rows] = to(joints)[rows]
    kept, said = without_strays(FILE, TIME_S, moved)
    odd = np.asarray(np.isnan(kept["wrist"]).all(axis=1))
    assert odd[rows].mean() > 0.9
    assert odd.sum() == odd[rows].sum()
    assert np.isfinite(kept["elbow"]).all()
    assert np.isfinite(kept["shoulder"]).all()
    (words,) = said
    assert "wrist is at" in words
    assert f"{int(odd.sum())} of 600 rows are such and are left out" in words


@pytest.mark.parametrize("rows", [slice(200, 400), slice(0, 100), slice(450, 600)])
@pytest.mark.parametrize("step", [1, 4])
def test_joints_that_are_exchanged_for_a_while_are_left_out(rows: slice, step: int) -> None:
    """3 s of 20 in which elbow and wrist were: 10 cm for 4, without a word, as no bone is of an odd length."""
    joints = arm()
    joints["elbow"][rows], joints["wrist"][rows] = joints["wrist"][rows].copy(), joints["elbow"][rows].copy()
    kept, said = without_strays(FILE, TIME_S[::step], {joint: points[::step] for joint, points in joints.items()})
    odd = np.zeros(600, dtype=bool)
    odd[rows] = True
    for joint in ("elbow", "wrist"):
        assert np.array_equal(np.isnan(kept[joint]).any(axis=1), odd[::step])
    assert np.isfinite(kept["shoulder"]).all()
    (words,) = said
    assert "elbow and wrist stand in each other's place" in words
    assert f"longest from {TIME_S[::step][odd[::step]][0]:.3f} to" in words


def test_an_elbow_that_leaps_takes_what_hangs_on_it_alone() -> None:
    joints = arm()
    joints["elbow"][50:60] += [0.0, 0.0, 1.0]
    kept, said = without_strays(FILE, TIME_S, joints)
    assert [int(np.isnan(kept[joint][:, 0]).sum()) for joint in ("shoulder", "elbow", "wrist")] == [10, 10, 10]
    assert len(said) == 3


def test_what_was_measured_stays(shared: Callable[[str], Path]) -> None:
    """Joints of people that were found without markers, whose lengths vary most."""
    for folder in sorted(shared("recordings").glob("people-gesture-*")):
        markers = read_truth_csv(folder / "truth.csv")
        joints = markers.positions_m
        kept, said = without_strays(FILE, markers.time_s, joints)
        assert said == []
        assert all(np.array_equal(kept[joint], joints[joint], equal_nan=True) for joint in joints)


def with_truth(folder: Path, time_s: Array, joints: dict[str, Array], markers: str = "") -> pt.Recording:
    """The recording with another truth."""
    head = ",".join(f"{joint}_{axis}_m" for joint in joints for axis in "xyz")
    np.savetxt(
        folder / "truth.csv",
        np.column_stack([time_s, *joints.values()]),
        "%.5f",
        ",",
        header=f"time_s,{head}",
        comments="",
    )
    text = (folder / "recording.toml").read_text().split("[truth]")[0]
    (folder / "recording.toml").write_text(f'{text}[truth]\nfile = "truth.csv"\n{markers}')
    return pt.load(folder)


@pytest.fixture
def recorded(tmp_path: Path) -> tuple[Path, Array, dict[str, Array]]:
    folder = pt.simulate_arm(tmp_path / "arm", pt.ArmScene(duration_s=4.0), 3)
    truth = pt.load(folder).truth
    assert truth is not None
    return folder, truth.time_s, dict(truth.joints_m)


def test_a_joint_that_is_never_seen_is_no_truth_of_it(recorded: tuple[Path, Array, dict[str, Array]]) -> None:
    """The truth was refused, and of a body nothing was scored, after all the work."""
    folder, time_s, joints = recorded
    recording = with_truth(folder, time_s, joints | {"shoulder": np.full_like(joints["shoulder"], np.nan)})
    assert recording.truth is not None
    assert sorted(recording.truth.joints_m) == ["elbow", "wrist"]
    assert any("shoulder was not seen in" in words for words in recording.warnings)
    track = pt.track(recording, pt.Layered(particles=50), 1)
    assert sorted(pt.evaluate(track, recording.truth).joints) == ["elbow", "wrist"]
    # Of two markers that a joint lies between, one that is never seen is no place of zeros.
    half = joints | {"inner": np.zeros_like(joints["shoulder"])}
    recording = with_truth(
        folder, time_s, half, 'markers = { shoulder = ["shoulder", "inner"], elbow = "elbow", wrist = "wrist" }\n'
    )
    assert recording.truth is not None
    assert sorted(recording.truth.joints_m) == ["elbow", "wrist"]
    with pytest.raises(pt.InputError, match="expected at least wrist"):
        with_truth(folder, time_s, joints | {"wrist": np.full_like(joints["wrist"], np.nan)})
    with pytest.raises(pt.InputError, match="wrist is never seen, expected truth"):
        with_truth(folder, time_s, {"wrist": np.full_like(joints["wrist"], np.nan)})


def test_rows_that_are_missing_are_told(recorded: tuple[Path, Array, dict[str, Array]]) -> None:
    """2 of 6 s: the page said that the whole of it was compared."""
    folder, time_s, joints = recorded
    keep = (time_s < 0.995) | (time_s > 2.495)
    recording = with_truth(folder, time_s[keep], {joint: points[keep] for joint, points in joints.items()})
    (words,) = (words for words in recording.warnings if "has no rows for" in words)
    assert "has no rows for 1.51 s in all, longest from 0.990 to 2.500 s" in words
    track = pt.track(recording, pt.Layered(particles=50), 1)
    pt.write_report([track], folder.parent / "out")
    scored = pt.evaluate(track, recording.truth).joints["wrist"].frames
    assert scored < 70
    assert f"Against the truth of {scored} of them the wrist is" in (folder.parent / "out" / "index.html").read_text()


def test_a_last_marker_that_is_never_seen_moves_no_columns(tmp_path: Path) -> None:
    """Frame and time were taken for places: 34 cm for 3."""
    head = "NO_OF_FRAMES\t3\nNO_OF_MARKERS\t2\nFREQUENCY\t100\nDATA_INCLUDED\t3D\nMARKER_NAMES\twrist\textra\n"
    names = "Frame\tTime\twrist X\twrist Y\twrist Z\textra X\textra Y\textra Z\n"
    rows = [f"{k + 1}\t{k / 100:.2f}\t{100 + k}\t200\t300\t\t\t" for k in range(3)]
    path = tmp_path / "truth.tsv"
    path.write_text(head + names + "\n".join(rows) + "\n")
    found = read_qualisys(path)
    assert found.time_s.tolist() == [0.0, 0.01, 0.02]
    np.testing.assert_allclose(found.positions_m["wrist"], [[0.1 + k / 1000, 0.2, 0.3] for k in range(3)])
    assert np.isnan(found.positions_m["extra"]).all()


def test_collar_bones_are_no_shoulders(tmp_path: Path) -> None:
    """8 cm apart, as Mixamo's and Rokoko's LeftShoulder are: shoulders 13 cm off, without a word."""
    folder = pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=1.0), 3)
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    assert recording.truth is not None
    joints = dict(recording.truth.joints_m)
    middle = 0.5 * (joints["left_shoulder"] + joints["right_shoulder"])
    for side in ("left", "right"):
        inwards = 0.8 * (middle - joints[f"{side}_shoulder"])
        for joint in ("shoulder", "elbow", "wrist"):
            joints[f"{side}_{joint}"] = joints[f"{side}_{joint}"] + inwards
    with pytest.raises(pt.InputError, match=r"left_shoulder and right_shoulder are 0\.0\d+ m apart .*collar bones"):
        with_truth(folder, recording.truth.time_s, joints)
