"""Whether an IMU agrees with itself: what contradicts is refused, what is usual is not."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from test_formats_imu import HEADER, load, write

import pytracker as pt
from pytracker.formats.imu.read import read_imu
from pytracker.inertial.check import check
from pytracker.inertial.gravity import check_step
from pytracker.inertial.log import ImuLog
from pytracker.inertial.orientation import orient
from pytracker.rotation import Array, conjugate, multiply, rotate, rotation_vector_to_quaternion
from pytracker.simulate import ArmSimulation


def waving(seconds: float = 6.0, hz: float = 100.0) -> Array:
    """A sensor that turns to and fro about all three axes, with gravity: time, acceleration, turn rate, orientation."""
    time_s = np.arange(0.0, seconds, 1 / hz)
    rate = np.stack([3.0 * np.cos(3.0 * time_s), 2.0 * np.cos(4.1 * time_s), 2.5 * np.sin(2.3 * time_s)], axis=1)
    q = np.zeros((len(time_s), 4))
    q[0] = [1.0, 0.0, 0.0, 0.0]
    for k in range(1, len(q)):
        q[k] = multiply(q[k - 1], rotation_vector_to_quaternion(0.5 * (rate[k] + rate[k - 1]) / hz))
    noise = np.random.default_rng(0).normal(0, 0.05, (len(q), 3))
    return np.column_stack([time_s, rotate(conjugate(q), np.array([0.0, 0.0, 9.81])) + noise, rate, q])


GYR, QUATERNION = slice(4, 7), slice(7, 11)


@pytest.mark.parametrize(
    ("gyr", "hint"),
    [
        (np.rad2deg, r"the gyroscope does 0\.01\d+ times about x, .* is gyr in degrees per second\?"),
        (lambda g: g[:, [1, 0, 2]], r"about x, .* about y, expected 1: "),
        (
            lambda g: g * [1.0, -1.0, 1.0],
            r"-(1|0\.9\d+) times about y, expected 1: do their axes, signs or units differ\?",
        ),
        (lambda g: 0.3 * g, r"expected at least as much .* does the gyroscope stand still, or is it in other units"),
        (lambda g: 3.0 * g, r"0\.33\d* times about x, .* do their axes, signs or units differ\?"),
        (lambda g: 0.0 * g, r"imu\.csv:\d+: the orientation turns by .* rad in .* s and the gyroscope by 0, expected"),
        (lambda g: np.vstack([g[:350], 0.0 * g[350:]]), r"imu\.csv:\d+: the orientation turns by"),
    ],
)
def test_a_gyroscope_that_contradicts_the_orientation(tmp_path: Path, gyr: Callable[[Array], Array], hint: str) -> None:
    table = waving()
    assert load(write(tmp_path / "good.csv", table.tolist())).warnings == ()
    table[:, GYR] = gyr(table[:, GYR])
    with pytest.raises(pt.InputError, match=hint):
        load(write(tmp_path / "imu.csv", table.tolist()))


@pytest.mark.parametrize(
    ("turned", "by"),
    [
        (lambda t: np.where(t > 3.0, np.radians(60.0), 0.0), "(59|60)"),
        (lambda t: np.radians(40.0) * np.clip(t - 3.0, 0.0, 1.0), "3[0-9]"),
    ],
)
def test_an_orientation_that_turns_by_itself(tmp_path: Path, turned: Callable[[Array], Array], by: str) -> None:
    """A heading that is reset, or disturbed by iron: 18 and 8 cm off, all valid, and clock or shoulder were blamed."""
    table = waving()
    heading = np.outer(turned(table[:, 0]), [0.0, 0.0, 1.0])
    table[:, QUATERNION] = multiply(rotation_vector_to_quaternion(heading), table[:, QUATERNION])
    (said,) = load(write(tmp_path / "imu.csv", table.tolist())).warnings
    assert re.search(
        rf"imu\.csv:\d+: about 3\.\d s the orientation turns by {by}° that the gyroscope does not, expected", said
    )


@pytest.mark.parametrize(("late", "scale"), [(5, 1.0), (0, 1.03), (3, 0.98)])
def test_an_orientation_that_is_late_turns_with_its_gyroscope(late: int, scale: float, tmp_path: Path) -> None:
    table = waving(20.0)
    table[late:, QUATERNION] = table[: len(table) - late, QUATERNION].copy()
    table[:, GYR] *= scale
    assert not [words for words in load(write(tmp_path / "imu.csv", table.tolist())).warnings if "does not" in words]


def test_bursts_at_an_even_rate_are_put_back(tmp_path: Path) -> None:
    """As by Bluetooth: five samples at once, every twentieth of a second. Times of arrival made 7.2 cm of 1.5."""
    table, k = waving(), np.arange(600)
    table[:, 0] = 0.05 * (k // 5 + 1) + 0.001 * (k % 5)
    log = load(write(tmp_path / "imu.csv", table.tolist()))
    assert log.time_s - log.time_s[0] == pytest.approx(0.01 * k, abs=1e-3)
    assert (log.time_s <= table[:, 0] + 1e-9).all()
    assert "they are put at an even 100 Hz" in log.warnings[0]
    packets = np.column_stack([0.1 * (k // 10 + 1), waving()[:, 1:]])  # one stamp each
    of_rate = orient(check(read_imu(write(tmp_path / "packets.csv", packets.tolist()), rate_hz=100.0)))
    assert of_rate.time_s - of_rate.time_s[0] == pytest.approx(0.01 * k, abs=2e-3)
    trials = waving()
    trials[:, 0] += 20.0 * (k // 100)  # measured now and then
    assert load(write(tmp_path / "trials.csv", trials.tolist())).time_s == pytest.approx(trials[:, 0])
    beside = np.delete(table, slice(200, 320), axis=0)  # a pause
    log = load(write(tmp_path / "pause.csv", beside.tolist()))
    assert log.time_s - log.time_s[0] == pytest.approx(np.delete(0.01 * k, slice(200, 320)), abs=2e-3)
    lost = np.delete(table, np.flatnonzero((k % 7 == 0) & (k > 300)), axis=0)
    assert load(write(tmp_path / "lost.csv", lost.tolist())).time_s == pytest.approx(lost[:, 0])


@pytest.mark.parametrize("step_s", [1 / 64, 0.02])
def test_a_coarse_clock_is_put_even(step_s: float, tmp_path: Path) -> None:
    """As Windows' own, of 15.6 ms: the file was refused."""
    table = waving()
    steps = np.column_stack([step_s * np.floor(table[:, 0] / step_s + 1e-9), table[:, 1:]])
    log = load(write(tmp_path / "imu.csv", steps.tolist()))
    assert log.time_s == pytest.approx(table[:, 0], abs=0.012)
    assert np.diff(log.time_s) == pytest.approx(0.01, abs=1e-4)
    assert "they are put at an even 100 Hz" in log.warnings[0]


