"""Particle clouds as SVG text: one cycle of a filter (Tao & Hu, Fig. 9), posteriors at several frames (Figs. 10, 11).

An arm is shown in the plane that holds the viewing ray and the middle of the elbow's sphere: there the ray is a line,
the sphere a circle, and where they meet the wrist may be. A body is shown from the front, as the camera sees it, and
from the side, where the depth is.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pytracker.recording.recording import ArmRecording
from pytracker.report.drawing import COLOURS, STYLE, TRUTH, svg
from pytracker.rotation import Array
from pytracker.tracking.cycle import Cloud, Cycle

__all__ = ["one_cycle", "snapshots"]

STYLE_HERE = {**STYLE, "axes.grid": False}
RAY = "#bc8f00"
SPHERE = "#8e6c8a"
ESTIMATE = "#c8553d"
AREA = 5.0
"""Of a dot of average weight, points²."""
LARGEST = 90.0
FLAT = 0.62
"""Height over width of an arm's panels: its clouds lie along the ray."""

LIMBS = (
    ("root", "head"), ("left_shoulder", "right_shoulder"),
    ("left_shoulder", "left_elbow"), ("left_elbow", "left_wrist"),
    ("right_shoulder", "right_elbow"), ("right_elbow", "right_wrist"),
)  # fmt: skip


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


