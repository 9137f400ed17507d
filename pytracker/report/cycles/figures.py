"""Particle clouds as SVG text: one cycle of a filter (Tao & Hu, Fig. 9), posteriors at several frames (Figs. 10, 11).

Which planes an arm and a body are looked at in, `cycle_arm` and `cycle_body` say.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pytracker.report.cycles.arm import FLAT, ArmDrawing
from pytracker.report.cycles.body import BodyDrawing
from pytracker.report.cycles.drawing import CycleDrawing, show
from pytracker.report.drawing import STYLE, svg
from pytracker.rotation import Array
from pytracker.tracking.cycle import Cloud, Cycle

__all__ = ["one_cycle", "snapshots"]

STYLE_HERE = {**STYLE, "axes.grid": False}
DRAWINGS: Mapping[str, CycleDrawing] = {"arm": ArmDrawing(), "body": BodyDrawing()}
"""By kind of recording."""


def one_cycle(cycle: Cycle) -> str:
    """What every layer did: a row a layer (two for a body), from the cloud that arrives to the one that leaves."""
    drawing = DRAWINGS[cycle.recording.kind]
    sections = drawing.sections(cycle)
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
                        drawing.cloud(axes, cloud, section)
                    drawing.scene(axes, cycle, section, with_estimate=column == 2 and number + 1 == len(cycle.layers))
                    axes.set_xlabel(section.names[0] if row + 1 == rows or len(sections) > 1 else "", fontsize=7)
                panels[row, 0].set_ylabel(section.names[1], fontsize=7)
        for row, axes in enumerate(panels.flat):
            drawing.limit(axes, cycle, sections[row // 4 % len(sections)])
        _legend(figure, panels[-1, 2])
        return svg(figure)


def snapshots(rows: Sequence[Sequence[Cycle]], titles: Sequence[str]) -> str:
    """Figs. 10 and 11: what the filter believes of an arm's wrist, a row a method, a column a frame."""
    drawing = ArmDrawing()
    with mpl.rc_context(STYLE_HERE):
        figure = Figure(figsize=(8.6, 1.8 * len(rows) + 0.4), layout="constrained")
        panels = figure.subplots(len(rows), len(rows[0]), squeeze=False, sharex=True, sharey=True)
        everything = []
        for r, (cycles, title) in enumerate(zip(rows, titles, strict=True)):
            for c, cycle in enumerate(cycles):
                axes, section = panels[r, c], drawing.sections(cycle)[0]
                cloud = cycle.layers[-1].weighted
                drawing.cloud(axes, cloud, section)
                drawing.scene(axes, cycle, section, with_estimate=True)
                share = 100 * cloud.ess / len(cloud.weights)
                axes.set_title(f"frame {cycle.frame}: ESS {share:.0f} %", fontsize=8)
                everything.append(section(_seen(cloud, "wrist")))
            panels[r, 0].set_ylabel(f"{title}\n{drawing.sections(cycles[0])[0].names[1]}", fontsize=7)
        for axes in panels[-1]:
            axes.set_xlabel(drawing.sections(rows[0][0])[0].names[0], fontsize=7)
        show(list(panels.flat), np.concatenate(everything), FLAT)
        _legend(figure, panels[0, 0])
        return svg(figure)


def _seen(cloud: Cloud, joint: str) -> Array:
    """Those that weigh something."""
    return np.asarray(cloud.points_m[joint][cloud.weights > 0.01 / len(cloud.weights)])


def _legend(figure: Figure, axes: Axes) -> None:
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=5, fontsize=7.5)
