"""How a body is tracked: frozen, validated, every parameter with its unit.

`BodyPlain` is Li & Kulić as printed. `Annealed` and `Partitioned` are other lists of layers, with likelihoods on a
fixed scale, so that their bands mean something. `BodyMixture` and `BodySmooth` are Gaussian.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pytracker.methods.method import Method
from pytracker.skeleton.skeleton import UPPER_BODY

__all__ = [
    "BODY_METHODS",
    "Annealed",
    "BodyMethod",
    "BodyMixture",
    "BodyParticleMethod",
    "BodyPlain",
    "BodySmooth",
    "Partitioned",
]

ALL = ("torso", "left_arm", "right_arm")

PAPER = ("edges", "blobs")
"""What Li & Kulić weigh by."""

BASIC = (*PAPER, "regions", "keypoints", "orientation", "effort", "posture", "limits")
OWN = ("edges", "regions", "keypoints", "orientation", "effort", "posture", "limits")
"""What our own methods weigh by: of folded arms the middle of a blob is no hand, their skin tells as a region."""

BodyLayer = tuple[tuple[tuple[str, ...], float], tuple[str, ...], tuple[str, float]]
"""Mover (groups that diffuse, share of the diffusion), cues, blend (its name, share of the sharpness)."""


@dataclass(frozen=True, kw_only=True)
class BodyMethod(Method):
    """What every body method assumes. Raises `InputError` when out of range.

    Attributes:
        unseen_distance_sd_m: standard deviation of how far off the body is, beyond what is tracked; like lean and turn
            it moves joints along their viewing rays, which one camera does not see, so that it widens their bands in
            depth and nothing else: from nothing at the first frame to all of it after two seconds (paper: 0).
        first_distance_sd_m: standard deviation of how far off the body is in the first pose, m, from the first frame
            on; a recording may say it (`[initial] distance_sd_m`).
        unseen_lean_sd_rad: of the trunk's lean towards the camera; set it to 0 where `free` lets the trunk bend.
        unseen_turn_sd_rad: of its turn about its long axis; likewise.
        unseen_bend: a trunk that came down since the first frame, by more than people sway, may have bent forwards in
            place of gone down with its legs, which are not looked at: so large a share of that bend is a standard
            deviation of its lean besides (paper: 0).
        keypoint_inflation: how many times its spread a keypoint has: errors of neighbouring frames are much alike.
        keypoint_reach: beyond about so many standard deviations a keypoint says nothing more.
        orientation_inflation: how many times its spread the orientation of a sensor has.
        effort_loss: log-likelihood lost by an upper arm that is held out level, twice as much overhead, nothing where
            it hangs: one camera hardly tells whether an arm leans towards it (paper: 0).
        posture_weight: share of the log-density of how people hold their arms, learned from captured motion; it counts
            once for every time in which a posture is forgotten (paper: 0).
        balance: of how far arms reach towards the camera, so much the trunk gives way, as who stands does (the
            shoulders of people who do exercises by 0.17 and 0.25); put it to 0 for who sits. It needs to know how far
            they reach (else: 0).
        crown_m: how far the head's outer shape reaches beyond the end of the skeleton's head, which in CMU skeletons is
            the middle of the face, m (paper: 0).
        free: channels of the skeleton that are tracked, `bone_dof`; empty: the paper's 11.
    """

    unseen_distance_sd_m: float = 0.0
    first_distance_sd_m: float = 0.0
    unseen_lean_sd_rad: float = 0.0
    unseen_turn_sd_rad: float = 0.0
    unseen_bend: float = 0.0
    keypoint_inflation: float = 2.0
    keypoint_reach: float = 4.0
    orientation_inflation: float = 2.0
    effort_loss: float = 0.0
    posture_weight: float = 0.0
    balance: float = 0.0
    crown_m: float = 0.0
    free: tuple[str, ...] = ()

    kind: ClassVar[str] = "body"
    filter: ClassVar[str]
    """Which of the filters runs it."""

    @property
    def cues(self) -> tuple[str, ...]:
        """What it weighs by, where a frame has it."""
        raise NotImplementedError(type(self).__name__)  # every method says its own

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that are tracked."""
        return self.free or UPPER_BODY

    @property
    def needs_picture(self) -> bool:
        """Whether nothing that it weighs by comes from elsewhere."""
        return "keypoints" not in self.cues


