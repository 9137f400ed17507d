"""Recording folders: read whole, or refused with file or key, value and expectation."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from conftest import load_arm

import pytracker as pt
from pytracker.formats.video import frames
from pytracker.rotation import conjugate, multiply, rotate, rotation_vector_to_quaternion
from pytracker.simulate import ArmSimulation


@pytest.fixture
def folder(simulated: Path, tmp_path: Path) -> Path:
    """A recording to spoil."""
    return Path(shutil.copytree(simulated, tmp_path / "recording"))


def edit(folder: Path, old: str, new: str) -> Path:
    path = folder / "recording.toml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return folder


def test_a_simulated_folder_loads_as_it_was_made(simulated: Path) -> None:
    recording = load_arm(simulated)
    simulation = ArmSimulation(pt.ArmScene(duration_s=3.0), seed=11)
    assert recording.arm == simulation.arm
    assert np.allclose(recording.views[0].camera.rotation, simulation.cameras[0].rotation, atol=1e-8)
    assert np.allclose(recording.imus[0].acc, simulation.imu.acc, atol=1e-6)
    assert recording.truth is not None
    assert np.allclose(recording.truth.joints_m["elbow"], simulation.truth.joints_m["elbow"], atol=1e-6)
    assert recording.warnings == ()
    assert {path.name for path in recording.files} == {"recording.toml", "video.mp4", "imu.csv", "qualisys.tsv"}


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("schema = 1", "schema = 2", "schema is 2, this version reads 1: the file is newer, update pytracker"),
        ("forearm_m = 0.25", "forearm_m = true", "arm.forearm_m is True, expected: input should be a valid number"),
        ("upper_arm_m = 0.3", "upper_arm_m = 0.42", "the elbow is 0.30 m from the shoulder, expected 0.42 ± 0.1 m"),
        ('segment = "right_forearm"', "heading_deg = 90", "check wrist_start_m, shoulder_m, the arm's lengths"),
        ("translation_m = [0.05", "translation_m = [0.5", "px away, expected at most"),
        ('file = "imu.csv"', 'file = "imu\\u0000.csv"', "imu[0].file is 'imu\\x00.csv', expected: the name of"),
        ('file = "imu.csv"', f'file = "{5000 * "i"}"', "expected: the name of a file, of 1 to 255 bytes"),
        ('file = "imu.csv"', 'file = ""', "imu[0].file is '', expected: the name of a file"),
        ('wrist = "wrist"', 'hand = "wrist"', "truth.markers.hand is no joint of the arm, expected: shoulder, elbow"),
        ('elbow = "elbow", wrist = "wrist"', 'elbow = "wrist", wrist = "elbow"', "m apart, expected 0.18 to 0.45 m by"),
        ('kind = "arm"', 'kind = "leg"', "kind is 'leg', expected 'arm' or 'body'"),
        ("patch_box", "patchbox", "camera[0].patchbox is not a known key, did you mean 'patch_box'?"),
        ("upper_arm_m", "uper_arm_m", "arm.uper_arm_m is not a known key, did you mean 'upper_arm_m'?"),
        (
            "upper_arm_m = 0.3",
            "upper_arm_m = 30",
            "arm.upper_arm_m is 30, expected: input should be less than or equal",
        ),
        ("upper_arm_m = 0.3", "", "arm.upper_arm_m is missing"),
        ('video = "video.mp4"', 'video = "film.mp4"', "film.mp4: no such file, expected a video"),
        ('file = "imu.csv"', 'file = "imu2.csv"', "imu2.csv: no such file"),
        ('file = "qualisys.tsv"', 'file = "truth.xls"', "truth.file is 'truth.xls', expected one of: .tsv, .csv"),
        ('wrist = "wrist"', 'wrist = "hand"', "truth.markers.wrist is 'hand', expected a marker of"),
        (
            "[[700.0, 0.0, 320.0]",
            "[[-700.0, 0.0, 320.0]",
            "camera matrix: focal lengths are -700 and 700 px, expected positive",
        ),
        (
            "[[700.0, 0.0, 320.0], [0.0, 700.0, 240.0]",
            "[[700.0, 0.0, 320.0], [9.0, 700.0, 240.0]",
            "expected [0, fy, cy]",
        ),
        ("rotation = [[-1.0", "rotation = [[-2.0", "camera rotation: R R' differs from the identity"),
        (
            "patch_offset_m = [0.0",
            "patch_offset_m = [nan",
            "camera[0].patch_offset_m[0] is nan, expected: input should be a finite",
        ),
        (
            'segment = "right_forearm"',
            "mount = [2, 0, 0, 0]",
            "imu[0].mount has norm 2.0000, expected a unit quaternion",
        ),
        (
            'segment = "right_forearm"',
            "offset_s = 99",
            "the IMU 99.000 to 102.000 s of recording time, expected them to overlap",
        ),
        ('segment = "right_forearm"', "rate_hz = 50", "stated as 50 Hz, but the times are 100.00 Hz apart"),
        ('segment = "right_forearm"', 'format = "MT9"', "imu[0].format is 'MT9', expected: input should be 'auto'"),
        ("schema = 1", "schema = ", "recording.toml: is not TOML: Invalid value (at line 1, column 10)"),
    ],
)
def test_a_fault_is_named(folder: Path, old: str, new: str, expected: str) -> None:
    with pytest.raises(pt.InputError) as error:
        load_arm(edit(folder, old, new))
    assert expected in str(error.value)


def test_patch_box_outside_the_frame(folder: Path) -> None:
    text = (folder / "recording.toml").read_text()
    line = next(line for line in text.splitlines() if line.startswith("patch_box"))
    with pytest.raises(pt.InputError, match=r"patch_box is \[630, 10, 30, 30\] .* inside the 640 x 480 px of"):
        load_arm(edit(folder, line, "patch_box = [630, 10, 30, 30]"))


def test_no_folder_and_no_file(tmp_path: Path) -> None:
    with pytest.raises(pt.InputError, match=r"nowhere: is no folder, expected a folder with recording\.toml"):
        load_arm(tmp_path / "nowhere")
    with pytest.raises(pt.InputError, match=r"holds no recording\.toml"):
        load_arm(tmp_path)


def test_truth_with_gaps_is_counted_and_left_out(folder: Path) -> None:
    path = folder / "qualisys.tsv"
    lines = path.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("MARKER_NAMES")) + 1
    for k in range(first + 50, first + 110):
        cells = lines[k].split("\t")
        lines[k] = "\t".join([*cells[:6], "", "", ""])
    path.write_text("\n".join(lines) + "\n")
    recording = load_arm(folder)
    assert "wrist was not seen in 60 of 301 frames; they are left out of the scores" in recording.warnings[0]
    track = pt.track(recording, pt.Layered(particles=50))
    scores = pt.evaluate(track, recording.truth)
    assert scores.frames_without_truth == 15
    assert scores.joints["wrist"].frames == 75 - 15


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (4, "has neither orientation nor a gyroscope, expected q_w"),
        (7, "heading_deg is missing; .*has no orientation, and one computed from its gyroscope has no heading"),
    ],
)
def test_what_an_imu_lacks_is_named(folder: Path, columns: int, words: str) -> None:
    """Of one without a gyroscope it was asked which heading its gyroscope has."""
    lines = (folder / "imu.csv").read_text().splitlines()
    (folder / "imu.csv").write_text("\n".join(",".join(line.split(",")[:columns]) for line in lines) + "\n")
    with pytest.raises(pt.InputError, match=words):
        pt.load(folder)


def test_heading_and_mount_turn_the_sensor_into_the_segment(folder: Path) -> None:
    """The same recording from a sensor worn a quarter turn about the forearm and headed 40° off."""
    straight = load_arm(folder).imus[0]
    mount = rotation_vector_to_quaternion(np.array([0.0, np.pi / 2, 0.0]))
    heading = rotation_vector_to_quaternion(np.array([0.0, 0.0, np.deg2rad(40.0)]))
    assert straight.gyr is not None
    table = np.column_stack(
        [
            straight.time_s,
            rotate(conjugate(mount), straight.acc),
            rotate(conjugate(mount), straight.gyr),
            multiply(multiply(conjugate(heading), straight.q_world_segment), mount),
        ]
    )
    header = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q_w,q_x,q_y,q_z"
    np.savetxt(folder / "imu.csv", table, fmt="%.8f", delimiter=",", header=header, comments="")
    edit(folder, 'segment = "right_forearm"', f"heading_deg = 40.0\nmount = {mount.tolist()}")
    turned = load_arm(folder).imus[0]
    assert np.allclose(turned.acc, straight.acc, atol=1e-6)
    assert np.allclose(np.abs((turned.q_world_segment * straight.q_world_segment).sum(axis=1)), 1, atol=1e-6)


def test_a_truth_of_another_time_is_told_as_it_loads(folder: Path) -> None:
    """It was told after the whole run, without the file or what it covers."""
    path = folder / "recording.toml"
    text = path.read_text("utf-8")
    path.write_text(text.replace("[truth]", "[truth]\noffset_s = 0.5"), "utf-8")
    words = "\n".join(pt.load(folder).warnings)
    assert "qualisys.tsv: the truth covers 0.500 to" in words
    assert "frames without truth are not scored" in words
    path.write_text(text.replace("[truth]", "[truth]\noffset_s = 1.7e9"), "utf-8")
    with pytest.raises(pt.InputError, match=r"qualisys.tsv: the truth covers 17\d+.000 to .* expected them to overlap"):
        pt.load(folder)


def test_a_truth_with_wrist_and_elbow_exchanged_is_told(folder: Path) -> None:
    """25 cm off, and lengths that may be an arm's."""
    assert not any("exchanged" in words for words in pt.load(folder).warnings)
    edit(folder, 'elbow = "elbow", wrist = "wrist"', 'elbow = "wrist", wrist = "elbow"')
    edit(folder, "upper_arm_m = 0.3", "upper_arm_m = 0.33")
    said = "\n".join(pt.load(folder).warnings)
    assert "the wrist keeps its distance from the shoulder to 0.000 m (sd) and the elbow's varies by 0." in said
    assert "are wrist and elbow exchanged?" in said


