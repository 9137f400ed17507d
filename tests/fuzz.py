"""Mutated files and absurd calls: nothing but our own errors, no hang, no memory.

`make fuzz` runs many, the tests a few.

python tests/fuzz.py 1000000
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from conftest import arm_tracker, shown

import pytracker as pt
from pytracker.cli.settings import chosen_method
from pytracker.formats import read_amc, read_asf
from pytracker.formats.capture_csv import read_csv_markers
from pytracker.formats.imu.read import read_imu
from pytracker.formats.keypoints.read import read_keypoints
from pytracker.formats.points import read_points
from pytracker.formats.qualisys import read_qualisys
from pytracker.formats.storage import read_storage
from pytracker.formats.trc import read_trc
from pytracker.inertial.check import check
from pytracker.inertial.orientation import orient
from pytracker.recording.keypoints.spreads import with_spreads
from pytracker.recording.projection import fit_weak_perspective
from pytracker.recording.schema import read_recording_file
from pytracker.report.files.tables import read_track
from pytracker.setup.conventions import find_conventions
from pytracker.tracking import resample

OURS = (pt.InputError, pt.TrackingError)
LONGEST_S = 5.0
MOST_BYTES = 2**30
ODD = [
    b"nan", b"inf", b"-1e308", b"1e308", b"0", b"-0", b"1e-320", b"9" * 5000, b"", b"=1+1", b"\xff\xfe", b"\0", b"true",
    b"[" * 3000, b"{" * 3000, b"-", b".", b"1_0", b"0x10", b"\r", b"\n\n", b"\t", b",", b";", b'"', b"(-inf inf)",
]  # fmt: skip

Reader = Callable[[Path], object]

SMALL_ASF = """:version 1.10
:name x
:units
 mass 1.0
 length 0.45
 angle deg
:root
 order TX TY TZ RX RY RZ
 axis XYZ
 position 0 0 0
 orientation 0 0 0
:bonedata
 begin
 id 1
 name a
 direction 0 1 0
 length 2
 axis 0 0 10 XYZ
 dof rx ry
 limits (-90 90)
 (-inf inf)
 end
 begin
 id 2
 name b
 direction 1 0 0
 length 1
 axis 0 0 0 XYZ
 end
:hierarchy
 begin
 root a
 a b
 end
