"""Sixty-one kinds of fault that an arm's recording may have, at three strengths: each changes a copy of its folder."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pytracker.rotation import Array, multiply, rotation_vector_to_quaternion

ACC, GYR, QUATERNION = slice(1, 4), slice(4, 7), slice(7, 11)
Change = Callable[[Path], None]


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong, at one strength."""

    where: str
    kind: str
    strength: str
    change: Change
    same_video: bool = True


def table(change: Callable[[Array, np.random.Generator], Array]) -> Change:
    """Change the table of the IMU: time, acceleration, turn rate, orientation."""

    def apply(folder: Path) -> None:
        path = folder / "imu.csv"
        header, *lines = path.read_text().splitlines()
        names = header.split(",")
        wanted = ["time_s", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z", "q_w", "q_x", "q_y", "q_z"]
        rows = np.array([[float(line.split(",")[names.index(name)]) for name in wanted] for line in lines])
        np.savetxt(path, change(rows, np.random.default_rng(8)), "%.6f", ",", header=",".join(wanted), comments="")

    return apply


def on(columns: slice, change: Callable[[Array, np.random.Generator], Array]) -> Change:
    def apply(rows: Array, rng: np.random.Generator) -> Array:
        rows[:, columns] = change(rows[:, columns], rng)
        return rows

    return table(apply)


def turned(degrees: float, axis: int, *, sensor: bool = False) -> Change:
    turn = rotation_vector_to_quaternion(np.radians(degrees) * np.eye(3)[axis])

    def apply(q: Array, _: np.random.Generator) -> Array:
        by = np.broadcast_to(turn, q.shape)
        return multiply(q, by) if sensor else multiply(by, q)

    return on(QUATERNION, apply)


def entry(key: str, change: Callable[[Array], Array]) -> Change:
    """Change the numbers of a key of recording.toml."""

    def apply(folder: Path) -> None:
        path = folder / "recording.toml"
        text = path.read_text("utf-8")
        found = re.search(rf"(?m)^{key} = (.*)$", text)
        assert found is not None, key
        value = np.array(eval(found[1], {"__builtins__": {}}), dtype=float)  # noqa: S307 - numbers that we wrote
        new = np.asarray(change(value))
        words = str(new.astype(int).tolist() if key == "patch_box" else new.tolist())
        path.write_text(text.replace(found[0], f"{key} = {words}"), "utf-8")

    return apply


def focal(factor: float) -> Change:
    return entry("matrix", lambda m: m * np.array([[factor, 1, 1], [1, factor, 1], [1, 1, 1]]))


def camera_turned(degrees: float, axis: int) -> Change:
    q = rotation_vector_to_quaternion(np.radians(degrees) * np.eye(3)[axis])
    w, x, y, z = q
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip

    def apply(folder: Path) -> None:
        entry("rotation", lambda rotation: turn @ rotation)(folder)
        entry("translation_m", lambda translation: turn @ translation)(folder)

    return apply


def imu_key(line: str) -> Change:
    def apply(folder: Path) -> None:
        path = folder / "recording.toml"
        path.write_text(path.read_text("utf-8").replace('file = "imu.csv"', f'file = "imu.csv"\n{line}'), "utf-8")

    return apply


def frozen(seconds: float) -> Change:
    def apply(rows: Array, _: np.random.Generator) -> Array:
        inside = (rows[:, 0] > 5.0) & (rows[:, 0] < 5.0 + seconds)
        rows[inside, 4] = rows[np.argmax(inside), 4]
        return rows

    return table(apply)


def late(seconds: float) -> Change:
    def apply(rows: Array, _: np.random.Generator) -> Array:
        then = np.stack([np.interp(rows[:, 0] - seconds, rows[:, 0], rows[:, k]) for k in (1, 2, 3)], axis=1)
        rows[:, ACC] = then
        return rows

    return table(apply)


def cell(value: float) -> Change:
    def apply(rows: Array, _: np.random.Generator) -> Array:
        rows[len(rows) // 2, 1] = value
        return rows

    return table(apply)


def in_ticks(a_second: float) -> Change:
    """A clock of so many ticks a second that does not say it."""

    def apply(folder: Path) -> None:
        path = folder / "imu.csv"
        header, *lines = path.read_text().splitlines()
        at = header.split(",").index("time_s")
        rows = [line.split(",") for line in lines]
        for row in rows:
            row[at] = str(round(a_second * float(row[at])))
        text = "\n".join([header.replace("time_s", "timestamp"), *(",".join(row) for row in rows)])
        path.write_text(text + "\n")

    return apply


def gap(seconds: float) -> Change:
    return table(lambda rows, _: rows[(rows[:, 0] < 5.0) | (rows[:, 0] > 5.0 + seconds)])


def cut(share: float) -> Change:
    def apply(folder: Path) -> None:
        path = folder / "video.mp4"
        whole = path.read_bytes()
        path.write_bytes(whole[: int(len(whole) * (1 - share))])

    return apply


def truth_cell(metres: float) -> Change:
    def apply(folder: Path) -> None:
        path = folder / "qualisys.tsv"
        lines = path.read_text().splitlines()
        row = len(lines) // 2
        cells = lines[row].split("\t")
        cells[-3] = f"{1000 * metres:.3f}"
        lines[row] = "\t".join(cells)
        path.write_text("\n".join(lines) + "\n")

    return apply


def columns_swapped(of: slice, x: float) -> Change:
    """Axes x and y, y and z, or z and x of a sensor exchanged."""
    a = int(x)
    order = [0, 1, 2]
    order[a], order[(a + 1) % 3] = order[(a + 1) % 3], order[a]
    return on(of, lambda values, _: values[:, order])


def clipped(at: float) -> Change:
    return on(ACC, lambda a, _: np.clip(a, -at, at))


def thinned(share: float) -> Change:
    """So many samples are lost, anywhere."""
    return table(lambda rows, rng: rows[np.sort(rng.permutation(len(rows))[: int(len(rows) * (1 - share))])])


def stretched(ppm: float) -> Change:
    def apply(rows: Array, _: np.random.Generator) -> Array:
        rows[:, 0] = rows[0, 0] + (rows[:, 0] - rows[0, 0]) * (1 + 1e-6 * ppm)
        return rows

    return table(apply)


def jittered(seconds: float) -> Change:
    def apply(rows: Array, rng: np.random.Generator) -> Array:
        rows[:, 0] = np.sort(rows[:, 0] + rng.uniform(-seconds, seconds, len(rows)))
        return rows

    return table(apply)


def drifting(degrees_per_minute: float) -> Change:
    def apply(rows: Array, _: np.random.Generator) -> Array:
        turn = np.radians(degrees_per_minute) / 60 * (rows[:, 0] - rows[0, 0])
        by = rotation_vector_to_quaternion(turn[:, None] * np.array([0.0, 0.0, 1.0]))
        rows[:, QUATERNION] = multiply(by, rows[:, QUATERNION])
        return rows

    return table(apply)


def orientation_late(seconds: float) -> Change:
    def apply(rows: Array, _: np.random.Generator) -> Array:
        q = np.stack([np.interp(rows[:, 0] - seconds, rows[:, 0], column) for column in rows[:, QUATERNION].T], axis=1)
        rows[:, QUATERNION] = q / np.linalg.norm(q, axis=1, keepdims=True)
        return rows

    return table(apply)


def truth_moved(metres: float) -> Change:
    """The truth's frame lies beside the world's."""

    def apply(folder: Path) -> None:
        path = folder / "qualisys.tsv"
        lines = path.read_text().splitlines()
        first = next(k for k, line in enumerate(lines) if line[:1].isdigit() or line[:1] == "-")
        moved = []
        for line in lines[first:]:
            cells = line.split("\t")
            start = len(cells) - 9
            for k in range(start, len(cells), 3):
                cells[k] = f"{float(cells[k]) + 1000 * metres:.3f}"
            moved.append("\t".join(cells))
        path.write_text("\n".join([*lines[:first], *moved]) + "\n")

    return apply


def shifted(axis: int, metres: float) -> Change:
    """The camera, beside or above its place."""
    return entry("translation_m", lambda t: t + metres * np.eye(3)[axis])


def arms(upper: float, fore: float) -> Change:
    def apply(folder: Path) -> None:
        entry("upper_arm_m", lambda v: v * upper)(folder)
        entry("forearm_m", lambda v: v * fore)(folder)

    return apply


def more_faults() -> Iterator[tuple[str, str, Callable[[float], Change], tuple[float, ...]]]:
    """As many again: other axes, clocks, lost and clipped samples, several at once."""
    yield "IMU", "accelerometer axes exchanged", lambda x: columns_swapped(ACC, x), (0, 1, 2)
    yield "IMU", "gyroscope axes exchanged", lambda x: columns_swapped(GYR, x), (0, 1, 2)
    yield "IMU", "gyroscope axis flipped", lambda x: on(GYR, lambda g, _: g * (1 - 2 * np.eye(3)[int(x)])), (0, 1, 2)
    yield "IMU", "accelerometer clipped at, m/s²", clipped, (8, 12, 20)
    yield (
        "IMU",
        "accelerometer biased along z, m/s²",
        lambda x: on(ACC, lambda a, _: a + np.array([0, 0, x])),
        (0.3, 1, 3),
    )
    yield (
        "IMU",
        "accelerometer along y scaled by",
        lambda x: on(ACC, lambda a, _: a * np.array([1, x, 1])),
        (0.9, 1.1, 1.5),
    )
    yield "IMU", "accelerometer in steps of, m/s²", lambda x: on(ACC, lambda a, _: np.round(a / x) * x), (0.05, 0.3, 2)
    yield "IMU", "gravity taken off, share", lambda x: on(ACC, lambda a, _: a * (1 - x)), (0.2, 0.5, 0.9)
    yield "IMU", "in units of g, times", lambda x: on(ACC, lambda a, _: a / 9.81 * x), (1, 1.02, 0.98)
    yield "IMU", "gyroscope biased, rad/s", lambda x: on(GYR, lambda g, _: g + x), (0.02, 0.2, 1)
    yield "IMU", "gyroscope silent, times", lambda x: on(GYR, lambda g, _: g * x), (0, 0.01, 0.1)
    yield "IMU", "samples lost, share", thinned, (0.05, 0.3, 0.7)
    yield "IMU", "clock too fast, ppm", stretched, (100, 1000, 10000)
    yield "IMU", "time stamps jitter, s", jittered, (0.002, 0.01, 0.05)
    yield "IMU", "heading drifts, ° a minute", drifting, (2, 15, 60)
    yield "IMU", "orientation late, s", orientation_late, (0.03, 0.1, 0.3)
    yield "IMU", "orientation tilted about y, °", lambda x: turned(x, 1), (3, 10, 20)
    yield "IMU", "heading, ° the other way", lambda x: turned(-x, 2), (7, 20, 90)
    yield "IMU", "mount turned about z, °", lambda x: turned(x, 2, sensor=True), (5, 15, 90)
    yield "IMU", "quaternion rolled by", lambda x: on(QUATERNION, lambda q, _: np.roll(q, int(x), axis=1)), (1, 2, 3)
    yield (
        "IMU",
        "quaternion conjugated, axis",
        lambda x: on(QUATERNION, lambda q, _: q * (1 - 2 * np.eye(4)[int(x)])),
        (1, 2, 3),
    )
    yield "IMU", "clock in ticks, a second", in_ticks, (1e4, 1e6, 1e7)
    yield "IMU", "early, s", lambda x: imu_key(f"offset_s = {-x}"), (0.05, 0.3, 1.0)
    yield "camera", "aside, m", lambda x: shifted(0, x), (0.02, 0.05, 0.2)
    yield "camera", "above, m", lambda x: shifted(1, x), (0.02, 0.05, 0.2)
    yield "camera", "nearer, m", lambda x: shifted(2, -x), (0.05, 0.2, 0.5)
    yield "camera", "half a turn and, °", lambda x: camera_turned(180 + x, 2), (0, 2, 5)
    yield "arm", "both lengths times", lambda x: arms(x, x), (0.95, 1.1, 1.2)
    yield "arm", "upper arm shorter, forearm longer, by", lambda x: arms(1 - x, 1 + x), (0.05, 0.1, 0.2)
    yield (
        "arm",
        "shoulder along z, m",
        lambda x: entry("shoulder_m", lambda v: v + np.array([0, 0, x])),
        (0.05, 0.1, 0.25),
    )
    yield "truth", "beside the world, m", truth_moved, (0.02, 0.1, 0.5)


def faults() -> Iterator[Fault]:
    """All of them."""

    def each(
        where: str, kind: str, make: Callable[[float], Change], values: tuple[float, ...], **more: bool
    ) -> Iterator[Fault]:
        for value in values:
            yield Fault(where, kind, f"{value:g}", make(value), **more)

    yield from each("IMU", "accelerometer scaled by", lambda x: on(ACC, lambda a, _: x * a), (0.9, 1.05, 1.1))
    yield from each(
        "IMU", "accelerometer biased, m/s²", lambda x: on(ACC, lambda a, _: a + np.array([x, 0, 0])), (0.3, 1, 3)
    )
    yield from each(
        "IMU", "accelerometer axis flipped", lambda x: on(ACC, lambda a, _: a * (1 - 2 * np.eye(3)[int(x)])), (0, 1, 2)
    )
    yield from each(
        "IMU", "accelerometer noise, m/s²", lambda x: on(ACC, lambda a, g: a + g.normal(0, x, a.shape)), (0.2, 1, 3)
    )
    yield from each("IMU", "acceleration late, s", late, (0.05, 0.2, 0.4))
    yield from each("IMU", "one reading, m/s²", cell, (50, -200, 1000))
    yield from each("IMU", "gyroscope times", lambda x: on(GYR, lambda g, _: x * g), (0.5, 2, 57.3))
    yield from each(
        "IMU", "gyroscope noise, rad/s", lambda x: on(GYR, lambda g, r: g + r.normal(0, x, g.shape)), (0.1, 0.5, 2)
    )
    yield from each("IMU", "gyroscope axis frozen, s", frozen, (0.5, 2, 5))
    yield from each("IMU", "orientation tilted, °", lambda x: turned(x, 0), (3, 10, 20))
    yield from each("IMU", "heading, °", lambda x: turned(x, 2), (7, 20, 90))
    yield from each("IMU", "clock, s", lambda x: imu_key(f"offset_s = {x}"), (0.05, 0.3, 1.0))
    yield from each("IMU", "mount turned about y, °", lambda x: turned(x, 1, sensor=True), (7, 25, 90))
    yield from each("IMU", "mount turned about x, °", lambda x: turned(x, 0, sensor=True), (5, 15, 90))
    yield from each("IMU", "silent, s", gap, (0.2, 1, 3))
    yield from each("video", "cut short by a share of", cut, (0.03, 0.06, 0.1))
    yield from each("camera", "focal length times", focal, (0.95, 1.1, 1.3))
    yield from each("camera", "pitched, °", lambda x: camera_turned(x, 0), (1, 2, 5))
    yield from each("camera", "panned, °", lambda x: camera_turned(x, 1), (1, 2, 5))
    yield from each("camera", "rolled, °", lambda x: camera_turned(x, 2), (2, 5, 15))
    yield from each(
        "camera", "farther, m", lambda x: entry("translation_m", lambda t: t + np.array([0, 0, x])), (0.05, 0.2, 0.5)
    )
    yield from each(
        "camera",
        "centre of the picture, px",
        lambda x: entry("matrix", lambda m: m + x * np.array([[0, 0, 1], [0] * 3, [0] * 3])),
        (10, 30, 80),
    )
    yield from each(
        "patch",
        "box beside the patch, px",
        lambda x: entry("patch_box", lambda b: b + np.array([x, 0, 0, 0])),
        (6, 15, 30),
        same_video=False,
    )
    yield from each(
        "patch", "offset, m", lambda x: entry("patch_offset_m", lambda o: o + np.array([x, 0, 0])), (0.01, 0.03, 0.06)
    )
    yield from each("arm", "upper arm times", lambda x: entry("upper_arm_m", lambda v: v * x), (0.95, 1.1, 1.2))
    yield from each("arm", "forearm times", lambda x: entry("forearm_m", lambda v: v * x), (0.95, 1.1, 1.2))
    yield from each(
        "arm",
        "shoulder along x, m",
        lambda x: entry("shoulder_m", lambda v: v + np.array([x, 0, 0])),
        (0.05, 0.1, 0.25),
    )
    yield from each(
        "arm",
        "shoulder along y, m",
        lambda x: entry("shoulder_m", lambda v: v + np.array([0, x, 0])),
        (0.05, 0.1, 0.25),
    )
    yield from each(
        "arm",
        "first wrist along y, m",
        lambda x: entry("wrist_start_m", lambda v: v + np.array([0, x, 0])),
        (0.03, 0.08, 0.2),
    )
    yield from each("truth", "one cell, m", truth_cell, (3, 30, 1000))
    for where, kind, make, values in more_faults():
        yield from each(where, kind, make, values)