def test_a_second_camera_of_a_part_is_told(tmp_path: Path) -> None:
    """Its video was cut short: 3 cm off for 0.1, without a word."""
    folder = pt.simulate_arm(tmp_path / "two", pt.ArmScene(duration_s=2.0, cameras=2), seed=2)
    recording = load_arm(folder)
    assert not any("covers" in words for words in recording.warnings)
    second = recording.views[1].video
    assert second is not None
    images = [frame.image for frame in frames(second)]
    height, width = images[0].shape[:2]
    writer = cv2.VideoWriter(str(second), cv2.VideoWriter.fourcc(*"mp4v"), 25.0, (width, height))
    for image in images[:20]:
        writer.write(image)
    writer.release()
    (said,) = (words for words in load_arm(folder).warnings if "covers" in words)
    assert "covers 0.000 to 0.800 s and" in said
    assert "where it has no frames the others are followed alone" in said


def test_what_was_odd_of_the_sensor_is_said_with_a_start_that_does_not_fit(folder: Path) -> None:
    """It may be why: of an orientation that was computed heading_deg alone says the heading."""
    rows = [line.split(",") for line in (folder / "imu.csv").read_text("utf-8").splitlines()]
    kept = [k for k, name in enumerate(rows[0]) if not name.startswith("q_")]
    (folder / "imu.csv").write_text("\n".join(",".join(row[k] for k in kept) for row in rows), "utf-8")
    with pytest.raises(
        pt.InputError, match=r"the elbow is .* and mount of the IMU; and .*its heading is what heading_deg says"
    ):
        load_arm(edit(folder, 'segment = "right_forearm"', 'segment = "right_forearm"\nheading_deg = 0'))