"""
SMALL_TRC = """PathFileType\t4\t(X/Y/Z)\ta.trc
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits
100\t100\t2\t1\tmm
Frame#\tTime\tA\t\t
\t\tX1\tY1\tZ1
1\t0.00\t1\t2\t3
2\t0.01\t1\t\t3
"""
SMALL_STO = """DataType=Vec3
nRows=2
endheader
time\tA\tB
0.00\t1,2,3\t4,5,6
0.01\t1,2,3\t4,,6
"""
SMALL_NEXUS = """Trajectories
100
,,A:E,,,A:W
Frame,Sub Frame,X,Y,Z,X,Y,Z
,,mm,mm,mm,mm,mm,mm
1,0,1,2,3,4,5,6
2,0,1,2,3,,,
"""
SMALL_MOTIVE = """Format Version,1.23,Export Frame Rate,100,Length Units,Meters
,Type,Rigid Body,Marker,Marker,Marker
,Name,H,W,W,W
,,Mean Marker Error,Position,Position,Position
Frame,Time (Seconds),,X,Y,Z
0,0.00,1,2,3,4
1,0.01,1,2,3,4
"""
PERSON = {"keypoints": [[5.0, 6.0]] * 17, "keypoint_scores": [0.9] * 17}
SMALL_STUDY = """schema = 1
seeds = 2
[[recording]]
name = "c"
simulate = "arm"
scene = { duration_s = 1.0 }
pixel_sd = 4.0
[[method]]
name = "layered"
grid = { particles = [5, 10] }
"""


SPORTS2D = (
    "PathFileType\t4\t(X/Y/Z)\tclip_px_person00.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\n"
    "30\t30\t2\t2\tm\t30\nFrame#\tTime\tLWrist\t\t\tRWrist\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    "0\t0.0\t100\t200\t0\t300\t200\t0\n1\t0.0333\t101\t200\t0\t\t\t\n"
)
DOT = (
    "sep=,\nDeviceTag:,Xsens DOT 1\nOutputRate:,100Hz\n\nPacketCounter,SampleTimeFine,Quat_W,Quat_X,Quat_Y,Quat_Z,"
    "FreeAcc_X,FreeAcc_Y,FreeAcc_Z,Gyr_X,Gyr_Y,Gyr_Z,Status\n"
    + "".join(f"{k},{10000 * k},1,0,0,0,0.1,0.2,0.0,1,2,3,0\n" for k in range(20))
)
DATES = "A. Logger\ntime,acc_x,acc_y,acc_z,qw,qx,qy,qz\n" + "".join(
    f"2024-05-01 12:00:00.{k:02d},0.1,0.2,9.8,1,0,0,0\n" for k in range(20)
)
PHYPHOX = (
    '"Time (s)";"Acceleration x (m/s^2)";"Acceleration y (m/s^2)";"Acceleration z (m/s^2)";"Gyroscope x (rad/s)";'
    '"Gyroscope y (rad/s)";"Gyroscope z (rad/s)"\n'
    + "".join(f"{k / 100:.2f};0,1;-0,2;9,{80 + k % 3};0,1;0,0;-0,{k % 9}\n".replace(".", ",") for k in range(40))
)


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """A few changes of a file: bytes, words, lines, its end."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        at, kind = int(rng.integers(0, max(1, len(out)))), int(rng.integers(0, 7))
        if kind == 0 and out:
            out[at % len(out)] = int(rng.integers(0, 256))
        elif kind == 1:
            del out[at : at + int(rng.integers(1, 40))]
        elif kind == 2:
            out[at:at] = ODD[int(rng.integers(len(ODD)))]
        elif kind == 3:
            end = at + 1
            while end < len(out) and out[end] not in b" \t,;\n=[]":
                end += 1
            out[at:end] = ODD[int(rng.integers(len(ODD)))]
        elif kind == 4:
            lines = bytes(out).split(b"\n")
            i, j = rng.integers(0, len(lines), 2)
            lines[i], lines[j] = lines[j], lines[i]
            out = bytearray(b"\n".join(lines))
        elif kind == 5:
            out = out[:at]
        else:
            out = bytearray(bytes(out).replace(b"\n", [b"\r\n", b"", b",", b"\r"][int(rng.integers(4))]))
    return bytes(out)


MVNX = (
    '<mvnx><subject><sensors><sensor label="RightForeArm"/></sensors><frames>'
    + "".join(
        f'<frame time="{k}" type="normal"><sensorFreeAcceleration>0 0 1</sensorFreeAcceleration>'
        "<sensorOrientation>1 0 0 0</sensorOrientation></frame>"
        for k in range(0, 200, 16)
    )
    + "</frames></subject></mvnx>"
)
MOTION = [f"{what}{axis}" for what in ("acceleration", "gravity", "rotationRate") for axis in "XYZ"]
WATCH = (
    "\n".join([",".join(["seconds_elapsed", *MOTION]), *(f"{k / 50},0,0,0,0,0,-1,0.1,0,0" for k in range(30))]) + "\n"
)
PHONE = "\n".join(["time,seconds_elapsed,z,y,x", *(f"{k}000,{k / 50},9.8,0.1,0" for k in range(30))]) + "\n"
SHIMMER = "\n".join([
    '"sep=,"', ",".join(f"S_{name}_CAL" for name in ("Timestamp_Unix", *(f"Accel_WR_{axis}" for axis in "XYZ"))),
    "ms,m/(s^2),m/(s^2),m/(s^2)", *(f"{20 * k},0,0,9.8" for k in range(30)),
]) + "\n"  # fmt: skip


