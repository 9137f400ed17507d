"""What the user chooses: how a recording is tracked. Frozen, validated, every parameter with its unit.

Arm (Tao & Hu 2008): `Inertial`, `Ekf`, `Plain`, `Layered`, `LayeredFromConstraint`, `Joint`, `Mixture` and
`Smooth`. A method differs from another in its filter and its list of layers (particles) or of corrections (Gaussian).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from pytracker.methods.method import Method

__all__ = [
    "METHODS",
    "ArmMethod",
    "Ekf",
    "GaussianMethod",
    "Inertial",
    "Joint",
    "Layered",
    "LayeredFromConstraint",
    "Mixture",
    "ParticleMethod",
    "Plain",
    "Smooth",
]

Layers = tuple[tuple[str, tuple[str, ...], tuple[str, float]], ...]
PRODUCT = ("sum", 1.0)
"""Likelihoods multiplied, as Bayes' rule asks for."""
MOVERS = {"inertial": "inertial motion", "walk": "random walk"}


@dataclass(frozen=True, kw_only=True)
class ArmMethod(Method):
    """What every arm method assumes about motion and measurement. Raises `InputError` when out of range.

    Attributes:
        accel_density: process noise of eq. (6), m/s/√s; a sample over T has sigma_f = accel_density / T^1.5.
        gap_density: the same where the IMU has said nothing for `hold_s`, m/s/√s.
        hold_s: how long an IMU sample holds, s; one and a half sampling intervals where those are longer.
        position_start_sd_m: wrist at the first frame, m per axis.
        velocity_start_sd: velocity at the first frame, m/s per axis; of a recording it is found where it is left at
            its default (`pytracker.track`).
        walk_density: random walk of eq. (17), m/√s; the paper's 1 cm at 25 frames/s is 0.05.
        pixel_sd: patch centre, px per axis (paper: 4).
        outlier_fraction: share of sightings that are something else, anywhere in an image of twice the principal
            point; the paper has 0. Particle methods only.
        arm_length_sd_m: upper-arm length, m (paper: 0.01).
        rest_speed: velocity while at rest, m/s per axis (the `rest` likelihood).
        rest_accel: the specific force varies by less at rest, m/s² RMS over all axes.
        rest_turn_rate: the sensor turns by less at rest, rad/s RMS over all axes.
        bias: whether the acceleration bias (world frame) is estimated.
        bias_start_sd: bias at the start, m/s² per axis.
        bias_density: how fast it wanders, m/s²/√s, drawn back so that its spread stays `bias_start_sd`.
        patch_offset: whether the patch's offset from the joint (sensor frame) is estimated, beyond the one given.
        patch_offset_start_sd_m: offset at the start, m per axis.
        patch_offset_density: how fast it wanders, m/√s, drawn back so that its spread stays `patch_offset_start_sd_m`.
    """

    accel_density: float = 0.1
    gap_density: float = 3.0
    hold_s: float = 0.05
    position_start_sd_m: float = 0.02
    velocity_start_sd: float = 0.02
    walk_density: float = 0.05
    pixel_sd: float = 4.0
    outlier_fraction: float = 0.0
    arm_length_sd_m: float = 0.01
    rest_speed: float = 0.01
    rest_accel: float = 0.2
    rest_turn_rate: float = 0.1
    bias: bool = False
    bias_start_sd: float = 0.15
    bias_density: float = 0.01
    patch_offset: bool = False
    patch_offset_start_sd_m: float = 0.015
    patch_offset_density: float = 0.005

    kind: ClassVar[str] = "arm"
    filter: ClassVar[str]
    """Which of the engine's filters runs it: `particles`, `gaussian`, `mixture` or `smoother`."""

    @property
    def follows_patch(self) -> bool:
        """Whether the patch says where the wrist is."""
        return True

    @property
    def shoulder_stays_m(self) -> float | None:
        """How far the shoulder may be from its place per axis, 95 %, m; None where the arm's length holds nothing."""
        return 0.0


