"""Commands on what was tracked: `evaluate`, `export`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

import pytracker as pt
from pytracker.cli.options import Folder, Force, check_new, say, warn
from pytracker.report.files.export import export as export_track
from pytracker.report.files.json_file import plain
from pytracker.report.files.metadata import of_another_run
from pytracker.report.files.tables import read_rows, read_track
from pytracker.report.labels import HELD
from pytracker.scores.agreement import against_truth, beside_truth
from pytracker.scores.evaluate import held

__all__ = ["commands"]

commands = typer.Typer()


@commands.command()
def evaluate(
    folder: Folder, results: Annotated[list[Path], typer.Argument(help="track.csv files, or folders that hold one.")]
) -> None:
    """Score track.csv files, and the first one's first pose, held, against the recording's truth; prints JSON."""
    recording = pt.load(folder)
    warn(recording.warnings)
    files = [path / "track.csv" if path.is_dir() else path for path in results]
    for file in files:
        warn(of_another_run(file, recording))
    tracks = [read_track(file, recording.camera) for file in files]
    for file, scored in zip(files, tracks, strict=True):
        odd = (*beside_truth(scored, recording.truth), *against_truth(scored, recording.truth))
        warn(tuple(f"{file}: {words}" for words in odd))
    shown = {str(path): track for path, track in zip(results, tracks, strict=True)} | {HELD: held(tracks[0])}
    scores = {name: pt.evaluate(track, recording.truth).as_dict() for name, track in shown.items()}
    print(json.dumps(plain(scores), indent=2))


@commands.command()
def export(
    result: Annotated[Path, typer.Argument(help="A track.csv, or a folder that holds one.")],
    out: Annotated[Path, typer.Argument(help=".trc for OpenSim and Pose2Sim, .c3d by the extra c3d.")],
    force: Force = False,
) -> None:
    """Write a track's joints as others read them, mm, in the recording's world; what is not valid is a gap."""
    check_new(out, out.suffix.lower(), force=force)
    track = read_rows(result / "track.csv" if result.is_dir() else result)
    gaps = export_track(track, out, force=force)
    said = ", ".join(f"{joint} {count}" for joint, count in gaps.items() if count)
    say(f"wrote {len(track.time_s)} frames of {', '.join(gaps)} to {out}", quiet=False)
    if said:
        warn((f"{out}: frames that are gaps, not valid: {said}",))
