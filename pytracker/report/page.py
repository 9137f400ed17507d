"""`index.html`: one self-contained page (but for the video beside it) that prints on A4."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import jinja2

from pytracker._core import __version__
from pytracker.doubting.doubts import is_unusable, unbelieved
from pytracker.report.contents import Contents
from pytracker.report.stretches import stretches_of
from pytracker.tracking.tracks import Track

__all__ = ["PageFigure", "embedded", "filled", "not_believed", "of_frames", "render"]


@dataclass(frozen=True)
class PageFigure:
    """A figure of a page.

    Attributes:
        title: heading.
        alt: what it shows, in words.
        source: the picture as a data URI.
        is_wide: whether it takes the whole width; others stand side by side.
    """

    title: str
    alt: str
    source: str
    is_wide: bool = True


def embedded(title: str, alt: str, picture: str | bytes, *, is_wide: bool = True) -> PageFigure:
    """A figure from SVG text or the bytes of a PNG."""
    raw, kind = (picture.encode(), "svg+xml") if isinstance(picture, str) else (picture, "png")
    return PageFigure(title, alt, f"data:image/{kind};base64,{base64.b64encode(raw).decode()}", is_wide)


def render(
    template: str,
    contents: Contents,
    *,
    title: str,
    summary: str,
    figures: Sequence[PageFigure],
    has_overlay: bool,
    **more: object,
) -> str:
    """The page as text: `template` within the frame that all pages share."""
    tracks, labels, scores = contents.tracks, contents.labels, contents.scores
    main = tracks[0]
    return filled(
        template,
        title=title + (f": {main.recording.folder.name}" if main.recording.folder else ""),
        summary=summary,
        rows=list(zip(labels, scores, tracks, strict=True)),
        has_truth=scores[0] is not None,
        figures=figures,
        has_overlay=has_overlay,
        stretches=stretches_of(main),
        warnings=dict.fromkeys((*unbelieved(main), *main.recording.warnings, *contents.doubts[0])),
        doubts_of_others=contents.doubts_of_others,
        parameters=[
            (label, track.seed, track.method.parameters()) for label, track in zip(labels, tracks, strict=True)
        ],
        main=main,
        held=contents.trivial,
        **more,
    )


def not_believed(track: Track) -> str:
    """A sentence, and a space, where most of a track is not to be believed; else empty."""
    return "In most of them it is not to be believed: see the warnings. " if is_unusable(track) else ""


def of_frames(scored: int, track: Track) -> str:
    """Words, after a space, where the truth covers fewer than all frames; else empty."""
    return f" of {scored} of them" if scored < len(track.time_s) else ""


def filled(template: str, **values: object) -> str:
    """A template of this package as text."""
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(
            lambda name: (resources.files("pytracker.report") / "templates" / name).read_text("utf-8")
        ),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(version=__version__, **values)
