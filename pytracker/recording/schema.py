"""`recording.toml`, schema 1: every key, its type and default. Unknown keys are errors that name the nearest."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from pytracker._core import InputError
from pytracker.formats.imu.read import ImuFormat
from pytracker.formats.toml_file import Entry, FileName, Finite, Length, Positive, Whole, read_toml, validated
from pytracker.inertial.conventions import AccReads, AccUnit, Conventions, Direction, Earth, GyrUnit, Order

__all__ = [
    "FILES",
    "SCHEMA",
    "ArmEntry",
    "ArmFile",
    "BodyCameraEntry",
    "BodyFile",
    "CameraEntry",
    "ImuEntry",
    "InitialEntry",
    "SkeletonEntry",
    "TruthEntry",
    "read_recording_file",
]

Triple = tuple[Finite, Finite, Finite]
Spread = Annotated[float, Field(strict=True, ge=0, le=1)]
"""A standard deviation: m, s, or a share."""
Matrix = tuple[Triple, Triple, Triple]
Box = tuple[Whole, Whole, Whole, Whole]
"""x, y, width, height, px."""


Up = Literal["x", "-x", "y", "-y", "z", "-z"]
ImuColumn = Literal[
    "time_s", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z", "mag_x", "mag_y", "mag_z",
    "q_w", "q_x", "q_y", "q_z"
]  # fmt: skip

SCHEMA = 1
"""The newest recording schema that this version reads."""

Pixels = Annotated[int, Field(strict=True, ge=8, le=16384)]
"""Width or height of a picture."""


class CameraEntry(Entry):
    """`[[camera]]`: a video and the calibrated camera that took it."""

    video: FileName
    start_s: Finite = 0.0
    matrix: Matrix
    focal_sd: Spread | None = None
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)
    rotation: Matrix
    rotation_sd_deg: Annotated[float, Field(strict=True, ge=0, le=45)] | None = None
    translation_m: Triple
    distance_sd_m: Spread | None = None
    patch_box: Box | None = None
    patch_offset_m: Triple = (0.0, 0.0, 0.0)
    patch_offset_sd_m: Spread | None = None
    patches: dict[Literal["shoulder", "elbow"], Box] = Field(default_factory=dict)
    keypoints: FileName | None = None
    keypoint_model: str = "auto"


class ImuEntry(Entry):
    """`[[imu]]`: an inertial sensor's file and how it is worn."""

    file: FileName
    orientation_file: FileName | None = None
    format: ImuFormat = "auto"
    columns: dict[ImuColumn, str] = Field(default_factory=dict)
    rate_hz: Positive | None = None
    segment: str | None = None
    offset_s: Finite = 0.0
    offset_sd_s: Spread | None = None
    drift_ppm: Annotated[float, Field(strict=True, ge=-1e4, le=1e4)] = 0.0
    heading_deg: Finite | None = None
    mount: tuple[Finite, Finite, Finite, Finite] = (1.0, 0.0, 0.0, 0.0)
    mount_sd_deg: Annotated[float, Field(strict=True, gt=0, le=57)] | None = None
    acc_unit: AccUnit = "m/s2"
    acc_reads: AccReads = "force"
    gyr_unit: GyrUnit = "rad/s"
    quaternion: Order = "wxyz"
    quaternion_takes: Direction = "sensor to world"
    earth: Earth = "z up"

    @property
    def conventions(self) -> Conventions:
        """What the file's numbers stand for."""
        return Conventions(
            acc_unit=self.acc_unit,
            acc_reads=self.acc_reads,
            gyr_unit=self.gyr_unit,
            quaternion=self.quaternion,
            quaternion_takes=self.quaternion_takes,
            earth=self.earth,
        )


class ArmEntry(Entry):
    """`[arm]`: the subject's arm."""

    side: Literal["right", "left"] = "right"
    shoulder_m: Triple
    shoulder_sd_m: Spread | None = None
    upper_arm_m: Length
    upper_arm_sd_m: Spread | None = None
    forearm_m: Length
    forearm_sd_m: Spread | None = None
    wrist_start_m: Triple | None = None


class TruthEntry(Entry):
    """`[truth]`: measured joints, as points, or a body's as an AMC motion on the same skeleton (with its rate)."""

    file: FileName
    markers: dict[str, str | tuple[str, ...]] = Field(default_factory=dict)
    up: Up | None = None
    rate_hz: Positive | None = None
    offset_s: Finite = 0.0


class BodyCameraEntry(Entry):
    """`[[camera]]` of a body: a video or keypoints alone; a pinhole, weak perspective, or point pairs to fit it."""

    video: FileName | None = None
    size_px: tuple[Pixels, Pixels] | None = None
    rate_hz: Positive | None = None
    start_s: Finite = 0.0
    background: FileName | None = None
    keypoints: FileName | None = None
    keypoint_model: str = "auto"
    points: FileName | None = None
    affine: tuple[tuple[Finite, ...], tuple[Finite, ...]] | None = None
    matrix: Matrix | None = None
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)
    rotation: Matrix | None = None
    translation_m: Triple | None = None
    focal_sd: Spread | None = None


class SkeletonEntry(Entry):
    """`[skeleton]`: the subject's Acclaim skeleton, or the package's own average one, scaled."""

    file: FileName | None = None
    height_m: Annotated[float, Field(strict=True, ge=0.5, le=2.5)] | None = None


class InitialEntry(Entry):
    """`[initial]`: the pose at the first frame: angles by file, or the truth's own at one of its frames.

    `distance_sd_m` is how well it tells how far off the person is.
    """

    angles: FileName | None = None
    frame: Annotated[int, Field(strict=True, ge=0)] | None = None
    distance_sd_m: Positive | None = None


class BodyFile(Entry):
    """The whole file of a body."""

    schema_: Annotated[Literal[1], Field(alias="schema")]
    kind: Literal["body"]
    camera: Annotated[tuple[BodyCameraEntry, ...], Field(min_length=1, max_length=1)]
    imu: Annotated[tuple[ImuEntry, ...], Field(max_length=4)] = ()
    skeleton: SkeletonEntry
    initial: InitialEntry | None = None
    truth: TruthEntry | None = None


class ArmFile(Entry):
    """The whole file of an arm."""

    schema_: Annotated[Literal[1], Field(alias="schema")]
    kind: Literal["arm"]
    camera: Annotated[tuple[CameraEntry, ...], Field(min_length=1)]
    imu: Annotated[tuple[ImuEntry, ...], Field(min_length=1, max_length=2)]
    arm: ArmEntry
    truth: TruthEntry | None = None


FILES: Mapping[str, type[ArmFile | BodyFile]] = {"arm": ArmFile, "body": BodyFile}
"""By kind of recording."""


def read_recording_file(path: Path) -> ArmFile | BodyFile:
    """Read and validate. Raises `InputError` naming every fault: key, value, expectation."""
    if not path.is_file():
        where = path.parent
        what = "is no folder" if not where.is_dir() else "holds no recording.toml"
        raise InputError(f"{where}: {what}, expected a folder with recording.toml")
    data = read_toml(path, SCHEMA)
    kind: object = data.get("kind")
    if not isinstance(kind, str) or kind not in FILES:
        raise InputError(f"{path}: kind is {kind!r}, expected {' or '.join(map(repr, FILES))}")
    return validated(path, data, FILES[kind])
