"""A body's recording set up: first pose from keypoints, camera, skeleton, and what is said where they change."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.formats.video import frames, probe
from pytracker.recording.camera import WeakPerspective
from pytracker.recording.found_pose import fingerprint, is_as_found, is_stale, lines_of
from pytracker.recording.keypoints.load import load_keypoints
from pytracker.setup import check, init
from pytracker.setup.checks.camera import check_video
from pytracker.setup.draft import Draft
from pytracker.setup.poses.keypoints import first_pose
from pytracker.setup.poses.person import first_person, first_row
from pytracker.skeleton import KEY_JOINTS

PEOPLE = Path(__file__).parents[2] / "shared"


@pytest.mark.parametrize("clip", ["20", "21", "22", "24", "29", "31", "33"])
def test_a_persons_first_pose_is_found_from_a_detectors_keypoints(clip: str) -> None:
    """Real people, MediaPipe's points: within 10 cm of the truth on average, and no joint farther than 16 cm."""
    folder = PEOPLE / "recordings" / f"people-gesture-{clip}"
    if not folder.exists():
        pytest.skip(f"{folder} is not there")
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    file = next((PEOPLE / "data" / "people" / "gestures").glob(f"*_{clip}_*mediapipe*.csv"))
    video = recording.view.video
    assert video is not None
    points = load_keypoints(file, "auto", video, probe(video)).points[0, 0]
    found = first_pose(recording.skeleton, recording.view.camera, points)
    assert found.fits
    assert found.rms_px < 2.0
    truth = np.genfromtxt(folder / "truth.csv", delimiter=",", names=True)
    joints = recording.skeleton.joints(found.channels(recording.skeleton)[None])
    off = [
        np.linalg.norm(joints[joint][0] - [truth[f"{joint}_{axis}_m"][0] for axis in "xyz"])
        for joint in KEY_JOINTS
        if joint != "head"  # the truth's is a crown
    ]
    assert np.mean(off) < 0.10
    assert max(off) < 0.16
    with pytest.raises(pt.InputError, match="expected 6 at least"):
        first_pose(recording.skeleton, recording.view.camera, np.full((9, 3), np.nan))
    points[[KEYPOINTS.index(f"{side}_shoulder") for side in ("left", "right")]] = np.nan
    with pytest.raises(pt.InputError, match=r"0 shoulders and 2 hips .* expected both shoulders, or one and a hip"):
        first_pose(recording.skeleton, recording.view.camera, points)


def person_at(u: float, height: float) -> np.ndarray:
    """Somebody seen from the front, `(9, 3)`."""
    rows = [
        (0, -1.0),
        (0.2, -0.8),
        (-0.2, -0.8),
        (0.3, -0.5),
        (-0.3, -0.5),
        (0.3, -0.2),
        (-0.3, -0.2),
        (0.1, 0),
        (-0.1, 0),
    ]
    return np.array([[u + height * x, 400 + height * y, 1.0] for x, y in rows])


def test_the_first_pose_is_of_one_person() -> None:
    """People come in any order, and joints of several had been taken together where some were missed."""
    here, there = person_at(200, 200), person_at(500, 80)
    gaps = here.copy()
    gaps[5:7, :2] = np.nan
    points = np.stack([np.stack([there, gaps]), np.stack([here, there]), np.stack([there, here])])
    person, people = first_person(points)
    assert people == 2
    assert (person == here).all()
    late = np.concatenate([np.full((2, 2, 9, 3), np.nan), points])
    assert (first_person(late)[0] == here).all()
    assert first_row(late) == 2
    assert first_row(np.full((3, 1, 9, 3), np.nan)) is None


def test_who_comes_late_is_told_when(tmp_path: Path) -> None:
    folder = pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=1.0, keypoint_sd_px=2.0), 3)
    draft = Draft(folder)
    text = draft.path.read_text()
    draft.path.write_text(text[: text.index("[truth]")])
    file = draft.file("camera.keypoints")
    assert file is not None
    header, *rows = file.read_text().splitlines()
    empty = ["," * header.count(",") if k < 12 else row for k, row in enumerate(rows)]
    file.write_text("\n".join([header, *empty]) + "\n")
    (found,) = (one for one in check(folder, write=True).findings if one.what == "first pose")
    assert found.verdict == "missing"
    assert "there are from frame 12 on: cut what is before it off the video" in found.evidence


