"""Commands on many runs: `study`, `reproduce`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import pytracker as pt
from pytracker.cli.options import Quiet, say, warn
from pytracker.cli.terminal import runs_bar
from pytracker.reproduce import PAPERS, SEEDS

__all__ = ["commands"]

commands = typer.Typer()


@commands.command()
def study(
    file: Annotated[Path, typer.Argument(help="The study, a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for table and results; one of a study is gone on with.")],
    scheduler: Annotated[str, typer.Option(help="A Dask scheduler, tcp://HOST:PORT; without it threads here.")] = "",
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; as many as cores where not said.")] = None,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write table.parquet besides table.csv.")] = False,
    quiet: Quiet = False,
) -> None:
    """Run recordings x methods x seeds and write one table and a page; what is done already is not done again."""
    with runs_bar(quiet) as progress:
        table = pt.run_study(
            pt.read_study(file), out, scheduler=scheduler, workers=workers, parquet=parquet, progress=progress
        )
    say(f"table: {out / 'table.csv'}, page: {out / 'index.html'}", quiet)
    for status, words in (("lost", "lost the track before the end"), ("failed", "failed")):
        if count := table.count(status):
            warn((f"{count} runs {words}, the first: {table.where(status=status)[0]['error']}",))
    warn(tuple(f"{name}: {words}" for name, words in sorted(table.said().items())))
    if table.count("failed"):
        raise typer.Exit(1)


@commands.command()
def reproduce(
    paper: Annotated[str, typer.Argument(help=f"Which paper: {', '.join(PAPERS)}.")],
    out: Annotated[Path, typer.Option(help="Folder for page and results; one of a reproduction is gone on with.")],
    seeds: Annotated[int, typer.Option(min=2, help="How many runs of everything.")] = SEEDS,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; as many as cores where not said.")] = None,
    quiet: Quiet = False,
) -> None:
    """Run a paper's tables and figures again and write a page with our figures beside the printed ones."""
    with runs_bar(quiet) as progress:
        page = pt.reproduce(paper, out, seeds=seeds, workers=workers, progress=progress)
    say(f"page: {page}", quiet)
