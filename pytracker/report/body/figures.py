"""Figures of a body's report: Li & Kulić's Figs. 2, 6, 7 as SVG text, Figs. 3 and 4 as PNG bytes, angles over time."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from pytracker.formats.video import Image
from pytracker.recording.camera import ProjectionFit
from pytracker.report.drawing import COLOURS, STYLE, TRUTH, legend_above, line, shade_invalid, svg
from pytracker.rotation import Array
from pytracker.scores.evaluate import Scores, average_error
from pytracker.tracking.body import BodyTrack

__all__ = ["angles", "depth_axis", "error_over_frames", "joint_bars", "projection", "wrists"]


def error_over_frames(tracks: Sequence[BodyTrack], labels: Sequence[str]) -> str:
    """Fig. 6: average error over the joints, frame by frame, cm."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 2.9), layout="constrained")
        axes = figure.subplots()
        truth = tracks[0].recording.truth
        assert truth is not None
        for k, track in enumerate(tracks):
            line(axes, track, 100 * average_error(track, truth), k, labels[k])
        shade_invalid(axes, tracks[0])
        axes.set_ylim(bottom=0)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("average error (cm)")
        legend_above(figure, axes)
        return svg(figure)


def joint_bars(scores: Sequence[Scores], labels: Sequence[str]) -> str:
    """Fig. 7: average error of every joint with its standard deviation, cm."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 3.2), layout="constrained")
        axes = figure.subplots()
        joints = list(scores[0].joints)
        width = 0.8 / len(scores)
        for k, (score, label) in enumerate(zip(scores, labels, strict=True)):
            at = np.arange(len(joints)) + (k - (len(scores) - 1) / 2) * width
            mean = [100 * score.joints[joint].average_m for joint in joints]
            sd = [100 * score.joints[joint].average_sd_m for joint in joints]
            axes.bar(at, mean, width, yerr=sd, color=COLOURS[k % len(COLOURS)], label=label,
                     error_kw={"elinewidth": 0.8, "ecolor": "#5c677d", "capsize": 2})  # fmt: skip
        axes.set_xticks(range(len(joints)), [joint.replace("_", "\n") for joint in joints])
        axes.set_ylim(bottom=0)
        axes.set_ylabel("average error (cm)")
        figure.legend(loc="outside upper center", ncols=2, fontsize=8)
        return svg(figure)


def depth_axis(track: BodyTrack) -> int:
    """Which of the world's level axes runs in depth: 0 for x, 2 for z."""
    root = track.joints["root"].mean
    seen = track.camera.viewing_directions(root[np.isfinite(root).all(axis=1)][:1])
    return 0 if len(seen) and abs(seen[0, 0]) > abs(seen[0, 2]) else 2


def wrists(track: BodyTrack, label: str) -> str:
    """Both wrists per axis over time with their 95 % bands, and the truth, cm."""
    truth, in_depth = track.recording.truth, depth_axis(track)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 5.4), layout="constrained")
        panels = figure.subplots(3, 2, sharex=True)
        for column, joint in enumerate(("left_wrist", "right_wrist")):
            found = track.joints[joint]
            at = truth.at(joint, track.time_s) if truth is not None and joint in truth.joints_m else None
            for d, name in enumerate("xyz"):
                axes = panels[d, column]
                axes.fill_between(track.time_s, 100 * found.lo[:, d], 100 * found.hi[:, d], color=COLOURS[0], alpha=0.2,
                                  lw=0, label=f"95 % band of {label}")  # fmt: skip
                line(axes, track, 100 * found.mean[:, d], 0, label)
                if at is not None:
                    axes.plot(
                        track.time_s, 100 * at[:, d], color=TRUTH, lw=0.9, ls=(0, (4, 2)), label="truth", zorder=5
                    )
                shade_invalid(axes, track, joint)
                axes.set_ylabel(f"{name}{', depth' if d == in_depth else ''} (cm)")
            panels[0, column].set_title(joint.replace("_", " "), fontsize=9)
            panels[2, column].set_xlabel("time (s)")
        legend_above(figure, panels[0, 0])
        return svg(figure)


def angles(track: BodyTrack, label: str) -> str:
    """Every tracked angle over time with its 95 % band, and the truth where there is one, degrees."""
    turning = [k for k, name in enumerate(track.free) if not name.split("_")[-1].startswith("t")]
    poses, truth = track.recording.poses, track.recording.truth
    rows = int(np.ceil(len(turning) / 3))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 1.35 * rows + 0.6), layout="constrained")
        panels = figure.subplots(rows, 3, sharex=True, squeeze=False)
        for number, k in enumerate(turning):
            axes = panels.flat[number]
            mean, _, _, lo, hi = np.degrees(track.angles[:, :, k])
            axes.fill_between(track.time_s, lo, hi, color=COLOURS[0], alpha=0.2, lw=0, label=f"95 % band of {label}")
            line(axes, track, mean, 0, label)
            column = track.recording.skeleton.channels.index(track.free[k])
            # In a world that is turned for the camera the root's angles are others than the truth's.
            is_alike = np.allclose(track.angles[0, :, k], track.poses[:, column], equal_nan=True)
            if poses is not None and truth is not None and is_alike:
                inside = (truth.time_s >= track.time_s[0]) & (truth.time_s <= track.time_s[-1])
                axes.plot(truth.time_s[inside], np.degrees(poses[inside, column]), color=TRUTH, lw=0.8,
                          ls=(0, (4, 2)), label="truth", zorder=5)  # fmt: skip
            axes.set_title(f"{track.free[k]} (°)", fontsize=8)
        for axes in panels.flat[len(turning) :]:
            axes.set_visible(False)
        for axes in panels[-1]:
            axes.set_xlabel("time (s)")
        legend_above(figure, panels[0, 0])
        return svg(figure)


def projection(fit: ProjectionFit, frame: Image) -> str:
    """Fig. 2: the points that the projection was fitted to, as clicked and as projected, over a frame."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.4, 4.2), layout="constrained")
        axes = figure.subplots()
        axes.imshow(frame[..., ::-1], alpha=0.6)
        projected: Array = fit.points_m @ fit.matrix[:, :3].T + fit.matrix[:, 3]
        axes.plot(*fit.pixels.T, "o", ms=5, mfc="none", mec="#c8553d", label="given")
        axes.plot(*projected.T, "+", ms=6, color="#0b6e99", label="projected")
        axes.grid(visible=False)
        axes.set_xlabel("u (px)")
        axes.set_ylabel("v (px)")
        legend_above(figure, axes)
        return svg(figure)