def test_a_row_that_is_written_twice_is_taken_once(tmp_path: Path) -> None:
    table = waving()
    log = load(write(tmp_path / "imu.csv", np.insert(table, 300, table[299], axis=0).tolist()))
    assert log.time_s == pytest.approx(table[:, 0])
    assert "imu.csv:302: 1 rows are written twice: each is taken once" in log.warnings[0]
    other = np.insert(table, 300, table[299], axis=0)
    other[300, 1] += 0.1
    with pytest.raises(pt.InputError, match=r"imu\.csv:302: time 2\.990000 s after 2\.990000 s, expected increasing"):
        load(write(tmp_path / "other.csv", other.tolist()).rename(tmp_path / "imu.csv"))


def test_a_clock_of_whole_seconds_is_early_by_what_it_cuts_off(tmp_path: Path) -> None:
    """Taken for times of arrival, all came a second early: 17.7 cm."""
    table = waving()
    log = load(write(tmp_path / "imu.csv", np.column_stack([np.floor(table[:, 0] + 0.3), table[:, 1:]]).tolist()))
    assert log.time_s == pytest.approx(table[:, 0], abs=0.011)
    assert "its times are in whole seconds, expected those at which samples were measured: they are" in log.warnings[0]


@pytest.mark.parametrize("lost", [slice(230, 260), slice(130, 270)])
def test_samples_lost_of_whole_seconds_move_no_other_second(lost: slice, tmp_path: Path) -> None:
    """Of 16 s half a second lost moved all others by as much: 9 cm, valid; a whole second lost, by two."""
    table = np.delete(waving(), lost, axis=0)
    log = load(write(tmp_path / "imu.csv", np.column_stack([np.floor(table[:, 0]), table[:, 1:]]).tolist()))
    second = np.floor(table[:, 0])
    kept = ~np.isin(second, [one for one in range(1, 5) if np.sum(second == one) < 100])
    assert log.time_s == pytest.approx(table[kept, 0], abs=0.011)
    assert re.search(r"without [12] of \d that have fewer than the usual 100 samples", log.warnings[0])


