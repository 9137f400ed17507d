"""IMU files: every variant that users have, and every fault with its place, value and expectation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.check import check
from pytracker.inertial.log import ImuLog
from pytracker.inertial.orientation import orient
from pytracker.rotation import (
    euler_to_quaternion,
    matrix_to_quaternion,
    rotate,
)
from pytracker.simulate import ArmSimulation

HEADER = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q_w,q_x,q_y,q_z"


def rows(count: int = 50) -> list[list[float]]:
    return [[0.01 * k, 0.1, -0.2, 9.8, 0.0, 0.01, 0.0, 1.0, 0.0, 0.0, 0.0] for k in range(count)]


def write(path: Path, table: list[list[float]] | list[list[str]], header: str = HEADER, end: str = "\n") -> Path:
    path.write_text(end.join([header, *(",".join(map(str, row)) for row in table)]) + end, "utf-8", newline="")
    return path


def load(path: Path, **options: object) -> ImuLog:
    return orient(check(read_imu(path, **options)))  # type: ignore[arg-type]


def test_plain_csv(tmp_path: Path) -> None:
    log = load(write(tmp_path / "imu.csv", rows()))
    assert log.time_s[-1] == pytest.approx(0.49)
    assert log.acc is not None
    assert log.acc[3].tolist() == [0.1, -0.2, 9.8]
    assert log.gyr is not None
    assert log.lines[0] == 2


def test_columns_are_found_by_name_in_any_order_with_crlf_and_extras(tmp_path: Path) -> None:
    table = [[*row[1:4], "x", *row[7:], row[0]] for row in rows()]
    path = write(tmp_path / "imu.csv", table, "Acc_X,acc_y,acc_z,note,q_w,q_x,q_y,q_z,time_s", "\r\n")  # type: ignore[arg-type]
    log = load(path)
    assert log.gyr is None
    assert log.time_s[1] == pytest.approx(0.01)


def test_semicolons_and_tabs(tmp_path: Path) -> None:
    for delimiter in ";\t":
        path = tmp_path / "imu.csv"
        path.write_text(write(path, rows()).read_text().replace(",", delimiter))
        assert len(load(path).time_s) == 50


def fault(tmp_path: Path, line: int, column: int, value: object) -> str:
    table: list[list[object]] = [list(row) for row in rows()]
    table[line - 2][column] = value
    with pytest.raises(pt.InputError) as error:
        load(write(tmp_path / "imu.csv", table))  # type: ignore[arg-type]
    return str(error.value)


@pytest.mark.parametrize(
    ("line", "column", "value", "expected"),
    [
        (7, 1, "abc", "imu.csv:7: acc_x is 'abc', expected a number"),
        (7, 1, "inf", "imu.csv:7: acc_x is 'inf', expected a finite number"),
        (7, 1, "NaN", "imu.csv:7: acc is [nan, -0.2, 9.8], expected finite numbers (1 of 50 samples)"),
        (9, 0, 0.06, "imu.csv:9: time 0.060000 s after 0.060000 s, expected increasing times (1 such rows)"),
        (9, 0, 0.01, "imu.csv:9: time 0.010000 s after 0.060000 s, expected increasing times (1 such rows)"),
        (5, 7, 1.2, "imu.csv:5: quaternion has norm 1.2000, expected 1 ± 0.02 (1 of 50 samples)"),
        (5, 7, "", "imu.csv:5: q_world_sensor is [nan, 0.0, 0.0, 0.0], expected finite numbers"),
    ],
)
def test_faulty_cell_is_named(tmp_path: Path, line: int, column: int, value: object, expected: str) -> None:
    assert expected in fault(tmp_path, line, column, value)


def scaled(factor: float) -> list[list[float]]:
    return [[row[0], *(factor * a for a in row[1:4]), *row[4:]] for row in rows()]


@pytest.mark.parametrize(
    ("table", "header", "expected"),
    [
        (scaled(1 / 9.8), HEADER, "median length of 1.000, which looks like units of g, expected m/s²"),
        (scaled(0.1), HEADER, "which looks like units of g"),
        (scaled(1000 / 9.8), HEADER, "looks like units of mg (which a header may name"),
        (scaled(0.01), HEADER, "median length of 0.098 m/s², expected about 9.81: the raw reading with gravity"),
        (scaled(-1.0), HEADER, "the mean acceleration is (-0.10, 0.20, -9.80) m/s², expected about (0, 0, 9.81)"),
        (rows(1), HEADER, "has 1 sample, expected at least 2"),
        ([], HEADER, "has a header but no rows"),
        (rows(), HEADER.replace("acc_x", "fx"), "imu.csv:1: header has no column acc_x"),
        (rows(), HEADER.replace("gyr_x", "ox"), "imu.csv:1: header has gyr_y, gyr_z but not gyr_x"),
        (rows(), HEADER.replace("gyr_x", "acc_x"), "column 'acc_x' stands more than once"),
        ([row[:-1] for row in rows()], HEADER, "imu.csv:2: row has 10 cells, expected 11 as the header has"),
        ([row[:4] for row in rows()], HEADER[:24], "has neither orientation nor a gyroscope, expected q_w"),
    ],
)
def test_faulty_file_is_explained(tmp_path: Path, table: list[list[float]], header: str, expected: str) -> None:
    with pytest.raises(pt.InputError) as error:
        load(write(tmp_path / "imu.csv", table, header))
    assert expected in str(error.value)
    assert "imu.csv" in str(error.value)


def test_inverted_orientation_is_recognised(tmp_path: Path) -> None:
    q = euler_to_quaternion(np.full(50, 1.2), np.zeros(50), np.zeros(50))
    acc = rotate(q, np.array([[0.0, 0.0, 9.81]] * 50))
    table = [[0.01 * k, *acc[k], 0, 0, 0, *q[k]] for k in range(50)]
    with pytest.raises(pt.InputError, match="the inverse fits, so these seem to take the world to the sensor"):
        load(write(tmp_path / "imu.csv", table))


def test_a_clock_that_jumps_is_refused(tmp_path: Path) -> None:
    table = rows()
    table[20:] = [[row[0] + 1.7e9, *row[1:]] for row in table[20:]]
    with pytest.raises(pt.InputError, match=r"imu\.csv:22: time jumps by 1\.7e\+09 s, expected one recording"):
        load(write(tmp_path / "imu.csv", table))


def test_missing_empty_and_binary_files(tmp_path: Path) -> None:
    with pytest.raises(pt.InputError, match=r"none\.csv: no such file"):
        read_imu(tmp_path / "none.csv")
    (tmp_path / "empty.csv").write_bytes(b"\n")
    with pytest.raises(pt.InputError, match=r"empty\.csv: the file is empty \(1 bytes\)"):
        read_imu(tmp_path / "empty.csv")
    (tmp_path / "binary.csv").write_bytes(b"\0\1\2\3")
    with pytest.raises(pt.InputError, match=r"binary\.csv: is a binary file, expected text"):
        read_imu(tmp_path / "binary.csv")
    with pytest.raises(pt.InputError, match="IMU format is 'xsens', expected one of: auto, csv"):
        read_imu(tmp_path / "empty.csv", form="xsens")


@pytest.mark.parametrize("order", ["le", "be"])
def test_utf_16_is_read_where_it_says_so(order: str, tmp_path: Path) -> None:
    path = write(tmp_path / "imu.csv", rows())
    expected = load(path)
    path.write_bytes(("\ufeff" + path.read_text()).encode(f"utf-16-{order}"))
    assert np.array_equal(load(path).time_s, expected.time_s)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(pt.InputError, match=r"imu\.csv: begins as UTF-16, and is none from byte \d+ on"):
        load(path)


def test_gaps_are_warned_of(tmp_path: Path) -> None:
    table = [row for k, row in enumerate(rows()) if not 10 <= k < 17]
    (warning,) = load(write(tmp_path / "imu.csv", table)).warnings
    assert "1 gap between samples, the longest 0.080 s at line 12 (0.090 s)" in warning


def test_stated_rate_must_agree(tmp_path: Path) -> None:
    path = write(tmp_path / "imu.csv", rows())
    assert load(path, rate_hz=100.0).rate_hz == 100.0
    with pytest.raises(pt.InputError, match=r"stated as 128 Hz, but the times are 100\.00 Hz apart"):
        load(path, rate_hz=128.0)


def test_orientation_by_vqf(tmp_path: Path) -> None:
    """The simulated gyroscope and accelerometer give back the tilt; the heading is said to be unknown."""
    simulation = ArmSimulation(pt.ArmScene(duration_s=20.0, dropped_imu=0.02), seed=3)
    imu = simulation.imu
    assert imu.gyr is not None
    table = np.column_stack([imu.time_s, imu.acc, imu.gyr]).tolist()
    log = load(write(tmp_path / "imu.csv", table, HEADER[:42]))
    assert "computed from its gyroscope by VQF; there is no magnetometer" in log.warnings[-1]
    assert log.q_world_sensor is not None
    up = np.array([0.0, 0.0, 1.0])
    true_up = rotate(simulation.q_world_sensor(imu.time_s) * [1, -1, -1, -1], up)
    found_up = rotate(log.q_world_sensor * [1, -1, -1, -1], up)
    angle = np.degrees(np.arccos(np.clip((true_up * found_up).sum(axis=1), -1, 1)))
    assert np.median(angle) < 2.0


# -- Xsens MT Manager ---------------------------------------------------------------------------------------


def mt_manager(tmp_path: Path, delimiter: str = "\t", rate: str = "// Update Rate: 100.0Hz\n", end: str = "\n") -> Path:
    names = ["PacketCounter", "SampleTimeFine", "Acc_X", "Acc_Y", "Acc_Z", "Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3"]
    counters = [65533, 65534, 65535, 0, 1, 4, 5]
    lines = [delimiter.join([f"{c:05d}", "", "0.0", "0.1", "9.8", "1", "0", "0", "0"]) for c in counters]
    path = tmp_path / "MT_0001-000_00B40001.txt"
    text = "// Start Time: Unknown\n" + rate + delimiter.join(names) + "\n" + "\n".join(lines) + "\n"
    path.write_text(text.replace("\n", end), newline="")
    return path


@pytest.mark.parametrize("delimiter", ["\t", ",", ";", " "])
def test_mt_manager_counter_wraps_and_gaps(tmp_path: Path, delimiter: str) -> None:
    log = load(mt_manager(tmp_path, delimiter, end="\r\n"))
    assert log.time_s == pytest.approx([0, 0.01, 0.02, 0.03, 0.04, 0.07, 0.08])
    assert "1 gap between samples, the longest 0.030 s" in log.warnings[0]


def test_mt_manager_without_rate_asks_for_it(tmp_path: Path) -> None:
    path = mt_manager(tmp_path, rate="")
    with pytest.raises(pt.InputError, match=r"states neither an Update Rate nor sample times .* expected rate_hz"):
        read_imu(path)
    assert load(path, rate_hz=50.0).time_s[1] == pytest.approx(0.02)
    with pytest.raises(pt.InputError, match=r":2: Update Rate is '-3', expected a positive number"):
        read_imu(mt_manager(tmp_path, rate="// Update Rate: -3Hz\n"))


def test_mt_manager_lost_rows_keep_their_time_without_a_counter(tmp_path: Path) -> None:
    path = tmp_path / "no_counter.txt"
    rows = ["0\t0\t9.8\t1\t0\t0\t0"] * 20
    rows[5:10] = ["NaN\t\t\t\t\t\t", "\t\t\t\t\t\t", *["0\t0\tNaN\t1\t0\t0\t0"] * 3]
    header = "Acc_X\tAcc_Y\tAcc_Z\tQuat_q0\tQuat_q1\tQuat_q2\tQuat_q3"
    path.write_text("// Update Rate: 100.0Hz\n" + "\n".join([header, *rows]) + "\n")
    log = load(path)
    assert log.time_s[-1] == pytest.approx(0.19)
    assert len(log.time_s) == 15
    assert "5 of 20 rows lack a reading" in log.warnings[0]


def test_mt_manager_two_rates_contradict(tmp_path: Path) -> None:
    """rate_hz was taken without a word: 22 cm, all valid."""
    with pytest.raises(pt.InputError, match=r"its Update Rate is 100 Hz, and rate_hz is 50, expected the same"):
        read_imu(mt_manager(tmp_path), rate_hz=50.0)


def test_a_clock_in_bursts_has_the_unit_of_its_mean(tmp_path: Path) -> None:
    """Five samples 30 µs apart every 50 ms were milliseconds: a recording of hours."""
    table = [[50_000 * (k // 5) + 30 * (k % 5), *row[1:]] for k, row in enumerate(rows())]
    log = read_imu(write(tmp_path / "imu.csv", table, HEADER.replace("time_s", "time")))
    assert log.time_s[-1] == pytest.approx(0.45012)


def test_mt_manager_a_counter_that_begins_anew_is_named(tmp_path: Path) -> None:
    """It was taken to have wrapped: a gap of 255 s."""
    path = tmp_path / "anew.txt"
    counts = [*range(40_000, 40_010), *range(10)]
    rows = [f"{k}\t0\t0\t9.8\t1\t0\t0\t0" for k in counts]
    header = "PacketCounter\tAcc_X\tAcc_Y\tAcc_Z\tQuat_q0\tQuat_q1\tQuat_q2\tQuat_q3"
    path.write_text("// Update Rate: 100.0Hz\n" + "\n".join([header, *rows]) + "\n")
    with pytest.raises(pt.InputError, match=r"anew.txt:13: PacketCounter is 0 after 40009, expected .* start anew\?"):
        load(path)
    path.write_text(path.read_text().replace("400", "655"))  # 65500 to 65509, of which 26 are lost as it wraps
    assert load(path).time_s[10] == pytest.approx(0.36)


@pytest.mark.parametrize(("ticks", "seconds"), [(100, 0.01), (16_667, 0.016667)])
def test_mt_manager_sample_clock(tmp_path: Path, ticks: int, seconds: float) -> None:
    """0.1 ms on an MTi, 1 µs on a DOT, told apart by the rate that they give; the 32-bit counter wraps."""
    path = tmp_path / "dot.csv"
    start = 2**32 - 3 * ticks
    lines = [f"{k},{(start + k * ticks) % 2**32},0,0,9.8,1,0,0,0" for k in range(10)]
    path.write_text(
        "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Quat_q0,Quat_q1,Quat_q2,Quat_q3\n" + "\n".join(lines)
    )
    assert load(path).time_s == pytest.approx(seconds * np.arange(10))


XSENS = {
    "MT2022_ACC_00B42D4B.txt": (5, False),
    "MT2022_ACC_GYRO_ROT_ALL_TAB_NAN_00B42D4B.txt": (4, True),
    "MT2022_ACC_GYRO_ROT_EULER_TAB_00B42D4F.txt": (5, True),
    "MT2022_ACC_GYRO_ROT_MAT_COMMA_00B42D4B.txt": (5, True),
    "MT2022_ACC_GYRO_ROT_MAT_SPACE_00B42D4B.txt": (5, True),
    "MT46_01-000_00B42D4D.txt": (5, True),
    "MT_01200454_000-000_00B40DE4.txt": (4, True),
    "MT_012005D6-000_sit_to_stand-000_00B421ED.txt": (1459, True),
    "MT_012005D6_009-001_00B42268.txt": (2496, True),
    "MT_012005D6_009-001_00B4227D.txt": (2505, True),
    "MT_012005D6_031-000_00B421AF.txt": (3369, True),
    "test1_00B421E6.txt": (3, True),
}


def test_every_shared_xsens_export_is_read(shared: Callable[[str], Path]) -> None:
    folder = shared("data/xsens")
    assert {path.name for path in folder.glob("*.txt")} == set(XSENS)
    for name, (count, oriented) in XSENS.items():
        stated = "Update Rate" in (folder / name).read_text("latin-1")
        log = read_imu(folder / name, rate_hz=None if stated else 100.0)
        assert len(log.time_s) == count, name
        assert (log.q_world_sensor is not None) == oriented, name
        assert (np.diff(log.time_s) > 0).all(), name
        if log.acc is not None and oriented and len(log.time_s) > 10:
            checked = check(log)
            assert checked.q_world_sensor is not None
            mean = rotate(checked.q_world_sensor, log.acc).mean(axis=0)
            assert np.allclose(mean, [0, 0, 9.81], atol=0.4), name


def test_quaternion_euler_and_matrix_of_one_shared_sample_agree(shared: Callable[[str], Path]) -> None:
    path = shared("data/xsens/MT2022_ACC_GYRO_ROT_ALL_TAB_NAN_00B42D4B.txt")
    log = read_imu(path, rate_hz=100.0)
    assert "Acc_X has no value; 1 of 5 rows lack a reading and are left out" in log.warnings[0]
    lines = [line.split("\t") for line in path.read_text().splitlines() if not line.startswith("//")]
    names, values = lines[0], np.array([[float(c) for c in line] for line in lines[2:]])
    column = {name: values[:, k] for k, name in enumerate(names)}
    by_euler = euler_to_quaternion(*(np.deg2rad(column[name]) for name in ("Roll", "Pitch", "Yaw")))
    m = np.stack([[column[f"Mat[{r}][{c}]"] for c in (1, 2, 3)] for r in (1, 2, 3)]).transpose(2, 0, 1)
    assert log.q_world_sensor is not None
    for other in (by_euler, matrix_to_quaternion(m)):
        dot = np.abs((log.q_world_sensor * other).sum(axis=1))
        assert np.allclose(dot, 1.0, atol=1e-5)


# -- MT9 logs -----------------------------------------------------------------------------------------------


def mt9(tmp_path: Path, kind: str, count: int = 40, start: float = 0.0) -> Path:
    q = euler_to_quaternion(np.full(count, 0.3), np.full(count, -0.2), np.linspace(0, 1, count))
    acc = rotate(q * [1, -1, -1, -1], np.array([0, 0, 9.81]))
    time = (start + np.arange(count) / 256.0)[:, None]
    m = np.stack([rotate(q, axis) for axis in np.eye(3)], axis=1).reshape(count, 9)
    euler = np.degrees(np.stack([np.full(count, 0.3), np.full(count, -0.2), np.linspace(0, 1, count)], axis=1))
    body = {"cal": np.hstack([acc, np.zeros((count, 3)), np.ones((count, 4))]), "quat": q, "euler": euler, "matrix": m}
    path = tmp_path / f"MT9_{kind}_00007154_001.log"
    np.savetxt(path, np.hstack([time, body[kind]]), fmt="%.6f", delimiter="\t")
    return path


@pytest.mark.parametrize("kind", ["quat", "euler", "matrix"])
def test_mt9_logs_come_in_two_files(tmp_path: Path, kind: str) -> None:
    log = load(mt9(tmp_path, "cal"), orientation_file=mt9(tmp_path, kind))
    expected = euler_to_quaternion(np.full(40, 0.3), np.full(40, -0.2), np.linspace(0, 1, 40))
    assert log.q_world_sensor is not None
    assert np.allclose(np.abs((log.q_world_sensor * expected).sum(axis=1)), 1, atol=1e-6)
    assert log.time_s[1] == pytest.approx(1 / 256, abs=1e-6)


def test_mt9_faults(tmp_path: Path) -> None:
    with pytest.raises(pt.InputError, match=r"row has 5 columns, expected 11: the MT9 log of calibrated data"):
        read_imu(mt9(tmp_path, "quat"))
    cal = mt9(tmp_path, "cal")
    with pytest.raises(pt.InputError, match="without a common time, expected two logs of the same session"):
        read_imu(cal, orientation_file=mt9(tmp_path, "quat", start=100.0))
    log = read_imu(cal, orientation_file=mt9(tmp_path, "quat", count=35))
    assert "5 rows have no partner of the same time and are left out" in log.warnings[0]
    with pytest.raises(pt.InputError, match="orientation_file goes with format mt9-log, but this is csv"):
        read_imu(write(tmp_path / "imu.csv", rows()), orientation_file=cal)


def test_mt9_logs_that_are_cut_short_lose_one_row(tmp_path: Path) -> None:
    """Either was refused whole."""
    cal, quat = mt9(tmp_path, "cal"), mt9(tmp_path, "quat")
    for log in (cal, quat):
        lines = log.read_text().splitlines(keepends=True)
        log.write_text("".join(lines[:-1]) + "\t".join(lines[-1].split("\t")[:3]))
    found = read_imu(cal, orientation_file=quat)
    assert len(found.time_s) == 39
    assert ["its last row has 3 cells of" in words for words in found.warnings] == [True, True]


# -- nothing but our own error, whatever the bytes -------------------------------------------------------------

CELLS = st.sampled_from(["0", "1", "-2.5", "9.8", "", "nan", "inf", "x", "1e999", "65535", "1_0", "٣", "Hz"])
NAMES = st.sampled_from(
    ["time_s", "acc_x", "acc_y", "acc_z", "q_w", "q_x", "q_y", "q_z", "gyr_x", "PacketCounter", "SampleTimeFine",
     "Acc_X", "Acc_Y", "Acc_Z", "Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3", "Roll", "Pitch", "Yaw", "Mat[1][1]", "?"]
)  # fmt: skip


@st.composite
def table_text(draw: st.DrawFn) -> bytes:
    delimiter = draw(st.sampled_from([",", "\t", ";", " "]))
    names = draw(st.lists(NAMES, max_size=12))
    comments = draw(st.lists(st.sampled_from(["// Update Rate: 100.0Hz", "// Update Rate: x", "//", ""]), max_size=3))
    body = draw(st.lists(st.lists(CELLS, max_size=12), max_size=6))
    lines = [*comments, delimiter.join(names), *(delimiter.join(row) for row in body)]
    return draw(st.sampled_from(["\n", "\r\n"])).join(lines).encode(draw(st.sampled_from(["utf-8", "utf-16"])))


@settings(max_examples=400, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(table_text(), st.binary(max_size=200)), st.sampled_from(["auto", "csv", "mt-manager", "mt9-log"]))
def test_readers_raise_only_input_error(tmp_path: Path, content: bytes, form: str) -> None:
    path = tmp_path / "fuzz.txt"
    path.write_bytes(content)
    try:
        log = check(read_imu(path, form=form))
    except pt.InputError as error:
        said = str(error)
        if "fuzz.txt" not in said:
            pytest.fail(f"the message names no file: {said}")
    else:
        assert log.acc is not None
        assert np.isfinite(log.acc).all()
