"""The `pytracker` command: a thin face over the Python calls.

Exit status 0: done; 1: the run failed (the track was lost); 2: bad usage or input. `--debug` before the subcommand
shows tracebacks.
"""

from __future__ import annotations

import io
import json
import signal
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

import pytracker as pt
from pytracker.evidence.grid import write_frame
from pytracker.methods import Method
from pytracker.output import check_target, whole_folder
from pytracker.registry import DEFAULTS, METHODS_OF, as_tuples, make_method, nearest
from pytracker.report.index import render_index
from pytracker.report.tables import read_run, read_track
from pytracker.reproduce import PAPERS as PAPER_NAMES
from pytracker.reproduce import SEEDS
from pytracker.terminal import frames_bar, print_comparison, runs_bar

__all__ = ["app", "main"]

app = typer.Typer(
    name="pytracker",
    help="Human motion tracking with particle filters, on a laptop CPU, with honest error bars.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
simulate = typer.Typer(help="Write a simulated recording folder, with truth.", no_args_is_help=True)
app.add_typer(simulate, name="simulate")

ARM_METHODS: tuple[Method, ...] = (
    pt.Joint(),
    pt.Layered(),
    pt.Plain(particles=5000),
    pt.Ekf(corrections=("colour", "arm_length"), bias=True, accel_density=0.15),
    pt.Ekf(corrections=("colour", "arm_projection"), accel_density=0.02),
    pt.Ekf(bias=True, accel_density=0.03),
    pt.Inertial(),
)
"""Each as tuned on simulated circles of other seeds than any that is reported."""

BODY_SHOWN: tuple[Method, ...] = (pt.Partitioned(), pt.BodyPlain(), pt.Annealed())
"""Tuned on simulated bodies of other seeds than any that is reported."""

SHOWN = {"arm": ARM_METHODS, "body": BODY_SHOWN}
"""What a report compares, by kind of recording."""

PAPERS = {"arm": "layered", "body": "plain"}
"""The papers' own."""

FEW_VALID = 0.5
"""Fewer valid frames than this share, and the command says so."""

WORDS = " ".join(f"{kind.capitalize()}: {', '.join(methods)}." for kind, methods in METHODS_OF.items())

Folder = Annotated[Path, typer.Argument(help="Recording folder (holds recording.toml).")]
Out = Annotated[Path, typer.Option(help="Folder to write; must not exist.")]
Seed = Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Seed of the random streams.")]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress, no tables.")]
NoReport = Annotated[bool, typer.Option("--no-report", help="Tables only: no page, figures or overlay.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Any other parameter; repeatable.")
]


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"pytracker {pt.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and leave.", is_eager=True, callback=_show_version)
    ] = False,
) -> None:
    # `main` looks for --debug itself: it has to know before anything is parsed.
    del debug, version


@app.command()
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
    arm_scene, body_scene = pt.ArmScene(duration_s=duration), pt.BodyScene(duration_s=body_duration)
    tracks = {}
    with tempfile.TemporaryDirectory() as scratch, frames_bar(quiet) as progress:
        folder = keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        pt.simulate_arm(folder / "simulated-circle", arm_scene, seed, force=force, progress=progress)
        pt.simulate_body(folder / "simulated-body", body_scene, seed, force=force, progress=progress)
        with whole_folder(out, force=force) as whole:
            for kind, name in (("arm", "simulated-circle"), ("body", "simulated-body")):
                recording = pt.load(folder / name)
                tracks[kind] = _track_all(recording, SHOWN[kind], seed, progress)
                pt.write_report(tracks[kind], whole / kind, progress=progress)
            (whole / "index.html").write_text(render_index(tracks), "utf-8")
    for of_kind in tracks.values():
        print_comparison(of_kind, quiet)
    _say(f"report: {out / 'index.html'}", quiet)