def seeds(folder: Path) -> list[tuple[str, bytes, Reader]]:
    """A small file of every kind, and what reads it."""
    arm = pt.simulate_arm(folder / "arm", pt.ArmScene(duration_s=1.0), 1)
    body = pt.simulate_body(folder / "body", pt.BodyScene(duration_s=1.0), 1)
    imu = b"\n".join((arm / "imu.csv").read_bytes().split(b"\n")[:40])
    rows = [row.split(b",") for row in imu.split(b"\n")[1:]]
    names = b"PacketCounter Acc_X Acc_Y Acc_Z Gyr_X Gyr_Y Gyr_Z Quat_q0 Quat_q1 Quat_q2 Quat_q3".replace(b" ", b"\t")
    xsens = b"// Update Rate: 100.0Hz\n" + names + b"\n"
    xsens += b"\n".join(b"\t".join([b"%d" % k, *row[1:]]) for k, row in enumerate(rows))
    mt9 = b"\n".join(b"\t".join([*row[:7], b"1", b"0", b"0", b"20"]) for row in rows)
    recording = pt.load(arm)
    track = pt.write_report([pt.track(recording, pt.Layered(particles=20))], folder / "track", page=False)
    asf = SMALL_ASF.encode()
    (folder / "small.asf").write_bytes(asf)
    skeleton = read_asf(folder / "small.asf")
    amc = b":FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3 4 5 6\na 10 20\n2\nroot 1 2 3 4 5 7\na 10 21\n"
    truth = b"time_s,wrist_x_m,wrist_y_m,wrist_z_m\n0,1,2,3\n0.1,1,2,3\n0.2,1,,3\n"
    study = SMALL_STUDY.encode()

    (folder / "phone").mkdir()
    for name in ("Gyroscope", "Accelerometer"):
        (folder / "phone" / f"{name}.csv").write_text(PHONE)

    def keypoints(path: Path) -> object:
        return with_spreads(read_keypoints(path))

    def imu_log(path: Path) -> object:
        return orient(check(read_imu(path, rate_hz=None)))

    return [
        ("imu.csv", imu, imu_log),
        (
            "imu-without-orientation.csv",
            b"\n".join(b",".join(row.split(b",")[:7]) for row in imu.split(b"\n")),
            imu_log,
        ),
        ("MT_1.txt", xsens, imu_log),
        ("phyphox.csv", PHYPHOX.encode(), imu_log),
        ("suit.mvnx", MVNX.encode(), lambda path: check(read_imu(path))),
        ("WristMotion.csv", WATCH.encode(), imu_log),
        ("shimmer.csv", SHIMMER.encode(), imu_log),
        ("phone/Gyroscope.csv", PHONE.encode(), lambda path: imu_log(path.parent)),
        (
            "phone/Metadata.csv",
            b'platform,sensors,standardisation\nios,"a,b",false\n',
            lambda path: imu_log(path.parent),
        ),
        ("phone/Accelerometer.csv", PHONE.encode(), lambda path: imu_log(path.parent)),
        ("any-imu.csv", imu, lambda path: find_conventions(read_imu(path))),
        ("mapped.csv", imu, lambda path: read_imu(path, columns={"mag_x": "acc_x", "q_w": "q_z"})),
        ("MT9_cal_1.log", mt9, lambda path: check(read_imu(path))),
        ("truth.tsv", b"\n".join((arm / "qualisys.tsv").read_bytes().split(b"\n")[:30]), read_qualisys),
        ("truth.csv", truth, read_csv_markers),
        ("nexus.csv", SMALL_NEXUS.encode(), read_csv_markers),
        ("motive.csv", SMALL_MOTIVE.encode(), read_csv_markers),
        ("lists.json", json.dumps([[[0.1, 0.2, 0.0, 0.9]] * 33] * 3).encode(), keypoints),
        ("columns.json", json.dumps([{"keypoints": {"x": [5] * 17, "y": [6] * 17}}] * 3).encode(), keypoints),
        ("points.csv", (body / "points.csv").read_bytes(), lambda path: fit_weak_perspective(*read_points(path))),
        ("small.asf", asf, read_asf),
        ("small.amc", amc, lambda path: read_amc(path, skeleton)),
        ("arm/recording.toml", (arm / "recording.toml").read_bytes(), read_recording_file),
        ("body/recording.toml", (body / "recording.toml").read_bytes(), read_recording_file),
        ("study.toml", study, pt.read_study),
        ("truth.trc", SMALL_TRC.encode(), read_trc),
        ("truth.sto", SMALL_STO.encode(), read_storage),
        ("keypoints.trc", SPORTS2D.encode(), keypoints),
        ("dot.csv", DOT.encode(), imu_log),
        ("dates.csv", DATES.encode(), imu_log),
        ("keypoints.csv", b"left_wrist_x,left_wrist_y\n1,2\n3,4\n5,6\n", keypoints),
        (
            "coco.json",
            json.dumps([{"image_id": k, "keypoints": [5.0, 6.0, 0.9] * 17} for k in range(3)]).encode(),
            keypoints,
        ),
        ("mmpose.json", json.dumps({"instance_info": [{"frame_id": 0, "instances": [PERSON]}]}).encode(), keypoints),
        (
            "track.csv",
            b"\n".join((track / "track.csv").read_bytes().split(b"\n")[:6]),
            lambda path: read_track(path, recording.camera),
        ),
    ]


