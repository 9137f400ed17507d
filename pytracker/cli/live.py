"""The command for a camera that is there now: `live`."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Annotated, TextIO

import typer

import pytracker as pt
from pytracker.cli.options import Folder, Force, Seed, check_new, warn
from pytracker.cli.settings import METHOD_WORDS, chosen_method
from pytracker.doubting.doubts import FEW_VALID
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
    who begins as in its first frame; `check --write` found what it says. Where most frames are not valid the exit
    status is 1. A sensor's first line names the columns time_s (its own clock), acc_x..z
    (m/s²), q_w..z (sensor to world, z up) and, where there is one, gyr_x..z (rad/s).
    """
    if out is not None:
        check_new(out, ".csv", force=force)
    recording = pt.load(folder)
    chosen = chosen_method(recording.kind, method or BEST[recording.kind], None, settings or [])
    warn(recording.warnings)
    counts, said = Live(), ""
    estimates = estimates_of(
        recording, chosen, camera, _lines(sensor), seed=seed, delay_s=delay, late_s=late, progress=counts,
        warn=lambda words: warn((words,)),
    )  # fmt: skip
    try:
        with ExitStack() as open_until_the_end:
            open_until_the_end.enter_context(closing(estimates))
            rows: Rows | None = None
            for found in estimates:
                if rows is None:  # not before something is known to come: an older file is kept until then
                    rows = Rows(sys.stdout if out is None else open_until_the_end.enter_context(_opened(out)))
                rows.write(found)
                if found.reason != said:
                    print(f"{found.estimate.time_s:.2f} s: {found.reason or 'right again'}", file=sys.stderr)
                    said = found.reason
    finally:
        _say(counts)
    if not counts.frames:
        raise pt.TrackingError("no frame was tracked")
    if counts.frames - counts.invalid < FEW_VALID * counts.frames:
        raise typer.Exit(1)


def _opened(out: Path) -> TextIO:
    return out.open("w", encoding="utf-8", newline="")


def _lines(sensor: str) -> Iterator[str]:
    """Line by line, opened when the first is wanted; where they come from a pipe may say nothing for ever.

    What is piped in is read by a file of its own, which whoever waits for a line holds when we leave.
    """
    if sensor != "-" and not Path(sensor).exists():
        raise pt.InputError(f"{sensor}: no such pipe or device, expected where the sensor's lines come from")
    source = os.dup(0) if sensor == "-" else sensor
    with open(source, encoding="utf-8-sig", errors="replace") as file:  # noqa: PTH123 - a number too
        yield from file


def _say(counts: Live) -> None:
    skipped = f"; {counts.skipped} came faster than they were worked on and were left out" if counts.skipped else ""
    refused = f"; {counts.refused} observations were refused" if counts.refused else ""
    unread = f"; {counts.unread} lines of the sensor were left out" if counts.unread else ""
    valid = counts.frames - counts.invalid
    if counts.frames or refused or unread:
        print(f"pytracker: {counts.frames} frames, {valid} of them valid{skipped}{refused}{unread}", file=sys.stderr)
