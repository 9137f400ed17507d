"""The application, and where the command starts: signals, errors, exit status.

Exit status 0: done; 1: the run failed (the track was lost, or is of no use); 2: bad usage or input;
128 + number: stopped by a signal. `--debug` before the subcommand shows tracebacks.
"""

from __future__ import annotations

import contextlib
import io
import os
import signal
import sys
import threading
from typing import Annotated

import typer

import pytracker as pt
from pytracker.cli import calibrating, live, recordings, results, setting_up, studies, tracking

__all__ = ["main"]

app = typer.Typer(
    name="pytracker",
    help="Human motion tracking with particle filters, on a laptop CPU, with honest error bars.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for part in (tracking, live, results, setting_up, calibrating, studies, recordings):
    app.add_typer(part.commands)


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


_taken: list[int] = []
"""Signals that stop this run."""


def _stop(number: int, frame: object) -> None:
    """Leave and clean up, runs in flight first; at a second signal at once."""
    del frame
    _taken.append(number)
    signal.signal(number, signal.SIG_DFL)
    with contextlib.suppress(OSError):  # the terminal that would show it may be what went away
        print("pytracker: stopping (again: at once)", file=sys.stderr)
    sys.exit(128 + number)


def _leave_all_the_same(ignored: sys.UnraisableHookArgs) -> None:
    """A signal that arrives in a destructor raises its `SystemExit` where Python ignores it: send it again."""
    if not isinstance(ignored.exc_value, SystemExit):
        sys.__unraisablehook__(ignored)
        return
    number = int(ignored.exc_value.code or 0) - 128
    signal.signal(number, lambda *_: sys.exit(128 + number))
    threading.Timer(0.01, os.kill, (os.getpid(), number)).start()


def _take_signals() -> None:
    """A run that is terminated cleans up."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        # Windows has no SIGHUP; `nohup` ignores it, and means it.
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)
    sys.unraisablehook = _leave_all_the_same


def main() -> None:
    """Run the command line and leave with its exit status."""
    debug = "--debug" in sys.argv[1:]
    _take_signals()
    # A terminal that cannot show ± gets something else, not an error.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        app()
    except BrokenPipeError:
        # Whoever read what we print has left, as `head` does: nothing is wrong, and nobody to tell.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.exit(128 + 13)
    except Exception as error:
        if debug and not _taken:
            raise
        sys.exit(_told(error))


def _in_words(error: Exception) -> str:
    """Without the number that an operating system gives it, such as of a full disk."""
    match error:
        case OSError(filename=str(file), strerror=str(why)):
            return f"{file}: {why.lower()}"
        case OSError(strerror=str(why)):
            return why.lower()
    return str(error)


def _told(error: Exception) -> int:
    """The exit status after an error, which is printed."""
    if isinstance(error, pt.InputError | pt.TrackingError | OSError):
        print(f"pytracker: {_in_words(error)}", file=sys.stderr)
        return 1 if isinstance(error, pt.TrackingError) else 2
    if _taken:
        # On its way out the signal became another: a module that is being imported says "initialization failed".
        return 128 + _taken[0]
    if isinstance(error, MemoryError):
        words = "out of memory, expected fewer particles or a shorter recording"
    else:
        words = f"internal error: {type(error).__name__}: {error} (--debug shows where)"
    print(f"pytracker: {words}", file=sys.stderr)
    return 1