def number(rng: np.random.Generator) -> float:
    """Any number, often an odd one."""
    odd = [0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-320, 1e15, 2.0**31, 0.5]
    return float(odd[int(rng.integers(len(odd)))]) if rng.random() < 0.4 else float(rng.normal(0, 3))


def follow_anything(tracker: pt.Tracker, rng: np.random.Generator, numbers: Callable[..., Any]) -> None:
    """Samples and frames of an arm at any time; every estimate is a number."""
    for k in range(6):
        at = 0.01 * k if rng.random() < 0.8 else number(rng)
        tracker.observe(pt.Observation.inertial(at, numbers(3), [1, 0, 0, 0], numbers(3)))
        pixel = numbers(2) * 300 if rng.random() < 0.7 else None
        if (estimate := tracker.observe(pt.Observation.patch(0.01 * k, pixel))) is not None:
            assert all(np.isfinite(place.mean).all() for place in estimate.places.values())
        between = tracker.estimate(0.01 * k + abs(number(rng)))
        assert np.isfinite(between.places["wrist"].mean).all()


def call_of_core(rng: np.random.Generator, saved: list[bytes], body: pt.Tracker) -> None:
    """One absurd call of the compiled half."""

    def numbers(*shape: int) -> Any:
        return np.array([number(rng) for _ in range(int(np.prod(shape)))]).reshape(shape)

    kind = int(rng.integers(0, 7))
    if kind == 0:
        resample("residual", np.abs(numbers(int(rng.integers(0, 6)))), int(rng.integers(0, 1000)), 1)
    elif kind == 1:
        pt.Tracker.restore(mutated(saved[0], rng))
    elif kind == 2:
        pt.Tracker.restore(mutated(saved[1], rng))
    elif kind == 3:
        method = [
            pt.Layered(particles=20),
            pt.Joint(particles=20),
            pt.Ekf(bias=True),
            pt.Mixture(),
            pt.Inertial(),
            pt.Smooth(),
        ]
        arm = pt.Arm(shoulder_m=tuple(numbers(3)), upper_arm_m=0.3, forearm_m=0.25, wrist_start_m=tuple(numbers(3)))
        camera = pt.Camera(matrix=((700.0, 0.0, 320.0), (0.0, 700.0, 240.0), (0.0, 0.0, 1.0)), translation_m=(0, 0, 2))
        tracker = arm_tracker(arm, camera, method[int(rng.integers(len(method)))], 1)
        follow_anything(tracker, rng, numbers)
        for table in tracker.smoothed():
            assert np.isfinite(table["wrist"]).all()
    elif kind == 4:
        edges = rng.integers(0, 2, (int(rng.integers(1, 9)), int(rng.integers(1, 9)))).astype(np.uint8)
        region = np.abs(numbers(*edges.shape)).astype(np.float32), numbers(int(rng.integers(0, 4)), 2)
        blobs, people = numbers(int(rng.integers(0, 5)), 2) * 100, numbers(int(rng.integers(0, 3)), 9, 3) * 100
        seen = shown(edges, blobs, skin_region=region, foreground_region=region, keypoints=people)
        turned = numbers(4) if rng.random() < 0.5 else [1.0, 0.0, 0.0, 0.0]
        worn = pt.Observation.orientation(number(rng), "left_forearm", turned, number(rng), number(rng))
        body.observe(worn if rng.random() < 0.2 else pt.Observation.picture(number(rng), seen))
    elif kind == 5:
        body.pose(numbers(2, int(rng.integers(1, 13))))
        body.channels(numbers(1, int(rng.integers(1, 13))))
    else:
        names = ("pixel_sd", "accel_density", "bias", "particles", "layers", "corrections", "components")
        settings = [f"{names[int(rng.integers(len(names)))]}={json.dumps(number(rng))}"]
        chosen_method("arm", ("layered", "ekf", "mixture")[int(rng.integers(3))], None, settings)