@dataclass(frozen=True, kw_only=True)
class BodyParticleMethod(BodyMethod):
    """What every method assumes that weighs particles, layer by layer.

    Attributes:
        particles: how many in every layer (paper: 300).
        islands: into how many shares the particles are divided that are filtered on their own, so that resampling
            does not make them all agree: where they do not, the pose is not known, and the bands say so (paper: 1).
        layers: (mover, cues, blend), applied in order. A mover is (groups, share of the diffusion): groups are `torso`,
            `left_arm`, `right_arm`; they diffuse, and their parts, blobs and points weigh. Cues are what weighs, where
            a frame has it: `edges` (Li & Kulić eq. 4), `blobs` (its distance cue), `regions` (skin and foreground),
            `keypoints`, `orientation` (of sensors on the arms), `effort` (upper arms against gravity), `posture` (arms
            as people hold them), `limits` (of joints, softly), `penetration` (elbows and hands inside the torso, paper
            IV-C1). A blend is (name, share of the sharpness): `sum`, losses of the cues added up; `rescaled`, the
            paper's, of edges and blobs: distances stretched over the set, `A^-d`, a weighted product.
        sharpness: `A` of the blend `rescaled`, above 1; the paper gives none.
        alpha: weight of the edge cue there, 0 to 2; the distance cue has the rest (paper: 1).
        adapt: how far alpha follows what each cue tells apart in a frame, 0 (the paper) to 1.
        resampling: `systematic` (the paper), `residual`, `stratified` or `multinomial`.
        ess_threshold: resample when ESS falls to this share of the particles; 1 is always (the paper).
        base_density: diffusion of the root's place, m/√s.
        base_turn_density: of its turns, rad/√s.
        trunk_density: of back and neck where they are free, rad/√s.
        joint_density: of shoulders and elbows, rad/√s.
        blob_sd_m: standard deviation of a blob's centre from the model's, m (fixed scale).
        blob_reach: beyond so many standard deviations a blob says nothing more (fixed scale).
        gate_m: how far from where it was expected a blob may be given to head or hand, m.
        anew_share: share of the particles whose arm is drawn anew from all that its joints allow, so that a lost arm is
            found again; 0 is the paper.
        skin_loss: log-likelihood lost by hands and bare forearms that lie off the skin, and as much by skin that
            neither head nor arm wears (fixed scale; the paper has blobs only: 0).
        foreground_loss: the same of limbs and the foreground above the hips.
        region_reach_m: farther off than this is as bad as any, m.
        edge_loss: log-likelihood lost by a part whose outline misses every edge (fixed scale).
        unseen_across_sd_m: standard deviation of joints across the picture, along each of its axes, m, where outlines
            and skin are all that shows them: clothes and hands are wider than bones, and off in the same way from frame
            to frame (paper: 0). It widens bands, from nothing at the first frame on, and nothing else.
    """

    particles: int = 300
    islands: int = 1
    layers: tuple[BodyLayer, ...] = (((ALL, 1.0), BASIC, ("sum", 1.0)),)
    sharpness: float = 1000.0
    alpha: float = 1.0
    adapt: float = 0.0
    resampling: str = "systematic"
    ess_threshold: float = 1.0
    base_density: float = 0.055
    base_turn_density: float = 0.11
    trunk_density: float = 0.75
    joint_density: float = 0.75
    blob_sd_m: float = 0.08
    blob_reach: float = 4.0
    gate_m: float = 0.45
    anew_share: float = 0.0
    skin_loss: float = 0.0
    foreground_loss: float = 0.0
    region_reach_m: float = 0.1
    edge_loss: float = 3.0
    unseen_across_sd_m: float = 0.0

    filter: ClassVar[str] = "particles"

    @property
    def sample_size(self) -> int | None:
        """How many particles it has."""
        return self.particles

    @property
    def cues(self) -> tuple[str, ...]:
        """What any layer weighs by."""
        return tuple(dict.fromkeys(cue for _, cues, _ in self.layers for cue in cues))

    def layers_in_words(self) -> list[tuple[str, str]]:
        """What moves the particles in each layer, and what weighs them."""
        return [
            (f"diffusion of {' and '.join(groups).replace('_', ' ')}", ", ".join(cues))
            for (groups, _), cues, _ in self.layers
        ]


@dataclass(frozen=True, kw_only=True)
class _Doubting(BodyMethod):
    """What one camera does not tell widens the bands."""

    unseen_distance_sd_m: float = 0.05
    unseen_lean_sd_rad: float = 0.17
    unseen_turn_sd_rad: float = 0.17
    unseen_bend: float = 1.0
    effort_loss: float = 1.25
    posture_weight: float = 0.5
    crown_m: float = 0.05


@dataclass(frozen=True, kw_only=True)
class _Momentum(_Doubting):
    """Channels that have velocities; of what one camera does not tell their covariance knows some: less is added.

    Attributes:
        base_accel_density: how the velocity of the root changes, m/s/√s.
        turn_accel_density: of its turns, and of back and neck where they are free, rad/s/√s.
        joint_accel_density: of shoulders and elbows, rad/s/√s.
        velocity_lasts_s: how long a velocity lasts, s.
        first_pose_sd_m: how well the root's place is known at the first frame, m per axis.
        first_pose_sd_rad: how well every angle is, rad.
    """

    base_accel_density: float = 2.0
    turn_accel_density: float = 5.0
    joint_accel_density: float = 25.0
    velocity_lasts_s: float = 0.3
    first_pose_sd_m: float = 0.02
    first_pose_sd_rad: float = 0.1
    unseen_distance_sd_m: float = 0.03
    unseen_lean_sd_rad: float = 0.09
    unseen_turn_sd_rad: float = 0.09


