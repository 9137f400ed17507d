"""A calibration board as a page to print."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from pytracker.evidence.boards import Board
from pytracker.output import whole_file

__all__ = ["write_board"]

MARGIN_MM = 10.0
MM_PER_INCH = 25.4


def write_board(board: Board, out: Path, *, force: bool = False) -> None:
    """A PDF page of the board in true size, with its size on it. Print without scaling, and measure a square."""
    columns, rows = board.squares
    square_mm = 1000 * board.square_m
    width, height = columns * square_mm, rows * square_mm
    page = (width + 2 * MARGIN_MM, height + 3 * MARGIN_MM)
    with mpl.rc_context({"savefig.facecolor": "white", "pdf.compression": 6}):
        figure = Figure(figsize=(page[0] / MM_PER_INCH, page[1] / MM_PER_INCH))
        axes = figure.add_axes((
            MARGIN_MM / page[0], 2 * MARGIN_MM / page[1], width / page[0], height / page[1],
        ))  # fmt: skip
        axes.imshow(board.drawn(), cmap="gray", vmin=0, vmax=255, interpolation="nearest", aspect="auto")
        axes.axis("off")
        words = f"{board.kind}, {columns} x {rows} squares of {square_mm:g} mm: print in true size, measure a square"
        figure.text(MARGIN_MM / page[0], 0.8 * MARGIN_MM / page[1], words, fontsize=8)
        with whole_file(out, force=force) as partial:
            figure.savefig(partial, format="pdf", metadata={"CreationDate": None})
