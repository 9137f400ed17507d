"""x-io's x-IMU3: a CSV a kind of message, in a folder."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu.read import files_of_imu, read_imu
from pytracker.inertial.check import check
from pytracker.inertial.gravity import GRAVITY
from pytracker.rotation import Array, rotate
from pytracker.simulate.arm import ArmSimulation

SIMULATION = ArmSimulation(pt.ArmScene(duration_s=4.0), 3)


def table(path: Path, header: str, time_s: Array, *columns: Array) -> None:
    rows = np.column_stack([np.rint(1e6 * time_s), *columns])
    np.savetxt(path, rows, ["%d", *["%.7f"] * (rows.shape[1] - 1)], ",", header=header, comments="")


def ximu3(folder: Path, *, every: int = 2, late: int = 0) -> Path:
    """As its GUI writes it: degrees and g, an orientation at half the rate that leaps to the other sign."""
    folder.mkdir()
    imu = SIMULATION.recording().imus[0]
    assert imu.gyr is not None
    turn = ",".join(f"Gyroscope {axis} (deg/s)" for axis in "XYZ")
    force = ",".join(f"Accelerometer {axis} (g)" for axis in "XYZ")
    table(folder / "Inertial.csv", f"Timestamp (us),{turn},{force}", imu.time_s, np.degrees(imu.gyr), imu.acc / GRAVITY)
    q = imu.q_world_segment.copy()
    q[200:] *= -1.0
    some = slice(late, None, every)
    table(folder / "Quaternion.csv", "Timestamp (us),W,X,Y,Z", imu.time_s[some] + 0.002, q[some])
    table(folder / "Temperature.csv", "Timestamp (us),Temperature (degC)", imu.time_s[::50], imu.time_s[::50])
    return folder


def test_messages_are_brought_together(tmp_path: Path) -> None:
    imu = SIMULATION.recording().imus[0]
    folder = ximu3(tmp_path / "x")
    log = read_imu(folder)
    assert {path.name for path in files_of_imu(folder)} == {"Inertial.csv", "Quaternion.csv"}
    assert log.acc is not None
    assert log.gyr is not None
    assert log.q_world_sensor is not None
    at = np.searchsorted(imu.time_s, log.time_s - 1e-4)
    assert len(log.time_s) >= len(imu.time_s) - 3
    assert np.allclose(log.acc, imu.acc[at], atol=1e-5)
    assert imu.gyr is not None
    assert np.allclose(log.gyr, imu.gyr[at], atol=1e-5)
    assert (np.abs((log.q_world_sensor * imu.q_world_segment[at]).sum(axis=1)) > 0.9999).all()
    assert np.linalg.norm(np.diff(log.q_world_sensor, axis=0), axis=1).max() < 0.1


def test_an_ngimus_messages_are_too(tmp_path: Path) -> None:
    """Called otherwise: a phone's files were expected, and its sensors.csv alone lost the orientation."""
    folder = ximu3(tmp_path / "x")
    as_x = read_imu(folder)
    (folder / "Inertial.csv").rename(folder / "sensors.csv")
    (folder / "Quaternion.csv").rename(folder / "quaternion.csv")
    log = read_imu(folder)
    assert {path.name for path in files_of_imu(folder)} == {"sensors.csv", "quaternion.csv"}
    assert log.q_world_sensor is not None
    assert as_x.q_world_sensor is not None
    assert np.array_equal(log.q_world_sensor, as_x.q_world_sensor)


def test_its_own_log_is_named(tmp_path: Path) -> None:
    (tmp_path / "log.ximu3").write_bytes(b"I,1,0,0,0,0,0,1\r\n")
    with pytest.raises(
        pt.InputError, match=r"log\.ximu3: is an x-IMU3's own log, expected what its GUI converts it to"
    ):
        read_imu(tmp_path / "log.ximu3")


