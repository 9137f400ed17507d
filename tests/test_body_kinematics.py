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
from pytracker.rotation import Array
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
    nodes, rows = read_bvh(shared("data/cmu/16_15.bvh"))
    assert len(rows) == len(starts)
    # It is keyed at 30 Hz: every fourth frame from the fifth on is a key, the others are interpolated.
    for frame in range(4, len(rows), 4):
        joints = bvh_joints(nodes, rows[frame])
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


def read_bvh(path: Path) -> tuple[list[tuple[str, int | None, Array, list[str]]], Array]:
    """Nodes (name, parent, offset in cm, channels) and one row a frame."""
    nodes: list[tuple[str, int | None, Array, list[str]]] = []
    stack: list[int] = []
    lines = path.read_text().split("\n")
    for number, line in enumerate(lines):
        words = line.split()
        if not words:
            continue
        parent = stack[-1] if stack else None
        if words[0] in ("ROOT", "JOINT"):
            nodes.append((words[1], parent, np.zeros(3), []))
        elif words[0] == "End":
            assert parent is not None
            nodes.append((nodes[parent][0] + "_end", parent, np.zeros(3), []))
        elif words[0] == "{":
            stack.append(len(nodes) - 1)
        elif words[0] == "}":
            stack.pop()
        elif words[0] == "OFFSET":
            nodes[stack[-1]][2][:] = [float(x) for x in words[1:]]
        elif words[0] == "CHANNELS":
            nodes[stack[-1]][3].extend(words[2:])
        elif words[0] == "MOTION":
            return nodes, np.array([[float(x) for x in row.split()] for row in lines[number + 3 :] if row.strip()])
    raise AssertionError("no MOTION")


def bvh_joints(nodes: list[tuple[str, int | None, Array, list[str]]], row: Array) -> dict[str, Array]:
    """Where the joints are, m."""
    rotations: list[Array] = []
    places: list[Array] = []
    values = iter(row)
    for _, parent, offset, channels in nodes:
        place, turn = (offset.copy() if parent is not None else np.zeros(3)), np.eye(3)
        for channel in channels:
            axis, value = "XYZ".index(channel[0]), next(values)
            if channel.endswith("position"):
                place[axis] = value
            else:
                s, c = np.sin(np.radians(value)), np.cos(np.radians(value))
                j, k = (axis + 1) % 3, (axis + 2) % 3
                m = np.eye(3)
                m[j, j], m[j, k], m[k, j], m[k, k] = c, -s, s, c
                turn = turn @ m
        rotations.append(turn if parent is None else rotations[parent] @ turn)
        places.append(place if parent is None else places[parent] + rotations[parent] @ place)
    return {name: place / 100 for (name, *_), place in zip(nodes, places, strict=True)}