def test_start_from_truth_or_from_the_patch(folder: Path) -> None:
    text = (folder / "recording.toml").read_text()
    line = next(line for line in text.splitlines() if line.startswith("wrist_start_m"))
    given = load_arm(folder).arm.wrist_start_m
    assert np.allclose(load_arm(edit(folder, line, "")).arm.wrist_start_m, given, atol=1e-3)
    path = folder / "recording.toml"
    path.write_text(path.read_text().split("[truth]")[0])
    recording = load_arm(folder)
    assert "the patch's ray meets the arm sphere at" in recording.warnings[-1]
    ray = recording.views[0].camera.ray(recording.views[0].camera.project(np.array([given]))[0])
    across = np.array(recording.arm.wrist_start_m) - given
    assert np.linalg.norm(across - ray * (across @ ray)) < 0.01
    # The start was found on the ray; a shoulder elsewhere leaves nothing to meet.
    far = edit(folder, "shoulder_m = [0.1", "shoulder_m = [3.1")
    with pytest.raises(pt.InputError, match=r"the patch's ray passes .* m from where the arm can reach, expected"):
        load_arm(far)


def test_camera_that_starts_before_the_imu(folder: Path) -> None:
    """Frames without any IMU are kept as rows with a reason."""
    recording = load_arm(edit(folder, 'segment = "right_forearm"', "offset_s = 1.0"))
    track = pt.track(recording, pt.Layered(particles=50))
    assert track.reason[:25] == ("before the first IMU sample",) * 25
    assert np.isnan(track.joints["wrist"].mean[:25]).all()
    assert np.isfinite(track.joints["wrist"].mean[25:]).all()


