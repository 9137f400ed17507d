"""What the command line shows: progress while it works, tables of scores when it is done."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

import pytracker as pt
from pytracker.report.labels import HELD, labels
from pytracker.scores.evaluate import Scored, Scores, held
from pytracker.skeleton import KEY_JOINTS

__all__ = ["frames_bar", "print_comparison", "runs_bar"]


@contextlib.contextmanager
def frames_bar(quiet: bool) -> Iterator[Callable[[str, int], None] | None]:
    """Stage and frames done, on the error stream; off where that is no terminal."""
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (
        TextColumn("{task.description:<18}"),
        BarColumn(),
        TextColumn("{task.completed:.0f} frames"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        tasks: dict[str, Any] = {}

        def advance(stage: str, done: int) -> None:
            if stage not in tasks:
                tasks[stage] = bar.add_task(stage, total=None)
            bar.update(tasks[stage], completed=done)

        yield advance


@contextlib.contextmanager
def runs_bar(quiet: bool) -> Iterator[Callable[[int, int], None] | None]:
    """Runs done and time left, on the error stream; off where that is no terminal."""
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (
        TextColumn("runs"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True, speed_estimate_period=300) as bar:
        task = bar.add_task("runs", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def print_comparison(tracks: Sequence[pt.Track], quiet: bool) -> None:
    """What the papers print: Table I of Tao & Hu, or the average errors of Li & Kulić, in cm."""
    if quiet:
        return
    make = TABLES[tracks[0].recording.kind]
    Console(width=None if sys.stdout.isatty() else 140).print(make(tracks), _joints_table(tracks[0]))


def _arm_table(tracks: Sequence[pt.Track]) -> Table:
    table = Table(title="wrist error, cm (mean / sd per axis, as Tao & Hu Table I)", title_justify="left")
    table.add_column("method")
    for name in ("x", "y", "z", "3-D RMS", "worst", "±5 cm", "band holds truth"):
        table.add_column(name, justify="right", no_wrap=True)
    for name, result in zip(labels(tracks), tracks, strict=True):
        scores: Scores = pt.evaluate(result, result.recording.truth)
        s = scores.joints["wrist"]
        axes = [f"{100 * m:.1f} / {100 * d:.1f}" for m, d in zip(s.mean_m, s.sd_m, strict=True)]
        lost = f" (lost after {s.frames} frames)" if result.lost else ""
        in_band = " ".join(f"{100 * c:.0f}" for c in s.coverage) + " %"
        table.add_row(
            name + lost, *axes, f"{100 * s.rms_m:.1f}", f"{100 * s.worst_m:.1f}", f"{100 * s.within_5cm:.0f} %", in_band
        )
    s = pt.evaluate(held(tracks[0]), tracks[0].recording.truth).joints["wrist"]
    axes = [f"{100 * m:.1f} / {100 * d:.1f}" for m, d in zip(s.mean_m, s.sd_m, strict=True)]
    table.add_row(HELD, *axes, f"{100 * s.rms_m:.1f}", f"{100 * s.worst_m:.1f}", f"{100 * s.within_5cm:.0f} %", "")
    return table


def _joints_table(track: pt.Track) -> Table:
    """Of the first method, and of the first pose held: what is typical, where it is off, and how often it is lost."""
    table = Table(title="median error of each joint, cm", title_justify="left")
    table.add_column(f"{labels([track])[0]} / {HELD}")
    for name in ("3-D", "across the picture", "in depth", "lost (over 20 cm across)"):
        table.add_column(name, justify="right", no_wrap=True)
    ours, still = (pt.evaluate(of, track.recording.truth).joints for of in (track, held(track)))
    for joint in ours:
        pair = ours[joint], still[joint]
        cells = [
            " / ".join(f"{100 * getattr(s, quantity):.{digits}f}" for s in pair)
            for quantity, digits in (("median_m", 1), ("across_m", 1), ("depth_m", 1), ("lost_share", 0))
        ]
        table.add_row(joint.replace("_", " "), *cells[:-1], f"{cells[-1]} %")
    return table


def _body_table(tracks: Sequence[pt.Track]) -> Table:
    table = Table(title="average error of the joints, cm (as Li & Kulić V-B)", title_justify="left")
    table.add_column("method")
    truth = tracks[0].recording.truth
    assert truth is not None
    joints = [joint for joint in KEY_JOINTS if joint in truth.joints_m]
    for name in ("all ± sd", *(joint.replace("_", " ") for joint in joints)):
        table.add_column(name, justify="right")
    shown: list[tuple[str, Scored]] = [
        (name + (" (lost)" if result.lost else ""), result) for name, result in zip(labels(tracks), tracks, strict=True)
    ]
    for name, result in (*shown, (HELD, held(tracks[0]))):
        scores = pt.evaluate(result, truth)
        each = [f"{100 * scores.joints[joint].average_m:.1f}" for joint in joints]
        table.add_row(name, f"{100 * scores.average_m:.1f} ± {100 * scores.average_sd_m:.1f}", *each)
    return table


TABLES: Mapping[str, Callable[[Sequence[pt.Track]], Table]] = {"arm": _arm_table, "body": _body_table}
"""By kind of recording."""
