"""The command for a camera that is there now: `live`."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Annotated, TextIO

import typer

import pytracker as pt
from pytracker.cli.options import Folder, Force, Seed, check_new, warn
from pytracker.cli.settings import METHOD_WORDS, chosen_method
from pytracker.live import Live, Rows
from pytracker.live import live as estimates_of

__all__ = ["commands"]

commands = typer.Typer()

BEST = {"arm": "mixture", "body": "partitioned"}
"""Of those that filter."""


@commands.command()
def live(
    folder: Folder,
    camera: Annotated[str, typer.Option(help="A camera's number, its address, or a video, played at its own pace.")],
    sensor: Annotated[
        str, typer.Option(help="Where an arm's sensor comes from: a pipe or serial device; - is what is piped in.")
    ] = "-",
    out: Annotated[Path | None, typer.Option(help="CSV to write; without it rows are printed.")] = None,
    method: Annotated[str, typer.Option(help=f"{METHOD_WORDS} Without it mixture, partitioned.")] = "",
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="As `track --help` lists them; repeatable.")
    ] = None,
    seed: Seed = 0,
    delay: Annotated[float, typer.Option(min=0.0, max=10.0, help="Put in order what comes so much later, s.")] = 0.1,
    late: Annotated[float, typer.Option(min=0.0, max=10.0, help="So long after it was seen a frame arrives, s.")] = 0.0,
    force: Force = False,
) -> None:
    """Follow what a camera sees now, a row a frame, until it ends or Ctrl-C.

    The recording in the folder was made with this camera where it stands, this sensor as it is worn and this person,
    who begins as in its first frame; `check --write` found what it says. A sensor's first line names the columns time_s
    (its own clock), acc_x..z (m/s²), q_w..z (sensor to world, z up) and, where there is one, gyr_x..z (rad/s).
    """
    if out is not None:
        check_new(out, ".csv", force=force)
    recording = pt.load(folder)
    chosen = chosen_method(recording.kind, method or BEST[recording.kind], None, settings or [])
    warn(recording.warnings)
    counts, lines, said = Live(), _lines(sensor), ""
    estimates = estimates_of(
        recording, chosen, camera, lines, seed=seed, delay_s=delay, late_s=late, progress=counts,
        warn=lambda words: warn((words,)),
    )  # fmt: skip
    try:
        with _rows(out) as file, closing(estimates):
            rows = Rows(file)
            for estimate, reason in estimates:
                rows.write(estimate, reason)
                if reason != said:
                    print(f"{estimate.time_s:.2f} s: {reason or 'right again'}", file=sys.stderr)
                    said = reason
    finally:
        _say(counts)


@contextmanager
def _rows(out: Path | None) -> Iterator[TextIO]:
    if out is None:
        yield sys.stdout
        return
    with out.open("w", encoding="utf-8", newline="") as file:
        yield file


def _lines(sensor: str) -> TextIO:
    """Line by line; of what is piped in by a file of its own, which whoever waits for a line holds when we leave."""
    if sensor == "-":
        return os.fdopen(os.dup(0), encoding="utf-8")
    if not Path(sensor).exists():
        raise pt.InputError(f"{sensor}: no such pipe or device, expected where the sensor's lines come from")
    return Path(sensor).open(encoding="utf-8")


def _say(counts: Live) -> None:
    if not counts.frames:
        return
    skipped = f"; {counts.skipped} came faster than they were worked on and were left out" if counts.skipped else ""
    refused = f"; {counts.refused} observations were refused, the first: {counts.words}" if counts.refused else ""
    valid = counts.frames - counts.invalid
    print(f"pytracker: {counts.frames} frames, {valid} of them valid{skipped}{refused}", file=sys.stderr)
