"""Who comes nearer, bends or turns leaves what is tracked: that is told, or tracked where keypoints show a distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.evidence.pose.stature import StatureSeen
from pytracker.evidence.pose.trunk import TrunkSeen, distance_changes
from pytracker.formats.keypoints.read import Keypoints
from pytracker.formats.video import Image
from pytracker.recording import BodyRecording, BodyView
from pytracker.report.body.figures import depth_axis
from pytracker.rotation import Array, triple
from pytracker.scores.evaluate import held
from pytracker.setup import check, init
from pytracker.setup.poses.keypoints import first_pose
from pytracker.skeleton.average import average_skeleton
from pytracker.tracking import default_method

CAMERA = pt.Camera(
    matrix=((800.0, 0.0, 320.0), (0.0, 800.0, 240.0), (0.0, 0.0, 1.0)),
    rotation=((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)),
    translation_m=(0.0, 1.0, 3.0),
)
WHOLE = replace(CAMERA, translation_m=(0.0, 1.0, 6.0))
"""So far off that feet are in the picture."""
SKELETON = average_skeleton(1.75)
RATE_HZ = 30.0


def poses(count: int, **channels: Array) -> Array:
    """Standing still but for channels, `(T,)` m or rad."""
    rows = np.zeros((count, len(SKELETON.channels)))
    rows[:, SKELETON.columns(("root_ty",))] = 0.93
    for name, values in channels.items():
        rows[:, SKELETON.columns((name,))[0]] += values
    return rows


def points_of(rows: Array, noise_px: float = 0.0) -> Array:
    """Where a detector sees poses `(T, C)`: `(T, 1, 9, 3)`, px."""
    starts, _, _ = SKELETON.core.pose(rows)
    joints = SKELETON.joints(rows)
    hips = {f"{side}_hip": starts[:, SKELETON.bone(f"{side[0]}femur")] for side in ("left", "right")}
    places = np.stack([(joints | hips)[name] for name in KEYPOINTS], axis=1)
    pixels = CAMERA.project(places.reshape(-1, 3)).reshape(len(rows), len(KEYPOINTS), 2)
    pixels = pixels + noise_px * np.random.default_rng(1).normal(size=pixels.shape)
    return np.concatenate([pixels, np.ones((*pixels.shape[:2], 1))], axis=2)[:, None]


def said(rows: Array, tracked: Array) -> str:
    """Of the last of some frames whose pose is taken to be `tracked`."""
    looked = TrunkSeen(CAMERA)
    joints = SKELETON.joints(tracked)
    trunks = [
        looked.look(frame / RATE_HZ, {name: at[frame] for name, at in joints.items()}, points[0])
        for frame, points in enumerate(points_of(rows))
    ]
    return trunks[-1].words


WALK_M = np.linspace(0.0, 0.7, 60)


@pytest.mark.parametrize(
    ("moved", "words"),
    [
        ({"root_tz": WALK_M}, "comes nearer than is tracked"),
        ({"root_tz": -WALK_M}, "bends or goes farther off than is tracked"),
        ({"root_ry": 1.6 * WALK_M}, "turns farther than is tracked"),
        ({"lhumerus_ry": -WALK_M, "root_tx": WALK_M}, ""),
    ],
)
def test_what_a_trunk_does_is_told(moved: dict[str, Array], words: str) -> None:
    rows = poses(60, **moved)
    still = poses(60, **{name: values for name, values in moved.items() if name == "root_tx"})
    assert said(rows, still) == words
    assert said(rows, rows) == ""


def test_hips_at_the_pictures_edge_are_no_step_nearer() -> None:
    """A trunk that looks longer and narrower: 66 % of the frames of a real clip were lost to it."""
    rows = poses(60)
    points = points_of(rows)
    hips = [KEYPOINTS.index(f"{side}_hip") for side in ("left", "right")]
    shoulders = [KEYPOINTS.index(f"{side}_shoulder") for side in ("left", "right")]
    late = slice(30, None)
    neck, root = (points[late][..., corners, :2].mean(axis=-2, keepdims=True) for corners in (shoulders, hips))
    points[late, :, hips, :2] += 0.1 * (root - neck)
    longer = points.copy()
    points[late, :, shoulders, :2] = neck + 0.85 * (points[late, :, shoulders, :2] - neck)
    joints = {name: at[0] for name, at in SKELETON.joints(rows).items()}
    last = []
    for seen in (longer, points):
        looked = TrunkSeen(CAMERA)
        trunks = [looked.look(frame / RATE_HZ, joints, people[0]) for frame, people in enumerate(seen)]
        last.append(trunks[-1].words)
    assert last == ["comes nearer than is tracked", ""]


def test_frames_without_points_say_nothing() -> None:
    looked = TrunkSeen(CAMERA)
    joints = {name: at[0] for name, at in SKELETON.joints(poses(1)).items()}
    assert looked.look(0.0, joints, None).words == ""
    assert looked.look(0.1, joints, np.full((9, 3), np.nan)).words == ""


def figure(rows: Array, feet_m: float = 0.0, raised_m: float = 0.0) -> Image:
    """A person standing at poses `(1, C)` with the crown 11 cm above the head, and a raised arm beside it."""
    joints = SKELETON.joints(rows)
    head, root = joints["head"][0], joints["root"][0]
    crown, hand = head + np.array([0.0, 0.11, 0.0]), head + np.array([0.35, raised_m, 0.0])
    (u, top), (_, bottom), (beside, highest) = WHOLE.project(np.stack([crown, [root[0], feet_m, root[2]], hand]))
    mask = np.zeros((480, 640), np.uint8)
    mask[max(0, round(top)) : round(bottom), round(u) - 20 : round(u) + 20] = 255
    mask[max(0, round(highest)) : round(bottom), round(beside) : round(beside) + 10] = 255
    return mask


@pytest.mark.parametrize(
    ("moved", "raised_m", "feet_m", "words"),
    [
        ({"root_tz": WALK_M}, 0.0, 0.0, "comes nearer than is tracked"),
        ({"root_tz": -2.5 * WALK_M}, 0.0, 0.0, "bends, squats or goes farther off than is tracked"),
        ({"root_tx": WALK_M}, 0.5, 0.0, ""),
        ({"root_tz": WALK_M}, 0.0, -1.5, ""),
    ],
)
def test_of_a_video_alone_the_height_tells(moved: dict[str, Array], raised_m: float, feet_m: float, words: str) -> None:
    """Raised arms are no height, and feet out of the picture tell nothing."""
    rows = poses(60, **moved)
    ends = SKELETON.core.pose(rows[:1])[1][0]
    looked = StatureSeen(WHOLE, ends, SKELETON.joints(rows[:1])["head"][0])
    joints = SKELETON.joints(poses(60, **{name: x for name, x in moved.items() if name == "root_tx"}))
    said = [
        looked.look(
            k / RATE_HZ,
            {name: at[k] for name, at in joints.items()},
            figure(rows[k : k + 1], feet_m, raised_m * k / 60),
        )
        for k in range(60)
    ]
    assert said[-1] == words
    assert said[0] == ""


@pytest.mark.parametrize("what", ["above", "beside", "light"])
def test_what_else_differs_from_the_background_makes_nobody_come_nearer(what: str) -> None:
    """A lens that breathes moves a lamp above the head, light a wall: 10 to 60 % of right joints were not valid."""
    rows = poses(60)
    ends, joints = SKELETON.core.pose(rows[:1])[1][0], SKELETON.joints(rows)
    looked = StatureSeen(WHOLE, ends, joints["head"][0])
    for k in range(60):
        mask: Image | None = figure(rows[k : k + 1], 0.0)
        if k >= 30 and mask is not None:
            mask[4:20, 300:340] |= np.uint8(255 * (what == "above"))
            mask[440:470, 20:120] |= np.uint8(255 * (what == "beside"))
            mask = None if what == "light" else mask
        assert looked.look(k / RATE_HZ, {name: at[k] for name, at in joints.items()}, mask) == ""


def test_a_background_that_held_the_legs_makes_nobody_come_nearer() -> None:
    """Legs that stood still are in the video's median, and show once they have moved."""
    rows = poses(60)
    ends, joints = SKELETON.core.pose(rows[:1])[1][0], SKELETON.joints(rows)

    def said(held: range) -> str:
        """In the last frame, where legs are in the background in some."""
        looked = StatureSeen(WHOLE, ends, joints["head"][0], is_median=True)
        words = ""
        for k in range(60):
            mask = figure(rows[k : k + 1], 0.0)
            if k in held:
                mask[300:, :] = 0
            words = looked.look(k / RATE_HZ, {name: at[k] for name, at in joints.items()}, mask)
        return words

    assert said(range(30)) == ""
    assert "or the background, a median, holds a part of the person" in said(range(30, 60))


