"""The page that leads to the demo's two reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import jinja2

from pytracker._core import __version__
from pytracker.evaluate import evaluate
from pytracker.joint_track import Track
from pytracker.report.labels import labels

__all__ = ["render_index"]

TITLES = {
    "arm": ("Arm", "Wrist IMU and one camera that sees a coloured patch, after Tao & Hu (2008)."),
    "body": ("Body", "Upper body from one camera, without markers, after Li & Kulić (2010)."),
}

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>pytracker demo</title><link rel="icon" href="data:,">
<style>
:root { color-scheme: light dark; --ink: #1c2126; --soft: #5a636d; --line: #d9dee4; --paper: #fff; --accent: #0b6e99; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8ebee; --soft: #a7b0ba; --line: #3a424b; --paper: #14181c;
  --accent: #6cc3ea; } }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
main { max-width: 880px; margin: 0 auto; padding: 28px 20px; }
section { border: 1px solid var(--line); border-radius: 8px; padding: 4px 20px 16px; margin: 18px 0; }
video { width: 100%; max-width: 480px; background: #000; border-radius: 6px; }
a { color: var(--accent); } .soft { color: var(--soft); }
table { border-collapse: collapse; width: 100%; } td { padding: .25rem 0; border-bottom: 1px solid var(--line); }
td:last-child { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; padding-left: 1rem; }
</style></head><body><main>
<h1>pytracker demo</h1>
<p class="soft">Two recordings, simulated and tracked by pytracker {{ version }}; errors against the
simulated truth.</p>
{% for kind, title, words, rows in parts %}
<section><h2>{{ title }}</h2><p>{{ words }} <a href="{{ kind }}/index.html">Open the report</a>.</p>
<video controls muted playsinline preload="auto" src="{{ kind }}/overlay.mp4" aria-label="{{ title }}, tracked"></video>
<table>{% for label, error in rows %}<tr><td>{{ label }}</td><td>{{ error }}</td></tr>{% endfor %}</table></section>
{% endfor %}
</main></body></html>
"""


def render_index(tracks: Mapping[str, Sequence[Track]]) -> str:
    """The page as text: for every kind its methods and their errors, and a link to `<kind>/index.html`."""
    parts = []
    for kind, of_kind in tracks.items():
        rows = [(label, _error(track)) for label, track in zip(labels(of_kind), of_kind, strict=True)]
        parts.append((kind, *TITLES[kind], rows))
    return jinja2.Environment(autoescape=True).from_string(PAGE).render(version=__version__, parts=parts)


def _error(track: Track) -> str:
    scores = evaluate(track, track.recording.truth)
    if track.recording.kind == "arm":
        return f"{100 * scores.joints['wrist'].rms_m:.1f} cm RMS of the wrist"
    return f"{100 * scores.average_m:.1f} cm average of eight joints"
