"""`simulate_body(folder, scene, seed)`: a recording folder of a person, as a user would bring one.

The motion has all the skeleton's channels, of which a tracker has some: its model is wrong in the way it is in reality.
"""

from __future__ import annotations

import dataclasses
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import cv2
import numpy as np

from pytracker._core import InputError
from pytracker.evidence.sightings import Progress
from pytracker.formats.amc import read_amc, write_amc
from pytracker.formats.asf import read_asf
from pytracker.formats.video_write import VideoWriter
from pytracker.output import whole_folder
from pytracker.recording.camera import Camera
from pytracker.recording.worn import ARM_SEGMENTS
from pytracker.rotation import Array
from pytracker.simulate.arm_script import MOVEMENTS, arm_script
from pytracker.simulate.body_senses import write_imu, write_keypoints
from pytracker.simulate.kinds import check_kind
from pytracker.simulate.person import Clothes, Painter
from pytracker.skeleton.average import average_skeleton
from pytracker.skeleton.skeleton import Skeleton

__all__ = ["BodyScene", "camera_before", "simulate_body"]

SIZE = (320, 240)
MOTION_RATE_HZ = 120.0
FIELD_M = 2.3
"""Width of what the camera sees at the person."""
WALL_BEHIND_M = 0.9
POINT_PAIRS = 35
"""As many as Li & Kulić fitted their projection to."""
POINT_NOISE_PX = 0.3
SECONDS_MOST = 600.0
MOVES = ("any", *MOVEMENTS)

CLOTHES = (
    Clothes((140, 85, 45), (45, 40, 38)),
    Clothes((60, 60, 150), (95, 80, 70)),
    Clothes((95, 105, 80), (40, 38, 36)),
    Clothes((120, 122, 128), (60, 45, 40)),
    Clothes((45, 45, 48), (110, 95, 85)),
    Clothes((190, 190, 195), (80, 60, 50)),
)


