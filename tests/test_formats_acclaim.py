"""ASF and AMC: what real files look like, what is refused and how, and that nothing else ever escapes."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pytracker as pt
from pytracker.formats import read_amc, read_asf, write_amc, write_asf
from pytracker.rotation import rotate, rotation_vector_to_quaternion, triple
from pytracker.skeleton.average import average_skeleton
from pytracker.skeleton.skeleton import Skeleton

ASF = """# comment
:version 1.10
:name someone
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   anything ; at all
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name spine
     direction 0 1 0
     length 9
     axis 0 0 0  XYZ
    dof rx ry rz
    limits (-20.0 45.0)
           (-30.0 30.0)
           (-30.0 30.0)
  end
  begin
     name arm
     axis 0 0 90
     length 4.5
     direction 1 0 0
     dof rx
     limits (-inf inf)
  end
:hierarchy
  begin
    root spine
    spine arm
  end
"""

AMC = """#!OML:ASF F:\\VICON\\USERDATA\\someone's file.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 0 0 90
spine 10 0 4.96962e-015
arm -30
2
arm -31
root 1 2 3 0 0 90
spine 10 0 0
"""


def asf(tmp_path: Path, text: str = ASF, name: str = "a.asf", encoding: str = "utf-8") -> Path:
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path


def test_lengths_are_inches_over_the_unit(tmp_path: Path) -> None:
    skeleton = read_asf(asf(tmp_path))
    assert [bone.name for bone in skeleton.bones] == ["root", "spine", "arm"]
    assert skeleton.bones[1].reach_m == pytest.approx((0.0, 9 / 0.45 * 0.0254, 0.0))
    assert skeleton.channels[:3] == ("root_tx", "root_ty", "root_tz")
    assert skeleton.channels[6:] == ("spine_rx", "spine_ry", "spine_rz", "arm_rx")
    assert skeleton.limits_rad[6] == pytest.approx([math.radians(-20), math.radians(45)])
    assert np.isinf(skeleton.limits_rad[9]).all()
    # `axis 0 0 90` turns x to y.
    assert np.array(skeleton.bones[2].frame)[:, 0] == pytest.approx([0, 1, 0], abs=1e-15)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("someone", "Jürgen"),
        lambda text: text.replace("axis 0 0 0  XYZ", "axis 0 0 0"),
        lambda text: text.replace("(-inf inf)", "(-INF Inf)"),
        lambda text: text.replace("     id 1\n", ""),
        lambda text: text.replace("begin\n    root spine\n", "begin\n\n    root spine\n"),
    ],
)
def test_liberties_that_files_take(tmp_path: Path, change: object) -> None:
    assert callable(change)
    changed = read_asf(asf(tmp_path, change(ASF), "b.asf", "latin-1"))
    assert changed.bones == read_asf(asf(tmp_path)).bones


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("length 0.45", "length 0", "6: length is '0', expected a positive number"),
        ("angle deg", "angle grad", "7: angle is 'grad', expected deg or rad"),
        ("direction 0 1 0", "direction 0 nan 0", "19: direction is '0 nan 0', expected 3 finite number(s)"),
        ("direction 0 1 0", "direction 0 2 0", "19: spine: direction has norm 2.0000, expected 1"),
        ("     length 9\n", "", "16: this bone has no length, expected 1 number(s)"),
        ("length 4.5", "length 4,5", "30: length is '4,5', expected 1 finite number(s)"),
        ("axis 0 0 0  XYZ", "axis 0 0 0  XYX", "21: order of axes is 'xyx', expected a permutation of XYZ"),
        ("dof rx ry rz", "dof rx ry tz", "22: spine: dof is 'rx ry tz', expected rx, ry, rz, each at most once"),
        ("           (-30.0 30.0)\n           (-30", "           (-30", "23: spine: 4 limits for 3 dof, expected 6"),
        ("(-20.0 45.0)", "(45.0 -20.0)", "23: spine: limits are"),
        ("spine arm\n", "spine leg\n", "38: 'leg' is not in :bonedata"),
        ("    spine arm\n", "", "bone 'arm' is not in :hierarchy"),
        ("root spine\n    spine arm", "spine arm\n    arm spine", "does not hang on the root, expected a tree"),
        (":bonedata", ":bonedat", "has no section :bonedata"),
        ("  end\n:hierarchy", ":hierarchy", "27: this bone has no end: the file is cut short"),
        ("order TX TY", "order TX TX", "11: root order is"),
    ],
)
def test_a_fault_in_a_skeleton_is_named(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert ASF.count(old) == 1 or old in ("length 0.45", "     length 9\n")
    with pytest.raises(pt.InputError) as error:
        read_asf(asf(tmp_path, ASF.replace(old, new, 1)))
    assert expected in str(error.value)
    assert "a.asf" in str(error.value)


def test_a_roots_orientation_is_in_the_files_unit(tmp_path: Path) -> None:
    """In radians it was taken for degrees: 8 cm off at the head, unsaid."""
    turned = ASF.replace("orientation 0 0 0", "orientation 0 90 0")
    assert turned != ASF
    radians = turned.replace("angle deg", "angle rad").replace("orientation 0 90 0", "orientation 0 1.5707963268 0")
    for old, new in (("axis 0 0 90", "axis 0 0 1.5707963268"), ("(-20.0 45.0)", "(-0.3490658504 0.7853981634)"),
                     ("(-30.0 30.0)", "(-0.5235987756 0.5235987756)")):  # fmt: skip
        assert old in radians
        radians = radians.replace(old, new)
    one, other = read_asf(asf(tmp_path, turned)), read_asf(asf(tmp_path, radians, "b.asf"))
    pose = np.full((1, len(one.channels)), 0.4)
    places = one.core.pose(pose)[1]
    np.testing.assert_allclose(other.core.pose(pose)[1], places, atol=1e-8)
    assert np.abs(read_asf(asf(tmp_path, name="c.asf")).core.pose(pose)[1] - places).max() > 0.01


def test_motion_in_metres_and_radians(tmp_path: Path) -> None:
    skeleton = read_asf(asf(tmp_path))
    motion = read_amc(asf(tmp_path, AMC.replace("\n", "\r\n"), "a.amc"), skeleton)
    assert motion.poses.shape == (2, 10)
    assert motion.poses[0, :6] == pytest.approx([0.0564444, 0.1128889, 0.1693333, 0, 0, math.pi / 2], abs=1e-6)
    assert motion.poses[:, 9] == pytest.approx(np.radians([-30, -31]))
    assert motion.warnings == ()


def test_a_bone_that_is_missing_is_said(tmp_path: Path) -> None:
    skeleton = read_asf(asf(tmp_path))
    motion = read_amc(asf(tmp_path, AMC.replace("arm -31\n", ""), "a.amc"), skeleton)
    assert motion.poses[1, 9] == 0
    assert len(motion.warnings) == 1
    assert "bone 'arm' is missing in 1 of 2 frames; its angles are taken as 0" in motion.warnings[0]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("arm -30", "arm", "7: 'arm' stands alone, expected a frame number or a bone and its values"),
        ("\n2\n", "\n2.5\n", "8: '2.5' stands alone, expected a frame number"),
        ("\n2\n", "\n\u00b2\n", "stands alone, expected a frame number"),
        ("arm -30", "arm x", "7: arm has the value 'x', expected a finite number"),
        ("arm -30", "arm 1e300", "7: arm has the value '1e300', expected at most 5729.58 in the file's units"),
        ("arm -30", "arm inf", "7: arm has the value 'inf', expected a finite number"),
        ("arm -30", "leg -30", "7: bone 'leg' is not in the skeleton, expected one of: root, spine, arm"),
        ("arm -31", "arm -31\narm -31", "10: bone 'arm' is there twice in frame 2, expected once"),
        ("\n2\n", "\n1\n", "8: frame 1 after frame 1, expected increasing numbers"),
        ("1\nroot", "root", "4: 'root' stands before the first frame number"),
    ],
)
def test_a_fault_in_a_motion_is_named(tmp_path: Path, old: str, new: str, expected: str) -> None:
    skeleton = read_asf(asf(tmp_path))
    with pytest.raises(pt.InputError) as error:
        read_amc(asf(tmp_path, AMC.replace(old, new, 1), "a.amc"), skeleton)
    assert expected in str(error.value)


def test_an_empty_motion_and_poses_that_cannot_be_written(tmp_path: Path) -> None:
    skeleton = read_asf(asf(tmp_path))
    with pytest.raises(pt.InputError, match="holds no frame"):
        read_amc(asf(tmp_path, ":DEGREES\n", "a.amc"), skeleton)
    with pytest.raises(pt.InputError, match=r"shape \(2, 3\), expected \(T, 10\)"):
        write_amc(tmp_path / "b.amc", skeleton, np.zeros((2, 3)))
    with pytest.raises(pt.InputError, match="pose 0: root_ty is nan"):
        write_amc(tmp_path / "b.amc", skeleton, np.array([[0, math.nan, *[0.0] * 8]]))


def mangled(text: str) -> st.SearchStrategy[str]:
    """`text` with lines dropped, doubled, swapped for junk, or cut."""
    lines = text.split("\n")
    junk = st.sampled_from(
        ["", "end", "begin", "1", "-3 4", ":hierarchy", "dof rx", "limits (", "nan", "\x00", "ü 1e999", "2"]
    )
    edit = st.tuples(st.integers(0, len(lines) - 1), st.sampled_from("dsj"), junk)

    def apply(edits: list[tuple[int, str, str]], cut: int) -> str:
        out = list(lines)
        for at, kind, word in edits:
            k = at % max(len(out), 1)
            if kind == "d":
                del out[k : k + 1]
            elif kind == "s":
                out[k:k] = out[k : k + 1]
            else:
                out[k : k + 1] = [word]
        return "\n".join(out)[: len(text) - cut]

    return st.builds(apply, st.lists(edit, max_size=6), st.integers(0, 60) | st.integers(0, len(text)))


@settings(max_examples=300)
@given(text=mangled(ASF))
def test_no_skeleton_raises_anything_else(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.getbasetemp() / "fuzz.asf"
    path.write_text(text, "utf-8")
    try:
        skeleton = read_asf(path)
    except pt.InputError:
        return
    starts, ends, _ = skeleton.core.pose(np.zeros((1, len(skeleton.channels))))
    assert np.isfinite(starts).all()
    assert np.isfinite(ends).all()


@settings(max_examples=300)
@given(text=mangled(AMC))
def test_no_motion_raises_anything_else(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    folder = tmp_path_factory.getbasetemp()
    path = folder / "fuzz.amc"
    path.write_text(text, "utf-8")
    skeleton = read_asf(asf(folder, name="whole.asf"))
    try:
        motion = read_amc(path, skeleton)
    except pt.InputError:
        return
    assert np.isfinite(motion.poses).all()


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@given(angles=st.tuples(*[st.floats(-3.1, 3.1)] * 3), middle=st.sampled_from([None, math.pi / 2, -math.pi / 2]))
def test_a_skeleton_that_is_written_is_read_again(
    tmp_path_factory: pytest.TempPathFactory,
    order: tuple[int, int, int],
    angles: tuple[float, float, float],
    middle: float | None,
) -> None:
    """Frames of whatever order, also where the first and the last turn are about one axis."""
    turned = list(angles)
    if middle is not None:
        turned[order[1]] = middle
    average = average_skeleton(1.62)
    frame = np.eye(3)
    for axis in order:
        turn = rotation_vector_to_quaternion(turned[axis] * np.eye(3)[axis])
        frame = rotate(np.broadcast_to(turn, (3, 4)), frame.T).T
    rows = triple(frame[0]), triple(frame[1]), triple(frame[2])
    turning = dataclasses.replace(average.bones[8], frame=rows, order=order)
    skeleton = Skeleton((*average.bones[:8], turning, *average.bones[9:]))
    path = tmp_path_factory.mktemp("asf") / "a.asf"
    write_asf(path, skeleton)
    again = read_asf(path)
    # Bones may come in another order: those of one parent stay together.
    columns = skeleton.columns(again.channels)
    np.testing.assert_allclose(again.limits_rad, skeleton.limits_rad[columns], atol=1e-9)
    poses = 0.3 * np.random.default_rng(0).standard_normal((3, len(skeleton.channels)))
    for joint, places in skeleton.joints(poses).items():
        np.testing.assert_allclose(again.joints(poses[:, columns])[joint], places, atol=1e-7)


def test_every_shared_skeleton_survives_being_written(shared: Callable[[str], Path], tmp_path: Path) -> None:
    for file in shared("data/cmu").rglob("*.asf"):
        skeleton = read_asf(file)
        write_asf(tmp_path / "again.asf", skeleton)
        again = read_asf(tmp_path / "again.asf")
        poses = 0.3 * np.ones((1, len(skeleton.channels)))
        assert again.unit_m == pytest.approx(skeleton.unit_m)
        for joint, places in skeleton.joints(poses).items():
            np.testing.assert_allclose(again.joints(poses)[joint], places, atol=1e-6)