def recording_of(rows: Array) -> BodyRecording:
    """Keypoints alone, with the truth."""
    points = points_of(rows, noise_px=1.0)
    keypoints = Keypoints(frames=np.arange(len(rows)), points=points)
    view = BodyView(camera=CAMERA, video=None, size_px=(640, 480), rate_hz=RATE_HZ, start_s=0.0, keypoints=keypoints)
    time_s = np.arange(len(rows)) / RATE_HZ
    truth = pt.Truth(time_s=time_s, joints_m=SKELETON.joints(rows))
    return BodyRecording(view=view, skeleton=SKELETON, initial=rows[0], truth=truth, poses=rows)


def test_who_comes_nearer_is_followed_in_depth() -> None:
    recording = recording_of(poses(60, root_tz=WALK_M))
    assert distance_changes(recording)
    method = default_method(recording)
    track = pt.track(recording, method, 1)
    ours, still = (pt.evaluate(of, recording.truth).joints["root"].average_m for of in (track, held(track)))
    fixed = pt.evaluate(pt.track(recording, pt.BodySmooth(), 1), recording.truth).joints["root"].average_m
    assert ours < 0.06 < 0.25 < still
    assert ours < 0.4 * fixed
    still_there = recording_of(poses(60, lhumerus_ry=-WALK_M))
    assert not distance_changes(still_there)
    assert default_method(still_there) == pt.BodySmooth()


