"""Commands on one recording: `demo`, `track`, `report`, `inspect`."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

import pytracker as pt
from pytracker import batch
from pytracker.cli import parameters
from pytracker.cli.options import Folder, Force, NoReport, Out, Quiet, Seed, Settings, check_new, say, warn
from pytracker.cli.settings import METHOD_WORDS, chosen_method
from pytracker.cli.terminal import frames_bar, print_comparison
from pytracker.doubting.doubts import is_unusable, unbelieved
from pytracker.evidence.observations import shared_sightings
from pytracker.methods import BodyMethod
from pytracker.methods.method import Method
from pytracker.outcomes import EARLIER, Outcome
from pytracker.output import check_target, whole_folder, write_whole
from pytracker.report.contents import contents_of
from pytracker.report.files.metadata import read_run
from pytracker.report.index import render_index
from pytracker.scores.agreement import against_truth
from pytracker.tracking.fits import why_unfit
from pytracker.tracking.track import default_method

__all__ = ["commands"]

commands = typer.Typer()

ARM_METHODS: tuple[Method, ...] = (
    pt.Smooth(),
    pt.Mixture(),
    pt.Joint(),
    pt.Layered(),
    pt.Plain(particles=5000),
    pt.Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15),
    pt.Ekf(corrections=("colour", "arm_projection"), accel_density=0.02),
    pt.Ekf(bias=True, accel_density=0.03),
    pt.Inertial(),
)
"""Each as tuned on simulated circles of other seeds than any that is reported."""

BODY_SHOWN: tuple[BodyMethod, ...] = (
    pt.BodySmooth(),
    pt.BodyMixture(),
    pt.Partitioned(),
    pt.BodyPlain(),
    pt.Annealed(),
)
"""Tuned on simulated bodies of other seeds than any that is reported."""

SHOWN: Mapping[str, tuple[Method, ...]] = {"arm": ARM_METHODS, "body": BODY_SHOWN}

PAPERS = {"arm": "layered", "body": "plain"}
"""The papers' own."""


def _of_use(recording: pt.Recording) -> tuple[Method, ...]:
    """What a report compares, the default first, of what can track it."""
    best = default_method(recording)
    of_use = (method for method in SHOWN[recording.kind] if not why_unfit(recording, method))
    return tuple(sorted(of_use, key=lambda method: method != best))


