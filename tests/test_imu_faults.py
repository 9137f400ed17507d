"""IMU files with one thing wrong: told, with file and line; and what is usual in life is not refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from test_formats_imu import HEADER, load, write
from test_imu_agreement import waving

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.check import check
from pytracker.inertial.log import ImuLog
from pytracker.inertial.orientation import orient
from pytracker.rotation import Array, conjugate, multiply, rotate, rotation_vector_to_quaternion
from pytracker.simulate import ArmSimulation

ACC, GYR, QUATERNION = slice(1, 4), slice(4, 7), slice(7, 11)


@pytest.fixture(scope="module")
def arm() -> Array:
    """20 s of a simulated wrist: time, acceleration, turn rate, orientation."""
    imu = ArmSimulation(pt.ArmScene(duration_s=20.0), seed=4).imu
    assert imu.gyr is not None
    return np.column_stack([imu.time_s, imu.acc, imu.gyr, imu.q_world_segment])


def told(tmp_path: Path, table: Array, header: str = HEADER) -> str:
    """What is said of a table: the error, or all warnings."""
    try:
        return " ".join(load(write(tmp_path / "imu.csv", table.tolist(), header)).warnings)
    except pt.InputError as error:
        return f"refused: {error}"


@pytest.mark.parametrize(
    ("column", "value"), [(1, 1000.0), (2, -1000.0), (3, -200.0), (1, 50.0), (5, 60.0), (6, -300.0)]
)
def test_one_corrupt_reading_is_left_out_and_said(tmp_path: Path, arm: Array, column: int, value: float) -> None:
    table = arm.copy()
    table[700, column] = value
    said = told(tmp_path, table)
    assert "imu.csv:702: the " in said
    assert "1 of 2001 samples are such and are left out" in said
    log = load(tmp_path / "imu.csv")
    assert len(log.time_s) == 2000
    assert np.allclose(log.time_s, np.delete(arm[:, 0], 700))


@pytest.mark.parametrize("text", ["NaN", ""])
def test_one_cell_without_a_number_is_left_out_and_said(tmp_path: Path, arm: Array, text: str) -> None:
    rows = [[str(x) for x in row] for row in arm]
    rows[700][2] = text
    log = load(write(tmp_path / "imu.csv", rows))
    assert "imu.csv:702: acc is [" in log.warnings[0]
    assert len(log.time_s) == 2000
    for row in rows[500:600]:
        row[2] = text
    with pytest.raises(
        pt.InputError, match=r"imu\.csv:502: acc is .*, expected finite numbers \(101 of 2001 samples\)"
    ):
        load(write(tmp_path / "imu.csv", rows))


def test_one_quaternion_that_is_none_is_left_out_and_many_are_refused(tmp_path: Path, arm: Array) -> None:
    table = arm.copy()
    table[700, 7] += 0.4
    assert "imu.csv:702: quaternion has norm" in told(tmp_path, table)
    table[:, QUATERNION] *= 1.1
    assert "refused: " in told(tmp_path, table)


def turned(table: Array, degrees: float) -> Array:
    turn = rotation_vector_to_quaternion(np.radians([degrees, 0.0, 0.0]))
    table[:, QUATERNION] = multiply(np.broadcast_to(turn, (len(table), 4)), table[:, QUATERNION])
    return table


def late(table: Array, seconds: float) -> Array:
    samples = round(100 * seconds)
    table[samples:, ACC] = table[:-samples, ACC].copy()
    return table


def changed(columns: slice, change: Callable[[Array], Array]) -> Callable[[Array], Array]:
    def apply(table: Array) -> Array:
        table[:, columns] = change(table[:, columns])
        return table

    return apply


def frozen(table: Array) -> Array:
    table[500:700, 4] = table[500, 4]
    return table


def still_at_first(table: Array) -> Array:
    """Three seconds at rest before the movement, as an arm before it begins."""
    count = 300
    rest = np.repeat(table[:1], count, axis=0)
    rest[:, 0] = np.arange(count) / 100
    rest[:, ACC] = rotate(conjugate(table[0, QUATERNION]), np.array([0.0, 0.0, 9.80665])) + np.random.default_rng(
        1
    ).normal(0, 0.03, (count, 3))
    rest[:, GYR] = np.random.default_rng(2).normal(0, 0.01, (count, 3))
    table[:, 0] += count / 100
    return np.vstack([rest, table])


FAULTS: dict[str, tuple[Callable[[Array], Array], str]] = {
    "scale 0.9": (changed(ACC, lambda a: 0.9 * a), "at rest"),
    "scale 1.1": (changed(ACC, lambda a: 1.1 * a), "at rest"),
    "bias": (changed(ACC, lambda a: a + np.array([1.0, 0.0, 0.0])), "beside gravity"),
    "flipped": (changed(ACC, lambda a: a * [1.0, -1.0, 1.0]), "expected about (0, 0, 9.81)"),
    "tilt 15": (lambda t: turned(t, 15.0), "expected about (0, 0, 9.81)"),
    "tilt 20": (lambda t: turned(t, -20.0), "expected about (0, 0, 9.81)"),
    "noise": (
        changed(GYR, lambda g: g + np.random.default_rng(3).normal(0, 0.5, g.shape)), "is noise of 0.5",
    ),
    "frozen axis": (frozen, "gyr_x stays"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told(tmp_path: Path, arm: Array, name: str) -> None:
    fault, words = FAULTS[name]
    right = still_at_first(arm.copy())
    assert told(tmp_path, right) == ""
    assert words in told(tmp_path, fault(right.copy()))


def test_acceleration_that_is_late_is_told(tmp_path: Path, arm: Array) -> None:
    assert told(tmp_path, arm) == ""
    assert "s earlier (what is not gravity falls to" in told(tmp_path, late(arm.copy(), 0.2))
    table = waving(20.0)
    assert told(tmp_path, table) == ""
    assert told(tmp_path, late(table, 0.2)) != ""


NO_QUATERNION = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z"


@pytest.mark.parametrize("names", ["quat_1,quat_2,quat_3,quat_5", "q0,q1,q2,extra", "roll,pitch,yaw,extra"])
def test_an_orientation_by_other_names_is_not_passed_over(tmp_path: Path, arm: Array, names: str) -> None:
    assert "look like an orientation, expected it as q_w, q_x, q_y, q_z" in told(
        tmp_path, arm, f"{NO_QUATERNION},{names}"
    )


@pytest.mark.parametrize("names", ["quat_1,quat_2,quat_3,quat_4", "q0,q1,q2,q3", "q0(),q1(),q2(),q3()"])
def test_a_numbered_quaternion_is_w_first_and_that_is_said(tmp_path: Path, arm: Array, names: str) -> None:
    assert f"columns {names.replace(',', ', ')} are taken as a quaternion's w, x, y, z" in told(
        tmp_path, arm, f"{NO_QUATERNION},{names}"
    )
    last = np.column_stack([arm[:, : QUATERNION.start], np.roll(arm[:, QUATERNION], -1, axis=1)])
    told_of_last = told(tmp_path, last, f"{NO_QUATERNION},{names}")
    assert "gravity" in told_of_last or "orientation" in told_of_last


def test_an_xsens_dot_export_keeps_its_orientation_and_its_degrees_are_told(tmp_path: Path, arm: Array) -> None:
    header = "PacketCounter,SampleTimeFine,Quat_W,Quat_X,Quat_Y,Quat_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z"

    def export(factor: float) -> Path:
        rows = np.column_stack(
            [np.arange(len(arm)), 1e4 * np.arange(len(arm)), arm[:, QUATERNION], arm[:, ACC], factor * arm[:, GYR]]
        )
        return write(tmp_path / "dot.csv", rows.tolist(), header)

    log = load(export(1.0))
    assert np.allclose(np.abs((log.q_world_sensor * arm[:, QUATERNION]).sum(axis=1)), 1.0, atol=1e-3)  # type: ignore[operator]
    with pytest.raises(pt.InputError, match="degrees per second"):
        load(export(180 / np.pi))
    path = export(1.0)
    path.write_text(path.read_text().replace("Quat_W", "Quat_0"))
    with pytest.raises(pt.InputError, match=r"columns Quat_0, Quat_X.* look like an orientation"):
        load(path)


def settles(table: Array) -> Array:
    """A filter that starts 40° off and settles within some seconds."""
    angle = np.radians(40.0) * np.exp(-table[:, 0] / 1.5)
    turn = rotation_vector_to_quaternion(np.stack([angle, 0 * angle, 0 * angle], axis=1))
    table[:, QUATERNION] = multiply(turn, table[:, QUATERNION])
    return table


def in_long_bursts(table: Array) -> Array:
    table[:, 0] = 0.5 * np.floor(2 * table[:, 0] + 1e-9) + 0.002 * (np.arange(len(table)) % 50)
    return table


def fast(table: Array) -> Array:
    """So fast that the median reading is above 16 m/s²: an arm that shakes at 4 Hz."""
    shake = 20.0 * np.sin(2 * np.pi * 4.0 * table[:, 0])
    table[:, ACC] += rotate(conjugate(table[:, QUATERNION]), np.stack([shake, shake, 0 * shake], axis=1))
    return table


@pytest.mark.parametrize(
    "change",
    [
        settles,
        fast,
        in_long_bursts,
        lambda t: t[::10],
        changed(GYR, lambda g: g + np.array([0.0, np.radians(20.0), 0.0])),
    ],
    ids=["settles", "fast", "long bursts", "10 Hz", "gyroscope biased by 20°/s"],
)
def test_what_is_usual_is_not_refused(tmp_path: Path, arm: Array, change: Callable[[Array], Array]) -> None:
    for table in (arm.copy(), waving(20.0)):
        assert "refused" not in told(tmp_path, change(table))


def test_bursts_without_orientation_need_no_memory(tmp_path: Path, arm: Array) -> None:
    table = in_long_bursts(arm.copy())[:, :7]
    table[:, 0] = np.floor(2 * table[:, 0] + 1e-9) / 2 + 1e-6 * (np.arange(len(table)) % 50)
    said = told(tmp_path, table, NO_QUATERNION)
    assert "samples come in bursts" in said


def test_a_log_whose_line_ends_are_lost_is_named_at_once(tmp_path: Path, arm: Array) -> None:
    path = write(tmp_path / "imu.csv", np.repeat(arm, 4, axis=0).tolist())
    path.write_text(path.read_text().replace("\n", ","))
    with pytest.raises(
        pt.InputError, match=r"imu\.csv:1: header has \d+ columns, expected a few: are its line ends lost\?"
    ):
        load(path)


def test_real_recordings_pass(shared: Callable[[str], Path]) -> None:
    """BROAD: fast and slow, whole and in windows of 1 to 20 s; none is refused."""
    scipy_io = pytest.importorskip("scipy.io")
    for path in sorted(shared("data/imu/broad").glob("*.mat")):
        trial = scipy_io.loadmat(path)
        q = trial["opt_quat"]
        ok = np.isfinite(q).all(axis=1)
        time_s = np.arange(len(ok)) / float(trial["sampling_rate"].squeeze())
        for length, step in ((1e9, 1e9), (20.0, 20.0), (5.0, 13.0), (1.0, 7.0)):
            for start in np.arange(0.0, min(time_s[-1], 1e3 * step), min(step, 1e6)):
                use = ok & (time_s >= start) & (time_s < start + length)
                if use.sum() < 100:
                    continue
                log = ImuLog(
                    path=path, lines=np.arange(int(use.sum())), time_s=time_s[use], acc=trial["imu_acc"][use],
                    gyr=trial["imu_gyr"][use], q_world_sensor=q[use],
                )  # fmt: skip
                assert not [w for w in check(log).warnings if " between samples" not in w], (path.name, start, length)


def test_every_shared_export_still_passes(shared: Callable[[str], Path]) -> None:
    for path in sorted(shared("data/xsens").glob("MT_012005D6_009*.txt")):
        assert orient(check(read_imu(path))).warnings == ()


def lively() -> Array:
    """10 s of a wrist that shakes: time, acceleration, turn rate, orientation."""
    imu = ArmSimulation(pt.ArmScene(duration_s=10.0, pattern="gesture", period_s=0.7), seed=4).imu
    assert imu.gyr is not None
    return np.column_stack([imu.time_s, imu.acc, imu.gyr, imu.q_world_segment])


@pytest.mark.parametrize(
    ("columns", "end", "expected"),
    [
        (ACC, 19.6133, "the acceleration along"),
        (GYR, 4.3633, "the turn rate along"),
        (GYR, 2.1816, "the turn rate along"),
    ],
    ids=["2 g", "250 degrees a second", "125 degrees a second"],
)
def test_a_range_that_is_too_small_is_said(tmp_path: Path, columns: slice, end: float, expected: str) -> None:
    table = lively()
    assert "stands at" not in told(tmp_path, table)
    assert (np.abs(table[:, columns]) > end).sum() > 20
    table[:, columns] = table[:, columns].clip(-end, end)
    said = told(tmp_path, table)
    assert expected in said
    assert "stands at" in said
    assert "what was beyond it is lost" in said


FILLED = slice(700, 750)