@app.command()
def track(
    folder: Folder,
    out: Out,
    method: Annotated[str, typer.Option(help=f"{WORDS} Without it the best: joint, partitioned.")] = "",
    particles: Annotated[int | None, typer.Option(min=1, help="Number of particles (particle methods).")] = None,
    settings: Settings = None,
    seed: Seed = 0,
    no_report: NoReport = False,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Track a recording and write track.csv, metadata.json, scores.json (with truth) and a report page."""
    check_target(out, force=force)  # before the work, not after it
    recording = pt.load(folder)
    chosen = _chosen(recording.kind, method, particles, settings or [])
    _warn(recording.warnings)
    with frames_bar(quiet) as progress:
        try:
            result = pt.track(recording, chosen, seed, progress=progress)
        except pt.TrackingError as error:
            if hasattr(error, "track"):
                pt.write_report([error.track], out, force=force, page=not no_report, progress=progress)
                print(f"pytracker: the frames before are in {out}", file=sys.stderr)
            raise
        pt.write_report([result], out, force=force, page=not no_report, progress=progress)
    if result.valid.mean() < FEW_VALID:
        unseen = len(result.valid) - int(result.valid.sum())
        _warn((f"{folder}: {unseen} of {len(result.valid)} frames are not valid, see reason in track.csv",))
    if recording.truth is not None:
        print_comparison([result], quiet)
    _say(f"wrote {out}", quiet)


@app.command()
def report(
    folder: Folder,
    out: Out,
    method: Annotated[list[str] | None, typer.Option(help=f"Repeatable. {WORDS}")] = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Track a recording by several methods and write one page that compares them."""
    check_target(out, force=force)  # before the work, not after it
    recording = pt.load(folder)
    named = tuple(_chosen(recording.kind, name, None, []) for name in method or ())
    chosen = named or SHOWN[recording.kind]
    _warn(recording.warnings)
    with frames_bar(quiet) as progress:
        tracks = _track_all(recording, chosen, seed, progress)
        pt.write_report(tracks, out, force=force, progress=progress)
    if recording.truth is not None:
        print_comparison(tracks, quiet)
    _say(f"report: {out / 'index.html'}", quiet)


@app.command()
def evaluate(
    folder: Folder, results: Annotated[list[Path], typer.Argument(help="track.csv files, or folders that hold one.")]
) -> None:
    """Score track.csv files against the recording's truth; prints JSON."""
    truth = pt.load(folder).truth
    scores = {}
    for path in results:
        file = path / "track.csv" if path.is_dir() else path
        scores[str(path)] = pt.evaluate(read_track(file), truth).as_dict()
    print(json.dumps(scores, indent=2))


@app.command()
def inspect(
    folder: Folder,
    number: Annotated[int, typer.Option("--frame", min=0, help="Which frame.")],
    out: Annotated[Path, typer.Option(help="SVG to write.")] = Path("cycle.svg"),
    of: Annotated[
        Path | None, typer.Option(help="A folder that `track` wrote: its method and seed, not those below.")
    ] = None,
    track_number: Annotated[int, typer.Option("--track", min=1, help="Which track of that folder.")] = 1,
    method: Annotated[str, typer.Option(help=f"{WORDS} Without it the papers': layered, plain.")] = "",
    particles: Annotated[int | None, typer.Option(min=1, help="Number of particles.")] = None,
    settings: Settings = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Draw one cycle of the filter at a frame: prior, predicted, weighted and resampled clouds, layer by layer."""
    _check_new(out, ".svg", force=force)
    recording = pt.load(folder)
    if of is not None:
        if method or particles is not None or settings or seed:
            raise pt.InputError("--of says method and seed, expected no --method, --particles, --set or --seed besides")
        chosen, seed = read_run(of, recording, track_number)
    else:
        chosen = _chosen(recording.kind, method or PAPERS[recording.kind], particles, settings or [])
    _warn(recording.warnings)
    with frames_bar(quiet) as progress:
        cycle = pt.record_cycle(recording, chosen, seed, frame=number, progress=progress)
    # Matplotlib takes a third of a second to import: only who draws pays for it.
    from pytracker.report.cycle_figures import one_cycle  # noqa: PLC0415

    out.write_text(one_cycle(cycle), "utf-8")
    _say(f"wrote {out}", quiet)


@app.command()
def study(
    file: Annotated[Path, typer.Argument(help="The study, a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for table and results; one of a study is gone on with.")],
    scheduler: Annotated[str, typer.Option(help="A Dask scheduler, tcp://HOST:PORT; without it threads here.")] = "",
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; as many as cores where not said.")] = None,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write table.parquet besides table.csv.")] = False,
    quiet: Quiet = False,
) -> None:
    """Run recordings x methods x seeds and write one table; what is done already is not done again."""
    with runs_bar(quiet) as progress:
        table = pt.run_study(
            pt.read_study(file), out, scheduler=scheduler, workers=workers, parquet=parquet, progress=progress
        )
    _say(f"table: {out / 'table.csv'}", quiet)
    for status, words in (("lost", "lost the track before the end"), ("failed", "failed")):
        if count := table.count(status):
            _warn((f"{count} runs {words}, the first: {table.where(status=status)[0]['error']}",))
    if table.count("failed"):
        raise typer.Exit(1)


@app.command()
def reproduce(
    paper: Annotated[str, typer.Argument(help=f"Which paper: {', '.join(PAPER_NAMES)}.")],
    out: Annotated[Path, typer.Option(help="Folder for page and results; one of a reproduction is gone on with.")],
    seeds: Annotated[int, typer.Option(min=2, help="How many runs of everything.")] = SEEDS,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; as many as cores where not said.")] = None,
    quiet: Quiet = False,
) -> None:
    """Run a paper's tables and figures again and write a page with our figures beside the printed ones."""
    with runs_bar(quiet) as progress:
        page = pt.reproduce(paper, out, seeds=seeds, workers=workers, progress=progress)
    _say(f"page: {page}", quiet)


@app.command()
def frame(
    folder: Folder,
    out: Annotated[Path, typer.Option(help="PNG to write.")] = Path("frame.png"),
    camera: Annotated[int, typer.Option(min=0, help="Which camera.")] = 0,
    number: Annotated[int, typer.Option("--frame", min=0, help="Which frame.")] = 0,
    force: Force = False,
) -> None:
    """Write one frame with a pixel grid, to choose patch_box without a window."""
    _check_new(out, ".png", force=force)
    write_frame(folder, out, camera, number)
    print(f"wrote {out}")


@simulate.command("arm")
def simulate_arm(
    out: Annotated[Path, typer.Argument(help="Folder to write; must not exist.")],
    settings: Settings = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """A subject at a table: video, IMU, truth. `--set pattern=rectangle`, `--set "occlusions=[[3, 4]]"` and so on."""
    scene = _scene(pt.ArmScene, settings or [])
    with frames_bar(quiet) as progress:
        pt.simulate_arm(out, scene, seed, force=force, progress=progress)
    _say(f"wrote {out}", quiet)


@simulate.command("body")
def simulate_body(
    out: Annotated[Path, typer.Argument(help="Folder to write; must not exist.")],
    settings: Settings = None,
    seed: Seed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """A person before a wall: video, background, truth. `--set skeleton=a.asf --set motion=a.amc` and so on."""
    scene = _scene(pt.BodyScene, settings or [])
    with frames_bar(quiet) as progress:
        pt.simulate_body(out, scene, seed, force=force, progress=progress)
    _say(f"wrote {out}", quiet)


def _check_new(out: Path, suffix: str, *, force: bool) -> None:
    """A file that may be written. Raises `InputError`."""
    if out.suffix.lower() != suffix:
        raise pt.InputError(f"{out}: expected a name that ends in {suffix}")
    if not out.resolve().parent.is_dir():
        raise pt.InputError(f"{out}: there is no folder {out.parent}, expected one")
    if out.exists() and not force:
        raise pt.InputError(f"{out}: already exists, expected a new file (or --force to replace it)")


def _chosen(kind: str, name: str, particles: int | None, settings: list[str]) -> Method:
    """A method for a kind of recording from what the command line says. Raises `InputError`."""
    values = _parse(settings)
    if particles is not None:
        if "particles" in values:
            raise pt.InputError("--particles and --set particles are both given, expected one of them")
        values["particles"] = particles
    name, methods = name or DEFAULTS[kind], METHODS_OF[kind]
    if name not in methods:
        raise pt.InputError(f"--method is {name!r}, expected one of: {', '.join(methods)} (kind {kind!r})")
    if particles is not None and not hasattr(methods[name], "particles"):
        raise pt.InputError(f"--particles does not go with --method {name}, which has none")
    try:
        return make_method(kind, name, values)
    except pt.InputError as error:
        raise pt.InputError(f"--set {error}") from None


def _scene(cls: type[Any], settings: list[str]) -> Any:
    """A scene to simulate from `--set`. Raises `InputError`."""
    values, known = _parse(settings), [field.name for field in fields(cls)]
    for key in values:
        if key not in known:
            raise pt.InputError(f"--set {key}: {cls.__name__} has no such parameter, {nearest(key, known)}")
    return cls(**values)


def _parse(settings: list[str]) -> dict[str, Any]:
    """`key=value` pairs; values are JSON, or words as they stand."""
    values: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise pt.InputError(f"--set {setting!r}, expected KEY=VALUE")
        try:
            values[key] = as_tuples(json.loads(text))
        except json.JSONDecodeError:
            values[key] = text
    return values


def _track_all(
    recording: pt.Recording, methods: Sequence[Method], seed: int, progress: Callable[[str, int], None] | None
) -> list[pt.Track]:
    """Every method on the same evidence; one that loses the track keeps what it had."""
    sightings = pt.sight(recording, progress=progress) if isinstance(recording, pt.ArmRecording) else None
    tracks: list[pt.Track] = []
    for method in methods:
        try:
            tracks.append(pt.track(recording, method, seed, sightings=sightings, progress=progress))
        except pt.TrackingError as error:
            if not hasattr(error, "track"):
                raise
            tracks.append(error.track)
    return tracks


def _warn(warnings: tuple[str, ...]) -> None:
    for warning in warnings:
        print(f"pytracker: warning: {warning}", file=sys.stderr)


def _say(words: str, quiet: bool) -> None:
    if not quiet:
        print(words)


def _stop(number: int, frame: object) -> None:
    """Leave and clean up, runs in flight first; at a second signal at once."""
    del frame
    signal.signal(number, signal.SIG_DFL)
    print("pytracker: stopping (again: at once)", file=sys.stderr)
    sys.exit(128 + number)


def main() -> None:
    """Run the command line and leave with its exit status."""
    debug = "--debug" in sys.argv[1:]
    # A terminal that cannot show ± gets something else, not an error; a terminated run cleans up.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _stop)
    try:
        app()
    except (pt.InputError, pt.TrackingError, OSError) as error:
        if debug:
            raise
        print(f"pytracker: {error}", file=sys.stderr)
        sys.exit(1 if isinstance(error, pt.TrackingError) else 2)
    except Exception as error:
        if debug:
            raise
        print(f"pytracker: internal error: {type(error).__name__}: {error} (--debug shows where)", file=sys.stderr)
        sys.exit(1)