def test_a_clock_faster_than_any_sensor_is_refused(tmp_path: Path) -> None:
    """Seconds that were taken for microseconds."""
    table = waving()
    table[:, 0] *= 1e-6
    with pytest.raises(pt.InputError, match="samples are 1e-08 s apart on average, expected at least 5e-05 s"):
        load(write(tmp_path / "imu.csv", table.tolist()))


def paused(table: Array, seconds: float) -> Array:
    table[300:, 0] += seconds
    return table


def test_a_long_pause_is_a_gap_and_no_burst(tmp_path: Path) -> None:
    """It was called bursts, and a gyroscope was asked nothing then: degrees passed as radians, 3.8 cm for 1.5."""
    table = paused(waving(), 60.0)
    (said,) = load(write(tmp_path / "good.csv", table.tolist())).warnings
    assert "1 gap between samples, the longest 60.010 s at line 302 (2.990 s)" in said
    assert said.endswith("was the sensor started anew there? Its heading may be another from then on")
    table[:, GYR] = np.rad2deg(table[:, GYR])
    with pytest.raises(pt.InputError, match="is gyr in degrees per second"):
        load(write(tmp_path / "imu.csv", table.tolist()))


def test_an_orientation_is_computed_beside_a_long_pause_as_without(tmp_path: Path) -> None:
    names = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z"
    table = waving()[:, :7]
    steady = load(write(tmp_path / "steady.csv", table.tolist(), names))
    beside = load(write(tmp_path / "paused.csv", paused(table, 60.0).tolist(), names))
    assert steady.q_world_sensor is not None
    assert beside.q_world_sensor is not None
    assert "Over its longest gap, 60 s, the heading is taken to have stayed" in beside.warnings[-1]
    up = [rotate(conjugate(log.q_world_sensor), np.array([0.0, 0.0, 1.0])) for log in (steady, beside)]  # type: ignore[arg-type]
    assert np.degrees(np.linalg.norm(up[0] - up[1], axis=1)).max() < 12.0


