from typing import Any, Self, final

import numpy as np
from numpy.typing import NDArray

from pytracker.body_methods import BodyMethod
from pytracker.evidence.silhouette import BodyEvidence
from pytracker.joint_track import Track
from pytracker.methods import ArmMethod
from pytracker.recording import Arm, Camera, WeakPerspective
from pytracker.skeleton import Bone, Part

__all__ = [
    "ARM_DOUBTS",
    "KEYPOINTS",
    "KEY_JOINTS",
    "ArmTracker",
    "BodyEstimate",
    "BodyTracker",
    "Estimate",
    "InputError",
    "LayerRecord",
    "Skeleton",
    "TrackingError",
    "__version__",
    "check_camera",
    "missed_edges",
    "resample",
]

__version__: str
ARM_DOUBTS: tuple[str, ...]
KEY_JOINTS: tuple[str, ...]
KEYPOINTS: tuple[str, ...]

class InputError(ValueError): ...

class TrackingError(RuntimeError):
    track: Track

@final
class Estimate:
    @property
    def time_s(self) -> float: ...
    @property
    def wrist(self) -> NDArray[np.float64]: ...
    @property
    def wrist_mode(self) -> NDArray[np.float64]: ...
    @property
    def wrist_sd(self) -> NDArray[np.float64]: ...
    @property
    def wrist_lo(self) -> NDArray[np.float64]: ...
    @property
    def wrist_hi(self) -> NDArray[np.float64]: ...
    @property
    def elbow(self) -> NDArray[np.float64]: ...
    @property
    def mean(self) -> NDArray[np.float64]: ...
    @property
    def covariance(self) -> NDArray[np.float64]: ...
    @property
    def ess(self) -> float | None: ...
    @property
    def log_evidence(self) -> float | None: ...
    @property
    def doubt(self) -> str: ...

@final
class LayerRecord:
    @property
    def layer(self) -> int: ...
    @property
    def time_s(self) -> float: ...
    @property
    def predicted(self) -> NDArray[np.float64]: ...
    @property
    def weights(self) -> NDArray[np.float64]: ...
    @property
    def ancestors(self) -> NDArray[np.uint32] | None: ...

@final
class ArmTracker:
    def __new__(cls, arm: Arm, cameras: Camera | list[Camera], method: ArmMethod, seed: int = 0) -> Self: ...
    def predict(self, time_s: float, acc: Any, q_world_sensor: Any, gyr: Any = None) -> None: ...
    def update(self, time_s: float, pixel: Any) -> Estimate: ...
    def update_recorded(self, time_s: float, pixel: Any) -> tuple[Estimate, list[LayerRecord]]: ...
    def estimate(self, time_s: float) -> Estimate: ...
    def run(
        self,
        imu_time_s: NDArray[np.float64],
        acc: NDArray[np.float64],
        q_world_sensor: NDArray[np.float64],
        gyr: NDArray[np.float64] | None,
        time_s: NDArray[np.float64],
        pixels: NDArray[np.float64],
        first_frame: int = 0,
        threads: int | None = None,
    ) -> tuple[dict[str, Any], int, str | None]: ...
    def smoothed(self, first: int, threads: int | None = None) -> dict[str, Any]: ...
    @property
    def particles(self) -> NDArray[np.float64] | None: ...
    @property
    def weights(self) -> NDArray[np.float64] | None: ...
    def save(self) -> bytes: ...
    @staticmethod
    def restore(state: bytes) -> ArmTracker: ...

def check_camera(camera: Camera) -> None: ...
def resample(scheme: str, weights: NDArray[np.float64], n: int, seed: int = 0) -> NDArray[np.uint32]: ...

@final
class Skeleton:
    def __new__(cls, bones: list[Bone]) -> Self: ...
    def pose(
        self, poses: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...

@final
class BodyEstimate:
    @property
    def time_s(self) -> float: ...
    @property
    def joints(self) -> NDArray[np.float64]: ...
    @property
    def state(self) -> NDArray[np.float64]: ...
    @property
    def covariance(self) -> NDArray[np.float64]: ...
    @property
    def blobs(self) -> NDArray[np.float64]: ...
    @property
    def ess(self) -> float: ...

@final
class BodyTracker:
    def __new__(
        cls,
        skeleton: Skeleton,
        pose: list[float],
        free: list[int],
        limits: NDArray[np.float64],
        parts: list[Part],
        camera: WeakPerspective | Camera,
        method: BodyMethod,
        seed: int = 0,
    ) -> Self: ...
    def update(
        self,
        time_s: float,
        evidence: BodyEvidence,
        threads: int | None = None,
    ) -> BodyEstimate: ...
    def update_recorded(
        self,
        time_s: float,
        evidence: BodyEvidence,
    ) -> tuple[BodyEstimate, list[LayerRecord]]: ...
    def joints(self, states: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def poses(self, states: NDArray[np.float64]) -> NDArray[np.float64]: ...
    @property
    def particles(self) -> NDArray[np.float64]: ...
    @property
    def weights(self) -> NDArray[np.float64]: ...
    def save(self) -> bytes: ...
    @staticmethod
    def restore(state: bytes) -> BodyTracker: ...
    def __reduce__(self) -> tuple[Any, tuple[bytes]]: ...

def missed_edges(edges: NDArray[np.uint8], outlines: NDArray[np.float64]) -> NDArray[np.float64]: ...