def test_a_clock_that_drifts_is_put_right_from_its_first_sample_on(folder: Path) -> None:
    given = load_arm(folder).imus[0].time_s
    put = load_arm(edit(folder, 'segment = "right_forearm"', "offset_s = 0.5\ndrift_ppm = 100.0")).imus[0].time_s
    assert put[0] == given[0] + 0.5
    assert np.allclose(put - put[0], (given - given[0]) * 1.0001, rtol=1e-12)


def test_rows_that_are_missing_are_a_gap_in_the_truth() -> None:
    time_s = np.concatenate([np.arange(0, 2, 0.01), np.arange(6, 8, 0.01)])
    truth = pt.Truth(time_s=time_s, joints_m={"wrist": np.stack([time_s] * 3, axis=1)})
    at = truth.at("wrist", np.array([1.005, 1.985, 4.0, 6.0, 7.5, 9.0]))
    assert np.isfinite(at[:, 0]).tolist() == [True, True, False, True, True, False]


def test_a_mount_that_is_rounded_changes_no_length(folder: Path) -> None:
    exact = load_arm(folder).imus[0].acc
    rounded = load_arm(edit(folder, 'segment = "right_forearm"', "mount = [0.99, 0.0, 0.0, 0.0]")).imus[0].acc
    assert np.allclose(rounded, exact)


def test_a_truth_of_which_much_is_far_off_is_refused(folder: Path) -> None:
    path = folder / "qualisys.tsv"
    lines = path.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.split("\t")[0].strip(" -.0123456789") == "" and "\t" in line)
    for k in range(first + 10, first + 40):
        cells = lines[k].split("\t")
        lines[k] = "\t".join([*cells[:-3], "-9999", "-9998", str(-9000 - k)])
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(pt.InputError, match=r"qualisys.tsv: \w+ is at .* and in 30 of \d+ rows farther than"):
        pt.load(folder)


def test_a_truth_cell_far_off_is_a_gap_and_is_said(folder: Path) -> None:
    path = folder / "qualisys.tsv"
    lines = path.read_text().splitlines()
    cells = lines[150].split("\t")
    lines[150] = "\t".join([*cells[:-1], "1000000.0"])
    path.write_text("\n".join(lines) + "\n")
    recording = load_arm(folder)
    (warning,) = recording.warnings
    assert "1 of 301 rows are such and are left out" in warning
    scores = pt.evaluate(pt.track(recording, pt.Mixture()), recording.truth)
    assert scores.joints["wrist"].worst_m < 1.0


def test_a_shoulder_that_is_elsewhere_is_said(folder: Path) -> None:
    recording = load_arm(edit(folder, "shoulder_m = [0.1, 0.0, 0.25]", "shoulder_m = [0.1, 0.0, 0.37]"))
    assert "the shoulder is at [0.1, 0.0, 0.25] m (median), 0.12 m from shoulder_m" in recording.warnings[0]


def test_warnings_do_not_say_where_a_folder_lies(folder: Path) -> None:
    recording = load_arm(edit(folder, "shoulder_m = [0.1, 0.0, 0.25]", "shoulder_m = [0.1, 0.0, 0.37]"))
    assert recording.warnings
    assert str(folder) not in " ".join(recording.warnings)


def test_a_thousand_frames_a_second_are_all_kept() -> None:
    from pytracker.evidence.patch.camshift import PatchTrack  # noqa: PLC0415
    from pytracker.evidence.sightings import _merge  # noqa: PLC0415

    count = 500
    time_s = np.arange(count) / 1000.0
    track = PatchTrack(time_s, np.zeros((count, 2)), np.ones(count, bool), ("",) * count)
    assert len(_merge([time_s], [track], [{}]).time_s) == count
    assert len(_merge([time_s, time_s + 1e-4], [track, track], [{}, {}]).time_s) == count


