"""`render(study, table)`: a study's page: errors beside the first pose held, bands, and what is said of the runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pytracker.methods.method import Method
from pytracker.report.labels import HELD, label
from pytracker.report.study.page import Section, Table, render_study_page
from pytracker.study.plan import Study
from pytracker.study.store import StudyTable

__all__ = ["render"]


@dataclass(frozen=True)
class _Kind:
    """How tracks of a kind are judged: by which joint and column; and of which joints bands are shown."""

    title: str
    error: str
    joint: str
    column: str
    banded: tuple[str, ...]


KINDS = {
    "arm": _Kind("Arms", "3-D RMS error of the wrist", "wrist", "rms_m", ("wrist",)),
    "body": _Kind("Bodies", "Mean 3-D error of the joints", "all", "average_m", ("left_wrist", "right_wrist")),
}
NONE = "\N{EN DASH}"


def render(study: Study, table: StudyTable) -> str:
    """The page as text, self-contained."""
    kinds = [kind for kind in KINDS if any(method.kind == kind for method in study.methods)]
    sections = [_of_kind(study, table, kind) for kind in kinds]
    return render_study_page(
        title="Study",
        lead=f"{len(study.recordings)} recordings, {len(study.methods)} methods, {len(study.seeds)} seeds",
        summary=_summary(table),
        sections=[*sections, _said(table)],
        source="Every run and joint is a row of table.csv; study.json says what was run.",
    )


def _summary(table: StudyTable) -> str:
    count = {status: table.count(status) for status in ("ok", "lost", "failed")}
    said = len(table.said())
    odd = f" Of some recordings ({said}) something is said, below: read it before their numbers." if said else ""
    return (
        f"{count['ok']} runs kept the track to the end, {count['lost']} lost it, {count['failed']} failed. A lost "
        f"track counts with its frames before the loss, which favours it.{odd}"
    )


def _of_kind(study: Study, table: StudyTable, kind: str) -> Section:
    judged = KINDS[kind]
    methods = [method for method in study.methods if method.kind == kind]
    of = [name for name in (recording.name for recording in study.recordings) if table.where(recording=name, kind=kind)]
    names = _names(methods)

    def shown(what: str, joint: str, in_words: Callable[[Sequence[float]], str]) -> list[list[str]]:
        return [
            [name, *(in_words(table.values(what, joint=joint, recording=r, method=method)) for r in of)]
            for name, method in zip(names, methods, strict=True)
        ]

    still = [HELD, *(_cm(table.values("held_m", joint=judged.joint, recording=r, kind=kind)) for r in of)]
    tables = [
        Table(
            f"{judged.error}, cm: mean over seeds (least to most)",
            ["method", *of],
            [*shown(judged.column, judged.joint, _cm), still],
        ),
        Table(
            "Share of frames that are valid: mean over seeds",
            ["method", *of],
            shown("valid_share", judged.banded[0], _share),
        ),
    ]
    for joint in judged.banded:
        holds = [
            [name, *(_holds(table, joint, r, method) for r in of)] for name, method in zip(names, methods, strict=True)
        ]
        what = joint.replace("_", " ")
        tables.append(Table(f"Share of frames whose 95 % band holds the {what}: x, y, z", ["method", *of], holds))
    return Section(kind, judged.title, (), tables)


def _names(methods: Sequence[Method]) -> list[str]:
    """What tells each from the others: their parameters, where words do not."""
    names = [label(method) for method in methods]
    varied = [
        key
        for key in dict.fromkeys(key for method in methods for key in method.parameters())
        if len({repr(method.parameters().get(key)) for method in methods}) > 1
    ]
    return [
        name
        if names.count(name) == 1
        else ", ".join([name, *(f"{key} = {m.parameters()[key]}" for key in varied if key in m.parameters())])
        for name, m in zip(names, methods, strict=True)
    ]


def _cm(values: Sequence[float]) -> str:
    known = 100.0 * np.array([value for value in values if np.isfinite(value)])
    if not known.size:
        return NONE
    return f"{known.mean():.1f}" + (f" ({known.min():.1f} to {known.max():.1f})" if known.size > 1 else "")


def _share(values: Sequence[float]) -> str:
    known = [value for value in values if np.isfinite(value)]
    return f"{np.mean(known):.0%}" if known else NONE


def _holds(table: StudyTable, joint: str, recording: str, method: Method) -> str:
    axes = [table.values(f"coverage_{axis}", joint=joint, recording=recording, method=method) for axis in "xyz"]
    return ", ".join(_share(of) for of in axes)


def _said(table: StudyTable) -> Section:
    """What speaks against recordings and runs."""
    odd = {
        (str(row["recording"]), str(row["method"]), "odd", str(row["said"])): None for row in table.rows if row["said"]
    }
    ended = {
        (str(row["recording"]), str(row["method"]), status, str(row["error"])): None
        for status in ("lost", "failed")
        for row in table.where(status=status)
    }
    rows = [*odd, *ended]
    if not rows:
        return Section("said", "What is said", ("Nothing speaks against any recording or run.",))
    header = ["recording", "method", "what", "words"]
    return Section("said", "What is said", (), (Table("Recording by recording", header, rows),))
