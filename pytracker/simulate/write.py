"""`simulate_arm(folder, scene, seed)`: a complete recording folder, as a user would bring one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pytracker.evidence.sightings import Progress
from pytracker.formats.video_write import VideoWriter
from pytracker.output import whole_folder
from pytracker.recording.camera import Camera
from pytracker.recording.recording import Imu
from pytracker.rotation import Array, rotate
from pytracker.simulate.arm import IMAGE_SIZE, TRUTH_RATE_HZ, ArmSimulation
from pytracker.simulate.arm_scene import ArmScene
from pytracker.simulate.scene import PATCH_HALF_M, render

__all__ = ["simulate_arm"]

IMU_FILES = ("imu.csv", "upper_arm.csv")


def simulate_arm(
    folder: Path | str,
    scene: ArmScene | None = None,
    seed: int = 0,
    *,
    force: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write a simulated recording: `recording.toml`, videos, IMU CSV and Qualisys truth. Returns the folder.

    The folder appears whole or not at all. Raises `InputError` where it exists, unless `force`.
    """
    simulation = ArmSimulation(scene, seed)
    with whole_folder(Path(folder), force=force, is_recording=True) as out:
        boxes, patches = [], []
        for index, camera in enumerate(simulation.true_cameras):
            _write_video(out / _video_name(index), simulation, index, progress)
            boxes.append(_first_box(simulation, camera))
            patches.append({joint: _box_of(simulation, camera, joint) for joint in simulation.joints_seen})
        for imu, name in zip(simulation.imus, IMU_FILES, strict=False):
            _write_imu(out / name, imu)
        _write_truth(out / "qualisys.tsv", simulation)
        (out / "recording.toml").write_text(_toml(simulation, boxes, patches), "utf-8")
    return Path(folder)


def _video_name(index: int) -> str:
    return "video.mp4" if index == 0 else f"video{index}.mp4"


def _write_video(path: Path, simulation: ArmSimulation, index: int, progress: Progress | None) -> None:
    """MPEG-4 at the camera's rate; where frames are dropped, Motion JPEG with the one before again, as webcams do."""
    rate = simulation.scene.frame_rate_hz
    # Each frame of Motion JPEG stands alone: a repeated frame is the same to the bit.
    codec = "MJPG" if simulation.scene.dropped_frames else "mp4v"
    slots = np.rint(simulation.frame_time_s * rate).astype(int)
    with VideoWriter(path, codec, rate, IMAGE_SIZE) as writer:
        for k, image in enumerate(render(simulation, index)):
            until = slots[k + 1] if k + 1 < len(slots) else slots[k] + 1
            for _ in range(writer.count, until):
                writer.write(image)
            if progress is not None:
                progress("render" if len(simulation.cameras) == 1 else f"render, camera {index}", writer.count)


def _first_box(simulation: ArmSimulation, camera: Camera) -> list[int]:
    """The box that a user would draw around the patch in the first frame."""
    time_s = simulation.frame_time_s[:1]
    return _around(camera, simulation.patch(time_s), simulation.q_world_sensor(time_s))


def _box_of(simulation: ArmSimulation, camera: Camera, joint: str) -> list[int]:
    """The same around the patch on a joint."""
    time_s = simulation.frame_time_s[:1]
    return _around(camera, simulation.landmark(joint, time_s), simulation.q_of_landmark(joint, time_s))


def _around(camera: Camera, centre: Array, q: Array) -> list[int]:
    turns = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * PATCH_HALF_M
    pixels = camera.project(centre + rotate(np.broadcast_to(q, (8, 4)), turns))
    low, high = np.floor(pixels.min(axis=0)).astype(int), np.ceil(pixels.max(axis=0)).astype(int)
    return [int(low[0]), int(low[1]), int(high[0] - low[0] + 1), int(high[1] - low[1] + 1)]


def _write_imu(path: Path, imu: Imu) -> None:
    assert imu.gyr is not None
    header = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q_w,q_x,q_y,q_z"
    rows = np.column_stack([imu.time_s, imu.acc, imu.gyr, imu.q_world_segment])
    np.savetxt(path, rows, fmt="%.6f", delimiter=",", header=header, comments="")


def _write_truth(path: Path, simulation: ArmSimulation) -> None:
    truth = simulation.truth
    names = list(truth.joints_m)
    header = [
        f"NO_OF_FRAMES\t{len(truth.time_s)}",
        "NO_OF_CAMERAS\t0",
        f"NO_OF_MARKERS\t{len(names)}",
        f"FREQUENCY\t{TRUTH_RATE_HZ:g}",
        "DESCRIPTION\tsimulated",
        "DATA_INCLUDED\t3D",
        "MARKER_NAMES\t" + "\t".join(names),
    ]
    rows = 1000 * np.column_stack([truth.joints_m[name] for name in names])
    np.savetxt(path, rows, fmt="%.3f", delimiter="\t", header="\n".join(header), comments="")


def _toml(simulation: ArmSimulation, boxes: list[list[int]], patches: list[dict[str, list[int]]]) -> str:
    arm, scene = simulation.arm, simulation.scene
    parts = ["schema = 1", 'kind = "arm"', ""]
    for index, (camera, box, others) in enumerate(zip(simulation.cameras, boxes, patches, strict=True)):
        parts += [
            "[[camera]]",
            f'video = "{_video_name(index)}"',
            f"matrix = {_list(camera.matrix)}",
            f"rotation = {_list(camera.rotation)}",
            f"translation_m = {_list(camera.translation_m)}",
            f"patch_box = {box}",
            f"patch_offset_m = {_list(camera.patch_offset_m)}",
        ]
        if others:
            parts.append("patches = { " + ", ".join(f"{joint} = {where}" for joint, where in others.items()) + " }")
        parts.append("")
    for imu, name in zip(simulation.imus, IMU_FILES, strict=False):
        parts += ["[[imu]]", f'file = "{name}"', f'segment = "{imu.segment}"']
        # Two sensors that were set to the same earth frame.
        parts += ["heading_deg = 0.0", ""] if imu is not simulation.imu else [""]
    parts += [
        "[arm]",
        'side = "right"',
        f"shoulder_m = {_list(scene.shoulder_m)}",
        f"upper_arm_m = {arm.upper_arm_m}",
        f"forearm_m = {arm.forearm_m}",
        f"wrist_start_m = {_list(arm.wrist_start_m)}",
        "",
        "[truth]",
        'file = "qualisys.tsv"',
        'markers = { shoulder = "shoulder", elbow = "elbow", wrist = "wrist" }',
        "",
    ]
    return "\n".join(parts)


def _list(values: object) -> str:
    return str(np.round(np.asarray(values, dtype=float), 9).tolist())
