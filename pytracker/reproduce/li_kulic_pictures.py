"""Li & Kulić (2010): what the page draws of the recording of seed 1."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from pytracker.evidence.picture.silhouette import Silhouette
from pytracker.evidence.picture.smaller import smaller
from pytracker.evidence.senses import senses_of
from pytracker.formats.video import frames
from pytracker.recording.recording import BodyRecording
from pytracker.report.body import figures as body_figures
from pytracker.report.body.evidence import evidence_pictures, side_by_side
from pytracker.report.body.overlay import draw_body
from pytracker.report.page import embedded
from pytracker.report.study.figures import errors_of_runs, sheet
from pytracker.report.study.page import Section, Table
from pytracker.reproduce import printed
from pytracker.scores.evaluate import average_error
from pytracker.tracking.body import BodyTrack

__all__ = ["evidence", "frames_shown", "over_frames", "projection", "rate"]

FRAMES_OF_FIG_9 = 12


def projection(recording: BodyRecording, example: BodyTrack) -> Section:
    """Table II and Fig. 2."""
    fit = recording.view.fit
    assert fit is not None
    per_m = 1 / printed.ACCLAIM_UNIT_M
    rows = []
    for name, paper in printed.TABLE_II.items():
        row, column = "ab".index(name[0]), {"x": 0, "y": 1, "constant": 3}[name.split()[-1]]
        scale = 1.0 if column == 3 else per_m
        theirs = [scale * value for value in paper]
        ours = [values[row, column] for values in (fit.matrix, fit.low, fit.high)]
        unit = "px" if column == 3 else "px/m"
        cells = [f"{v:.1f} ({low:.1f}, {high:.1f})" for v, low, high in (theirs, ours)]
        rows.append([f"{name}, {unit}", *cells])
    goodness = {"SSE": fit.sse, "R²": fit.r2, "adjusted R²": fit.adjusted_r2, "RMSE, px": fit.rmse}
    fits = [
        [f"{name}, {row}", f"{printed.TABLE_II_GOODNESS[name][k]:g}", f"{values[k]:.4g}"]
        for k, row in enumerate("uv")
        for name, values in goodness.items()
    ]
    assert recording.view.video is not None
    image = next(frame.image for frame in frames(recording.view.video) if frame.index == len(example.time_s) // 2)
    return Section(
        "projection",
        "Table II and Fig. 2: weak perspective",
        (
            "Least squares on point pairs. The paper clicked 35 points in its images (its SSE and RMSE imply 42); ours are 35 "
            "joints of the simulated person with 0.3 px of noise, seen by a perspective camera 4 m away: what is left over is "
            "what weak perspective leaves out. The paper's coefficients are turned from Acclaim units (0.0564 m) to metres; "
            "camera and distance are others.",
        ),
        (
            Table("Coefficients with 95 % bounds", ["coefficient", "paper", "ours"], rows),
            Table("Goodness of fit", ["measure", "paper", "ours"], fits),
        ),
        (
            embedded(
                "Fig. 2: points as given and as projected.",
                "A frame with the points that the projection was fitted to, as given and as projected",
                body_figures.projection(fit, image),
                is_wide=False,
            ),
        ),
    )


def evidence(example: BodyTrack) -> Section:
    """Figs. 3 and 4."""
    image, _, cues = evidence_pictures(example)
    senses = senses_of(example.recording)
    extract = senses.silhouette
    assert extract is not None
    assert example.shown is not None
    in_grey = Silhouette(
        extract.background, extract.px2_per_m2**0.5, dataclasses.replace(extract.parameters, colour=False)
    )
    foreground = side_by_side(image, in_grey(smaller(image, senses.shrunk)).foreground, example.shown.foreground)
    return Section(
        "evidence",
        "Figs. 3 and 4: evidence",
        ("The paper prefers colour to grey: it keeps parts of the person that are as bright as the wall.",),
        (),
        (
            embedded("Fig. 3: a frame, its foreground from grey, from colour.",
                     "A frame and its foreground, white on black, found in grey and found in colour", foreground),
            embedded("Fig. 4: the frame, its edges, its skin.",
                     "A frame, the edges within its foreground, and its blobs of skin: head and hands", cues),
        ),
    )  # fmt: skip


def over_frames(tracks: Sequence[BodyTrack]) -> Section:
    """Fig. 6."""
    truth = tracks[0].recording.truth
    assert truth is not None
    errors = np.stack([average_error(found, truth) for found in tracks])
    return Section(
        "over-frames",
        "Fig. 6: error over frames",
        (f"The recording of seed 1, tracked {len(tracks)} times with 300 particles and other seeds.",),
        (),
        (
            embedded(
                "Fig. 6: average error of the eight joints, frame by frame.",
                "Average error over time, mean and range of the runs",
                errors_of_runs(tracks[0].time_s, errors),
            ),
        ),
    )


def frames_shown(example: BodyTrack) -> Section:
    """Fig. 9."""
    step = max(1, len(example.time_s) // FRAMES_OF_FIG_9)
    chosen = set(range(step // 2, len(example.time_s), step))
    assert example.recording.view.video is not None
    images = [
        draw_body(frame.image, example, frame.index)
        for frame in frames(example.recording.view.video)
        if frame.index in chosen
    ]
    return Section(
        "frames",
        "Fig. 9: frames of the tracked video",
        (),
        (),
        (
            embedded(
                "Fig. 9: green skeleton, white outer shape, red circles around the skin that was given to head and hands.",
                "Frames of the simulated person with the tracked skeleton and rectangles drawn over them",
                sheet(images[:FRAMES_OF_FIG_9], 3),
            ),
        ),
    )


def rate(example: BodyTrack, took_s: float) -> Section:
    """How fast the paper's filter was, from file to estimate in `took_s`."""
    count = len(example.time_s)
    rows = [[stage, f"{1000 * seconds / count:.2f}"] for stage, seconds in example.stage_s.items()]
    return Section(
        "rate",
        "Rate",
        (
            f"{count} frames in {took_s:.2f} s: {count / took_s:.0f} frames a second from file to estimate, on the machine "
            f"that made this page; the paper: {printed.RATE_HZ}. The evidence of the next frame is extracted while the filter "
            "works on this one.",
        ),
        (Table("Time per frame and stage, ms", ["stage", "ms"], rows),),
    )