@dataclass(frozen=True, kw_only=True)
class BodyScene:
    """What is filmed. Raises `InputError` for what is out of range.

    Attributes:
        duration_s: length, s; a motion that is shorter ends the recording.
        frame_rate_hz: camera rate, Hz.
        height_m: the person's height, where the package's own skeleton is used, m.
        movement: of the built-in motion: `any` (arms go anywhere, each by itself), `waving`, `reaching`, `bending`,
            `crossing` (of the arms) or `meeting` (of the hands).
        pace_s: how often an arm changes its pose in it, s.
        turned_deg: how far the person is turned to their left in it.
        skeleton: an ASF to use instead; with `motion`.
        motion: an AMC at 120 Hz to use instead.
        first_frame: first frame of that motion, from 0.
        clothes: which of six sets of clothes; -1: by the seed.
        distance_m: camera to person, m.
        noise: standard deviation of the image noise, grey levels.
        hidden: (from, to) in s, when boards hide both forearms.
        keypoint_sd_px: a detector's keypoints are written too, off by so much; 0: none are.
        imus: segments that wear a sensor: `left_forearm`, `right_forearm`, `left_upper_arm`, `right_upper_arm`.
        imu_sd_deg: how far off their orientation is.
    """

    duration_s: float = 8.0
    frame_rate_hz: float = 30.0
    height_m: float = 1.75
    movement: str = "any"
    pace_s: float = 1.1
    turned_deg: float = 0.0
    skeleton: str = ""
    motion: str = ""
    first_frame: int = 0
    clothes: int = -1
    distance_m: float = 4.0
    noise: float = 3.0
    hidden: tuple[tuple[float, float], ...] = ()
    keypoint_sd_px: float = 0.0
    imus: tuple[str, ...] = ()
    imu_sd_deg: float = 3.0

    kind: ClassVar[str] = "body"

    def __post_init__(self) -> None:
        """Check kinds and ranges."""
        for field in dataclasses.fields(self):
            check_kind(field.name, getattr(self, field.name), field.default)
        finite = all(np.isfinite(x) for x in (self.duration_s, self.frame_rate_hz, self.height_m, self.pace_s))
        for name, is_good, expected in (
            ("duration_s", finite and 0 < self.duration_s <= SECONDS_MOST, f"above 0, at most {SECONDS_MOST:.0f} s"),
            ("frame_rate_hz", finite and 1 <= self.frame_rate_hz <= MOTION_RATE_HZ, "1 to 120 Hz"),
            ("height_m", finite and 0.5 <= self.height_m <= 2.5, "0.5 to 2.5 m"),
            ("pace_s", finite and self.pace_s > 0.1, "above 0.1 s"),
            ("movement", self.movement in MOVES, f"of: {', '.join(MOVES)}"),
            ("movement", self.movement == "any" or not self.motion, "any, of a motion that was captured"),
            ("turned_deg", -90 <= self.turned_deg <= 90, "-90° to 90°"),
            ("turned_deg", self.turned_deg == 0 or not self.motion, "0, of a motion that was captured"),
            ("motion", bool(self.motion) == bool(self.skeleton), "both a skeleton and a motion, or neither"),
            ("first_frame", self.first_frame >= 0, "0 or more"),
            ("clothes", -1 <= self.clothes < len(CLOTHES), f"-1 to {len(CLOTHES) - 1}"),
            ("distance_m", 1.5 <= self.distance_m <= 100, "1.5 to 100 m"),
            ("noise", 0 <= self.noise <= 255, "0 to 255"),
            ("keypoint_sd_px", 0 <= self.keypoint_sd_px <= 100, "0 to 100 px"),
            ("imus", set(self.imus) <= set(ARM_SEGMENTS), f"of: {', '.join(ARM_SEGMENTS)}"),
            ("imu_sd_deg", 0 <= self.imu_sd_deg <= 30, "0° to 30°"),
            ("hidden", all(start < end for start, end in self.hidden), "(from, to) with from before to, s"),
        ):
            if not is_good:
                raise InputError(f"{name} is {getattr(self, name)!r}, expected {expected}")


