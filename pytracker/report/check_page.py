"""The page of a check: every line, the patch in the first frame, and both signals laid over each other."""

from __future__ import annotations

from collections import Counter
from functools import singledispatch

import matplotlib as mpl
from matplotlib.figure import Figure

from pytracker.evidence.grid import draw_grid, png_of
from pytracker.formats.video import Image, frames
from pytracker.report.body.overlay import draw_body
from pytracker.report.drawing import COLOURS, STYLE, legend_above, svg
from pytracker.report.page import PageFigure, embedded, filled
from pytracker.setup.check import Checkup
from pytracker.setup.draft import Draft
from pytracker.tracking.body import BodyTrack

__all__ = ["render_check"]


def render_check(checkup: Checkup) -> str:
    """The page as text."""
    counts = Counter(finding.verdict for finding in checkup.findings)
    words = ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common())
    ready = "Nothing is missing or wrong." if checkup.is_ready else "Not ready yet: see what is missing or wrong."
    return filled(
        "check.html",
        title=f"Check: {checkup.folder.resolve().name}",
        summary=f"{ready} {len(checkup.findings)} things were looked at: {words}.",
        findings=checkup.findings,
        figures=[*_first_frame(checkup), *_laid_over(checkup)],
    )


def _first_frame(checkup: Checkup) -> list[PageFigure]:
    file = Draft(checkup.folder).file("camera.video")
    frame = None if file is None or not file.is_file() else next(frames(file), None)
    if frame is None:
        return []
    return [_drawn(checkup.track, checkup, frame.image)]


@singledispatch
def _drawn(track: object, checkup: Checkup, image: Image) -> PageFigure:
    """The first frame with what is found in it: of an arm, or before anything is tracked."""
    box = None if checkup.patch_box is None else tuple(int(value) for value in checkup.patch_box)
    image = draw_grid(image, None if box is None else (box[0], box[1], box[2], box[3]))
    alt = "The first frame with a grid in pixels" + ("" if box is None else f" and the patch's box, {list(box)}")
    return embedded("The first frame", alt, png_of(image))


@_drawn.register
def _(track: BodyTrack, checkup: Checkup, image: Image) -> PageFigure:
    alt = "The first frame with the skeleton, green, and its outer shape, white, as they are tracked"
    return embedded("The first frame", alt, png_of(draw_body(image, track, 0)), is_wide=False)


def _laid_over(checkup: Checkup) -> list[PageFigure]:
    if checkup.laid_over is None:
        return []
    time_s, seen, by_imu = checkup.laid_over
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 2.8), layout="constrained")
        axes = figure.subplots()
        axes.plot(time_s, seen, color=COLOURS[0], lw=1.2, label="the patch, in the picture")
        axes.plot(time_s, by_imu, color=COLOURS[1], lw=1.0, ls="--", label="the IMU, as the picture should show it")
        axes.set(xlabel="time (s)", ylabel="way (px)")
        legend_above(figure, axes)
        picture = svg(figure)
    alt = "The patch's way in the picture, and what the IMU's movement makes of it: they should lie on each other"
    return [embedded("Both clocks", alt, picture)]
