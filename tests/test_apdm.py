"""APDM's HDF5: the sensor that is worn where the arm needs it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.rotation import Array, rotation_vector_to_quaternion

h5py = pytest.importorskip("h5py")

COUNT = 256
RNG = np.random.default_rng(1)
ACC, GYR, MAG = (RNG.normal(0, 1, (4, COUNT, 3)) for _ in range(3))
Q: Array = np.asarray(rotation_vector_to_quaternion(RNG.normal(0, 0.5, (COUNT, 3))))
LABELS = ("Lumbar", "Right Wrist", "Right Upper Arm", "Left Wrist")


def opal(path: Path, labels: tuple[str, ...] = LABELS) -> Path:
    """As Moveo writes it, 128 Hz, with orientations."""
    with h5py.File(path, "w") as file:
        file.attrs["FileFormatVersion"] = 5
        for k, label in enumerate(labels):
            group = file.create_group(f"Sensors/{100 + k}")
            group.create_group("Configuration").attrs["Label 0"] = np.bytes_(label.ljust(32, "\0"))
            group["Time"] = (1_600_000_000_000_000 + np.arange(COUNT) * 7812.5).astype(np.uint64)
            for name, values in (("Accelerometer", ACC), ("Gyroscope", GYR), ("Magnetometer", MAG)):
                group[name] = values[k]
            file[f"Processed/{100 + k}/Orientation"] = Q
    return path


def test_the_sensor_is_found_by_where_it_is_worn(tmp_path: Path) -> None:
    path = opal(tmp_path / "trial.h5")
    for segment, at in (("right_forearm", 1), ("right_upper_arm", 2), ("left_forearm", 3)):
        log = read_imu(path, segment=segment)
        assert log.acc == pytest.approx(ACC[at])
        assert log.gyr == pytest.approx(GYR[at])
        assert log.mag == pytest.approx(MAG[at])
        assert log.q_world_sensor == pytest.approx(Q)
        assert log.time_s == pytest.approx(np.arange(COUNT) / 128, abs=2e-6)


def test_the_only_sensor_is_the_one(tmp_path: Path) -> None:
    log = read_imu(opal(tmp_path / "one.h5", ("Sternum",)))
    assert log.acc == pytest.approx(ACC[0])
    (words,) = log.warnings
    assert "its only sensor says it is worn at 'Sternum', and is taken for the right forearm's" in words
    assert read_imu(opal(tmp_path / "nowhere.h5", ("",))).warnings == ()
    assert read_imu(opal(tmp_path / "there.h5", ("Right Wrist",))).warnings == ()


def test_a_second_label_says_where_it_is_worn_too(tmp_path: Path) -> None:
    path = opal(tmp_path / "trial.h5", ("Subject 3", "Subject 3"))
    with h5py.File(path, "a") as file:
        for name, label in (("100", "Left Wrist"), ("101", "Right Wrist")):
            file[f"Sensors/{name}/Configuration"].attrs["Label 1"] = np.bytes_(label)
    assert read_imu(path, segment="right_forearm").acc == pytest.approx(ACC[1])


def test_sides_may_be_letters(tmp_path: Path) -> None:
    path = opal(tmp_path / "trial.h5", ("L Wrist", "R Wrist"))
    assert read_imu(path, segment="right_forearm").acc == pytest.approx(ACC[1])
    assert read_imu(path, segment="left_forearm").acc == pytest.approx(ACC[0])


def test_what_is_amiss_is_said(tmp_path: Path) -> None:
    path = opal(tmp_path / "trial.h5", ("Lumbar", "Right Foot"))
    with pytest.raises(pt.InputError, match=r"its sensors are 100 \(Lumbar\), 101 \(Right Foot\), expected one on"):
        read_imu(path)
    with pytest.raises(pt.InputError, match="segment is 'wrist', expected a side's forearm"):
        read_imu(path, segment="wrist")
    path = opal(tmp_path / "short.h5", ("Right Wrist",))
    with h5py.File(path, "a") as file:
        del file["Sensors/100/Gyroscope"]
        file["Sensors/100/Gyroscope"] = GYR[0, :-1]
    with pytest.raises(pt.InputError, match="has 255 rows of gyr, expected 256"):
        read_imu(path)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(pt.InputError, match="holds x, expected /Sensors, APDM's format 5"):
        read_imu(tmp_path / "other.h5")
    whole = opal(tmp_path / "cut.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(pt.InputError, match="is no file of APDM's that can be read"):
        read_imu(tmp_path / "cut.h5")
