"""Figures of a report, each as SVG text: Tao & Hu's Figs. 6 to 8, effective sample size and the patch's timeline."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pytracker.evaluate import WITHIN_M
from pytracker.recording import Truth
from pytracker.rotation import Array
from pytracker.track_arm import ArmTrack

__all__ = ["errors", "path_3d", "sample_size", "trajectories"]

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


def trajectories(tracks: Sequence[ArmTrack], labels: Sequence[str], joint: str = "wrist") -> str:
    """Fig. 6: a joint per axis over time, in cm; the first track with its 95 % band, and the truth."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 6.6), layout="constrained")
        panels = figure.subplots(3, 1, sharex=True)
        truth = _truth(tracks[0], joint)
        main = tracks[0].joints[joint]
        for d, axes in enumerate(panels):
            for k, track in enumerate(tracks):
                _line(axes, track, 100 * track.joints[joint].mean[:, d], k, labels[k])
            axes.fill_between(
                tracks[0].time_s,
                100 * main.lo[:, d],
                100 * main.hi[:, d],
                color=COLOURS[0],
                alpha=0.18,
                lw=0,
                label=f"95 % band of {labels[0]}",
                zorder=1,
            )
            if truth is not None:
                axes.plot(
                    tracks[0].time_s, 100 * truth[:, d], color=TRUTH, lw=1.0, ls=(0, (4, 2)), label="truth", zorder=5
                )
            _limit(axes, [main.mean[:, d], main.lo[:, d], main.hi[:, d]] + ([] if truth is None else [truth[:, d]]))
            _shade_lost(axes, tracks[0])
            axes.set_ylabel(f"{AXES[d]} (cm)")
        panels[-1].set_xlabel("time (s)")
        _legend_above(figure, panels[0])
        return _svg(figure)


def errors(tracks: Sequence[ArmTrack], labels: Sequence[str], joint: str = "wrist") -> str:
    """Fig. 7: error per axis over time, in cm, with the paper's ±5 cm."""
    truth = _truth(tracks[0], joint)
    assert truth is not None
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 5.6), layout="constrained")
        panels = figure.subplots(3, 1, sharex=True)
        for d, axes in enumerate(panels):
            for k, track in enumerate(tracks):
                _line(axes, track, 100 * (track.joints[joint].mean[:, d] - truth[:, d]), k, labels[k])
            for level in (-WITHIN_M, WITHIN_M):
                axes.axhline(100 * level, color="#8a929c", lw=0.9, ls="--")
            main = tracks[0].joints[joint].mean[:, d] - truth[:, d]
            reach = 1.25 * max(2 * WITHIN_M, float(np.nanmax(np.abs(main))))
            axes.set_ylim(-100 * reach, 100 * reach)
            axes.set_ylabel(f"{AXES[d]} error (cm)")
        panels[-1].set_xlabel("time (s)")
        _legend_above(figure, panels[0])
        return _svg(figure)


def path_3d(tracks: Sequence[ArmTrack], labels: Sequence[str]) -> str:
    """Fig. 8: the wrist's path in space, first track and truth, with the arm at the middle of the recording."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.2, 4.4), layout="constrained")
        axes = figure.add_subplot(projection="3d")
        track, truth = tracks[0], _truth(tracks[0], "wrist")
        wrist, elbow = track.joints["wrist"].mean, track.joints["elbow"].mean
        axes.plot(*(100 * wrist).T, color=COLOURS[0], lw=1.0, label=labels[0])
        if truth is not None:
            axes.plot(*(100 * truth).T, color=TRUTH, lw=0.9, ls="--", label="truth")
        tracked = np.flatnonzero(np.isfinite(wrist).all(axis=1))
        if len(tracked):
            at = tracked[len(tracked) // 2]
            arm = 100 * np.stack([np.asarray(track.recording.arm.shoulder_m), elbow[at], wrist[at]])
            axes.plot(*arm.T, color="#5c677d", lw=2.5, marker="o", ms=4, label=f"arm at {track.time_s[at]:.1f} s")
        for name, axis in zip(AXES, (axes.xaxis, axes.yaxis, axes.zaxis), strict=True):
            axis.set_label_text(f"{name} (cm)")
        axes.set_aspect("equal")
        axes.view_init(elev=28, azim=-62)
        figure.legend(loc="outside upper center", ncols=3, fontsize=8)
        return _svg(figure)


def sample_size(tracks: Sequence[ArmTrack], labels: Sequence[str]) -> str:
    """Effective sample size as a share of the particles, and when the patch was lost."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 2.6), layout="constrained")
        axes = figure.subplots()
        for k, track in enumerate(tracks):
            particles = getattr(track.method, "particles", None)
            if particles is not None:
                axes.plot(
                    track.time_s,
                    100 * track.ess / particles,
                    color=COLOURS[k % len(COLOURS)],
                    lw=0.9,
                    label=labels[k],
                    zorder=4 - 0.1 * k,
                )
        _shade_lost(axes, tracks[0])
        axes.set_ylim(0, 100)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("ESS (% of particles)")
        _legend_above(figure, axes)
        return _svg(figure)


def _line(axes: Axes, track: ArmTrack, values: Array, number: int, label: str) -> None:
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


def _truth(track: ArmTrack, joint: str) -> Array | None:
    truth: Truth | None = track.recording.truth
    return None if truth is None or joint not in truth.joints_m else truth.at(joint, track.time_s)


def _limit(axes: Axes, shown: list[Array]) -> None:
    """Show the first track and the truth whole; a method that runs away leaves the frame."""
    values = 100 * np.concatenate(shown)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.12 * max(high - low, 2.0)
    axes.set_ylim(low - margin, high + margin)


def _shade_lost(axes: Axes, track: ArmTrack) -> None:
    """Shaded where the patch was not seen or the IMU not heard."""
    lost = ~track.valid
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(int)))
    step = float(np.median(np.diff(track.time_s))) if len(track.time_s) > 1 else 0.0
    for number, (start, end) in enumerate(edges.reshape(-1, 2)):
        axes.axvspan(
            track.time_s[start],
            track.time_s[end - 1] + step,
            color="#f2b8a0",
            alpha=0.5,
            lw=0,
            zorder=0,
            label="patch not seen, or no IMU" if number == 0 else None,
        )


def _legend_above(figure: Figure, axes: Axes) -> None:
    """In drawing order from front to back: the first track first."""
    handles, names = axes.get_legend_handles_labels()
    order = sorted(range(len(handles)), key=lambda k: -handles[k].get_zorder())
    if handles:
        figure.legend(
            [handles[k] for k in order], [names[k] for k in order], loc="outside upper center", ncols=2, fontsize=8
        )


def _svg(figure: Figure) -> str:
    out = io.StringIO()
    figure.savefig(out, format="svg", facecolor="white", metadata={"Date": None, "Creator": None})
    return out.getvalue()