@dataclass(frozen=True, kw_only=True)
class ParticleMethod(ArmMethod):
    """What every particle method has besides.

    Attributes:
        particles: how many, at least 1 (paper: 500).
        resampling: `residual` (the paper), `systematic`, `stratified` or `multinomial`.
        ess_threshold: resample when ESS falls to this share of the particles; 1 is always (the paper).
        layers: (mover, cues, blend), applied in order. A mover is `inertial` or `walk`; cues are `colour`, `arm_length`
            and `rest` (no velocity, while the IMU says that it lies still); a blend is (name, share of the sharpness):
            `sum`, log-likelihoods added up; with another share than 1, as in annealing, they are no evidence any more.
    """

    filter: ClassVar[str] = "particles"

    particles: int = 500
    resampling: str = "residual"
    ess_threshold: float = 1.0
    layers: Layers = (("inertial", (), PRODUCT),)

    @property
    def sample_size(self) -> int | None:
        """How many particles it has."""
        return self.particles

    @property
    def follows_patch(self) -> bool:
        """Whether the patch weighs its particles in any layer."""
        return any("colour" in cues for _, cues, _ in self.layers)

    @property
    def shoulder_stays_m(self) -> float | None:
        """None where no layer has the arm's length."""
        return 0.0 if any("arm_length" in cues for _, cues, _ in self.layers) else None

    def layers_in_words(self) -> list[tuple[str, str]]:
        """What moves the particles in each layer, and what weighs them."""
        return [(MOVERS[mover], " and ".join(cues).replace("_", " ")) for mover, cues, _ in self.layers]


@dataclass(frozen=True, kw_only=True)
class Plain(ParticleMethod):
    """The particle filter without the arm (Tao & Hu III-C)."""

    layers: Layers = (("inertial", ("colour",), PRODUCT),)


@dataclass(frozen=True, kw_only=True)
class Layered(ParticleMethod):
    """Layered sampling (Tao & Hu III-E, the seven steps): colour first, then the arm's length."""

    layers: Layers = (("inertial", ("colour",), PRODUCT), ("walk", ("arm_length",), PRODUCT))


@dataclass(frozen=True, kw_only=True)
class LayeredFromConstraint(ParticleMethod):
    """The same cycle as IV-B tells it: the arm's length at the last frame first, then colour."""

    layers: Layers = (("walk", ("arm_length",), PRODUCT), ("inertial", ("colour",), PRODUCT))


@dataclass(frozen=True, kw_only=True)
class Joint(ParticleMethod):
    """Colour and the arm's length weighed together, in one layer: the best of the particle filters.

    Acceleration bias and patch offset are estimated; `patch_offset=False` where the patch is known to sit on the joint.
    """

    particles: int = 5000
    ess_threshold: float = 0.5
    arm_length_sd_m: float = 0.008
    bias: bool = True
    bias_density: float = 0.02
    patch_offset: bool = True

    layers: Layers = (("inertial", ("colour", "arm_length"), PRODUCT),)


@dataclass(frozen=True, kw_only=True)
class GaussianMethod(ArmMethod):
    """What the Gaussian baselines have besides.

    Attributes:
        corrections: applied in order: `colour`; `arm_length`, the constraint as a pseudo-measurement;
            `rest`, no velocity while the IMU says that it lies still; `arm_projection`, the mean moved to the
            arm's length afterwards (the authors' earlier method).
    """

    filter: ClassVar[str] = "gaussian"

    corrections: tuple[str, ...] = ()

    @property
    def follows_patch(self) -> bool:
        """Whether the patch is among its corrections."""
        return "colour" in self.corrections

    @property
    def shoulder_stays_m(self) -> float | None:
        """None where the arm's length is not among its corrections."""
        return 0.0 if "arm_length" in self.corrections else None


@dataclass(frozen=True, kw_only=True)
class Ekf(GaussianMethod):
    """Extended Kalman filter."""

    corrections: tuple[str, ...] = ("colour",)


@dataclass(frozen=True, kw_only=True)
class Inertial(GaussianMethod):
    """The IMU integrated twice from the start: no corrections."""


