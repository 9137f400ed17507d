"""Li & Kulić (2010): what is run. A person before a wall, who moves the arms from pose to pose."""

from __future__ import annotations

from pytracker.methods.body import Annealed, BodyMethod, BodyPlain, Partitioned
from pytracker.simulate import BodyScene
from pytracker.study import Study, StudyRecording

__all__ = [
    "ALPHAS",
    "COUNTS",
    "DURATION_S",
    "METHODS",
    "PAPER",
    "RUNS",
    "SHIPPED",
    "SHORTEST_S",
    "make_study",
    "with_alpha",
    "with_particles",
]

DURATION_S = 8.0

SHORTEST_S = 1.0

RUNS = 3
"""Of every method on every recording, with other seeds of the filter: their mean is the recording's figure."""

COUNTS = (10, 30, 100, 300, 1000, 3000)
"""Numbers of particles of Fig. 5."""

ALPHAS = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8)
"""Weights of the edge cue of Fig. 8."""

PAPER = BodyPlain()
"""300 particles, alpha = 1."""

SHIPPED: dict[str, BodyMethod] = {"paper's filter": PAPER, "annealed": Annealed(), "partitioned": Partitioned()}
"""What the package offers, with 300 particles a layer."""


def with_particles(count: int) -> BodyPlain:
    """The paper's filter with so many particles."""
    return BodyPlain(particles=count)


def with_alpha(alpha: float) -> BodyPlain:
    """The paper's filter with another weight of the edge cue."""
    return BodyPlain(alpha=alpha)


METHODS: dict[str, BodyMethod] = {
    **{f"{n} particles": with_particles(n) for n in COUNTS},
    **{f"alpha = {alpha:g}": with_alpha(alpha) for alpha in ALPHAS if alpha != PAPER.alpha},
    **{name: method for name, method in SHIPPED.items() if method != PAPER},
}
"""All of them; the paper's filter is that with 300 particles."""


def make_study(seeds: tuple[int, ...], duration_s: float) -> Study:
    """Everything that the page averages: a recording a seed, with motion, clothes and noise of its own."""
    scene = BodyScene(duration_s=duration_s)
    recordings = tuple(StudyRecording(name=f"person {seed}", scene=scene, seed=seed) for seed in seeds)
    return Study(recordings=recordings, methods=tuple(METHODS.values()), seeds=tuple(range(1, RUNS + 1)))
