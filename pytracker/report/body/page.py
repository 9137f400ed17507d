"""The page of a body's report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytracker._core import KEY_JOINTS
from pytracker.report.body import figures
from pytracker.report.body.evidence import evidence_pictures
from pytracker.report.contents import Contents
from pytracker.report.drawing import sample_size
from pytracker.report.page import PageFigure, embedded, not_believed, of_frames, render
from pytracker.scores.evaluate import Scores, error_by_speed
from pytracker.tracking.body import BodyTrack

__all__ = ["render_body_page"]


def render_body_page(tracks: Sequence[BodyTrack], contents: Contents, *, has_overlay: bool) -> str:
    """The page as text."""
    labels, scores = contents.labels, contents.scores
    main, truth = tracks[0], tracks[0].recording.truth
    return render(
        "body.html",
        contents,
        title="Body track",
        summary=_summary(main, labels[0], scores[0]),
        figures=_figures(tracks, labels, scores),
        has_overlay=has_overlay,
        depth="xyz"[figures.depth_axis(main)],
        joints=[joint for joint in KEY_JOINTS if scores[0] is None or joint in scores[0].joints],
        fit=main.recording.view.fit,
        speeds=error_by_speed(main, truth) if truth is not None and scores[0] is not None else [],
    )


def _summary(track: BodyTrack, label: str, scores: Scores | None) -> str:
    """What a clinician reads: one paragraph, in words and centimetres."""
    band = np.nanmean(
        [(track.joints[j].hi - track.joints[j].lo) / 2 for j in ("left_wrist", "right_wrist")], axis=(0, 1)
    )
    depth = figures.depth_axis(track)
    sideways_cm, height_cm, depth_cm = (100 * band[axis] for axis in (2 - depth, 1, depth))
    alone = track.recording.view.video is None
    left, right = (100 * track.joints[f"{side}_wrist"].valid.mean() for side in ("left", "right"))
    known = f"The left wrist is valid in {left:.0f} %, the right one in {right:.0f} % of the frames."
    words = (
        f"The upper body was followed for {track.time_s[-1] - track.time_s[0]:.1f} s ({len(track.time_s)} camera "
        f"frames) by “{label}”. {not_believed(track)}"
        f"{'There was no video, only keypoints of one. ' if alone else ''}{known} The tracker states its own "
        f"uncertainty of the wrists as a 95 % band of on average ±{sideways_cm:.1f} cm sideways, ±{height_cm:.1f} cm "
        f"in height and ±{depth_cm:.1f} cm in depth, which a single camera does not see."
    )
    besides = _besides(track)
    if besides and not alone:
        words += f" {besides} told besides where the arms are."
    if scores is not None:
        scored = max(joint.frames for joint in scores.joints.values())
        words += (
            f" Against the truth{of_frames(scored, track)} the {len(scores.joints)} joints are "
            f"{100 * scores.average_m:.1f} cm off on average (standard deviation {100 * scores.average_sd_m:.1f} cm)."
        )
    return words


def _besides(track: BodyTrack) -> str:
    """The senses that were used beside the picture, in words."""
    recording, cues = track.recording, track.method.cues
    senses = ["A detector's keypoints"] if recording.view.keypoints is not None and "keypoints" in cues else []
    if recording.imus and "orientation" in cues:
        worn = ", ".join(imu.segment.replace("_", " ") for imu in recording.imus)
        senses.append(f"{'inertial' if senses else 'Inertial'} sensors ({worn})")
    return " and ".join(senses)


def _figures(tracks: Sequence[BodyTrack], labels: Sequence[str], scores: Sequence[Scores | None]) -> list[PageFigure]:
    main = tracks[0]
    made: list[tuple[str, str, str | bytes]] = []
    known = [score for score in scores if score is not None]
    if len(known) == len(scores):
        average = 100 * known[0].average_m
        alt = (
            f"Average error over eight joints in every frame by {len(tracks)} method(s); {labels[0]}: {average:.1f} cm"
        )
        made.append(("Average error over frames", alt, figures.error_over_frames(tracks, labels)))
        alt = "Average error of every joint with its standard deviation: small at the trunk, larger along the arms"
        made.append(("Error of the joints", alt, figures.joint_bars(known, labels)))
    made += [
        (
            "Wrists over time",
            f"Both wrists per axis over time with the 95 % band of {labels[0]}; shaded where a wrist is not valid",
            figures.wrists(main, labels[0]),
        ),
        (
            "Angles over time",
            f"Every tracked angle over time with the 95 % band of {labels[0]}",
            figures.angles(main, labels[0]),
        ),
    ]
    if main.shown is not None:
        image, foreground, cues = evidence_pictures(main)
        made += [
            ("Foreground", "A frame; its foreground, white on black", foreground),
            ("Edges and skin", "The same frame; its edges within the foreground; its skin", cues),
        ]
        if main.recording.view.fit is not None:
            alt = "Points that the projection was fitted to, as given and as projected"
            made.append(("Projection", alt, figures.projection(main.recording.view.fit, image)))
    if any(np.isfinite(track.ess).any() for track in tracks):
        alt = "Effective sample size over time as a share of the particles"
        made.append(("Effective sample size", alt, sample_size(tracks, labels)))
    return [embedded(title, alt, picture) for title, alt, picture in made]
