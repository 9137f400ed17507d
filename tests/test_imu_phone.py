"""A phone's and a watch's recordings: a CSV a sensor, Core Motion in one file; Shimmer's units in a row."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

import pytracker as pt
from pytracker.formats.imu.read import files_of_imu, read_imu
from pytracker.inertial.gravity import GRAVITY
from pytracker.rotation import Array, rotate
from pytracker.setup import check, init

TIME_S = np.arange(300) / 100
TURN = np.stack([0.4 * np.sin(TIME_S), 0.3 * np.cos(2 * TIME_S), np.full(300, 0.2)], axis=1)
FORCE = np.stack([np.sin(3 * TIME_S), np.zeros(300), np.full(300, GRAVITY)], axis=1)
UP = np.array([0.0, 0.0, GRAVITY])
ANDROID = "version,platform,standardisation\n1.5,android,false\n"
IPHONE = "version,platform,standardisation\n1.5,ios,false\n"
STANDARD = 'version,platform,sensors,standardisation\n1.5,ios,"Accelerometer,Gravity",true\n'


def sensor(path: Path, time_s: Array, values: Array) -> None:
    """As Sensor Logger writes it: axes from z to x."""
    rows = [
        f"{1.7e18 + 1e9 * t:.0f},{t:.6f},{z:.9f},{y:.9f},{x:.9f}" for t, (x, y, z) in zip(time_s, values, strict=True)
    ]
    path.write_text("\n".join(["time,seconds_elapsed,z,y,x", *rows]) + "\n")


def phone(folder: Path, metadata: str, sign: float = 1.0) -> Path:
    """Acceleration without gravity, gravity, and a gyroscope that ticks on its own and begins later."""
    folder.mkdir()
    sensor(folder / "Accelerometer.csv", TIME_S, sign * (FORCE - UP))
    sensor(folder / "Gravity.csv", TIME_S, sign * np.tile(UP, (300, 1)))
    sensor(folder / "Gyroscope.csv", TIME_S[10:] + 0.004, TURN[10:])
    if metadata:
        (folder / "Metadata.csv").write_text(metadata)
    return folder


@pytest.mark.parametrize(("metadata", "sign"), [(ANDROID, 1.0), (IPHONE, -1.0), (STANDARD, 1.0)])
def test_a_phones_sensors_are_put_together(metadata: str, sign: float, tmp_path: Path) -> None:
    log = read_imu(phone(tmp_path / "phone", metadata, sign))
    assert log.acc is not None
    assert log.gyr is not None
    assert log.warnings == ()
    assert log.time_s == pytest.approx(TIME_S[11:])  # from where there is a gyroscope
    assert log.acc == pytest.approx(FORCE[11:], abs=1e-6)
    between = [np.interp(TIME_S[11:], TIME_S[10:] + 0.004, TURN[10:, d]) for d in range(3)]
    assert log.gyr == pytest.approx(np.stack(between, axis=1), abs=1e-6)


def test_a_clock_in_nanoseconds_need_not_say_so(tmp_path: Path) -> None:
    """Sensor Logger's `time` alone was "1e7 s apart"."""
    folder = phone(tmp_path / "phone", ANDROID)
    for path in folder.glob("[AG]*.csv"):
        rows = [line.split(",") for line in path.read_text("utf-8").splitlines()]
        path.write_text("\n".join(",".join([row[0], *row[2:]]) for row in rows), "utf-8")
    assert read_imu(folder).time_s - 1.7e9 == pytest.approx(TIME_S[11:], abs=1e-5)


@pytest.mark.parametrize("every", [21, 60])
def test_seconds_elapsed_are_seconds_however_slow_the_sensor(every: int, tmp_path: Path) -> None:
    """At 5 Hz and less, as Android's own rate for gravity, they were milliseconds, and no sensor overlapped."""
    folder = phone(tmp_path / "phone", ANDROID)
    sensor(folder / "Gravity.csv", TIME_S[::every], np.tile(UP, (len(TIME_S[::every]), 1)))
    log = read_imu(folder)
    assert log.acc == pytest.approx(FORCE[11 : 11 + len(log.time_s)], abs=1e-6)
    assert log.time_s[-1] > 2.3