def test_how_well_a_first_pose_knows_its_distance_is_in_the_bands() -> None:
    recording = recording_of(poses(20))
    unsure = replace(recording, spreads={"first_distance_sd_m": 0.2})
    widths = [pt.track(of, pt.BodySmooth(), 1).joints["root"].sd[:, 2] for of in (recording, unsure)]
    assert (widths[1] > 0.19).all()
    assert np.allclose(np.hypot(widths[0], 0.2), widths[1], rtol=0.05)


@pytest.mark.parametrize("turned_deg", [0.0, 90.0, 200.0])
@pytest.mark.parametrize("is_from_behind", [False, True])
def test_a_first_pose_is_found_wherever_the_world_looks(turned_deg: float, is_from_behind: bool) -> None:
    """A laboratory's axes have nothing to do with where a person stands and looks."""
    rows = poses(1, lhumerus_ry=np.radians([-60.0]), rhumerus_ry=np.radians([70.0]), lradius_rx=np.radians([30.0]))
    rows[:, SKELETON.columns(("root_ry",))] = np.pi if is_from_behind else 0.0
    points = points_of(rows)[0, 0]
    c, s = np.cos(np.radians(turned_deg)), np.sin(np.radians(turned_deg))
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    moved = np.array([2.0, 0.5, -1.0])
    rotation = np.array(CAMERA.rotation) @ turn.T
    camera = replace(
        CAMERA,
        rotation=(triple(rotation[0]), triple(rotation[1]), triple(rotation[2])),
        translation_m=triple(np.array(CAMERA.translation_m) - rotation @ moved),
    )
    pose = first_pose(SKELETON, camera, points)
    assert pose.fits
    assert pose.is_from_behind == is_from_behind
    found = np.zeros((1, len(SKELETON.channels)))
    for name, value in pose.angles.items():
        found[0, SKELETON.columns((name,))[0]] = value if name.startswith("root_t") else np.radians(value)
    joints, truth = SKELETON.joints(found), SKELETON.joints(rows)
    for name in ("root", "left_shoulder", "right_shoulder", "left_wrist", "right_wrist"):
        assert np.linalg.norm(joints[name][0] - (turn @ truth[name][0] + moved)) < 0.25, name


@pytest.mark.parametrize("is_from_behind", [False, True])
def test_a_first_pose_is_found_by_a_camera_that_hangs_upside_down(is_from_behind: bool) -> None:
    rows = poses(1, lhumerus_ry=np.radians([-60.0]), rhumerus_ry=np.radians([70.0]))
    rows[:, SKELETON.columns(("root_ry",))] = np.pi if is_from_behind else 0.0
    points = points_of(rows)[0, 0]
    points[:, :2] = 2.0 * np.array([320.0, 240.0]) - points[:, :2]
    (x, y, z), (tx, ty, tz) = CAMERA.rotation, CAMERA.translation_m
    upside_down = replace(
        CAMERA, rotation=(triple(-np.array(x)), triple(-np.array(y)), z), translation_m=(-tx, -ty, tz)
    )
    pose = first_pose(SKELETON, upside_down, points)
    assert pose.fits
    assert pose.is_from_behind == is_from_behind
    assert abs(abs(pose.angles["root_ry"]) - (180.0 if is_from_behind else 0.0)) < 20.0


def in_a_turned_world(recording: BodyRecording, turned_deg: float) -> tuple[BodyRecording, Array]:
    """The same camera and person, in axes that are turned about the vertical; and the turn `(3, 3)`."""
    c, s = np.cos(np.radians(turned_deg)), np.sin(np.radians(turned_deg))
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    assert isinstance(recording.view.camera, pt.Camera)
    rows = [triple(row) for row in np.array(recording.view.camera.rotation) @ turn.T]
    view = replace(recording.view, camera=replace(recording.view.camera, rotation=(rows[0], rows[1], rows[2])))
    initial = np.array(SKELETON.core.turned(recording.initial.tolist(), turn.tolist()))
    return replace(recording, view=view, initial=initial), turn


