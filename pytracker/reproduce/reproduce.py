"""`reproduce(paper, out)`: the studies of a paper, then its page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from pytracker._core import InputError
from pytracker.output import MADE_HERE, write_whole
from pytracker.reproduce import li_kulic, tao_hu
from pytracker.study import run_study

__all__ = ["PAPERS", "SEEDS", "reproduce"]

PAPERS = ("tao-hu", "li-kulic")
"""What the command line calls them."""

SEEDS = 20
"""How many runs of everything where not said."""

LONGEST_S = 600.0


def _folder(out: Path, paper: str) -> Path:
    """The folder, new or of the same paper. Raises `InputError` where it holds anything else."""
    mark = out / MADE_HERE
    if out.exists() and not (out.is_dir() and (not any(out.iterdir()) or mark.is_file())):
        raise InputError(f"{out}: already exists and is no reproduction, expected a new folder or one to go on with")
    # Killed between making the mark and writing it, it is empty.
    if mark.is_file() and mark.read_text("utf-8") not in ("", paper):
        raise InputError(f"{out}: holds something else than {paper}, expected a new folder or one to go on with")
    out.mkdir(parents=True, exist_ok=True)
    mark.write_text(paper, "utf-8")
    return out


def reproduce(
    paper: str,
    out: Path | str,
    *,
    seeds: int = SEEDS,
    duration_s: float | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Reproduce `tao-hu` or `li-kulic` with `seeds` runs of everything; returns `<out>/index.html`.

    What an earlier call did is used again. `duration_s` of the simulated recordings is the paper's where not said. Raises
    `InputError` for another paper, fewer than two seeds, or a folder that holds something else.
    """
    if paper not in PAPERS:
        raise InputError(f"the paper is {paper!r}, expected one of: {', '.join(PAPERS)}")
    if seeds < 2:
        raise InputError(f"there are {seeds} seeds, expected at least 2: an interval needs them")
    of = tao_hu if paper == "tao-hu" else li_kulic
    duration_s = of.DURATION_S if duration_s is None else duration_s
    if not of.SHORTEST_S <= duration_s <= LONGEST_S:
        raise InputError(f"duration_s is {duration_s}, expected {of.SHORTEST_S:g} to {LONGEST_S:g} s")
    out = _folder(Path(out), paper)
    study = of.make_study(tuple(range(1, seeds + 1)), duration_s)
    table = run_study(study, out / "study", workers=workers, progress=progress)
    from pytracker.reproduce import li_kulic_page, tao_hu_page  # noqa: PLC0415 - Matplotlib is slow

    make_page = tao_hu_page.make_page if paper == "tao-hu" else li_kulic_page.make_page
    page = out / "index.html"
    write_whole(page, make_page(table, seeds, duration_s))
    return page
