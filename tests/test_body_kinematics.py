"""Forward kinematics against data that nobody here made: optical markers (C3D), and another program's BVH."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from conftest import estimated, shown

import pytracker as pt
from pytracker.formats import read_amc, read_asf, write_amc
from pytracker.formats.bvh import read_bvh
from pytracker.skeleton import KEY_JOINTS, average_skeleton

MARKERS = {"shoulder": ("SHO",), "elbow": ("ELB",), "wrist": ("WRA", "WRB")}
BONES = {"shoulder": ("humerus", 0), "elbow": ("humerus", 1), "wrist": ("wrist", 1)}


@pytest.mark.parametrize(
    ("joint", "within_m", "correlation"), [("elbow", 0.09, 0.99), ("wrist", 0.09, 0.99), ("shoulder", 0.12, 0.98)]
)
@pytest.mark.parametrize("side", ["l", "r"])
def test_joints_are_where_the_markers_are(
    shared: Callable[[str], Path], side: str, joint: str, within_m: float, correlation: float
) -> None:
    """HDM05: markers sit on the skin, some centimetres from the joints that were made from them."""
    folder = shared("data/cmu/hdm05")
    skeleton = read_asf(folder / "HDM_dg.asf")
    motion = read_amc(next(folder.glob("*.amc")), skeleton)
    c3d = ezc3d.c3d(str(next(folder.glob("*.c3d"))))
    labels = c3d["parameters"]["POINT"]["LABELS"]["value"]
    names = [side.upper() + name for name in MARKERS[joint]]
    picked = [k for k, label in enumerate(labels) if label.strip().endswith(tuple(names))]
    assert len(picked) == len(names)
    # C3D is in mm with z up: its x, y, z are the skeleton's z, x, y.
    marker = c3d["data"]["points"][:3, picked].mean(axis=1).T[:, [1, 2, 0]] / 1000
    bone, end = BONES[joint]
    found = skeleton.core.pose(motion.poses)[end][:, skeleton.bone(side + bone)]
    assert np.linalg.norm(found - marker, axis=1).max() <= within_m
    for axis in range(3):
        assert np.corrcoef(found[:, axis], marker[:, axis])[0, 1] > correlation


def test_poses_agree_with_the_bvh_of_the_same_trial(shared: Callable[[str], Path]) -> None:
    skeleton = read_asf(shared("data/cmu/16.asf"))
    starts, ends, _ = skeleton.core.pose(read_amc(shared("data/cmu/16_15.amc"), skeleton).poses)
    found = read_bvh(shared("data/cmu/16_15.bvh"))
    assert len(found.time_s) == len(starts)
    assert found.rate_hz == pytest.approx(120.0, abs=0.1)
    # It is keyed at 30 Hz: every fourth frame from the fifth on is a key, the others are interpolated.
    for frame in range(4, len(starts), 4):
        joints = {name: place[frame] for name, place in found.positions_m.items()}
        for name in (
            "head",
            "lhumerus",
            "lradius",
            "lwrist",
            "lhand",
            "rhumerus",
            "rradius",
            "rwrist",
            "rhand",
            "ltibia",
        ):
            assert np.abs(joints[name] - starts[frame, skeleton.bone(name)]).max() < 1e-3, (frame, name)
        assert np.abs(joints["head_end"] - ends[frame, skeleton.bone("head")]).max() < 1e-3


@pytest.mark.parametrize(
    ("motion", "skeleton", "frames"),
    [
        ("07_05-walk", "07-walk", 517), ("131_04-dance", "131-dance", 1086), ("13_29", "16", 4592),
        ("16_15", "16", 471), ("35_01", "35", 358), ("49_18", "49", 1102), ("49_19", "49", 957),
        ("hdm05/HDM_dg_06-03_03_120", "hdm05/HDM_dg", 202),
    ],
)  # fmt: skip
def test_every_file_parses(
    shared: Callable[[str], Path], tmp_path: Path, motion: str, skeleton: str, frames: int
) -> None:
    """And comes back the same from our own writer."""
    bones = read_asf(shared(f"data/cmu/{skeleton}.asf"))
    assert len(bones.bones) == 31
    read = read_amc(shared(f"data/cmu/{motion}.amc"), bones)
    assert read.poses.shape == (frames, 62)
    assert read.warnings == ()
    write_amc(tmp_path / "again.amc", bones, read.poses)
    assert np.abs(read_amc(tmp_path / "again.amc", bones).poses - read.poses).max() < 1e-6


def test_the_compiled_joints_are_the_skeletons(body: pt.BodyRecording) -> None:
    """What the tracker calls a joint is what the skeleton calls it."""
    tracker = pt.Tracker(body, pt.BodyPlain(particles=5))
    found = estimated(tracker, pt.Observation.picture(0.0, shown(np.zeros((240, 320), np.uint8)))).places
    expected = body.skeleton.joints(body.initial[None])
    for name in KEY_JOINTS:
        assert np.abs(found[name].mean - expected[name][0]).max() < 1e-12


def test_average_skeleton_is_a_person() -> None:
    skeleton = average_skeleton(1.8)
    starts, ends, _ = skeleton.core.pose(np.zeros((1, len(skeleton.channels))))
    feet = ends[0, skeleton.bone("ltoes"), 1]
    assert ends[0, skeleton.bone("head"), 1] - feet == pytest.approx(1.8, abs=0.1)
    span = ends[0, skeleton.bone("lfingers"), 0] - ends[0, skeleton.bone("rfingers"), 0]
    assert span == pytest.approx(1.8, abs=0.1)
    # A positive elbow angle brings either hand forward, to +z, where the person looks.
    for side in "lr":
        pose = np.zeros((1, len(skeleton.channels)))
        pose[0, skeleton.channels.index(f"{side}radius_rx")] = np.pi / 2
        bent = skeleton.core.pose(pose)[1]
        assert bent[0, skeleton.bone(f"{side}wrist"), 2] > starts[0, skeleton.bone(f"{side}radius"), 2] + 0.2
