"""How a particle cloud is drawn: in which planes, with which joints, before which scene."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib.axes import Axes

from pytracker.report.drawing import TRUTH
from pytracker.rotation import Array
from pytracker.tracking.cycle import Cloud, Cycle

__all__ = ["ESTIMATE", "CycleDrawing", "Section", "show"]

ESTIMATE = "#c8553d"
AREA = 5.0
"""Of a dot of average weight, points²."""
LARGEST = 90.0


@dataclass(frozen=True)
class Section:
    """A plane to look at, in cm.

    Attributes:
        origin: world, m `(3,)`.
        across: right and up in the picture, world `(2, 3)`.
        names: of the axes.
    """

    origin: Array
    across: Array
    names: tuple[str, str]

    def __call__(self, points: Array) -> Array:
        """World points `(N, 3)`, m, in the plane `(N, 2)`, cm."""
        return np.asarray(100 * (points - self.origin) @ self.across.T)


class CycleDrawing(ABC):
    """Of one kind of recording.

    Attributes:
        joints: whose particles are drawn, and in which colour.
    """

    joints: ClassVar[Mapping[str, str]]

    @abstractmethod
    def sections(self, cycle: Cycle) -> tuple[Section, ...]:
        """What is drawn."""

    @abstractmethod
    def background(self, axes: Axes, cycle: Cycle, section: Section, *, with_estimate: bool) -> None:
        """What is there besides particles."""

    @abstractmethod
    def limit(self, axes: Axes, cycle: Cycle, section: Section) -> None:
        """Where the panel ends."""

    def cloud(self, axes: Axes, cloud: Cloud, section: Section) -> None:
        """Every particle a dot whose area is its weight."""
        area = np.minimum(AREA * len(cloud.weights) * cloud.weights, LARGEST)
        for joint, colour in self.joints.items():
            label = "particles (area: weight)"
            if len(self.joints) > 1:
                label = f"particles: {joint.replace('_', ' ')}"
            # A picture within the SVG: thousands of circles would make a page of megabytes.
            x, y = section(cloud.points_m[joint]).T
            axes.scatter(x, y, s=area, color=colour, alpha=0.45, lw=0, rasterized=True,
                         label=label, zorder=2)  # fmt: skip

    def scene(self, axes: Axes, cycle: Cycle, section: Section, *, with_estimate: bool) -> None:
        """What does not change, where the joints really were, and where they are estimated."""
        axes.tick_params(labelsize=7)
        self.background(axes, cycle, section, with_estimate=with_estimate)
        if known := [cycle.truth_m[joint] for joint in self.joints if joint in (cycle.truth_m or ())]:
            axes.plot(*section(np.stack(known)).T, "o", color=TRUTH, ms=5, zorder=4, label="truth")
        if with_estimate:
            axes.plot(*section(np.stack([cycle.estimate_m[j] for j in self.joints])).T, "+", color=ESTIMATE, ms=9,
                      mew=1.8, zorder=5, label="estimate (mean)")  # fmt: skip


def show(panels: list[Axes], points: Array, shape: float = 1.0) -> None:
    """Nearly all points `(N, 2)`, a centimetre as long upwards as sideways; `shape` is height over width."""
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    low, high = np.minimum(low, -2.0), np.maximum(high, 2.0)
    width, height = high - low
    half = 0.56 * float(max(width, height / shape))
    for axes in panels:
        axes.set_aspect("equal", adjustable="box")
        (x, y) = 0.5 * (low + high)
        axes.set_xlim(x - half, x + half)
        axes.set_ylim(y - shape * half, y + shape * half)