def test_a_body_with_keypoints_needs_no_first_pose(tmp_path: Path) -> None:
    folder = pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=1.0, keypoint_sd_px=2.0), 3)
    draft = Draft(folder)
    text = draft.path.read_text()
    draft.path.write_text(text[: text.index("[truth]")])
    found = {finding.what: finding for finding in check(folder, write=True).findings}
    assert found["first pose"].writes == {"initial.angles": "initial.toml"}
    assert found["the track"].verdict in ("right", "doubtful")
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    assert recording.initial.any()


def test_a_first_pose_is_found_again_where_the_height_changed(tmp_path: Path) -> None:
    """It stayed as it was, "given", of a person of another height."""
    folder = pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=1.0, keypoint_sd_px=2.0), 3)
    draft = Draft(folder)
    text = draft.path.read_text()
    draft.path.write_text(text[: text.index("[truth]")])
    check(folder, write=True)
    first = (folder / "initial.toml").read_text()
    assert not pt.load(folder).warnings
    same = {finding.what: finding for finding in check(folder).findings}
    assert same["first pose"].verdict == "right"
    draft = Draft(folder)
    draft.set("skeleton.height_m", 1.65)
    draft.save()
    (said,) = pt.load(folder).warnings
    assert "pytracker check --write finds the first pose again" in said
    again = {finding.what: finding for finding in check(folder, write=True).findings}
    assert "was found with another camera, height or keypoints" in again["first pose"].evidence
    assert (folder / "initial.toml").read_text() != first
    assert not pt.load(folder).warnings
    by_hand = (folder / "initial.toml").read_text() + "head_rx = 1.0\n"
    (folder / "initial.toml").write_text(by_hand)
    draft.set("skeleton.height_m", 1.75)
    draft.save()
    check(folder, write=True)
    assert (folder / "initial.toml").read_text() == by_hand


def test_what_a_first_pose_is_found_from(tmp_path: Path) -> None:
    folder = pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=0.2, keypoint_sd_px=2.0), 3)
    recording = pt.load(folder)
    assert isinstance(recording, pt.BodyRecording)
    skeleton, view = recording.skeleton, recording.view
    assert isinstance(view.camera, WeakPerspective)
    assert view.keypoints is not None
    inputs = fingerprint(skeleton, view, 0.0)
    file = tmp_path / "initial.toml"
    file.write_text(lines_of({"root_ty": 0.93}, inputs))
    assert is_as_found(file)
    moved = view.keypoints.points.copy()
    moved[0] += 1.0
    rows = tuple((*row[:3], row[3] + 2.0) for row in view.camera.affine)
    others = {
        "height": fingerprint(skeleton.scaled(1.02), view, 0.0),
        "focal length": fingerprint(skeleton, view, 0.1),
        "camera": fingerprint(
            skeleton, dataclasses.replace(view, camera=WeakPerspective(affine=(rows[0], rows[1]))), 0.0
        ),
        "keypoints": fingerprint(
            skeleton, dataclasses.replace(view, keypoints=dataclasses.replace(view.keypoints, points=moved)), 0.0
        ),
    }
    assert {name for name, other in others.items() if is_stale(file, other)} == set(others)
    alone = dataclasses.replace(view, keypoints=None)
    assert not is_stale(file, inputs)
    assert not is_stale(file, fingerprint(skeleton, alone, 0.0))  # tracked by the video alone afterwards
    assert is_stale(file, fingerprint(skeleton.scaled(1.02), alone, 0.0))
    file.write_text(file.read_text() + "head_rx = 1.0\n")
    assert not is_as_found(file)
    assert not is_stale(file, others["height"])


