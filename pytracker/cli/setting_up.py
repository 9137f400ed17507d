"""Commands that make a recording ready: `init`, `keypoints`, `clap`, `check`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from pytracker.cli.options import Folder, Force, Quiet, check_new, say
from pytracker.cli.terminal import frames_bar
from pytracker.output import write_whole
from pytracker.setup import check as examine
from pytracker.setup import detect
from pytracker.setup import init as begin
from pytracker.setup.clap import clock_by_claps

__all__ = ["commands"]

commands = typer.Typer()


@commands.command()
def init(
    out: Annotated[Path, typer.Argument(help="Folder of the recording; its recording.toml must not exist.")],
    video: Annotated[Path, typer.Option(help="The camera's file.")],
    imu: Annotated[Path | None, typer.Option(help="The IMU's file: an arm. Without one: a body.")] = None,
    keypoints: Annotated[Path | None, typer.Option(help="2-D keypoints of the video (body).")] = None,
    truth: Annotated[Path | None, typer.Option(help="Measured joints, where there are any.")] = None,
    known: Annotated[
        Path | None,
        typer.Option(help="What is known: keys of [[camera]] and [arm] as TOML, or another's calibration."),
    ] = None,
    camera: Annotated[str | None, typer.Option(help="Which camera of a calibration of several.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a recording.toml that is there.")] = False,
) -> None:
    """Write a first recording.toml that says what was found, what was guessed and what is missing."""
    path = begin(
        out, video=video, imu=imu, keypoints=keypoints, truth=truth, camera=known, camera_name=camera, force=force
    )
    say(f"wrote {path}; next: pytracker check {shlex.quote(str(out))}", quiet=False)


@commands.command("keypoints")
def find_keypoints(
    folder: Folder,
    camera: Annotated[int, typer.Option(min=0, help="Which camera.")] = 0,
    force: Annotated[bool, typer.Option("--force", help="Replace keypoints that are there.")] = False,
    quiet: Quiet = False,
) -> None:
    """Find 2-D keypoints in the video, offline, and name them in recording.toml. Needs MediaPipe (extra keypoints)."""
    with frames_bar(quiet) as progress:
        found = detect(folder, camera, force=force, progress=progress)
    say(f"wrote {found.path}: somebody in {found.seen} of {found.frames} frames, by {found.detector}", quiet)


@commands.command()
def clap(
    folder: Folder,
    frames: Annotated[
        list[int], typer.Argument(min=0, help="The first frame of each clap in which hands touch: see pytracker frame.")
    ],
    imu: Annotated[int, typer.Option(min=0, help="Which sensor.")] = 0,
    quiet: Quiet = False,
) -> None:
    """The clock of an IMU by claps, taps or jumps: the blows it felt when the video shows them; into recording.toml."""
    found = clock_by_claps(folder, frames, imu)
    blows = ", ".join(
        f"{hard:.0f} m/s² at {time_s:.3f} s" for time_s, hard in zip(found.blow_s, found.hard, strict=True)
    )
    say(
        f"felt in those frames: {blows} of the sensor's time; offset {found.offset_s:+.3f} ± {found.offset_sd_s:.3f} s",
        quiet,
    )
    print(f"wrote offset_s of imu[{imu}] into {folder / 'recording.toml'}")


@commands.command()
def check(
    folder: Folder,
    write: Annotated[bool, typer.Option("--write", help="Put what is found into recording.toml.")] = False,
    html: Annotated[Path | None, typer.Option(help="A page with the pictures, to be written.")] = None,
    force: Force = False,
) -> None:
    """Look at a recording as a doctor would: units, axes, clock, heading, mount, camera, patch, each with its reason.

    Exit status 1 where something is missing or wrong still.
    """
    if html is not None:
        check_new(html, ".html", force=force)
    found = examine(folder, write=write)
    for finding in found.findings:
        print(finding)
    if html is not None:
        from pytracker.report.check_page import render_check  # noqa: PLC0415 - Matplotlib is slow

        write_whole(html, render_check(found), force=force)
    pending = {place for finding in found.findings for place in finding.writes}
    if write and pending:
        print(f"wrote {', '.join(sorted(pending))} into {folder / 'recording.toml'}")
    elif pending:
        print("nothing was written: --write puts these lines into recording.toml")
    unsolved = [f for f in found.findings if f.verdict in ("missing", "wrong") and not (write and f.writes)]
    if unsolved:
        raise typer.Exit(1)