@pytest.mark.parametrize("turned_deg", [-90.0, 61.0, 145.0, 180.0])
@pytest.mark.parametrize("method", [pt.Partitioned(), pt.BodySmooth()], ids=lambda m: m.name)
def test_the_worlds_axes_do_not_matter(method: pt.Partitioned, turned_deg: float) -> None:
    """Where the camera looked along x the trunk leant and went away from it: 20 cm and more."""
    sway, lean = 0.15 * np.sin(np.linspace(0.0, 6.0, 60)), 0.2 * np.sin(np.linspace(0.0, 4.0, 60))
    rows = poses(60, root_tx=sway, root_rz=lean, lhumerus_rz=-0.5 + 4 * lean, lradius_rx=0.6 + lean)
    recording = recording_of(rows)
    turned, turn = in_a_turned_world(recording, turned_deg)
    track, other = pt.track(recording, method, 1), pt.track(turned, method, 1)
    for name, joint in track.joints.items():
        off = np.linalg.norm(other.joints[name].mean - joint.mean @ turn.T, axis=1)
        assert np.median(off) < 0.03, name
    assert depth_axis(other) == (0 if turned_deg in (-90.0, 61.0) else 2)
    assert np.allclose(SKELETON.joints(other.poses)["root"], other.joints["root"].mean, atol=0.03)


def test_real_people_on_a_beam(shared: Callable[[str], Path], tmp_path: Path) -> None:
    """A man comes 0.7 m nearer: from files to a track, by the calibration of a laboratory whose z axis is up."""
    people = shared("data/people/pose2sim_truth")
    trial = people / "S00_P00_SingleParticipant" / "S00_P00_T01_BalancingTrial"
    videos = shared("data/video/pose2sim_single")
    for number in (2, 4) if IS_ACCEPTANCE else (4,):
        folder = tmp_path / f"cam{number}"
        init(
            folder,
            video=videos / f"cam0{number}.mp4",
            keypoints=trial / "pose" / f"cam0{number}_json",
            truth=trial / "pose-3d" / "S00_P00_T01_BalancingTrial_0-100_filt_butterworth.trc",
            camera=people / "S00_Calibration" / "Calib_qualisys.toml",
            camera_name=f"cam_0{number}",
        )
        path = folder / "recording.toml"
        path.write_text(path.read_text().replace("# height_m = 1.70", "height_m = 1.68"))
        track = check(folder, write=True).track
        assert track is not None
        scores, still = (pt.evaluate(of, track.recording.truth) for of in (track, held(track)))
        assert scores.average_m < 0.5 * still.average_m
        assert min(min(joint.coverage) for joint in scores.joints.values()) > 0.7


@pytest.mark.parametrize("noise_px", [0.0, 3.0])
def test_who_bends_where_they_stand_goes_nowhere(noise_px: float) -> None:
    """Shoulders that come down and turn look farther off: the trunk was 15 to 24 cm off in depth, all valid."""
    rows = poses(90)
    points = points_of(rows, noise_px)
    shoulders = [KEYPOINTS.index(f"{side}_shoulder") for side in ("left", "right")]
    hips = [KEYPOINTS.index(f"{side}_hip") for side in ("left", "right")]
    bent = slice(30, None)
    neck, root = (points[bent][..., corners, :2].mean(axis=-2, keepdims=True) for corners in (shoulders, hips))
    points[bent, :, shoulders, :2] = root + 0.86 * (neck - root) + 0.86 * (points[bent, :, shoulders, :2] - neck)
    recording = recording_of(rows)
    keypoints = Keypoints(frames=np.arange(len(rows)), points=points)
    bends = replace(recording, view=replace(recording.view, keypoints=keypoints))
    assert not distance_changes(bends)
    # Who sits down has their hips lower, and the trunk leans.
    points[bent, ..., 1] += 0.6 * np.linalg.norm(neck - root, axis=-1)[..., 0].mean()
    keypoints = Keypoints(frames=np.arange(len(rows)), points=points)
    assert not distance_changes(replace(recording, view=replace(recording.view, keypoints=keypoints)))
    assert distance_changes(recording_of(poses(90, root_tz=-np.linspace(0.0, 1.5, 90))))
    assert distance_changes(recording_of(poses(90, root_tz=np.linspace(0.0, 0.7, 90))))
