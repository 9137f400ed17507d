"""The page that leads to the demo's two reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pytracker.report.labels import labels
from pytracker.report.page import filled
from pytracker.scores.evaluate import Scored, evaluate, held
from pytracker.tracking.tracks import Track

__all__ = ["render_index"]

TITLES = {
    "arm": ("Arm", "Wrist IMU and one camera that sees a coloured patch, after Tao & Hu (2008)."),
    "body": ("Body", "Upper body from one camera, without markers, after Li & Kulić (2010)."),
}
STILL = {"arm": "first position held", "body": "first pose held"}
"""No tracking at all."""
FIGURES = {"arm": "RMS of the wrist", "body": "average of eight joints"}


def render_index(tracks: Mapping[str, Sequence[Track]]) -> str:
    """The page as text: errors of every kind's methods and of no tracking, and a link to `<kind>/index.html`."""
    parts = []
    for kind, of_kind in tracks.items():
        rows = [(label, _error(track, track)) for label, track in zip(labels(of_kind), of_kind, strict=True)]
        rows.append((STILL[kind], _error(of_kind[0], held(of_kind[0]))))
        parts.append((kind, *TITLES[kind], rows))
    return filled("demo.html", title="pytracker demo", parts=parts)


def _error(track: Track, of: Scored) -> str:
    error_m = evaluate(of, track.recording.truth).figure_m(track.judged_by)
    return f"{100 * error_m:.1f} cm {FIGURES[track.recording.kind]}"
