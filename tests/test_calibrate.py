"""Cameras from boards rendered with distortion, blur and noise: focal length, its spread, and what is refused."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

import pytracker as pt
from pytracker.cli.entry import app
from pytracker.evidence.boards import Board, BoardKind, find_corners
from pytracker.formats.toml_file import parse_toml
from pytracker.formats.video import Image
from pytracker.formats.video_write import VideoWriter
from pytracker.report.board import write_board
from pytracker.rotation import Array, rotate, rotation_vector_to_quaternion, triple
from pytracker.setup.calibrate import calibrate_camera, find_pose, pose_by_level

SIZE = (640, 480)
MATRIX = np.array([[610.0, 0.0, 325.0], [0.0, 612.0, 236.0], [0.0, 0.0, 1.0]])
DISTORTION = np.array([-0.12, 0.06, 0.001, -0.0008, 0.0])


def seen(board: Board, turn: Array, shift: Array, rng: np.random.Generator) -> Image:
    """The board as a camera sees it: every pixel's ray, undistorted, met with the board's plane; blurred and noisy."""
    picture, scale = board.drawn(), 120 / board.square_m
    v, u = np.mgrid[0 : SIZE[1], 0 : SIZE[0]].astype(np.float64)
    rays = cv2.undistortPoints(np.stack([u.ravel(), v.ravel()], 1)[:, None], MATRIX, DISTORTION).reshape(-1, 2)
    rotation = cv2.Rodrigues(turn)[0]
    plane = np.column_stack([rotation[:, 0], rotation[:, 1], shift])
    on_board = np.linalg.solve(plane, np.column_stack([rays, np.ones(len(rays))]).T)
    x, y = (on_board[:2] / on_board[2] * scale - 0.5).astype(np.float32).reshape(2, *u.shape)
    grey = cv2.remap(picture, x, y, cv2.INTER_AREA, borderMode=cv2.BORDER_CONSTANT, borderValue=200)
    grey = cv2.GaussianBlur(grey, (0, 0), 0.8).astype(np.float64) + rng.normal(0, 3, grey.shape)
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


def filmed(path: Path, board: Board, seed: int, *, tilt: float = 0.7, views: int = 36) -> Path:
    """A video of the board, moved about the picture and tilted to all sides."""
    rng = np.random.default_rng(seed)
    middle = 0.5 * board.square_m * np.array([*board.squares, 0.0])
    with VideoWriter(path, "mp4v", 10.0, SIZE) as writer:
        for _ in range(views):
            turn = np.array([*rng.uniform(-tilt, tilt, 2), rng.uniform(-0.4, 0.4)])
            far = rng.uniform(0.35, 0.7)
            where = np.array([*(rng.uniform(-0.28, 0.28, 2) * [far, 0.75 * far]), far])
            writer.write(seen(board, turn, where - cv2.Rodrigues(turn)[0] @ middle, rng))
    return path


@pytest.mark.parametrize(("kind", "squares"), [("charuco", (7, 5)), ("chess", (8, 6))])
def test_focal_length_within_half_a_percent_and_within_its_spread(
    tmp_path: Path, kind: BoardKind, squares: tuple[int, int]
) -> None:
    board = Board(kind, squares, 0.03)
    found = calibrate_camera(filmed(tmp_path / "board.mp4", board, 1), board)
    share = found.matrix[0, 0] / MATRIX[0, 0] - 1
    assert abs(share) < 0.005
    assert abs(share) < 3 * found.focal_sd
    assert np.median(found.rms_px) < 0.5
    assert 0.0001 < found.focal_sd < 0.005


def test_too_little_is_refused_with_what_to_film(tmp_path: Path) -> None:
    board = Board("charuco", (7, 5), 0.03)
    with pytest.raises(pt.InputError, match="tilt it to all sides"):
        calibrate_camera(filmed(tmp_path / "flat.mp4", board, 1, tilt=0.02), board)
    with pytest.raises(pt.InputError, match="expected 8 at least: film it"):
        calibrate_camera(filmed(tmp_path / "short.mp4", board, 1, views=4), board)
    with pytest.raises(pt.InputError, match="different views"):
        calibrate_camera(tmp_path / "flat.mp4", Board("chess", (9, 8), 0.03))


def test_the_board_is_written_in_true_size_and_found_again(tmp_path: Path) -> None:
    board = Board("charuco", (7, 5), 0.03)
    write_board(board, tmp_path / "board.pdf")
    text = (tmp_path / "board.pdf").read_bytes()
    # 7 squares of 30 mm and two margins of 10 mm, in points.
    assert b"/MediaBox [ 0 0 651.96" in text
    page = cv2.copyMakeBorder(board.drawn(), 40, 40, 40, 40, cv2.BORDER_CONSTANT, value=255)
    corners = find_corners(board, np.asarray(page, dtype=np.uint8))
    assert corners is not None
    assert len(corners[0]) == 24
    # White on black, with other markers, as others print theirs.
    other = Board("charuco", (4, 5), 0.054, "4X4_1000", is_inverted=True)
    paper = cv2.copyMakeBorder(other.drawn(), 40, 40, 40, 40, cv2.BORDER_CONSTANT, value=255)
    corners = find_corners(other, np.asarray(255 - paper, dtype=np.uint8))
    assert corners is not None
    assert len(corners[0]) == 12
    with pytest.raises(pt.InputError, match="did you mean '4X4_1000'"):
        Board("charuco", (4, 5), 0.054, "4x4_1000")


@pytest.mark.parametrize("flat", [True, False])
def test_a_camera_is_found_from_points(flat: bool) -> None:
    rng = np.random.default_rng(5)
    world = rng.uniform(-0.5, 0.5, (8, 3)) * [1, 1, 0 if flat else 1]
    turn, shift = np.array([2.0, 0.3, -0.2]), np.array([0.1, -0.05, 2.2])
    pixels = cv2.projectPoints(world, turn, shift, MATRIX, DISTORTION)[0].reshape(-1, 2).astype(np.float64)
    found = find_pose(MATRIX, DISTORTION, world, pixels + rng.normal(0, 0.3, pixels.shape))
    assert np.abs(found.rotation - cv2.Rodrigues(turn)[0]).max() < 0.01
    assert np.abs(found.translation_m - shift).max() < 0.02
    with pytest.raises(pt.InputError, match="four or more"):
        find_pose(MATRIX, DISTORTION, world[:3], pixels[:3])
    with pytest.raises(pt.InputError, match="one line"):
        find_pose(MATRIX, DISTORTION, np.outer(np.arange(5.0), [1, 1, 1]), pixels[:5])


def test_from_a_board_and_points_to_a_file_that_init_takes(tmp_path: Path) -> None:
    run = CliRunner()
    board = Board("charuco", (7, 5), 0.03)
    video, out = filmed(tmp_path / "board.mp4", board, 3), tmp_path / "camera.toml"
    done = run.invoke(app, ["calibrate", "camera", str(video), "--square-mm", "30", "--out", str(out), "--quiet"])
    assert done.exit_code == 0, done.output
    world = np.array([[0, 0, 0], [0.4, 0, 0], [0.4, 0.3, 0], [0, 0.3, 0], [0.2, 0.1, 0.3]])
    pixels = cv2.projectPoints(world, np.array([2.0, 0.0, 0.0]), np.array([0.0, 0.0, 2.0]), MATRIX, DISTORTION)[0]
    rows = [",".join(f"{x:.4f}" for x in (*place, *pixel)) for place, pixel in zip(world, pixels[:, 0], strict=True)]
    points = tmp_path / "points.csv"
    points.write_text("x_m,y_m,z_m,u,v\n" + "\n".join(rows) + "\n")
    for _ in range(2):  # a second time the pose is replaced, not added
        done = run.invoke(app, ["calibrate", "pose", str(points), str(out)])
        assert done.exit_code == 0, done.output
    assert out.read_text().count("rotation = ") == 1
    path = pt.setup.init(tmp_path / "recording", video=video, camera=out)
    assert "rotation = [[" in path.read_text()
    by_hand = out.read_text().replace("rotation = [[", "rotation = [\n[") + '\n[arm]\nside = "left"\n'
    out.write_text(by_hand)
    assert run.invoke(app, ["calibrate", "pose", str(points), str(out)]).exit_code == 0
    assert parse_toml(out)["arm"] == {"side": "left"}
    points.write_text(points.read_text().replace(rows[4], rows[4].split(",", 3)[0] + ",0.1,0.3,9,400"))
    whole = out.read_text()
    assert "is one of them mistaken?" in str(run.invoke(app, ["calibrate", "pose", str(points), str(out)]).exception)
    assert out.read_text() == whole


@pytest.mark.parametrize(("down_deg", "roll_deg"), [(0.0, 0.0), (25.0, -4.0), (-10.0, 90.0)])
def test_tape_and_level_tell_where_a_camera_stands(down_deg: float, roll_deg: float) -> None:
    camera = pt.Camera(matrix=((500.0, 0.0, 319.5), (0.0, 500.0, 239.5), (0.0, 0.0, 1.0)), distortion=(0.1, 0, 0, 0, 0))
    pose = pose_by_level(camera, np.array([200.0, 150.0]), 2.4, down_deg, roll_deg)
    assert np.linalg.det(pose.rotation) == pytest.approx(1.0)
    rows = (triple(pose.rotation[0]), triple(pose.rotation[1]), triple(pose.rotation[2]))
    stands = dataclasses.replace(camera, rotation=rows, translation_m=triple(pose.translation_m))
    assert stands.project(np.zeros((1, 3)))[0] == pytest.approx([200.0, 150.0], abs=0.01)
    assert np.linalg.norm(stands.position_m) == pytest.approx(2.4)
    ahead, right, up = pose.rotation[2], np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    assert ahead == pytest.approx([0.0, np.cos(np.radians(down_deg)), -np.sin(np.radians(down_deg))])
    # A camera that is turned clockwise sees the upright lean to the left.
    u, v = (pose.rotation @ (up - ahead * (up @ ahead)))[:2]
    assert np.degrees(np.arctan2(-u, -v)) == pytest.approx(roll_deg)
    assert (pose.rotation @ right)[2] == pytest.approx(0.0, abs=1e-12)


def test_an_arm_is_followed_whose_camera_stands_by_tape_and_level(tmp_path: Path) -> None:
    run, truth, out = CliRunner(), tmp_path / "simulated", tmp_path / "camera.toml"
    pt.simulate_arm(truth, pt.ArmScene(worn=True, pattern="gesture", period_s=2.0), 8)
    known = parse_toml(truth / "recording.toml")
    (camera,), arm = known["camera"], known["arm"]
    rotation, shoulder = np.array(camera["rotation"]), np.array(arm["shoulder_m"])
    seen = rotation @ shoulder + np.array(camera["translation_m"])
    u, v = (np.array(camera["matrix"]) @ seen / seen[2])[:2]
    out.write_text(
        f"matrix = {camera['matrix']}\nupper_arm_m = {arm['upper_arm_m']}\nforearm_m = {arm['forearm_m']}\n"
        f"patch_box = {camera['patch_box']}\n"
    )
    # As well as one reads a level, a tape and a picture.
    down_deg, distance_m = np.degrees(np.arcsin(-rotation[2, 2])) + 1.5, np.linalg.norm(seen) - 0.04
    measured = [f"--shoulder={u + 4:.0f},{v - 4:.0f}", f"--distance-m={distance_m}", f"--down-deg={down_deg}"]
    for _ in range(2):
        done = run.invoke(app, ["calibrate", "level", str(out), *measured])
        assert done.exit_code == 0, done.output
    assert "is at (" in done.output
    folder = tmp_path / "trial"
    path = pt.setup.init(folder, video=truth / "video.mp4", imu=truth / "imu.csv", camera=out)
    # The simulation's heading, beside the camera's, which looks along its world's y axis.
    pan_deg = np.degrees(np.arctan2(rotation[2, 1], rotation[2, 0]))
    path.write_text(path.read_text().replace("[[imu]]", f"[[imu]]\nheading_deg = {90.0 - pan_deg}"))
    recording = pt.load(folder)
    assert recording.spreads["camera_turn_sd_rad"] == pytest.approx(np.radians(2.0))
    track = pt.track(recording, pt.Smooth(), 1)
    real = pt.load(truth).truth
    assert real is not None
    turned = rotation_vector_to_quaternion(np.array([0.0, 0.0, np.radians(90.0 - pan_deg)]))
    wrist = rotate(turned, real.at("wrist", track.time_s) - shoulder)
    assert np.nanmedian(np.linalg.norm(track.joints["wrist"].mean - wrist, axis=1)) < 0.06
    assert track.valid.mean() > 0.9


@pytest.mark.parametrize(
    ("matrix", "shoulder", "words"),
    [
        ("[[500.0, 0.0, 320.0], [0.0, 500.0, 240.0], [0.0, 0.0, 1.0]]", "312", "--shoulder is '312', expected a pixel"),
        ("[[500.0, 0.0, 320.0], [0.0, 500.0, 240.0], [0.0, 0.0, 1.0]]", "3,nan", "--shoulder is '3,nan', expected a"),
        ("[[0.0, 0.0, 320.0], [0.0, 500.0, 240.0], [0.0, 0.0, 1.0]]", "3,4", "camera.toml: "),
        ("7", "3,4", "camera.toml: "),
    ],
)
def test_what_tape_and_level_lack_is_said(tmp_path: Path, matrix: str, shoulder: str, words: str) -> None:
    (known := tmp_path / "camera.toml").write_text(f"matrix = {matrix}\n")
    measured = ["--shoulder", shoulder, "--distance-m", "2", "--down-deg", "10"]
    assert words in str(CliRunner().invoke(app, ["calibrate", "level", str(known), *measured]).exception)