def one_cycle(cycle: Cycle) -> str:
    """What every layer did: a row a layer (two for a body), from the cloud that arrives to the one that leaves."""
    sections = _sections(cycle)
    rows = len(cycle.layers) * len(sections)
    with mpl.rc_context(STYLE_HERE):
        figure = Figure(figsize=(8.6, (2.35 if len(sections) > 1 else 1.75) * rows + 0.4), layout="constrained")
        panels = figure.subplots(rows, 4, squeeze=False, sharex=len(sections) == 1, sharey=len(sections) == 1)
        for number, layer in enumerate(cycle.layers):
            stages: tuple[tuple[str, Cloud | None], ...] = (
                ("prior" if number == 0 else "arriving", layer.arriving),
                (f"predicted: {layer.moved_by}", layer.predicted),
                (f"weighed: {layer.weighed_by or 'nothing seen'}", layer.weighted),
                ("resampled", layer.resampled),
            )
            for s, section in enumerate(sections):
                row = number * len(sections) + s
                for column, (title, cloud) in enumerate(stages):
                    axes = panels[row, column]
                    if s == 0:
                        words = textwrap.fill(f"{number + 1}{'abcd'[column]}  {title}", 30)
                        axes.set_title(words, fontsize=7.5)
                    if cloud is None:
                        axes.text(0.5, 0.5, "not resampled", transform=axes.transAxes, ha="center", color="#5a636d")
                    else:
                        _cloud(axes, cycle, cloud, section)
                    _scene(axes, cycle, section, with_estimate=column == 2 and number + 1 == len(cycle.layers))
                    axes.set_xlabel(section.names[0] if row + 1 == rows or len(sections) > 1 else "", fontsize=7)
                panels[row, 0].set_ylabel(section.names[1], fontsize=7)
        for row, axes in enumerate(panels.flat):
            _limit(axes, cycle, sections[row // 4 % len(sections)])
        _legend(figure, panels[-1, 2])
        return svg(figure)


def snapshots(rows: Sequence[Sequence[Cycle]], titles: Sequence[str]) -> str:
    """Figs. 10 and 11: what the filter believes of an arm's wrist, a row a method, a column a frame."""
    with mpl.rc_context(STYLE_HERE):
        figure = Figure(figsize=(8.6, 1.8 * len(rows) + 0.4), layout="constrained")
        panels = figure.subplots(len(rows), len(rows[0]), squeeze=False, sharex=True, sharey=True)
        everything = []
        for r, (cycles, title) in enumerate(zip(rows, titles, strict=True)):
            for c, cycle in enumerate(cycles):
                axes, section = panels[r, c], _sections(cycle)[0]
                cloud = cycle.layers[-1].weighted
                _cloud(axes, cycle, cloud, section)
                _scene(axes, cycle, section, with_estimate=True)
                share = 100 * cloud.ess / len(cloud.weights)
                axes.set_title(f"frame {cycle.frame}: ESS {share:.0f} %", fontsize=8)
                everything.append(section(_seen(cloud, "wrist")))
            panels[r, 0].set_ylabel(f"{title}\n{_sections(cycles[0])[0].names[1]}", fontsize=7)
        for axes in panels[-1]:
            axes.set_xlabel(_sections(rows[0][0])[0].names[0], fontsize=7)
        _show(list(panels.flat), np.concatenate(everything), FLAT)
        _legend(figure, panels[0, 0])
        return svg(figure)


def _sections(cycle: Cycle) -> tuple[Section, ...]:
    """What to look at: one plane for an arm, two for a body."""
    where = cycle.truth_m or cycle.estimate_m
    if not isinstance(cycle.recording, ArmRecording):
        origin = np.array([where["root"][0], where["root"][1], where["root"][2]])
        front, side = np.eye(3)[[0, 1]], np.eye(3)[[2, 1]]
        return (
            Section(origin, front, ("front: sideways (cm)", "height (cm)")),
            Section(origin, side, ("side: depth, towards the camera (cm)", "height (cm)")),
        )
    start, ray = _ray(cycle, cycle.recording)
    to_middle = _sphere_middle(cycle, cycle.recording) - start
    up = to_middle - (to_middle @ ray) * ray
    if np.linalg.norm(up) < 1e-6:  # the ray goes through the middle: any plane will do
        up = np.cross(ray, np.roll(ray, 1))
    up /= np.linalg.norm(up)
    along = ((where["wrist"] - start) @ ray) * ray
    return (Section(start + along, np.stack([ray, up]), ("along the viewing ray (cm)", "across it (cm)")),)


def _ray(cycle: Cycle, recording: ArmRecording) -> tuple[Array, Array]:
    """Where the first camera stands that saw the patch, and the direction in which; else towards the estimate."""
    assert cycle.pixels is not None
    for view, pixel in zip(recording.views, cycle.pixels, strict=True):
        if np.isfinite(pixel).all():
            return view.camera.position_m, view.camera.ray(pixel)
    start = recording.views[0].camera.position_m
    towards = cycle.estimate_m["wrist"] - start
    return start, towards / np.linalg.norm(towards)


def _sphere_middle(cycle: Cycle, recording: ArmRecording) -> Array:
    """Middle of the sphere on which the arm's length holds the wrist (eq. 15): the shoulder less the forearm."""
    forearm = cycle.estimate_m["elbow"] - cycle.estimate_m["wrist"]
    return np.asarray(np.asarray(recording.arm.shoulder_m) - forearm)


def _cloud(axes: Axes, cycle: Cycle, cloud: Cloud, section: Section) -> None:
    """Every particle a dot whose area is its weight."""
    area = np.minimum(AREA * len(cloud.weights) * cloud.weights, LARGEST)
    joints = ("wrist",) if cycle.recording.kind == "arm" else ("head", "left_wrist", "right_wrist")
    colours = (COLOURS[0],) if len(joints) == 1 else (COLOURS[5], COLOURS[0], COLOURS[2])
    for joint, colour in zip(joints, colours, strict=True):
        label = "particles (area: weight)" if len(joints) == 1 else f"particles: {joint.replace('_', ' ')}"
        # A picture within the SVG: thousands of circles would make a page of megabytes.
        x, y = section(cloud.points_m[joint]).T
        axes.scatter(x, y, s=area, color=colour, alpha=0.45, lw=0, rasterized=True,
                     label=label, zorder=2)  # fmt: skip


def _scene(axes: Axes, cycle: Cycle, section: Section, *, with_estimate: bool) -> None:
    """What does not change: viewing ray and sphere, or the skeleton; where the joints really were."""
    axes.tick_params(labelsize=7)
    if isinstance(cycle.recording, ArmRecording):
        start, ray = _ray(cycle, cycle.recording)
        axes.axline(*section(np.stack([start, start + ray])), color=RAY, lw=1.0, label="viewing ray", zorder=1)
        middle = section(_sphere_middle(cycle, cycle.recording)[None])[0]
        turn = np.linspace(0, 2 * np.pi, 721)
        circle = middle + 100 * cycle.recording.arm.upper_arm_m * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        axes.plot(*circle.T, color=SPHERE, lw=1.0, ls="--", label="sphere of the arm's length", zorder=1)
        joints: tuple[str, ...] = ("wrist",)
    else:
        joints = ("head", "left_wrist", "right_wrist")
        for places, colour, is_shown in ((cycle.truth_m, TRUTH, True), (cycle.estimate_m, ESTIMATE, with_estimate)):
            for a, b in LIMBS if is_shown and places else ():
                axes.plot(*section(np.stack([places[a], places[b]])).T, color=colour, lw=0.8, zorder=1)
    if cycle.truth_m:
        axes.plot(*section(np.stack([cycle.truth_m[j] for j in joints])).T, "o", color=TRUTH, ms=5, zorder=4,
                  label="truth")  # fmt: skip
    if with_estimate:
        axes.plot(*section(np.stack([cycle.estimate_m[j] for j in joints])).T, "+", color=ESTIMATE, ms=9, mew=1.8,
                  zorder=5, label="estimate (mean)")  # fmt: skip


def _limit(axes: Axes, cycle: Cycle, section: Section) -> None:
    if cycle.recording.kind == "arm":
        clouds = [cloud for layer in cycle.layers for cloud in (layer.arriving, layer.predicted)]
        _show([axes], np.concatenate([section(cloud.points_m["wrist"]) for cloud in clouds]), FLAT)
    else:
        clouds = [layer.predicted for layer in cycle.layers]
        _show([axes], np.concatenate([section(p) for cloud in clouds for p in cloud.points_m.values()]))


def _seen(cloud: Cloud, joint: str) -> Array:
    """Those that weigh something."""
    return np.asarray(cloud.points_m[joint][cloud.weights > 0.01 / len(cloud.weights)])


def _show(panels: list[Axes], points: Array, shape: float = 1.0) -> None:
    """Nearly all points, a centimetre as long upwards as sideways."""
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    low, high = np.minimum(low, -2.0), np.maximum(high, 2.0)
    width, height = high - low
    half = 0.56 * float(max(width, height / shape))
    for axes in panels:
        axes.set_aspect("equal", adjustable="box")
        (x, y) = 0.5 * (low + high)
        axes.set_xlim(x - half, x + half)
        axes.set_ylim(y - shape * half, y + shape * half)


def _legend(figure: Figure, axes: Axes) -> None:
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=5, fontsize=7.5)
