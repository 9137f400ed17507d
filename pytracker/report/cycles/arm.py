"""A cloud of an arm, in the plane that holds the viewing ray and the middle of the elbow's sphere.

There the ray is a line, the sphere a circle, and where they meet the wrist may be.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from matplotlib.axes import Axes

from pytracker.recording.recording import ArmRecording
from pytracker.report.cycles.drawing import CycleDrawing, Section, show
from pytracker.report.drawing import COLOURS
from pytracker.rotation import Array
from pytracker.tracking.cycle import Cycle

__all__ = ["FLAT", "ArmDrawing"]

RAY = "#bc8f00"
SPHERE = "#8e6c8a"
FLAT = 0.62
"""Height over width of a panel: clouds lie along the ray."""


class ArmDrawing(CycleDrawing):
    """The wrist's particles, in one plane."""

    joints: ClassVar[Mapping[str, str]] = {"wrist": COLOURS[0]}

    def sections(self, cycle: Cycle) -> tuple[Section, ...]:
        """Along the ray, and across it towards the sphere's middle."""
        start, ray = _ray(cycle)
        to_middle = _sphere_middle(cycle) - start
        up = to_middle - (to_middle @ ray) * ray
        if np.linalg.norm(up) < 1e-6:  # the ray goes through the middle: any plane will do
            up = np.cross(ray, np.roll(ray, 1))
        up /= np.linalg.norm(up)
        along = (((cycle.truth_m or cycle.estimate_m)["wrist"] - start) @ ray) * ray
        return (Section(start + along, np.stack([ray, up]), ("along the viewing ray (cm)", "across it (cm)")),)

    def background(self, axes: Axes, cycle: Cycle, section: Section, *, with_estimate: bool) -> None:
        """Viewing ray and sphere."""
        start, ray = _ray(cycle)
        axes.axline(*section(np.stack([start, start + ray])), color=RAY, lw=1.0, label="viewing ray", zorder=1)
        middle = section(_sphere_middle(cycle)[None])[0]
        turn = np.linspace(0, 2 * np.pi, 721)
        circle = middle + 100 * _of(cycle).arm.upper_arm_m * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        axes.plot(*circle.T, color=SPHERE, lw=1.0, ls="--", label="sphere of the arm's length", zorder=1)

    def limit(self, axes: Axes, cycle: Cycle, section: Section) -> None:
        """Around all clouds before they are weighed."""
        clouds = [cloud for layer in cycle.layers for cloud in (layer.arriving, layer.predicted)]
        show([axes], np.concatenate([section(cloud.points_m["wrist"]) for cloud in clouds]), FLAT)


def _of(cycle: Cycle) -> ArmRecording:
    assert isinstance(cycle.recording, ArmRecording)
    return cycle.recording


def _ray(cycle: Cycle) -> tuple[Array, Array]:
    """Where the first camera stands that saw the patch, and the direction in which; else towards the estimate."""
    views = _of(cycle).views
    assert cycle.pixels is not None
    for view, pixel in zip(views, cycle.pixels, strict=True):
        if np.isfinite(pixel).all():
            return view.camera.position_m, view.camera.ray(pixel)
    start = views[0].camera.position_m
    towards = cycle.estimate_m["wrist"] - start
    return start, towards / np.linalg.norm(towards)


def _sphere_middle(cycle: Cycle) -> Array:
    """Middle of the sphere on which the arm's length holds the wrist (eq. 15): the shoulder less the forearm."""
    forearm = cycle.estimate_m["elbow"] - cycle.estimate_m["wrist"]
    return np.asarray(np.asarray(_of(cycle).arm.shoulder_m) - forearm)