@dataclass(frozen=True, kw_only=True)
class BodyPlain(BodyParticleMethod):
    """The particle filter of Li & Kulić: distances rescaled over the set, `A^-d`, one layer."""

    layers: tuple[BodyLayer, ...] = (((ALL, 1.0), PAPER, ("rescaled", 1.0)),)

    @property
    def name(self) -> str:
        """The name that the command line knows it by."""
        return "plain"


@dataclass(frozen=True, kw_only=True)
class _Fixed(_Doubting, BodyParticleMethod):
    """Cues on a fixed scale."""

    base_turn_density: float = 0.2
    skin_loss: float = 30.0
    foreground_loss: float = 30.0
    unseen_across_sd_m: float = 0.025


@dataclass(frozen=True, kw_only=True)
class Annealed(_Fixed):
    """Annealing: the same cues several times, from flat to sharp, while the diffusion shrinks (Deutscher & Blake)."""

    layers: tuple[BodyLayer, ...] = (
        ((ALL, 1.0), OWN, ("sum", 0.3)),
        ((ALL, 0.5), OWN, ("sum", 0.6)),
        ((ALL, 0.25), OWN, ("sum", 1.0)),
    )


@dataclass(frozen=True, kw_only=True)
class Partitioned(_Fixed):
    """Partitions: the torso first, then each arm on it (MacCormick & Isard), on islands: the best of those online."""

    islands: int = 8

    layers: tuple[BodyLayer, ...] = (
        ((("torso",), 1.0), (*OWN, "penetration"), ("sum", 1.0)),
        ((("left_arm",), 1.0), (*OWN, "penetration"), ("sum", 1.0)),
        ((("right_arm",), 1.0), (*OWN, "penetration"), ("sum", 1.0)),
    )
    anew_share: float = 0.1


@dataclass(frozen=True, kw_only=True)
class BodyMixture(_Momentum):
    """Gaussians over channels and their velocities, by keypoints and sensors: no particles, no seed, no picture needed.

    A limb that leans towards the camera looks like one that leans away by as much: both are components of the mixture.

    Attributes:
        corrections: what corrects it, all at once, where a frame has it: `keypoints`, `orientation` (of sensors on the
            arms), `effort` (upper arms against gravity), `posture` (arms as people hold them), `limits` (of joints,
            softly).
        components: how many Gaussians are kept; one is an iterated extended Kalman filter.
    """

    corrections: tuple[str, ...] = ("keypoints", "orientation", "effort", "posture", "limits")
    components: int = 12
    balance: float = 0.12

    filter: ClassVar[str] = "mixture"

    @property
    def name(self) -> str:
        """The name that the command line knows it by."""
        return "mixture"

    @property
    def cues(self) -> tuple[str, ...]:
        """What corrects it."""
        return self.corrections

    @property
    def needs_picture(self) -> bool:
        """It sees none."""
        return False

    @property
    def needs_one_of(self) -> tuple[str, ...]:
        """Nothing else tells it where joints are."""
        return tuple(cue for cue in self.corrections if cue in ("keypoints", "orientation"))


@dataclass(frozen=True, kw_only=True)
class BodySmooth(Partitioned, _Momentum):
    """The whole recording at once: what `Partitioned` gives, smoothed by Gauss-Newton over all frames: the best here.

    Every frame is estimated from what comes before and after it, by where a detector saw the joints, or the particles
    where there was none, by the sensors' orientations, and by how limbs move. Of two ways for a limb to lean it settles
    on one; what a mixture like `BodyMixture` makes of the same frames has a share of three tenths in means and bands,
    and where no detector saw the joints what the particles make of them one of a half.
    Online it gives what `Partitioned` of the same parameters does.
    """

    balance: float = 0.12
    unseen_across_sd_m: float = 0.035
    unseen_distance_sd_m: float = _Momentum.unseen_distance_sd_m
    unseen_lean_sd_rad: float = _Momentum.unseen_lean_sd_rad
    unseen_turn_sd_rad: float = _Momentum.unseen_turn_sd_rad

    filter: ClassVar[str] = "smoother"

    @property
    def name(self) -> str:
        """The name that the command line knows it by."""
        return "smooth"


BODY_METHODS: dict[str, type[BodyMethod]] = {
    "plain": BodyPlain,
    "annealed": Annealed,
    "partitioned": Partitioned,
    "mixture": BodyMixture,
    "smooth": BodySmooth,
}
"""Body methods by the name that the command line knows them by."""
