"""What several commands share: options, a check, words to the user."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import pytracker as pt

__all__ = ["Folder", "Force", "NoReport", "Out", "Quiet", "Seed", "Settings", "check_new", "say", "warn"]

Folder = Annotated[Path, typer.Argument(help="Recording folder (holds recording.toml).")]
Out = Annotated[Path, typer.Option(help="Folder to write; one that exists needs --force.")]
Seed = Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Seed of the random streams.")]
Force = Annotated[bool, typer.Option("--force", help="Replace what is there.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress, no tables.")]
NoReport = Annotated[bool, typer.Option("--no-report", help="Tables only: no page, figures or overlay.")]

Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Any other parameter, listed below; repeatable."),
]


def check_new(out: Path, suffix: str, *, force: bool) -> None:
    """A file that may be written. Raises `InputError`."""
    if out.suffix.lower() != suffix:
        raise pt.InputError(f"{out}: expected a name that ends in {suffix}")
    if not out.resolve().parent.is_dir():
        raise pt.InputError(f"{out}: there is no folder {out.parent}, expected one")
    if out.exists() and not force:
        raise pt.InputError(f"{out}: already exists, expected a new file (or --force to replace it)")


def warn(warnings: tuple[str, ...]) -> None:
    """Lines on the error stream."""
    for warning in warnings:
        print(f"pytracker: warning: {warning}", file=sys.stderr)


def say(words: str, quiet: bool) -> None:
    """A line, unless it was asked to be quiet."""
    if not quiet:
        print(words)
