"""The page of an arm's report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytracker.doubting.doubts import is_unusable
from pytracker.methods.arm import Mixture
from pytracker.report.arm import figures
from pytracker.report.contents import Contents
from pytracker.report.drawing import sample_size
from pytracker.report.page import PageFigure, embedded, not_believed, of_frames, render
from pytracker.scores.evaluate import Scores
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.found import found_by

__all__ = ["render_arm_page"]


def render_arm_page(tracks: Sequence[ArmTrack], contents: Contents, *, has_overlay: bool) -> str:
    """The page as text."""
    labels, scores = contents.labels, contents.scores
    return render(
        "arm.html",
        contents,
        title="Arm track",
        summary=_summary(tracks[0], labels[0], scores[0]),
        figures=_figures(tracks, labels, scores[0]),
        has_overlay=has_overlay,
        shoulder=_shoulder(tracks[0]),
        # What a wrong track makes of the set-up says nothing of it.
        found=() if is_unusable(tracks[0]) else found_by(tracks[0]),
    )


def _summary(track: ArmTrack, label: str, scores: Scores | None) -> str:
    """What a clinician reads: one paragraph, in words and centimetres."""
    seen = 100 * track.sightings.valid.mean()
    by_keypoints = all(view.patch_box is None and view.keypoints is not None for view in track.recording.views)
    what = "wrist (a detector's keypoint)" if by_keypoints else "patch"
    half = 100 * np.nanmean((track.joints["wrist"].hi - track.joints["wrist"].lo) / 2, axis=0)
    words = (
        f"The wrist was followed for {track.time_s[-1] - track.time_s[0]:.1f} s ({len(track.time_s)} camera frames) by "
        f"“{label}”. {not_believed(track)}The {what} was seen in {seen:.1f} % of the frames. "
        f"{_senses(track)}The tracker states its own uncertainty as a 95 % band of on average ±{half[0]:.1f} cm across "
        f"(x), ±{half[1]:.1f} cm in y and ±{half[2]:.1f} cm in height (z)."
    )
    if scores is not None:
        wrist = scores.joints["wrist"]
        words += (
            f" Against the truth{of_frames(wrist.frames, track)} the wrist is {100 * wrist.rms_m:.1f} cm off (3-D root "
            "mean square), at worst "
            f"{100 * wrist.worst_m:.1f} cm, and the bands hold the truth in "
            f"{', '.join(f'{100 * c:.0f} %' for c in wrist.coverage)} of the frames (x, y, z; 95 % would be ideal)."
        )
    return words


def _shoulder(track: ArmTrack) -> str:
    """What no recording of an arm shows, for who reads nothing but the page; empty where no shoulder holds the arm."""
    stays_m = track.method.shoulder_stays_m
    if stays_m is None:
        return ""
    stays = f"to stay within ±{100 * stays_m:.0f} cm of its place" if stays_m else "not to move"
    return (
        f"How far away the hand is hangs on the shoulder, which is taken {stays}. Who leans farther, towards the "
        "camera or away from it, is followed too near or too far by as much, and nothing here shows it."
    )


def _senses(track: ArmTrack) -> str:
    """What else there was, and whether it was used; ends with a space where it says something."""
    recording = track.recording
    landmarks = track.sightings.landmarks
    seen = {joint: [of.pixels for of in landmarks if of.joint == joint] for joint in recording.landmarks}
    there = [
        f"the {joint} (seen in {100 * np.mean([np.isfinite(of_camera).all(axis=1).mean() for of_camera in of]):.0f} %)"
        for joint, of in seen.items()
        if of
    ]
    there += ["a sensor on the upper arm"] if recording.has_upper_arm else []
    if not there:
        return ""
    used = "used" if isinstance(track.method, Mixture) else "not used by this method"
    each = f"{', '.join(there[:-1])}{' and ' if there[:-1] else ''}{there[-1]}"
    return f"Besides, there was more to go by, which was {used}: {each}. "


def _figures(tracks: Sequence[ArmTrack], labels: Sequence[str], scores: Scores | None) -> list[PageFigure]:
    made = [
        (
            "Wrist over time",
            f"Wrist position per axis over time by {len(tracks)} method(s), with the 95 % band of {labels[0]}"
            + (" and the truth" if scores else ""),
            figures.trajectories(tracks, labels),
        )
    ]
    if scores is not None:
        rms = 100 * scores.joints["wrist"].rms_m
        alt = f"Error per axis over time with lines at plus and minus 5 cm; {labels[0]} has {rms:.1f} cm 3-D RMS"
        made.append(("Error over time", alt, figures.errors(tracks, labels)))
    made.append(
        ("Path in space", f"Path of the wrist in space by {labels[0]}, with the arm", figures.path_3d(tracks, labels))
    )
    if any(np.isfinite(track.ess).any() for track in tracks):
        alt = "Effective sample size over time as a share of the particles; shaded where it is not valid"
        made.append(("Effective sample size", alt, sample_size(tracks, labels)))
    return [embedded(title, alt, svg) for title, alt, svg in made]