@dataclass(frozen=True, kw_only=True)
class Mixture(ArmMethod):
    """A mixture of Gaussians over the state of an IMU that is worn: the best here online on living arms.

    Besides position and velocity the state holds the accelerometer's bias (in the sensor's frame), the error of the
    measured orientation, the patch's offset and how far the shoulder has moved. Where the viewing ray meets the elbow's
    sphere twice there is a component for either; what told them apart is forgotten within 1.3 s. Some 30 frames a
    second correct it, however many there are: what a patch, a strap and an arm are off by is alike in those between.

    Attributes:
        components: how many Gaussians are kept; with 1 it is an iterated extended Kalman filter.
        corrections: what corrects it besides the patch: `arm_length`; `rest`, no velocity while the IMU lies still.
        accel_growth: how `accel_density` grows with what the wrist accelerates by, per m/s².
        forearm_sd_rad: direction of the forearm beside the sensor's axis: skin and strap, rad.
        tilt_start_sd_rad: error of the orientation, rad per axis.
        tilt_density: how fast it wanders, rad/√s, drawn back so that its spread stays `tilt_start_sd_rad`.
        shoulder: whether the shoulder may move.
        shoulder_motion_sd_m: how far, m per axis.
        shoulder_density: how fast, m/√s, drawn back so that its spread stays `shoulder_motion_sd_m`.
        clock_sd_s: by how much the clocks of camera and IMU differ, s.
        landmark_sd_m: how far what is seen of shoulder or elbow lies from the joint, m per axis: a patch on the skin, a
            detector's idea of it.
        landmark_density: how fast that wanders, m/√s, drawn back so that its spread stays `landmark_sd_m`.
        upper_arm_turn_sd_rad: error of where the upper arm's sensor says that it points, rad per axis.
        upper_arm_turn_density: how fast it wanders, rad/√s, likewise.
    """

    filter: ClassVar[str] = "mixture"

    corrections: tuple[str, ...] = ("arm_length",)
    position_start_sd_m: float = 0.05
    velocity_start_sd: float = 0.8
    components: int = 12
    accel_density: float = 0.085
    arm_length_sd_m: float = 0.012
    bias: bool = True
    bias_start_sd: float = 0.08
    bias_density: float = 0.03
    patch_offset: bool = True
    patch_offset_start_sd_m: float = 0.01
    accel_growth: float = 0.3
    forearm_sd_rad: float = 0.07
    tilt_start_sd_rad: float = 0.017
    tilt_density: float = 0.003
    shoulder: bool = True
    shoulder_motion_sd_m: float = 0.022
    shoulder_density: float = 0.025
    clock_sd_s: float = 0.05
    landmark_sd_m: float = 0.03
    landmark_density: float = 0.005
    upper_arm_turn_sd_rad: float = 0.07
    upper_arm_turn_density: float = 0.08

    @property
    def shoulder_stays_m(self) -> float | None:
        """By how far it may move."""
        if "arm_length" not in self.corrections:
            return None
        return 2.0 * self.shoulder_motion_sd_m if self.shoulder else 0.0


@dataclass(frozen=True, kw_only=True)
class Smooth(Mixture):
    """The whole recording at once: what `Mixture` gives, smoothed by Gauss-Newton over all frames.

    It is started from the mixture's track and from either depth at which the viewing ray meets the elbow's sphere,
    throughout; ways that settle apart are weighed, as a whole, for each window of 24 s, or of 600 frames
    where that is longer.
    Every frame is estimated from what comes before and after it, and averaged with what `Mixture` says of it, which has
    up to three tenths of the say. Online it gives what `Mixture` does; the state is linearised again until it settles,
    eight times at most. Where no trajectory is found the frames stay as they were, and say so. What was measured once
    is estimated with the rest, and widens the bands where the data do not tell it. Where for a second neither the
    sensor turns nor the patch moves in the picture the wrist is taken to lie still, to within `rest_speed`.

    Attributes:
        upper_arm_sd_m: how well the upper arm's length is known, m.
        forearm_sd_m: how well the forearm's length is known, m.
        shoulder_place_sd_m: how well the place about which the shoulder moves is known, m per axis.
        mount_sd_rad: how well it is known how the sensor lies on the forearm, rad per axis across it.
        camera_turn_sd_rad: how well a camera's direction is known, rad per axis.
        camera_distance_sd_m: how well a camera's distance is known, m.
        focal_sd: how well its focal length is known, as a share of it.
    """

    filter: ClassVar[str] = "smoother"

    arm_length_sd_m: float = 0.02
    forearm_sd_rad: float = 0.08
    shoulder_motion_sd_m: float = 0.03
    shoulder_density: float = 0.045
    upper_arm_sd_m: float = 0.012
    forearm_sd_m: float = 0.01
    shoulder_place_sd_m: float = 0.03
    mount_sd_rad: float = 0.035
    camera_turn_sd_rad: float = 0.01
    camera_distance_sd_m: float = 0.1
    focal_sd: float = 0.015

    @property
    def shoulder_stays_m(self) -> float | None:
        """By how far it may move, from a place that is known so well."""
        moves_m = super().shoulder_stays_m
        return None if moves_m is None else math.hypot(moves_m, 2.0 * self.shoulder_place_sd_m)


METHODS: dict[str, type[ArmMethod]] = {
    cls.__name__.lower(): cls for cls in (Inertial, Ekf, Plain, Layered, LayeredFromConstraint, Joint, Mixture, Smooth)
}
"""Arm methods by the name that the command line knows them by."""
