"""Figures over many runs: curves and bars with 95 % intervals as SVG text, sheets of frames as PNG bytes."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imsave

from pytracker.formats.video import Image
from pytracker.report.drawing import COLOURS, STYLE, legend_above, svg
from pytracker.rotation import Array
from pytracker.scores.intervals import Interval
from pytracker.student import student_975

__all__ = ["curve", "errors_of_runs", "joint_intervals", "sheet"]

PAPER = "#c8553d"


def curve(
    x: Sequence[float], y: Sequence[Interval], printed: Mapping[float, float], xlabel: str, *, is_log: bool = False
) -> str:
    """Error in cm against a parameter, each with its interval, and what the paper printed."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 3.2), layout="constrained")
        axes = figure.subplots()
        value, half = 100 * np.array([i.value for i in y]), 100 * np.array([i.half for i in y])
        axes.errorbar(x, value, yerr=half, color=COLOURS[0], marker="o", ms=4, lw=1.3, capsize=3,
                      label="ours, with 95 % interval over the runs")  # fmt: skip
        if printed:
            axes.plot(
                list(printed), list(printed.values()), "s", color=PAPER, ms=6, mfc="none", label="the paper's text"
            )
        if is_log:
            axes.set_xscale("log")
        axes.set_xticks(x, [f"{v:g}" for v in x])
        axes.minorticks_off()
        axes.set_ylim(bottom=0)
        axes.set_xlabel(xlabel)
        axes.set_ylabel("overall average error (cm)")
        figure.legend(loc="outside upper center", ncols=2, fontsize=8)
        return svg(figure)


def errors_of_runs(time_s: Array, errors_m: Array) -> str:
    """Error of every frame: mean of the runs with its 95 % interval, and their range, in cm; errors `(runs, T)`."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 2.9), layout="constrained")
        axes = figure.subplots()
        low, high = 100 * np.nanmin(errors_m, axis=0), 100 * np.nanmax(errors_m, axis=0)
        axes.fill_between(time_s, low, high, color=COLOURS[0], alpha=0.15, lw=0, label=f"range of {len(errors_m)} runs")
        if len(errors_m) > 1:
            mean, sd = 100 * np.nanmean(errors_m, axis=0), 100 * np.nanstd(errors_m, axis=0, ddof=1)
            half = student_975(len(errors_m) - 1) * sd / np.sqrt(len(errors_m))
            axes.fill_between(time_s, mean - half, mean + half, color=COLOURS[0], alpha=0.4, lw=0,
                              label="95 % interval of the mean")  # fmt: skip
        axes.plot(time_s, 100 * np.nanmean(errors_m, axis=0), color=COLOURS[0], lw=1.4, label="mean of the runs")
        axes.set_ylim(bottom=0)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("average error (cm)")
        legend_above(figure, axes)
        return svg(figure)


def joint_intervals(joints: Sequence[str], mean: Sequence[Interval], sd: Sequence[Interval]) -> str:
    """A pair of bars a joint, in cm: mean error and its standard deviation, each with its interval over the runs."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 3.2), layout="constrained")
        axes = figure.subplots()
        for k, (values, label) in enumerate(((mean, "average error"), (sd, "standard deviation of the error"))):
            at = np.arange(len(joints)) + 0.4 * (k - 0.5)
            height, half = [100 * i.value for i in values], [100 * i.half for i in values]
            axes.bar(at, height, 0.4, yerr=half, color=COLOURS[3 * k], label=label,
                     error_kw={"elinewidth": 0.9, "ecolor": "#1c2126", "capsize": 3})  # fmt: skip
        axes.set_xticks(range(len(joints)), [joint.replace("_", "\n") for joint in joints])
        axes.set_ylabel("cm")
        figure.legend(loc="outside upper center", ncols=2, fontsize=8)
        return svg(figure)


def sheet(images: Sequence[Image], columns: int) -> bytes:
    """Frames (BGR, all of one size) in rows, as a PNG."""
    height, width = images[0].shape[:2]
    rows = -(-len(images) // columns)
    whole = np.full((rows * (height + 4) - 4, columns * (width + 4) - 4, 3), 255, dtype=np.uint8)
    for k, image in enumerate(images):
        top, left = k // columns * (height + 4), k % columns * (width + 4)
        whole[top : top + height, left : left + width] = image
    out = io.BytesIO()
    imsave(out, whole[..., ::-1], format="png")
    return out.getvalue()
