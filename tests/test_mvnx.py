"""MVNX: the sensor of one segment out of a suit's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.rotation import Array, conjugate, rotate, rotation_vector_to_quaternion

LABELS = ("Pelvis", "RightUpperArm", "RightForeArm", "LeftForeArm")
UP = np.array([0.0, 0.0, 9.80665])


def words(values: Array) -> str:
    return " ".join(f"{x:.9f}" for x in values.ravel())


def suit(path: Path, q: Array, free: Array, namespace: str = ' xmlns="http://www.xsens.com/mvn/mvnx"') -> Path:
    """A suit of four sensors at 60 Hz, orientation `(M, 4, 4)` and free acceleration `(M, 4, 3)`."""
    pose = '<frame time="0" index="" type="identity"><orientation>1 0 0 0</orientation></frame>'
    frames = [
        f'<frame time="{1000 * k / 60:.0f}" index="{k}" type="normal"><orientation>1 0 0 0</orientation>'
        f"<sensorFreeAcceleration>{words(free[k])}</sensorFreeAcceleration>"
        f"<sensorOrientation>{words(q[k])}</sensorOrientation></frame>"
        for k in range(len(q))
    ]
    sensors = "".join(f'<sensor label="{label}"/>' for label in LABELS)
    path.write_text(
        f'<?xml version="1.0"?><mvnx version="4"{namespace}><subject frameRate="60"><sensors>{sensors}</sensors>'
        f'<frames sensorCount="4">{pose}{"".join(frames)}</frames></subject></mvnx>'
    )
    return path


@pytest.fixture
def motion() -> tuple[Array, Array]:
    rng = np.random.default_rng(1)
    q = rotation_vector_to_quaternion(np.cumsum(rng.normal(0, 0.02, (120, 4, 3)), axis=0))
    return np.asarray(q), rng.normal(0, 1.0, (120, 4, 3))


@pytest.mark.parametrize("namespace", ["", ' xmlns="http://www.xsens.com/mvn/mvnx"'])
def test_a_segments_sensor_is_read(namespace: str, motion: tuple[Array, Array], tmp_path: Path) -> None:
    q, free = motion
    path = suit(tmp_path / "suit.mvnx", q, free, namespace)
    for segment, at in (("right_upper_arm", 1), ("right_forearm", 2), ("left_forearm", 3)):
        log = read_imu(path, segment=segment)
        assert log.time_s[:3] == pytest.approx([0.0, 0.017, 0.033])
        assert log.q_world_sensor == pytest.approx(q[:, at], abs=1e-8)
        assert log.acc == pytest.approx(rotate(conjugate(q[:, at]), free[:, at] + UP), abs=1e-7)
        assert log.gyr is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "RightForeArm",
            "RightHand",
            "its sensors are Pelvis, RightUpperArm, RightHand, LeftForeArm, expected RightF",
        ),
        ("sensorFreeAcceleration", "acceleration", "frame 0 has no sensorFreeAcceleration, .*all its sensor data"),
        ('type="normal"', 'type="tpose"', "has no frame of type normal"),
        ('time="17"', 'time="x"', "frame 1: time is 'x', expected milliseconds"),
        ("</subject>", "", "is no MVNX: mismatched tag"),
        (
            "<sensorOrientation>",
            "<sensorOrientation>1 ",
            "frame 0: sensorOrientation holds 17 numbers, expected 4 of",
        ),
        ("<sensorOrientation>", "<sensorOrientation>one ", "frame 0: sensorOrientation holds 'one "),
    ],
)
def test_what_is_amiss_is_said(old: str, new: str, message: str, motion: tuple[Array, Array], tmp_path: Path) -> None:
    path = suit(tmp_path / "suit.mvnx", *motion)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(pt.InputError, match=message):
        read_imu(path)


def test_a_segment_that_no_arm_has_is_named(motion: tuple[Array, Array], tmp_path: Path) -> None:
    with pytest.raises(pt.InputError, match="segment is 'wrist', expected one of: right_forearm"):
        read_imu(suit(tmp_path / "suit.mvnx", *motion), segment="wrist")


def test_a_suit_tracks_an_arm(tmp_path: Path) -> None:
    """Forearm and upper arm out of one file."""
    scene = pt.ArmScene(duration_s=8.0, imu_rate_hz=60.0, senses=("upper_arm",))
    folder = pt.simulate_arm(tmp_path / "arm", scene, 3)
    recording = pt.load(folder)
    assert isinstance(recording, pt.ArmRecording)
    forearm, upper = recording.imus
    count = len(forearm.time_s)
    q, free = np.zeros((count, 4, 4)), np.zeros((count, 4, 3))
    q[..., 0] = 1.0
    for at, imu in ((2, forearm), (1, upper)):
        nearest = np.searchsorted(imu.time_s, forearm.time_s).clip(0, len(imu.time_s) - 1)
        q[:, at] = imu.q_world_segment[nearest]
        free[:, at] = rotate(imu.q_world_segment, imu.acc)[nearest] - UP
    suit(folder / "suit.mvnx", q, free)
    toml = folder / "recording.toml"
    text = toml.read_text()
    for name in ("imu.csv", "upper_arm.csv"):
        assert f'"{name}"' in text
        text = text.replace(f'"{name}"', '"suit.mvnx"')
    toml.write_text(text)
    read = pt.load(folder)
    assert isinstance(read, pt.ArmRecording)
    error = {name: pt.evaluate(pt.track(of, pt.Smooth()), of.truth).joints["wrist"].rms_m
             for name, of in (("own", recording), ("suit", read))}  # fmt: skip
    assert error["suit"] < 1.3 * error["own"] + 0.005, error