@pytest.mark.parametrize("order", [(0, 1), (0, 0, 1, 1), (0, 1, 2)])
@pytest.mark.parametrize("columns", [slice(0, 11), slice(0, 7)], ids=["oriented", "without orientation"])
def test_several_sensors_in_one_file_are_refused(tmp_path: Path, order: tuple[int, ...], columns: slice) -> None:
    """Two of them loaded: 9 cm, all valid, and a doubt of the shoulder."""
    which = np.resize(order, 600)
    turns = [rotation_vector_to_quaternion(turn) for turn in np.radians([[0.0, 0, 0], [80.0, 0, 0], [0, 70.0, 0]])]
    table = waving()
    for k, turn in enumerate(turns):
        rows = which == k
        turned = np.broadcast_to(turn, (int(rows.sum()), 4))
        for vectors in (slice(1, 4), GYR):
            table[rows, vectors] = rotate(conjugate(turned), table[rows, vectors])
        table[rows, QUATERNION] = multiply(table[rows, QUATERNION], turned)
    names = ["time_s", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z", "q_w", "q_x", "q_y", "q_z"][columns]
    path = write(tmp_path / "imu.csv", table[:, columns].tolist(), ",".join(names))
    if columns.stop == 11:
        with pytest.raises(
            pt.InputError, match=rf"those of {len(set(order)) * 1 if len(order) < 4 else 4} sensors in turn\? Write"
        ):
            load(path)
    else:
        assert "sensors in turn, or does the arm tremble as fast?" in " ".join(check(read_imu(path)).warnings)


def test_a_part_in_g_is_named(tmp_path: Path) -> None:
    table = waving()
    table[450:, 1:4] /= 9.81
    with pytest.raises(
        pt.InputError, match=r"imu\.csv:402: for 2 s from here on .* looks like units of g, and elsewhere"
    ):
        load(write(tmp_path / "imu.csv", table.tolist()))


def test_an_orientation_that_stands_still(tmp_path: Path) -> None:
    table = waving()
    table[:, QUATERNION] = [1.0, 0, 0, 0]
    table[:, 1:4] = np.array([0.0, 0.0, 9.81]) + np.random.default_rng(1).normal(0, 0.02, (len(table), 3))
    with pytest.raises(pt.InputError, match="does the orientation stand still"):
        load(write(tmp_path / "imu.csv", table.tolist()))


def noisy(table: Array, degrees: float) -> Array:
    turn = np.random.default_rng(1).normal(0, np.deg2rad(degrees), (len(table), 3))
    table[:, QUATERNION] = multiply(table[:, QUATERNION], rotation_vector_to_quaternion(turn))
    return table


def at_rest(table: Array) -> Array:
    table[:, QUATERNION], table[:, 1:4] = [1.0, 0, 0, 0], [0.0, 0.0, 9.81]
    table[:, GYR] = np.random.default_rng(2).normal(0, 0.01, (len(table), 3))
    return noisy(table, 1.5)


def in_bursts(table: Array) -> Array:
    table[:, 0] = 0.1 * np.floor(10 * table[:, 0] + 1e-9) + 0.001 * (np.arange(len(table)) % 10)
    return table


def held(table: Array) -> Array:
    table[:, QUATERNION] = table[np.arange(len(table)) // 20 * 20, QUATERNION]
    return table


@pytest.mark.parametrize(
    "change",
    [
        lambda t: noisy(t, 1.5), at_rest, in_bursts, held,
        lambda t: t[::10], lambda t: np.vstack([t[:200], t[300:]]), lambda t: t[:40],
        lambda t: t * np.repeat([1.0, -1.0], [7, 4]),
    ],
    ids=["noisy", "at rest", "in bursts", "held", "10 Hz", "gap", "short", "negated"],
)  # fmt: skip
def test_what_is_usual_is_no_contradiction(tmp_path: Path, change: Callable[[Array], Array]) -> None:
    log = load(write(tmp_path / "imu.csv", change(waving()).tolist()))
    assert not [warning for warning in log.warnings if "gyroscope" in warning]


def test_a_gyroscope_of_another_scale_is_warned_of(tmp_path: Path) -> None:
    table = waving()
    table[:, GYR] *= 1.6
    (warning,) = load(write(tmp_path / "imu.csv", table.tolist())).warnings
    assert "as the gyroscope does 0.625 times about x" in warning.replace("0.624", "0.625")
    assert "does one of them lag, or have another scale?" in warning


def test_degrees_per_second_without_orientation(tmp_path: Path) -> None:
    table = waving()
    table[:, GYR] = np.rad2deg(table[:, GYR])
    with pytest.raises(
        pt.InputError, match=r"the mean acceleration is .* computed from the gyroscope: is gyr in rad/s"
    ):
        load(write(tmp_path / "imu.csv", table[:, :7].tolist(), "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z"))


@pytest.mark.parametrize(("axis", "is_refused"), [(0, True), (1, False)])
def test_all_signs_that_may_be_turned_are_named(axis: int, is_refused: bool) -> None:
    """Of an arm another's leaves gravity 6 % steadier, and was named alone; followed, all seemed well.

    Where gravity is not steadier by far it is a warning: of right slices of BROAD 3 of 169 were refused.
    """
    imu = ArmSimulation(pt.ArmScene(worn=True, pattern="gesture", duration_s=20.0), 101).imu
    assert imu.gyr is not None
    gyr = imu.gyr * np.where(np.arange(3) == axis, -1.0, 1.0)
    log = ImuLog(Path("imu.csv"), np.arange(len(gyr)), imu.time_s, acc=imu.acc, gyr=gyr)
    try:
        said = " ".join(orient(log).warnings)
        assert not is_refused
    except pt.InputError as error:
        said = str(error)
        assert is_refused
    assert f"its {'xyz'[axis]} has the other sign" in said
    assert " or " in said.split(" from gravity ")[1].split(";")[0]


def test_a_sensor_that_hangs_is_warned_of(tmp_path: Path) -> None:
    table = at_rest(waving())
    table[:, 1:4] = np.round(table[:, 1:4], 1)  # a coarse accelerometer at rest does not hang
    assert load(write(tmp_path / "imu.csv", table.tolist())).warnings == ()
    table[100:250, 1:7] = table[100, 1:7]
    (warning,) = load(write(tmp_path / "imu.csv", table.tolist())).warnings
    assert "imu.csv:102: every reading stays the same for 1.490 s, expected some noise" in warning


@pytest.mark.parametrize(("hz", "is_refused"), [(60.0, False), (30.0, True)])
def test_a_rate_that_is_told_too_low_is_asked_for(tmp_path: Path, hz: float, is_refused: bool) -> None:
    """Samples at 100 Hz whose times say another rate: all turns of the gyroscope are too large alike."""
    table = waving()
    table[:, 0] *= 100.0 / hz
    question = rf"Or were its samples taken at (99\.\d|100|101) Hz, where their times or the stated rate say {hz:g}\?"
    if is_refused:
        with pytest.raises(pt.InputError, match=question):
            load(write(tmp_path / "imu.csv", table.tolist()))
    else:
        assert re.search(question, " ".join(load(write(tmp_path / "imu.csv", table.tolist())).warnings))


@pytest.mark.parametrize("period_s", [2.0, 2.5])
def test_arms_that_go_round_are_in_step(period_s: float) -> None:
    """Of twelve that went round in 2.5 s seven were told that their acceleration is late."""
    for seed in range(30, 38):
        scene = pt.ArmScene(worn=True, period_s=period_s, duration_s=12.0)
        imu = ArmSimulation(scene, seed).recording().imus[0]
        log = ImuLog(
            Path("imu.csv"), np.arange(len(imu.time_s)), imu.time_s, imu.acc, q_world_sensor=imu.q_world_segment
        )
        assert check_step(log) == []


@pytest.mark.parametrize("samples", [-20, -10, 10, 20])
def test_acceleration_that_is_out_of_step_is_told(samples: int) -> None:
    table = waving(12.0)
    first, last = max(0, samples), len(table) + min(0, samples)
    acc, rest = table[first:last, 1:4], table[max(0, -samples) : len(table) - max(0, samples)]
    log = ImuLog(Path("imu.csv"), np.arange(len(acc)), rest[:, 0], acc, q_world_sensor=rest[:, QUATERNION])
    way = "later" if samples > 0 else "earlier"
    with pytest.raises(pt.InputError, match=rf"fits the orientation better 0\.{abs(samples) // 10}0 s {way}"):
        check_step(log)


def test_acceleration_without_gravity_is_not_taken_for_g(tmp_path: Path) -> None:
    """A lively wrist's has a median near 1: it was told to be in g, and the next error blamed the orientation."""
    imu = ArmSimulation(pt.ArmScene(duration_s=20.0, pattern="gesture", period_s=1.6), seed=4).imu
    up = np.broadcast_to([0.0, 0.0, 9.80665], imu.acc.shape)
    free = imu.acc - rotate(conjugate(imu.q_world_segment), up)
    free /= np.median(np.linalg.norm(free, axis=1))
    table = np.column_stack([imu.time_s, free, np.asarray(imu.gyr), imu.q_world_segment])
    with pytest.raises(pt.InputError, match="the raw reading with gravity, not the free acceleration"):
        load(write(tmp_path / "imu.csv", table.tolist(), HEADER))