def test_a_video_of_one_frame_is_no_movement(simulated: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(simulated, tmp_path / "arm")
    image = next(frames(folder / "video.mp4")).image
    writer = cv2.VideoWriter(
        str(folder / "one.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (image.shape[1], image.shape[0])
    )
    writer.write(image)
    writer.release()
    draft = Draft(folder)
    draft.set("camera.video", "one.avi")
    assert check_video(draft).verdict == "wrong"


def test_a_body_needs_no_calibration(tmp_path: Path) -> None:
    """Nor hips in the picture: joints are told from the camera, how they lie to each other is right."""
    scene = pt.BodyScene(duration_s=2.0, keypoint_sd_px=1.0)
    true = pt.load(pt.simulate_body(tmp_path / "true", scene, 3))
    assert isinstance(true, pt.BodyRecording)
    assert true.truth is not None
    folder, files = tmp_path / "told", tmp_path / "true"
    path = init(folder, video=files / "video.mp4", keypoints=files / "keypoints.csv")
    path.write_text(path.read_text().replace("# height_m = 1.70", "height_m = 1.75"))
    found = {finding.what: finding for finding in check(folder, write=True).findings}
    assert found["focal length"].verdict == "doubtful"
    assert "known to 10%" in found["focal length"].evidence
    assert found["first pose"].writes["initial.distance_sd_m"]
    assert list(found["camera's pitch"].writes) == ["camera.rotation"]
    assert "give or take" in found["camera's pitch"].evidence
    written = path.read_text()
    assert "# found by pytracker check" in next(line for line in written.splitlines() if line.startswith("rotation"))
    assert "guessed, as of a phone" in written
    assert 'angles = "initial.toml"' in written
    assert "# missing: the first pose" not in written
    later = {finding.what: finding for finding in check(folder).findings}
    assert not later["camera's pitch"].writes
    assert "of a camera whose place is not known" in later["camera's pitch"].evidence
    told = pt.load(folder)
    assert isinstance(told, pt.BodyRecording)
    track = pt.track(told, pt.BodySmooth())
    # The simulation's camera is level too, far off and straight before the person.
    for name in ("left_wrist", "right_wrist", "left_elbow", "right_elbow"):
        seen = track.joints[name].mean - track.joints["root"].mean
        truth = true.truth.at(name, track.time_s) - true.truth.at("root", track.time_s)
        assert np.nanmedian(np.linalg.norm((seen - truth)[:, :2], axis=1)) < 0.08, name


def test_a_guess_of_a_cut_picture_is_told(tmp_path: Path) -> None:
    """A focal length is guessed from whole pictures: of a square out of one wrists were 24 cm off, and valid."""
    folder = pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=0.2), 3)
    draft = Draft(folder)
    text = draft.path.read_text().replace('points = "points.csv"', "")
    camera = "matrix = [[300.0, 0, 159.5], [0, 300.0, 119.5], [0, 0, 1]]\nfocal_sd = 0.1\n"
    pose = "rotation = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]\ntranslation_m = [0, 1.0, 3.0]\n"
    draft.path.write_text(text.replace('video = "video.mp4"', 'video = "video.mp4"\n' + camera + pose))
    assert not pt.load(folder).warnings
    whole = list(frames(folder / "video.mp4"))
    cut = cv2.VideoWriter(str(folder / "cut.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, (240, 240))
    for frame in whole:
        cut.write(frame.image[:240, 40:280])
    cut.release()
    text = draft.path.read_text().replace("video.mp4", "cut.avi").replace('background = "background.png"', "")
    draft.path.write_text(text.replace("159.5", "119.5"))
    (said,) = pt.load(folder).warnings
    assert "the picture is 240 x 240 px, which is a part of what a camera took" in said


def test_a_calibration_by_ourselves_goes_with_a_body(tmp_path: Path, simulated_body: Path) -> None:
    """Its file says how well the focal length is known."""
    known = tmp_path / "camera.toml"
    known.write_text("matrix = [[500.0, 0, 160], [0, 500.0, 120], [0, 0, 1]]\nfocal_sd = 0.002\n")
    path = init(tmp_path / "new", video=simulated_body / "video.mp4", camera=known)
    assert "focal_sd = 0.002" in path.read_text()
    path.write_text(path.read_text().replace("# height_m", "height_m").replace("[initial]", "[truth]"))
    said = {finding.what for finding in check(tmp_path / "new").findings if finding.verdict == "wrong"}
    assert not said & {"camera or keypoints", "focal length"}


def test_a_body_is_looked_at_too(tmp_path: Path) -> None:
    folder = pt.simulate_body(tmp_path / "body", pt.BodyScene(duration_s=1.0), 3)
    found = check(folder)
    assert {finding.verdict for finding in found.findings} <= {"right", "doubtful"}
    first = next(frames(folder / "video.mp4"))
    assert first.index == 0
    init(tmp_path / "new", video=folder / "video.mp4")
    said = {finding.what: finding for finding in check(tmp_path / "new").findings}
    assert said["skeleton"].verdict == "missing"
