"""What happens when one thing of a recording is wrong: told before, told after, harmless, or silent. `make faults`.

Sixty kinds of fault in IMU, video, camera, patch, arm and truth, at three strengths each, one at a time, on three
arms: a simulated circle, simulated gestures as bad as life, and a recording by another renderer where the shared data
are. Then right recordings, of which nothing may be said. Writes the table as Markdown.
"""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import pytracker as pt
from pytracker.evidence import sight
from pytracker.rotation import Array, multiply, rotation_vector_to_quaternion
from pytracker.simulate import ArmSimulation
from pytracker.tracking.doubts import unbelieved

SHARED = Path(__file__).parents[2] / "shared" / "recordings" / "arm-circle"
HARMLESS = 1.2
"""An error of so many times the right one's is no harm."""
SILENT_M, SILENT_COVERAGE = 0.10, 0.70
"""A fault that is not told must not be worse than this."""

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


def judged(folder: Path, sightings: pt.Sightings | None) -> tuple[str, float, float, str]:
    """What is said of a folder, its error, its least coverage, and the words."""
    try:
        recording = pt.load(folder)
        assert isinstance(recording, pt.ArmRecording)
        if recording.warnings:
            return "told before", np.nan, np.nan, recording.warnings[0]
        seen = sightings if sightings is not None else sight(recording)
        track = pt.track(recording, pt.Smooth(), 1, sightings=seen)
    except pt.InputError as error:
        return "told before", np.nan, np.nan, str(error)
    except pt.TrackingError as error:
        return "told after", np.nan, np.nan, str(error)
    said = (*unbelieved(track), *pt.doubts(track))
    wrist = pt.evaluate(track, recording.truth).joints["wrist"]
    return ("told after" if said else ""), wrist.rms_m, min(wrist.coverage), said[0] if said else ""


def recordings(scratch: Path) -> dict[str, Path]:
    """The arms that faults are tried on."""
    found = {
        "circle": pt.simulate_arm(scratch / "circle", pt.ArmScene(patch_offset_m=(0.0, 0.0, 0.0)), 41),
        "gestures, worn": pt.simulate_arm(
            scratch / "gesture", pt.ArmScene(pattern="gesture", period_s=2.5, worn=True), 42
        ),
    }
    if SHARED.exists():
        folder = shutil.copytree(SHARED, scratch / "shared")
        text = (folder / "recording.toml").read_text("utf-8")
        # The same keys as a simulated folder has.
        (folder / "recording.toml").write_text(
            text.replace("patch_box", "patch_offset_m = [0.0, 0.0, 0.0]\npatch_box", 1)
        )
        for path in folder.iterdir():
            path.chmod(0o644)
        found["another renderer"] = folder
    return found


Row = tuple[tuple[str, str, str], str, float, float, str]


def of_recording(name: str, folder: Path) -> tuple[float, list[Row]]:
    """Every fault on one recording; first the error of the right one."""
    right = pt.load(folder)
    assert isinstance(right, pt.ArmRecording)
    sightings = sight(right)
    verdict, error, _, words = judged(folder, sightings)
    if verdict:
        raise SystemExit(f"{name}: something is said of the right recording: {words}")
    rows = []
    for fault in faults():
        spoilt = folder.with_name(f"{folder.name}-spoilt")
        shutil.copytree(folder, spoilt)
        fault.change(spoilt)
        verdict, rms, coverage, words = judged(spoilt, sightings if fault.same_video else None)
        if not verdict:
            verdict = "harmless" if rms <= HARMLESS * error else "silent"
        rows.append(((fault.where, fault.kind, fault.strength), verdict, rms, coverage, words))
        shutil.rmtree(spoilt)
    return error, rows


def said_of_right(seed: int) -> str:
    """What is said of a right simulated recording; empty: nothing."""
    patterns = ("circle", "rectangle", "reach", "gesture")
    worn = seed % 2 == 0
    scene = pt.ArmScene(pattern=patterns[seed % 4], worn=worn, period_s=(2.0, 3.0, 4.0)[seed % 3])
    simulation = ArmSimulation(scene, seed)
    recording = simulation.recording()
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0 + seed % 3))
    try:
        track = pt.track(recording, pt.Smooth(), seed, sightings=sightings)
    except (pt.InputError, pt.TrackingError) as error:
        return f"seed {seed}: {error}"
    said = (*unbelieved(track), *pt.doubts(track))
    return f"seed {seed} ({scene.pattern}{', worn' if worn else ''}): {said[0]}" if said else ""


def main(out: Path) -> int:
    """Write the table; the number of silent faults that are worse than they may be, and of false alarms."""
    lines = [
        "# One thing wrong at a time",
        "",
        "Made by `make faults`, with the default method. *told before*: an error or a warning of the recording; "
        "*told after*: frames that are not valid, a track that is lost, or a doubt; *harmless*: nothing is said, and "
        "the wrist is off by at most 1.2 times the right recording's error; *silent*: nothing is said. Behind the "
        "verdict: 3-D RMS of the wrist in cm, least share of frames whose band holds the truth on an axis.",
        "",
    ]
    bad = unheld = 0
    with tempfile.TemporaryDirectory() as scratch, ProcessPoolExecutor() as pool:
        arms = recordings(Path(scratch))
        found = dict(zip(arms, pool.map(of_recording, arms, arms.values()), strict=True))
        lines += [
            "| where | what | strength | " + " | ".join(f"{n} ({100 * e:.1f} cm)" for n, (e, _) in found.items()) + " |"
        ]
        lines += ["|---|---|---|" + "---|" * len(found)]
        counts: dict[str, int] = {}
        for rows in zip(*(rows for _, rows in found.values()), strict=True):
            cells = []
            for _, verdict, rms, coverage, _ in rows:
                counts[verdict] = counts.get(verdict, 0) + 1
                is_bad = verdict == "silent" and (rms > SILENT_M or coverage < SILENT_COVERAGE)
                bad += is_bad
                unheld += verdict == "harmless" and coverage < SILENT_COVERAGE
                numbers = "" if np.isnan(rms) else f" ({100 * rms:.1f}, {100 * coverage:.0f} %)"
                cells.append(("**" if is_bad else "") + verdict + numbers + ("**" if is_bad else ""))
            lines.append(f"| {' | '.join(rows[0][0])} | {' | '.join(cells)} |")
        alarms = [words for words in pool.map(said_of_right, range(201, 261)) if words]
    lines += ["", "Together: " + ", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items())) + "."]
    lines += [f"Silent and worse than 10 cm, or with bands that hold the truth in under 70 %: {bad} (in bold)."]
    lines += [f"Harmless, but with bands that hold the truth in under 70 %: {unheld}."]
    lines += [f"Of 60 right recordings, half of them worn, something was said of {len(alarms)}."]
    lines += [f"- {words}" for words in alarms]
    out.write_text("\n".join(lines) + "\n", "utf-8")
    print("\n".join(lines[-4 - len(alarms) :]))
    return bad + len(alarms)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
