"""The page of a study: sections of words, tables and figures, self-contained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytracker.report.page import PageFigure, filled

__all__ = ["Section", "Table", "render_study_page"]


@dataclass(frozen=True)
class Table:
    """A table of a page; the first column names the rows.

    Attributes:
        caption: what it is.
        header: a word a column.
        rows: cells as they are shown.
    """

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Section:
    """A part of a page.

    Attributes:
        name: its anchor.
        title: its heading.
        words: paragraphs.
        tables: after the words.
        figures: after the tables.
    """

    name: str
    title: str
    words: Sequence[str] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[PageFigure] = ()


def render_study_page(*, title: str, lead: str, summary: str, sections: Sequence[Section], source: str) -> str:
    """The page as text: `lead` in small print below the title, `source` at the end."""
    return filled("study.html", title=title, lead=lead, summary=summary, sections=sections, source=source)
