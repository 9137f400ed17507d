"""What a reader calls a method."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from pytracker.methods.arm import Ekf
from pytracker.methods.method import Method
from pytracker.tracking.tracks import Track

__all__ = ["HELD", "label", "labels"]

HELD = "first pose held"
"""The trivial answer."""

WORDS = {
    "Inertial": "Inertial only",
    "Ekf": "EKF",
    "Plain": "PF",
    "Layered": "PF with constraint (layered)",
    "LayeredFromConstraint": "PF with constraint (layered, from IV-B)",
    "Joint": "PF with constraint (joint)",
    "Mixture": "Gaussian mixture",
    "Smooth": "Gaussian mixture, smoothed",
    "BodyPlain": "PF of Li & Kulić",
    "Annealed": "Annealed PF",
    "Partitioned": "Partitioned PF",
    "BodyMixture": "Gaussian mixture of the body",
    "BodySmooth": "Partitioned PF, smoothed",
}


def label(method: Method) -> str:
    """In the words of the paper's Table I, with what tells it from its neighbours."""
    words = WORDS.get(type(method).__name__, type(method).__name__)
    if isinstance(method, Ekf):
        if "arm_length" in method.corrections:
            words = "EKF with constraint"
        elif "arm_projection" in method.corrections:
            words = "EKF, then projected to the arm"
    extra = [name.replace("_", " ") for name in ("bias", "patch_offset") if getattr(method, name, False)]
    if method.sample_size is not None:
        extra.insert(0, f"N = {method.sample_size}")
    return f"{words}, {', '.join(extra)}" if extra else words


def labels(tracks: Sequence[Track]) -> list[str]:
    """One a track, all different."""
    names = [label(track.method) for track in tracks]
    counts = Counter(names)
    names = [f"{n}, seed {t.seed}" if counts[n] > 1 else n for n, t in zip(names, tracks, strict=True)]
    counts = Counter(names)
    return [f"{n} [{k + 1}]" if counts[n] > 1 else n for k, n in enumerate(names)]