def simulate_body(
    folder: Path | str,
    scene: BodyScene | None = None,
    seed: int = 0,
    *,
    force: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write a simulated recording: `recording.toml`, video, background, point pairs, skeleton and truth.

    Returns the folder, which appears whole or not at all. Raises `InputError` where it exists, unless `force`.
    """
    scene = scene or BodyScene()
    rng = np.random.default_rng([seed, *b"body"])
    skeleton, poses = _motion(scene, rng)
    frame_time_s = np.arange(0.0, (len(poses) - 1) / MOTION_RATE_HZ, 1.0 / scene.frame_rate_hz)
    shown = poses[np.rint(frame_time_s * MOTION_RATE_HZ).astype(int)]
    root = skeleton.joints(shown)["root"]
    camera = camera_before(root, scene.distance_m)
    clothes = CLOTHES[scene.clothes if scene.clothes >= 0 else int(rng.integers(len(CLOTHES)))]
    painter = Painter(camera, SIZE, clothes, float(root[:, 2].min()) - WALL_BEHIND_M, scene.noise, rng)
    hidden = np.zeros(len(frame_time_s), dtype=bool)
    for start, end in scene.hidden:
        hidden |= (frame_time_s >= start) & (frame_time_s < end)
    with whole_folder(Path(folder), force=force, is_recording=True) as out:
        with VideoWriter(out / "video.mp4", "mp4v", scene.frame_rate_hz, SIZE) as writer:
            for k, image in enumerate(painter.frames(skeleton, shown, hidden)):
                writer.write(image)
                if progress is not None:
                    progress("render", k + 1)
        if not cv2.imwrite(str(out / "background.png"), painter.background()):
            raise OSError(f"{out / 'background.png'}: could not be written: is the disk full?")
        _write_points(out / "points.csv", skeleton, shown, camera, rng)
        write_amc(out / "motion.amc", skeleton, poses)
        if scene.keypoint_sd_px:
            write_keypoints(out / "keypoints.csv", skeleton, shown, camera, scene.keypoint_sd_px, SIZE, seed)
        for segment in scene.imus:
            sd = np.radians(scene.imu_sd_deg)
            write_imu(out / f"{segment}.csv", skeleton, poses, MOTION_RATE_HZ, segment, sd, seed)
        if scene.skeleton:
            shutil.copy(scene.skeleton, out / "subject.asf")
        whose = 'file = "subject.asf"' if scene.skeleton else f"height_m = {scene.height_m}"
        (out / "recording.toml").write_text(_toml(whose, scene), "utf-8")
    return Path(folder)


def _motion(scene: BodyScene, rng: np.random.Generator) -> tuple[Skeleton, Array]:
    """The skeleton and its poses at `MOTION_RATE_HZ`."""
    count = round(scene.duration_s * MOTION_RATE_HZ) + 1
    if scene.motion:
        skeleton = read_asf(scene.skeleton)
        poses = read_amc(scene.motion, skeleton).poses[scene.first_frame :][:count]
        if len(poses) < 2:
            raise InputError(f"{scene.motion}: has no two frames from {scene.first_frame} on, expected a motion")
        return skeleton, poses
    skeleton = average_skeleton(scene.height_m)
    time_s = np.arange(count) / MOTION_RATE_HZ
    # Hip joint to the floor, as the skeleton's legs are long.
    height = 0.53 * scene.height_m
    poses = arm_script(skeleton, time_s, height, scene.pace_s, rng, scene.movement, scene.turned_deg)
    return skeleton, poses


def camera_before(root: Array, distance_m: float) -> Camera:
    """A camera before somebody whose root is at `root` `(T, 3)`, m: level, looking along -z."""
    middle = np.median(root, axis=0)
    # The upper body in the middle of the picture.
    place = np.array([middle[0], middle[1] + 0.15, middle[2] + distance_m])
    rotation = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
    focal = SIZE[0] / FIELD_M * distance_m
    t = -np.array(rotation) @ place
    matrix = ((focal, 0.0, SIZE[0] / 2), (0.0, focal, SIZE[1] / 2), (0.0, 0.0, 1.0))
    return Camera(matrix=matrix, rotation=rotation, translation_m=(float(t[0]), float(t[1]), float(t[2])))


def _write_points(path: Path, skeleton: Skeleton, poses: Array, camera: Camera, rng: np.random.Generator) -> None:
    """Joints of some frames and where they are seen, as somebody who clicks on them would write them down."""
    joints = np.stack(list(skeleton.joints(poses).values()), axis=1)
    picked = joints[rng.integers(len(poses), size=POINT_PAIRS), rng.integers(joints.shape[1], size=POINT_PAIRS)]
    pixels = camera.project(picked) + POINT_NOISE_PX * rng.standard_normal((POINT_PAIRS, 2))
    table = np.column_stack([picked, pixels])
    np.savetxt(path, table, fmt="%.5f", delimiter=",", header="x_m,y_m,z_m,u,v", comments="")


def _toml(skeleton: str, scene: BodyScene) -> str:
    keypoints = 'keypoints = "keypoints.csv"\n' if scene.keypoint_sd_px else ""
    worn = "".join(
        f'\n[[imu]]\nfile = "{segment}.csv"\nsegment = "{segment}"\nheading_deg = 0.0\n'
        f"mount_sd_deg = {max(scene.imu_sd_deg, 0.5)}\n"
        for segment in scene.imus
    )
    return f"""schema = 1
kind = "body"

[[camera]]
video = "video.mp4"
background = "background.png"
points = "points.csv"
{keypoints}{worn}
[skeleton]
{skeleton}

[truth]
file = "motion.amc"
rate_hz = {MOTION_RATE_HZ}
"""