def test_what_a_mac_leaves_beside_files_is_none_of_them(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    (folder / "._Accelerometer.csv").write_bytes(b"\0\5\x16\7Mac OS X")
    assert len(read_imu(folder).time_s) == 289


def test_total_acceleration_is_taken_where_there_is_one(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", "")
    assert "Metadata.csv" in read_imu(folder).warnings[0]
    sensor(folder / "TotalAcceleration.csv", TIME_S, FORCE + np.array([0.0, 1.0, 0.0]))
    log = read_imu(folder)
    assert log.acc is not None
    assert log.acc[0, 1] == pytest.approx(1.0)
    assert log.warnings == ()
    assert {path.name for path in files_of_imu(folder)} == {
        "Accelerometer.csv", "Gravity.csv", "Gyroscope.csv", "TotalAcceleration.csv",
    }  # fmt: skip


def test_phyphox_exports_a_folder_too(tmp_path: Path) -> None:
    folder = tmp_path / "Acceleration and rotation"
    (folder / "meta").mkdir(parents=True)
    for name, unit, values in (("Accelerometer", "m/s^2", FORCE), ("Gyroscope", "rad/s", TURN)):
        head = ",".join(['"Time (s)"', *(f'"{axis} ({unit})"' for axis in "XYZ")])
        rows = [",".join(f"{cell:.6e}" for cell in (t, *row)) for t, row in zip(TIME_S, values, strict=True)]
        (folder / f"{name}.csv").write_text("\n".join([head, *rows]) + "\n")
    log = read_imu(folder)
    assert log.acc == pytest.approx(FORCE, abs=1e-5)
    assert log.gyr == pytest.approx(TURN, abs=1e-5)
    assert log.warnings == ()


@pytest.mark.parametrize(
    ("break_it", "words"),
    [
        (
            lambda f: (f / "Gravity.csv").unlink(),
            r"0\.\d\d m/s² in the median, expected about 9.8: gravity is not in it",
        ),
        (lambda f: [path.unlink() for path in f.glob("*.csv")], "with no CSV file, expected a phone's"),
        (lambda f: sensor(f / "Gyroscope.csv", TIME_S + 60, TURN), "its sensors do not overlap .*Gyroscope.csv 60.00"),
        (
            lambda f: sensor(f / "Gravity.csv", TIME_S + 60, TURN),
            "its sensors do not overlap .*Accelerometer.csv 0.00 to 2.99 s; Gravity.csv 60.00",
        ),
        (lambda f: sensor(f / "Gyroscope.csv", TIME_S[::-1], TURN), "Gyroscope.csv:3: time goes back"),
        (lambda f: sensor(f / "Gyroscope.csv", TIME_S, np.nan * TURN), "none of its 300 rows has x, y and z"),
        (lambda f: (f / "Gyroscope.csv").write_text("a,b\n1,2\n"), "header has no column time_s, gyr_x, gyr_y, gyr_z"),
    ],
)
def test_what_a_folder_lacks_is_said(break_it: object, words: str, tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    break_it(folder)  # type: ignore[operator]
    with pytest.raises(pt.InputError, match=words):
        read_imu(folder)


def test_a_sensor_that_pauses_leaves_a_gap(tmp_path: Path) -> None:
    """What lay between was interpolated, as an arm that moves evenly."""
    folder = phone(tmp_path / "phone", ANDROID)
    kept = (TIME_S < 1.0) | (TIME_S > 1.5)
    sensor(folder / "Gyroscope.csv", TIME_S[kept], TURN[kept])
    log = read_imu(folder)
    assert "Gyroscope.csv says nothing for 0.52 s" in log.warnings[0]
    assert not ((log.time_s > 1.02) & (log.time_s < 1.48)).any()
    assert float(np.diff(log.time_s).max()) == pytest.approx(0.5, abs=0.05)


def test_a_lively_arm_needs_gravity_all_the_same(tmp_path: Path) -> None:
    """Its acceleration without gravity is as long as gravity."""
    folder = phone(tmp_path / "phone", ANDROID)
    lively = 14.0 * np.stack([np.sin(9 * TIME_S), np.cos(7 * TIME_S), np.zeros(300)], axis=1)
    sensor(folder / "Accelerometer.csv", TIME_S, lively)
    log = read_imu(folder)
    assert log.acc == pytest.approx(lively[11:] + UP, abs=1e-6)


def test_a_magnetometer_cuts_nothing_off(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    sensor(folder / "Magnetometer.csv", TIME_S[200:], TURN[200:])
    log = read_imu(folder)
    assert log.mag is None
    assert len(log.time_s) == 289
    assert "Magnetometer.csv goes from 2.00 to 2.99 s only: it is left out" in log.warnings[0]


def test_what_a_late_gyroscope_cuts_off_is_told(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    sensor(folder / "Gyroscope.csv", TIME_S[250:], TURN[250:])
    assert "phone: 2.50 s are left out" in read_imu(folder).warnings[0]


def test_two_recordings_in_a_folder_are_refused(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    sensor(folder / "Gyroscope (1).csv", TIME_S, TURN)
    with pytest.raises(pt.InputError, match=r"has Gyroscope \(1\).csv and Gyroscope.csv, expected one of them"):
        read_imu(folder)


def test_a_watch_with_two_accelerations_is_refused(tmp_path: Path) -> None:
    path = watch(tmp_path / "WristMotion.csv", 1.0)
    head, *rows = path.read_text().splitlines()
    axes = ",".join(f"userAcceleration{axis}" for axis in "XYZ")
    path.write_text("\n".join([f"{head},{axes}", *(f"{row},0,0,0" for row in rows)]))
    with pytest.raises(pt.InputError, match="has several columns for acc_x"):
        read_imu(path)


def test_what_is_not_unpacked_is_told(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    with zipfile.ZipFile(tmp_path / "phone.zip", "w") as packed:
        packed.write(folder / "Gyroscope.csv", "Gyroscope.csv")
    with pytest.raises(pt.InputError, match="is a ZIP or a workbook, expected what it unpacks to"):
        read_imu(tmp_path / "phone.zip")


def watch(path: Path, unit: float) -> Path:
    """A watch's motion: in g with Apple's signs, or standardised."""
    names = [f"{what}{axis}" for what in ("rotationRate", "gravity", "acceleration") for axis in "XYZ"]
    values = np.hstack([TURN, np.tile(UP, (300, 1)) / unit, (FORCE - UP) / unit])
    rows = [f"{1.7e18:.0f},{t:.6f}," + ",".join(f"{x:.9f}" for x in row) for t, row in zip(TIME_S, values, strict=True)]
    path.write_text("\n".join([",".join(["time", "seconds_elapsed", *names]), *rows]) + "\n")
    return path


@pytest.mark.parametrize("unit", [-GRAVITY, 1.0])
def test_a_watch_is_read_whatever_its_units(unit: float, tmp_path: Path) -> None:
    log = read_imu(watch(tmp_path / "WristMotion.csv", unit))
    assert log.acc == pytest.approx(FORCE, abs=1e-6)
    assert log.gyr == pytest.approx(TURN, abs=1e-6)


def test_of_a_phones_folder_the_watch_is_taken(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", IPHONE, -1.0)
    watch(folder / "WristMotion.csv", -GRAVITY)
    log = read_imu(folder)
    assert log.path.name == "WristMotion.csv"
    assert "the watch's is taken" in log.warnings[0]


def test_shimmers_units_stand_in_a_row(tmp_path: Path) -> None:
    names = [f"S_Wrist_{name}_CAL" for name in (
        "Timestamp_Unix", *(f"{what}_{axis}" for what in ("Accel_LN", "Accel_WR", "Gyro") for axis in "XYZ"), "Battery",
    )]  # fmt: skip
    units = ["ms", *["m/(s^2)"] * 6, *["deg/s"] * 3, "mV"]
    rows = [
        ",".join(
            [f"{1.6e12 + 10 * k:.1f}", "0,0,19.6", *(f"{x:.6f}" for x in (*FORCE[k], *np.degrees(TURN[k]))), "4000"]
        )
        for k in range(300)
    ]
    path = tmp_path / "shimmer.csv"
    path.write_text(
        "\n".join(['"sep=,"', ",".join(names) + ",", ",".join(units) + ",", *(row + "," for row in rows)]) + "\n"
    )
    log = read_imu(path)
    assert log.acc == pytest.approx(FORCE, abs=1e-5)
    assert log.gyr == pytest.approx(TURN, abs=1e-5)
    assert np.diff(log.time_s) == pytest.approx(0.01, abs=1e-6)
    assert log.lines[0] == 4


def test_samples_that_come_in_batches_are_no_gaps(tmp_path: Path) -> None:
    """Twenty of a gyroscope at one time every 0.2 s: the accelerometer was said to have one sample."""
    folder = phone(tmp_path / "phone", ANDROID)
    batched = TIME_S[np.arange(len(TIME_S)) // 20 * 20]
    sensor(folder / "Gyroscope.csv", batched, TURN)
    assert len(read_imu(folder).time_s) > 250


def test_a_magnetometer_that_pauses_takes_no_samples_along(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    kept = (TIME_S < 1.0) | (TIME_S > 1.5)
    before = len(read_imu(folder).time_s)
    sensor(folder / "Magnetometer.csv", TIME_S[kept], np.tile([20.0, 0.0, -40.0], (int(kept.sum()), 1)))
    log = read_imu(folder)
    assert len(log.time_s) == before
    assert "Magnetometer.csv says nothing for" in log.warnings[-1]
    assert "interpolated" in log.warnings[-1]


def test_gravity_of_one_sample_is_no_recordings(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    (folder / "TotalAcceleration.csv").unlink(missing_ok=True)
    sensor(folder / "Accelerometer.csv", TIME_S, FORCE - UP)
    sensor(folder / "Gravity.csv", TIME_S[:1], UP[None])
    with pytest.raises(pt.InputError, match="its sensors do not overlap"):
        read_imu(folder)


@pytest.mark.parametrize("starred", ["", "*"])
def test_shimmers_readable_times_and_quaternions(starred: str, tmp_path: Path) -> None:
    names = ["Timestamp_FormattedUnix", *(f"Accel_WR_{axis}" for axis in "XYZ")]
    names += [f"Quat_Madge_{of}DOF_{axis}" for of in (6, 9) for axis in "WXYZ"]
    units = ["yyyy/mm/dd hh:mm:ss.000", *[f"m/(s^2){starred}"] * 3, *["no_units"] * 8]
    rows = [f"2022/07/26 14:40:{36 + 0.01 * k:06.3f},0,0,9.81,1,0,0,0,0.6,0.8,0,0" for k in range(200)]
    path = tmp_path / "shimmer.csv"
    path.write_text("\n".join([",".join(f"S_{name}_CAL" for name in names), ",".join(units), *rows]) + "\n")
    log = read_imu(path)
    assert log.time_s == pytest.approx(0.01 * np.arange(200), abs=1e-6)
    assert log.acc is not None
    assert log.acc[0] == pytest.approx([0, 0, 9.81])
    assert log.q_world_sensor is not None
    assert log.q_world_sensor[0] == pytest.approx([0.6, 0.8, 0, 0])  # with a heading


def test_gravity_that_pauses_leaves_a_gap(tmp_path: Path) -> None:
    folder = phone(tmp_path / "phone", ANDROID)
    (folder / "TotalAcceleration.csv").unlink(missing_ok=True)
    sensor(folder / "Accelerometer.csv", TIME_S, FORCE - UP)
    kept = (TIME_S < 1.0) | (TIME_S > 1.5)
    sensor(folder / "Gravity.csv", TIME_S[kept], np.tile(UP, (int(kept.sum()), 1)))
    log = read_imu(folder)
    assert not ((log.time_s > 1.02) & (log.time_s < 1.48)).any()


def test_a_watchs_arm_is_found_and_tracked(tmp_path: Path) -> None:
    """The simulated sensor, written as a watch would, in a folder: heading and mount by `check`, then the wrist."""
    folder = pt.simulate_arm(tmp_path / "arm", pt.ArmScene(pattern="gesture", duration_s=15.0, acc_bias=0.0), 3)
    recording = pt.load(folder)
    assert isinstance(recording, pt.ArmRecording)
    imu, arm = recording.imus[0], recording.arm
    assert imu.gyr is not None
    up = rotate(imu.q_world_segment * [1.0, -1.0, -1.0, -1.0], np.tile(UP, (len(imu.acc), 1)))
    names = [f"{what}{axis}" for what in ("rotationRate", "gravity", "acceleration") for axis in "XYZ"]
    values = np.hstack([imu.gyr, -up / GRAVITY, (up - imu.acc) / GRAVITY])
    rows = [f"{t:.6f}," + ",".join(f"{x:.9f}" for x in row) for t, row in zip(imu.time_s, values, strict=True)]
    (tmp_path / "phone").mkdir()
    motion = tmp_path / "phone" / "WristMotion.csv"
    motion.write_text("\n".join([",".join(["seconds_elapsed", *names]), *rows]) + "\n")
    known: dict[str, object] = {"matrix": recording.camera.matrix, "rotation": recording.camera.rotation}
    known |= {"translation_m": recording.camera.translation_m, "shoulder_m": arm.shoulder_m}
    known |= {"upper_arm_m": arm.upper_arm_m, "forearm_m": arm.forearm_m, "distortion": recording.camera.distortion}
    entries = {key: np.asarray(value).tolist() for key, value in known.items()}
    (tmp_path / "known.toml").write_text("\n".join(f"{key} = {value}" for key, value in entries.items()))
    made = tmp_path / "made"
    assert recording.video is not None
    init(made, video=recording.video, imu=motion.parent, camera=tmp_path / "known.toml")
    track = check(made, write=True).track
    assert track is not None
    assert track.valid.mean() > 0.9
    assert pt.evaluate(track, recording.truth).joints["wrist"].rms_m < 0.06


def test_sensorlog_of_a_watch_is_core_motion_in_one_file(tmp_path: Path) -> None:
    """SensorLog's names and units; its accelerometer, which has gravity in it, stands beside the motion."""
    path = tmp_path / "2024-05-01_Apple Watch.csv"
    axes = "XYZ"
    names = [
        "loggingTime(txt)", *(f"accelerometerAcceleration{a}(G)" for a in axes), "motionTimestamp_sinceReboot(s)",
        *(f"motionRotationRate{a}(rad/s)" for a in axes), *(f"motionUserAcceleration{a}(G)" for a in axes),
        *(f"motionGravity{a}(G)" for a in axes), "activity(txt)",
    ]  # fmt: skip
    rows = [
        ["2024-05-01 12:00:00.1 +0200", *-f / GRAVITY, 5000 + t, *w, *-(f - UP) / GRAVITY, *-UP / GRAVITY, "unknown"]
        for t, f, w in zip(TIME_S, FORCE, TURN, strict=True)
    ]
    path.write_text("\n".join(",".join(map(str, row)) for row in [names, *rows]) + "\n")
    log = read_imu(path)
    assert log.acc == pytest.approx(FORCE)
    assert log.gyr == pytest.approx(TURN)
    assert log.time_s - 5000 == pytest.approx(TIME_S)


@pytest.mark.parametrize("late_s", [0.1, 0.4])
def test_metawears_sensors_count_from_their_own_first_sample(tmp_path: Path, late_s: float) -> None:
    """Started one after another: 5.5° of tilt and a heading that wandered by 15°, without a word."""
    time_s = np.arange(0.0, 3.0, 0.01)
    turn = np.stack([np.sin(3.0 * time_s), np.cos(2.0 * time_s), 0.5 * time_s], axis=1)
    for called, unit, first in (("Accelerometer", "g", 0), ("Gyroscope", "deg/s", round(100 * late_s))):
        header = "epoch (ms),time (01:00),elapsed (s)," + ",".join(f"{axis}-axis ({unit})" for axis in "xyz")
        rows = [
            f"{1.7e12 + 1e3 * t:.0f},12.00,{t - time_s[first]:.3f},{x:.9f},{y:.9f},{z:.9f}"
            for t, (x, y, z) in zip(time_s[first:], turn[first:], strict=True)
        ]
        (tmp_path / f"MetaWear_2024-05-01_C8_{called}_100.000Hz_1.7.2.csv").write_text("\n".join([header, *rows]))
    log = read_imu(tmp_path)
    assert log.gyr is not None
    assert log.acc is not None
    assert log.time_s[0] == pytest.approx(late_s, abs=0.011)
    assert np.degrees(log.gyr) == pytest.approx(log.acc / GRAVITY, abs=1e-5)
    assert log.warnings == ()


@pytest.mark.parametrize("day", ["2023-11-14T22:13:{s:06.3f}", "{boot:.0f}", ""])
def test_a_clock_of_the_day_that_tells_nothing_is_passed_over(tmp_path: Path, day: str) -> None:
    """Words, or the time since the phone was started in one of the files."""
    for called, values in (("TotalAcceleration", FORCE), ("Gyroscope", TURN)):
        rows = []
        for t, (x, y, z) in zip(TIME_S, values, strict=True):
            boot = 1e9 * t if called == "Gyroscope" else 1.7e18 + 1e9 * t
            rows.append(f"{day.format(s=t, boot=boot)},{t:.3f},{z},{y},{x}")
        (tmp_path / f"{called}.csv").write_text("\n".join(["time,seconds_elapsed,z,y,x", *rows]))
    log = read_imu(tmp_path)
    assert log.time_s == pytest.approx(TIME_S, abs=1e-3)
    assert log.gyr == pytest.approx(TURN, abs=1e-6)


def test_metawear_writes_the_sensor_into_a_long_name(tmp_path: Path) -> None:
    start = "epoch (ms),time (01:00),elapsed (s),"
    for called, unit, values, offset in (
        ("Accelerometer", "g", FORCE / GRAVITY, 0.0),
        ("Gyroscope", "deg/s", np.degrees(TURN), 0.003),
    ):
        rows = [
            f"{1.7e12 + 1e3 * t:.0f},12.00,{t + offset:.3f},{x},{y},{z}"
            for t, (x, y, z) in zip(TIME_S, values, strict=True)
        ]
        header = start + ",".join(f"{axis}-axis ({unit})" for axis in "xyz")
        (tmp_path / f"MetaWear_2024-05-01T12.00.00_C8B1_{called}_100.000Hz_1.7.2.csv").write_text(
            "\n".join([header, *rows])
        )
    log = read_imu(tmp_path)
    assert log.acc == pytest.approx(FORCE[1:])
    assert log.gyr is not None
    assert np.abs(log.gyr - TURN[1:]).max() < 0.01