@commands.command()
def demo(
    out: Out = Path("report"),
    seed: Seed = 7,
    duration: Annotated[float, typer.Option(min=1.0, help="Length of the arm's recording, s.")] = 20.0,
    body_duration: Annotated[float, typer.Option(min=1.0, help="Length of the body's recording, s.")] = 8.0,
    keep: Annotated[Path | None, typer.Option(help="Keep the simulated recordings in this folder.")] = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Simulate an arm and a body, track them by every method, print the comparisons and write the reports."""
    check_target(out, force=force)  # before the work, not after it
    arm_scene, body_scene = pt.ArmScene(duration_s=duration, worn=True), pt.BodyScene(duration_s=body_duration)
    tracks = {}
    with tempfile.TemporaryDirectory() as scratch, frames_bar(quiet) as progress:
        folder = keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        pt.simulate_arm(folder / "simulated-circle", arm_scene, seed, force=force, progress=progress)
        pt.simulate_body(folder / "simulated-body", body_scene, seed, force=force, progress=progress)
        with whole_folder(out, force=force) as whole:
            for kind, name in (("arm", "simulated-circle"), ("body", "simulated-body")):
                recording = pt.load(folder / name)
                tracks[kind] = by_each(recording, _of_use(recording), seed, progress)
                pt.write_report(tracks[kind], whole / kind, progress=progress)
            (whole / "index.html").write_text(render_index(tracks), "utf-8")
    for of_kind in tracks.values():
        print_comparison(of_kind, quiet)
    say(f"report: {out / 'index.html'}", quiet)


@commands.command(epilog=parameters.of_methods())
def track(
    folders: Annotated[list[Path], typer.Argument(help="Recording folders (each holds recording.toml).")],
    out: Out,
    method: Annotated[
        str,
        typer.Option(help=f"{METHOD_WORDS} Without it the best: smooth."),
    ] = "",
    particles: Annotated[int | None, typer.Option(min=1, help="Number of particles (particle methods).")] = None,
    settings: Settings = None,
    seed: Seed = 0,
    no_report: NoReport = False,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Several recordings: so many at a time.")] = 1,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Track a recording and write track.csv, metadata.json, scores.json (with truth) and a report page.

    Several: each into a folder of its own below the one given, one that fails stops no other, and index.html leads to
    all. Exit status 1 where one failed.
    """
    if len(folders) > 1:
        _track_several(
            folders,
            out,
            partial(_chosen, method, particles, tuple(settings or ())),
            seed,
            no_report,
            jobs,
            force,
            quiet,
        )
        return
    folder = folders[0]
    check_target(out, force=force)  # before the work, not after it
    recording = pt.load(folder)
    chosen = _chosen(method, particles, tuple(settings or ()), recording)
    warn(recording.warnings)
    with frames_bar(quiet) as progress:
        try:
            result = pt.track(recording, chosen, seed, progress=progress)
        except pt.TrackingError as error:
            if error.track is not None:
                pt.write_report([error.track], out, force=force, page=not no_report, progress=progress)
                _warn_of(error.track)
                print(f"pytracker: the frames before are in {out}", file=sys.stderr)
            raise
        pt.write_report([result], out, force=force, page=not no_report, progress=progress)
    _warn_of(result)
    if recording.truth is not None:
        print_comparison([result], quiet)
    say(f"wrote {out}", quiet)
    if is_unusable(result):
        # What there is of it is written all the same.
        raise typer.Exit(1)


def _warn_of(track: pt.Track) -> None:
    """What speaks against it, and how much of it is not to be believed."""
    warn((*track.doubts, *against_truth(track, track.recording.truth)))
    warn(unbelieved(track))


def _chosen(method: str, particles: int | None, settings: tuple[str, ...], recording: pt.Recording) -> Method:
    best = None if method else default_method(recording)
    return chosen_method(recording.kind, best.name if best else method, particles, list(settings), best)


def _track_several(
    folders: list[Path],
    out: Path,
    method_of: Callable[[pt.Recording], Method],
    seed: int,
    no_report: bool,
    jobs: int,
    force: bool,
    quiet: bool,
) -> None:
    if out.exists() and not out.is_dir():
        raise pt.InputError(f"{out}: is a file, expected a folder")

    def told(one: Outcome) -> None:
        error = "" if one.error_m is None else f", {100 * one.error_m:.1f} cm off"
        said = one.words[1:] if one.is_earlier and not one.stale else one.words
        why, others = (said[0], said[1:]) if one.has_failed and said else ("", said)
        earlier = f" ({EARLIER})" if one.is_earlier and not one.stale else ""
        if one.has_failed:
            print(f"pytracker: {one.recording}: failed: {why}{earlier}", file=sys.stderr)
        else:
            say(f"{one.recording}: {one.valid:.0%} of {one.frames} frames valid{error}{earlier}", quiet)
        warn(tuple(f"{one.recording}: {words}" for words in others))

    outcomes = batch.track_all(
        folders, out, method_of, seed=seed, page=not no_report, force=force, jobs=jobs, done=told
    )
    say(f"wrote {out / 'index.html'}", quiet)
    if any(one.has_failed for one in outcomes):
        raise typer.Exit(1)


@commands.command()
def report(
    folder: Folder,
    out: Out,
    method: Annotated[list[str] | None, typer.Option(help=f"Repeatable. {METHOD_WORDS}")] = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Track a recording by several methods and write one page that compares them."""
    check_target(out, force=force)  # before the work, not after it
    recording = pt.load(folder)
    named = tuple(chosen_method(recording.kind, name, None, []) for name in method or ())
    chosen = named or _of_use(recording)
    warn(recording.warnings)
    with frames_bar(quiet) as progress:
        tracks = by_each(recording, chosen, seed, progress)
        pt.write_report(tracks, out, force=force, progress=progress)
    contents = contents_of(tracks)
    warn((*contents.doubts[0], *(f"{label}: {words}" for label, words in contents.doubts_of_others)))
    if recording.truth is not None:
        print_comparison(tracks, quiet)
    say(f"report: {out / 'index.html'}", quiet)


@commands.command()
def inspect(
    folder: Folder,
    number: Annotated[int, typer.Option("--frame", min=0, help="Which frame.")],
    out: Annotated[Path, typer.Option(help="SVG to write.")] = Path("cycle.svg"),
    of: Annotated[
        Path | None, typer.Option(help="A folder that `track` wrote: its method and seed, not those below.")
    ] = None,
    track_number: Annotated[int, typer.Option("--track", min=1, help="Which track of that folder.")] = 1,
    method: Annotated[str, typer.Option(help=f"{METHOD_WORDS} Without it the papers': layered, plain.")] = "",
    particles: Annotated[int | None, typer.Option(min=1, help="Number of particles.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="As `track --help` lists them; repeatable.")
    ] = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Draw one cycle of the filter at a frame: prior, predicted, weighted and resampled clouds, layer by layer."""
    check_new(out, ".svg", force=force)
    recording = pt.load(folder)
    if of is not None:
        if method or particles is not None or settings or seed:
            raise pt.InputError("--of says method and seed, expected no --method, --particles, --set or --seed besides")
        chosen, seed = read_run(of, recording, track_number)
    else:
        chosen = chosen_method(recording.kind, method or PAPERS[recording.kind], particles, settings or [])
    warn(recording.warnings)
    with frames_bar(quiet) as progress:
        cycle = pt.record_cycle(recording, chosen, seed, frame=number, progress=progress)
    from pytracker.report.cycles.figures import one_cycle  # noqa: PLC0415 - Matplotlib is slow

    write_whole(out, one_cycle(cycle), force=force)
    say(f"wrote {out}", quiet)


def by_each(
    recording: pt.Recording, methods: Sequence[Method], seed: int, progress: Callable[[str, int], None] | None
) -> list[pt.Track]:
    """Every method on the same evidence; one that loses the track keeps what it had."""
    sightings = shared_sightings(recording, progress)
    tracks: list[pt.Track] = []
    for method in methods:
        try:
            tracks.append(pt.track(recording, method, seed, sightings=sightings, progress=progress))
        except pt.TrackingError as error:
            if error.track is None:
                raise
            tracks.append(error.track)
    return tracks
