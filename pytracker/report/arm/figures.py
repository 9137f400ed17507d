"""Figures of an arm's report, each as SVG text: Tao & Hu's Figs. 6 to 8."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from pytracker.report.drawing import AXES, COLOURS, STYLE, TRUTH, legend_above, limit, line, shade_invalid, svg, true
from pytracker.scores.evaluate import WITHIN_M
from pytracker.tracking.arm import ArmTrack

__all__ = ["errors", "path_3d", "trajectories"]


def trajectories(tracks: Sequence[ArmTrack], labels: Sequence[str], joint: str = "wrist") -> str:
    """Fig. 6: a joint per axis over time, in cm; the first track with its 95 % band, and the truth."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 6.6), layout="constrained")
        panels = figure.subplots(3, 1, sharex=True)
        truth = true(tracks[0], joint)
        main = tracks[0].joints[joint]
        for d, axes in enumerate(panels):
            for k, track in enumerate(tracks):
                line(axes, track, 100 * track.joints[joint].mean[:, d], k, labels[k])
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
            limit(axes, [main.mean[:, d], main.lo[:, d], main.hi[:, d]] + ([] if truth is None else [truth[:, d]]))
            shade_invalid(axes, tracks[0])
            axes.set_ylabel(f"{AXES[d]} (cm)")
        panels[-1].set_xlabel("time (s)")
        legend_above(figure, panels[0])
        return svg(figure)


def errors(tracks: Sequence[ArmTrack], labels: Sequence[str], joint: str = "wrist") -> str:
    """Fig. 7: error per axis over time, in cm, with the paper's ±5 cm."""
    truth = true(tracks[0], joint)
    assert truth is not None
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 5.6), layout="constrained")
        panels = figure.subplots(3, 1, sharex=True)
        for d, axes in enumerate(panels):
            for k, track in enumerate(tracks):
                line(axes, track, 100 * (track.joints[joint].mean[:, d] - truth[:, d]), k, labels[k])
            for level in (-WITHIN_M, WITHIN_M):
                axes.axhline(100 * level, color="#8a929c", lw=0.9, ls="--")
            main = tracks[0].joints[joint].mean[:, d] - truth[:, d]
            reach = 1.25 * max(2 * WITHIN_M, float(np.nanmax(np.abs(main))))
            axes.set_ylim(-100 * reach, 100 * reach)
            axes.set_ylabel(f"{AXES[d]} error (cm)")
        panels[-1].set_xlabel("time (s)")
        legend_above(figure, panels[0])
        return svg(figure)


def path_3d(tracks: Sequence[ArmTrack], labels: Sequence[str]) -> str:
    """Fig. 8: the wrist's path in space, first track and truth, with the arm at the middle of the recording."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.2, 4.4), layout="constrained")
        axes = figure.add_subplot(projection="3d")
        track, truth = tracks[0], true(tracks[0], "wrist")
        wrist, elbow = track.joints["wrist"].mean, track.joints["elbow"].mean
        if (np.isfinite(wrist).all(axis=1) & ~track.valid).any():
            axes.plot(*(100 * wrist).T, color=COLOURS[0], lw=0.6, ls=":", alpha=0.5, label="not valid")
        axes.plot(*(100 * np.where(track.valid[:, None], wrist, np.nan)).T, color=COLOURS[0], lw=1.0, label=labels[0])
        if truth is not None:
            axes.plot(*(100 * truth).T, color=TRUTH, lw=0.9, label="truth")
        tracked = np.flatnonzero(np.isfinite(wrist).all(axis=1) & track.valid)
        if len(tracked):
            at = tracked[len(tracked) // 2]
            arm = 100 * np.stack([np.asarray(track.recording.arm.shoulder_m), elbow[at], wrist[at]])
            axes.plot(*arm.T, color="#5c677d", lw=2.5, marker="o", ms=4, label=f"arm at {track.time_s[at]:.1f} s")
        for name, axis in zip(AXES, (axes.xaxis, axes.yaxis, axes.zaxis), strict=True):
            axis.set_label_text(f"{name} (cm)")
        axes.set_aspect("equal")
        axes.view_init(elev=28, azim=-62)
        figure.legend(loc="outside upper center", ncols=2, fontsize=8)
        return svg(figure)