def run(count: int, seed: int = 0, *, say: Callable[[str], None] = print) -> list[str]:
    """So many inputs; what was wrong with them, in words."""
    rng, wrong = np.random.default_rng(seed), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = seeds(folder)
        made = pt.Tracker(pt.load(folder / "body"), pt.Partitioned(particles=16, islands=2))
        arm = arm_tracker(
            pt.Arm(shoulder_m=(0.1, 0, 0.25), upper_arm_m=0.3, forearm_m=0.25, wrist_start_m=(0.2, 0.3, 0)),
            pt.Camera(matrix=((700, 0, 320), (0, 700, 240), (0, 0, 1)), translation_m=(0, 0, 2)), pt.Mixture(), 1,
        )  # fmt: skip
        saved = [arm.save(), made.save()]
        spoilt = folder / "spoilt"
        spoilt.mkdir()
        # The simulations that made the files are no input.
        at_first = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for k, what in enumerate(_inputs(rng, count)):
            kind, data, reader = files[what % len(files)]
            path = spoilt / Path(kind).name
            is_file, began = what >= 0, time.monotonic()
            content = mutated(data, rng) if is_file else b""
            try:
                with np.errstate(all="ignore"), warnings.catch_warnings():
                    warnings.simplefilter("ignore", RuntimeWarning)
                    if is_file:
                        path.write_bytes(content)
                        reader(path)
                    else:
                        call_of_core(rng, saved, made)
            except OURS:
                if not is_file:
                    made = pt.Tracker.restore(saved[1])
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                wrong.append(
                    f"input {k} ({kind if is_file else 'core'}): {type(error).__name__}: {error} {content[:300]!r}"
                )
            lasted = time.monotonic() - began
            if lasted > LONGEST_S:
                wrong.append(f"input {k} ({kind if is_file else 'core'}): {lasted:.1f} s {content[:300]!r}")
            if k % 50_000 == 49_999:
                say(f"{k + 1} inputs, {len(wrong)} wrong")
        grown = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - at_first)
        if grown > MOST_BYTES:
            wrong.append(f"memory grew by {grown / 2**20:.0f} MiB")
    return wrong


def _inputs(rng: np.random.Generator, count: int) -> Iterator[int]:
    """Which file each input is; a call of the core is -1."""
    for _ in range(count):
        yield int(rng.integers(0, 1000)) if rng.random() < 0.7 else -1


if __name__ == "__main__":
    total = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    found = run(total, int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    print("\n".join(found[:50]))
    print(f"{total - len(found)} passed, {len(found)} failed")
    sys.exit(bool(found))
