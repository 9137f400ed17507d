"""Commands that make recordings or help to describe them: `simulate`, `frame`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import pytracker as pt
from pytracker.cli import parameters
from pytracker.cli.options import Force, Quiet, Seed, Settings, check_new, say
from pytracker.cli.settings import chosen_scene
from pytracker.cli.terminal import frames_bar
from pytracker.setup.frame import write_frame

__all__ = ["commands"]

simulate = typer.Typer(help="Write a simulated recording folder, with truth.", no_args_is_help=True)
commands = typer.Typer()
commands.add_typer(simulate, name="simulate")


@simulate.command("arm", epilog=parameters.of_scene(pt.ArmScene))
def simulate_arm(
    out: Annotated[Path, typer.Argument(help="Folder to write; must not exist.")],
    settings: Settings = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """A subject at a table: video, IMU, truth. `--set pattern=rectangle`, `--set "occlusions=[[3, 4]]"` and so on."""
    scene = chosen_scene(pt.ArmScene, settings or [])
    with frames_bar(quiet) as progress:
        pt.simulate_arm(out, scene, seed, force=force, progress=progress)
    say(f"wrote {out}", quiet)


@simulate.command("body", epilog=parameters.of_scene(pt.BodyScene))
def simulate_body(
    out: Annotated[Path, typer.Argument(help="Folder to write; must not exist.")],
    settings: Settings = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """A person before a wall: video, background, truth. `--set skeleton=a.asf --set motion=a.amc` and so on."""
    scene = chosen_scene(pt.BodyScene, settings or [])
    with frames_bar(quiet) as progress:
        pt.simulate_body(out, scene, seed, force=force, progress=progress)
    say(f"wrote {out}", quiet)


@commands.command()
def frame(
    folder: Annotated[Path, typer.Argument(help="A recording's folder, complete or not, or a video.")],
    out: Annotated[Path, typer.Option(help="PNG to write.")] = Path("frame.png"),
    camera: Annotated[int, typer.Option(min=0, help="Which camera.")] = 0,
    number: Annotated[int, typer.Option("--frame", min=0, help="Which frame.")] = 0,
    force: Force = False,
) -> None:
    """Write one frame with a pixel grid, to choose patch_box without a window."""
    check_new(out, ".png", force=force)
    write_frame(folder, out, camera, number, force=force)
    print(f"wrote {out}")
