"""What a page is made by, kind of recording by kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pytracker.formats.video import Image
from pytracker.report.arm.overlay import draw_arm, write_arm_overlay
from pytracker.report.arm.page import render_arm_page
from pytracker.report.body.overlay import draw_body, write_body_overlay
from pytracker.report.body.page import render_body_page

__all__ = ["PAGES", "Page"]


@dataclass(frozen=True)
class Page:
    """Of one kind.

    Attributes:
        render: tracks, contents and `has_overlay` to the page as text.
        write_overlay: path, track and an event that stops it: the video.
        draw: image, track and row: one frame of it.
    """

    render: Callable[..., str]
    write_overlay: Callable[..., bool]
    draw: Callable[[Image, Any, int], Image]


PAGES: Mapping[str, Page] = {
    "arm": Page(render_arm_page, write_arm_overlay, draw_arm),
    "body": Page(render_body_page, write_body_overlay, draw_body),
}