@pytest.mark.parametrize("name", ["RotationMatrix", "EulerAngles"])
def test_an_orientation_may_be_written_otherwise(name: str, tmp_path: Path) -> None:
    folder = ximu3(tmp_path / "x")
    expected = read_imu(folder).q_world_sensor
    (folder / "Quaternion.csv").unlink()
    imu = SIMULATION.recording().imus[0]
    q, time_s = imu.q_world_segment[::2], imu.time_s[::2] + 0.002
    m = np.stack([rotate(q, np.tile(axis, (len(q), 1))) for axis in np.eye(3)], axis=2)  # columns: the sensor's axes
    if name == "RotationMatrix":
        head = ",".join(f"{row}{column}" for row in "XYZ" for column in "XYZ")
        table(folder / "RotationMatrix.csv", f"Timestamp (us),{head}", time_s, m.reshape(-1, 9))
    else:
        roll, pitch = np.arctan2(m[:, 2, 1], m[:, 2, 2]), -np.arcsin(np.clip(m[:, 2, 0], -1.0, 1.0))
        angles = np.degrees(np.stack([roll, pitch, np.arctan2(m[:, 1, 0], m[:, 0, 0])], axis=1))
        table(folder / "EulerAngles.csv", "Timestamp (us),Roll (deg),Pitch (deg),Yaw (deg)", time_s, angles)
    log = read_imu(folder)
    assert {path.name for path in files_of_imu(folder)} == {"Inertial.csv", f"{name}.csv"}
    assert log.q_world_sensor is not None
    assert expected is not None
    assert (np.abs((log.q_world_sensor * expected).sum(axis=1)) > 0.9999).all()
    assert len(check(log).warnings) == 1  # nothing before the first orientation


def test_without_an_orientation_one_is_computed_and_the_field_is_taken(tmp_path: Path) -> None:
    folder = ximu3(tmp_path / "x")
    (folder / "Quaternion.csv").unlink()
    time_s = SIMULATION.recording().imus[0].time_s
    field = np.tile([0.2, 0.0, -0.4], (len(time_s), 1))
    header = "Timestamp (us),Magnetometer X (a.u.),Magnetometer Y (a.u.),Magnetometer Z (a.u.)"
    table(folder / "Magnetometer.csv", header, time_s, field)
    log = read_imu(folder)
    assert log.q_world_sensor is None
    assert log.mag is not None
    assert np.allclose(log.mag, [0.2, 0.0, -0.4])
    table(folder / "Magnetometer.csv", header, time_s[:60], field[:60])
    log = read_imu(folder)
    assert log.mag is None
    assert len(log.time_s) == len(time_s)
    assert "Magnetometer.csv has nothing at" in log.warnings[0]


def test_what_is_missing_is_left_out_and_told(tmp_path: Path) -> None:
    log = read_imu(ximu3(tmp_path / "late", late=101))
    assert log.time_s[0] > 1.0
    assert "Quaternion.csv: has nothing at 10" in log.warnings[0]
    folder = ximu3(tmp_path / "gap")
    lines = (folder / "Quaternion.csv").read_text().splitlines()
    (folder / "Quaternion.csv").write_text("\n".join([*lines[:50], *lines[90:]]) + "\n")
    assert np.diff(read_imu(folder).time_s).max() > 0.7


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lines: [lines[0].replace("W", "V"), *lines[1:]], "header has no column q_w"),
        (lambda lines: [*lines[:3], "1,0.1,0.1,0.1,0.1", *lines[3:]], "time does not go on"),
        (lambda lines: [*lines[:3], lines[3].split(",")[0] + ",0,0,0,0", *lines[4:]], "expected one of length 1"),
        (lambda lines: [lines[0], *(f"9{line:0>50}" for line in lines[1:])], "expected one recording"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, change: Callable[[list[str]], list[str]], words: str) -> None:
    file = ximu3(tmp_path / "x") / "Quaternion.csv"
    file.write_text("\n".join(change(file.read_text().splitlines())) + "\n")
    with pytest.raises(pt.InputError, match=words):
        read_imu(file.parent)


def test_a_recording_may_have_one(tmp_path: Path) -> None:
    folder = pt.simulate_arm(tmp_path / "arm", SIMULATION.scene, 3)
    right = pt.load(folder)
    ximu3(folder / "imu")
    text = (folder / "recording.toml").read_text()
    other = Path(shutil.copytree(folder, tmp_path / "other"))
    (other / "recording.toml").write_text(text.replace('file = "imu.csv"', 'file = "imu"'))
    recording = pt.load(other)
    was, now = (pt.evaluate(pt.track(of, pt.Mixture()), of.truth).joints["wrist"].rms_m for of in (right, recording))
    assert now < was + 0.01