@pytest.mark.parametrize("is_given", [True, False])
def test_an_imu_that_starts_late_knows_no_start(simulated: Path, tmp_path: Path, is_given: bool) -> None:
    """The first frame's start was taken to hold where tracking starts: 6 to 15 cm off, and half of it in the bands."""
    folder = shutil.copytree(simulated, tmp_path / "late")
    head, *rows = (folder / "imu.csv").read_text("utf-8").splitlines()
    (folder / "imu.csv").write_text("\n".join([head, *rows[len(rows) // 4 :]]) + "\n", "utf-8")
    if not is_given:
        path = folder / "recording.toml"
        lines = [line for line in path.read_text("utf-8").split("[truth]")[0].splitlines() if "wrist_start" not in line]
        path.write_text("\n".join(lines) + "\n", "utf-8")
    recording = load_arm(folder)
    assert recording.spreads["position_start_sd_m"] == 0.3
    (said,) = recording.warnings
    assert "the frames before are not tracked, and where the wrist is when tracking starts is not known" in said
    track = pt.track(recording, pt.Smooth())
    scores = pt.evaluate(track, load_arm(simulated).truth).joints["wrist"]
    assert scores.median_m < (0.08 if is_given else 0.16)  # of two seconds, and the bands know
    assert min(scores.coverage) > 0.8
    assert "before the first IMU sample" in track.reason[0]


def test_a_camera_of_another_size_is_said(simulated: Path, tmp_path: Path) -> None:
    camera = pt.Camera(matrix=((1400.0, 0, 640.0), (0, 1400.0, 480.0), (0, 0, 1)))
    (words,) = camera.oddities((640, 480))
    assert "principal point at (640, 480), 50% off the middle of pictures of 640 x 480 px" in words
    assert "of about 1280 x 960 px" in words
    assert camera.oddities((1280, 960)) == ()
    # Off by as much of either side: of a picture that was scaled. Lenses are off by less, or by other shares.
    assert len(camera.oddities((1600, 1200))) == len(camera.oddities((1024, 768))) == 1
    assert camera.oddities((1240, 930)) == camera.oddities((1400, 1060)) == ()
    (words,) = pt.Camera(matrix=((700.0, 0, 240.0), (0, 700.0, 320.0), (0, 0, 1))).oddities((640, 480))
    assert words.endswith("are cx and cy exchanged?")
    (words,) = pt.Camera(matrix=((910.0, 0, 320.0), (0, 700.0, 240.0), (0, 0, 1))).oddities((640, 480))
    assert "focal lengths of 910 and 700 px" in words
    assert not any("principal point" in warning for warning in pt.load(simulated).warnings)
    folder = tmp_path / "off"
    shutil.copytree(simulated, folder)
    text = (folder / "recording.toml").read_text("utf-8")
    ((x, rest),) = re.findall(r"patch_box = \[(\d+)(.*)", text)
    text = text.replace("[700.0, 0.0, 320.0]", "[700.0, 0.0, 190.0]").replace(f"[{x}{rest}", f"[{int(x) - 130}{rest}")
    (folder / "recording.toml").write_text(text, "utf-8")
    assert any(
        "camera[0].matrix has its principal point at (190, 240)" in warning for warning in pt.load(folder).warnings
    )


@pytest.mark.parametrize(
    ("distortion", "words"),
    [
        ((-0.22, 0.22, 0.002, -0.0115, 0.0), ""),
        ((-0.03, 0.04, -0.05, 0.02, 0.0), "distortion has p1 = -0.05 and p2 = 0.02, expected at most 0.03, .* fisheye"),
        ((-0.5, 0.0, 0.0, 0.0, 0.0), r"distortion folds the picture over 245 px from its middle, expected .* 320 px"),
        ((-0.4, 0.0, 0.0, 0.0, 0.0), ""),  # near the edge, as wide lenses that are calibrated by what is inside
    ],
)
def test_a_distortion_that_no_lens_has(distortion: tuple[float, float, float, float, float], words: str) -> None:
    """A fisheye's four in place of k1, k2, p1, p2 bend rays the wrong way; what folds over has two places a pixel."""
    camera = pt.Camera(matrix=((450.0, 0, 320.0), (0, 450.0, 240.0), (0, 0, 1)), distortion=distortion)
    assert re.fullmatch(f"{words}.*" if words else "", "".join(camera.oddities((640, 480))))


def test_points_that_show_one_direction_only_are_refused(simulated_body: Path, tmp_path: Path) -> None:
    folder = tmp_path / "line"
    shutil.copytree(simulated_body, folder)
    header, *rows = (folder / "points.csv").read_text("utf-8").splitlines()
    cells = [row.split(",") for row in rows]
    lines = [",".join([*row[:3], row[3], str(2.0 * float(row[3]))]) for row in cells]
    (folder / "points.csv").write_text("\n".join([header, *lines]) + "\n", "utf-8")
    with pytest.raises(pt.InputError, match="expected pixels of different directions"):
        pt.load(folder)
