"""What all figures share: style, lines, shading, legends, SVG text."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pytracker.rotation import Array
from pytracker.series import runs
from pytracker.tracking.tracks import Track

__all__ = [
    "AXES",
    "COLOURS",
    "STYLE",
    "TRUTH",
    "legend_above",
    "limit",
    "line",
    "sample_size",
    "shade_invalid",
    "svg",
    "true",
]

COLOURS = ("#0b6e99", "#c8553d", "#6a994e", "#8e6c8a", "#bc8f00", "#5c677d", "#2a9d8f")
TRUTH = "#111111"
AXES = "xyz"
STYLE: Any = {
    "font.size": 9,
    "font.family": "sans-serif",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "grid.linewidth": 0.6,
    "axes.edgecolor": "#8a929c",
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "pytracker",
    "path.simplify": True,
    "path.simplify_threshold": 0.5,
}


def sample_size(tracks: Sequence[Track], labels: Sequence[str]) -> str:
    """Effective sample size as a share of the particles, and when nothing was seen."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 2.6), layout="constrained")
        axes = figure.subplots()
        for k, track in enumerate(tracks):
            particles = track.method.sample_size
            if particles is not None:
                axes.plot(
                    track.time_s,
                    100 * track.ess / particles,
                    color=COLOURS[k % len(COLOURS)],
                    lw=0.9,
                    label=labels[k],
                    zorder=4 - 0.1 * k,
                )
        shade_invalid(axes, tracks[0])
        axes.set_ylim(0, 100)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("ESS (% of particles)")
        legend_above(figure, axes)
        return svg(figure)


def line(axes: Axes, track: Track, values: Array, number: int, label: str) -> None:
    """One method's line: the first in front and strong, the others behind it in order."""
    front = number == 0
    axes.plot(
        track.time_s,
        values,
        color=COLOURS[number % len(COLOURS)],
        lw=1.7 if front else 0.9,
        alpha=1.0 if front else 0.75,
        label=label,
        zorder=4 - 0.1 * number,
    )


def true(track: Track, joint: str) -> Array | None:
    """Where a joint really was, at the track's frames `(T, 3)`; None where there is no truth."""
    truth = track.recording.truth
    return None if truth is None or joint not in truth.joints_m else truth.at(joint, track.time_s)


def limit(axes: Axes, shown: list[Array]) -> None:
    """Show the first track and the truth whole; a method that runs away leaves the frame."""
    values = 100 * np.concatenate(shown)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.12 * max(high - low, 2.0)
    axes.set_ylim(low - margin, high + margin)


def shade_invalid(axes: Axes, track: Track, joint: str | None = None) -> None:
    """Shaded where the track says that its frame, or a joint of it, is not to be believed."""
    valid = track.valid if joint is None else track.joints[joint].valid
    step = float(np.median(np.diff(track.time_s))) if len(track.time_s) > 1 else 0.0
    for number, (start, end) in enumerate(runs(~valid)):
        axes.axvspan(
            track.time_s[start],
            track.time_s[end - 1] + step,
            color="#f2b8a0",
            alpha=0.5,
            lw=0,
            zorder=0,
            label="not valid" if number == 0 else None,
        )


def legend_above(figure: Figure, axes: Axes) -> None:
    """In drawing order from front to back: the first track first."""
    handles, names = axes.get_legend_handles_labels()
    order = sorted(range(len(handles)), key=lambda k: -handles[k].get_zorder())
    if handles:
        figure.legend(
            [handles[k] for k in order], [names[k] for k in order], loc="outside upper center", ncols=2, fontsize=8
        )


def svg(figure: Figure) -> str:
    """As text, the same every time."""
    out = io.StringIO()
    figure.savefig(out, format="svg", dpi=160, facecolor="white", metadata={"Date": None, "Creator": None})
    return out.getvalue()
