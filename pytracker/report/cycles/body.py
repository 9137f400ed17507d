"""A cloud of a body, from the front, as the camera sees it, and from the side, where the depth is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from matplotlib.axes import Axes

from pytracker.report.cycles.drawing import ESTIMATE, CycleDrawing, Section, show
from pytracker.report.drawing import COLOURS, TRUTH
from pytracker.tracking.cycle import Cycle

__all__ = ["BodyDrawing"]

LIMBS = (
    ("root", "head"), ("left_shoulder", "right_shoulder"),
    ("left_shoulder", "left_elbow"), ("left_elbow", "left_wrist"),
    ("right_shoulder", "right_elbow"), ("right_elbow", "right_wrist"),
)  # fmt: skip


class BodyDrawing(CycleDrawing):
    """Particles of head and wrists, in two planes."""

    joints: ClassVar[Mapping[str, str]] = {"head": COLOURS[5], "left_wrist": COLOURS[0], "right_wrist": COLOURS[2]}

    def sections(self, cycle: Cycle) -> tuple[Section, ...]:
        """Front and side."""
        origin = np.array((cycle.truth_m or {}).get("root", cycle.estimate_m["root"]))
        front, side = np.eye(3)[[0, 1]], np.eye(3)[[2, 1]]
        return (
            Section(origin, front, ("front: sideways (cm)", "height (cm)")),
            Section(origin, side, ("side: depth, towards the camera (cm)", "height (cm)")),
        )

    def background(self, axes: Axes, cycle: Cycle, section: Section, *, with_estimate: bool) -> None:
        """The skeleton, true and estimated."""
        for places, colour, is_shown in ((cycle.truth_m, TRUTH, True), (cycle.estimate_m, ESTIMATE, with_estimate)):
            # A truth may lack some joints.
            for a, b in (limb for limb in LIMBS if is_shown and places and set(limb) <= places.keys()):
                axes.plot(*section(np.stack([places[a], places[b]])).T, color=colour, lw=0.8, zorder=1)

    def limit(self, axes: Axes, cycle: Cycle, section: Section) -> None:
        """Around all joints' particles."""
        clouds = [layer.predicted for layer in cycle.layers]
        show([axes], np.concatenate([section(p) for cloud in clouds for p in cloud.points_m.values()]))
