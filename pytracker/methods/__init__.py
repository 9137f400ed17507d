"""What the user chooses: how a recording is tracked. `arm` and `body` by kind of recording, `registry` by name."""

from __future__ import annotations

from pytracker.methods.arm import (
    METHODS,
    ArmMethod,
    Ekf,
    Inertial,
    Joint,
    Layered,
    LayeredFromConstraint,
    Mixture,
    ParticleMethod,
    Plain,
    Smooth,
)
from pytracker.methods.body import BODY_METHODS, Annealed, BodyMethod, BodyMixture, BodyPlain, BodySmooth, Partitioned
from pytracker.methods.method import Method

__all__ = [
    "BODY_METHODS",
    "METHODS",
    "Annealed",
    "ArmMethod",
    "BodyMethod",
    "BodyMixture",
    "BodyPlain",
    "BodySmooth",
    "Ekf",
    "Inertial",
    "Joint",
    "Layered",
    "LayeredFromConstraint",
    "Method",
    "Mixture",
    "ParticleMethod",
    "Partitioned",
    "Plain",
    "Smooth",
]
