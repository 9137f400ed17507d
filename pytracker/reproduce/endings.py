"""Runs that did not end well: what became of them, in words and in a table; and single runs for pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import overload

from pytracker._core import TrackingError
from pytracker.evidence.sightings import Sightings
from pytracker.methods.arm import ArmMethod
from pytracker.methods.body import BodyMethod
from pytracker.methods.method import Method
from pytracker.recording.recording import ArmRecording, BodyRecording, Recording
from pytracker.report.study.page import Section, Table
from pytracker.study import StudyTable
from pytracker.tracking.arm import ArmTrack
from pytracker.tracking.body import BodyTrack
from pytracker.tracking.track import track
from pytracker.tracking.tracks import Track

__all__ = ["endings", "tracked"]


def endings(table: StudyTable, methods: Mapping[str, Method], recordings: Mapping[str, Sequence[str]]) -> Section:
    """How many runs of each method were lost before the end, or failed; `recordings` by what they are shown as."""
    rows = []
    for name, method in methods.items():
        cells = []
        for names in recordings.values():
            found = [row for row in table.where(method=method) if row["recording"] in names]
            runs = {(row["recording"], row["seed"], row["status"]) for row in found}
            count = {status: sum(run[2] == status for run in runs) for status in ("lost", "failed")}
            words = [f"{count[status]} {status}" for status in count if count[status]]
            cells.append(", ".join(words) or "–")
        if any(cell != "–" for cell in cells):
            rows.append([name, *cells])
    if not rows:
        return Section("endings", "How the runs ended", ("Every run kept its track to the end.",))
    return Section(
        "endings",
        "How the runs ended",
        (
            "A lost track counts with its frames before the loss, in every table and comparison of this page: that favours "
            "the method that was lost. A run that failed has no numbers, and is left out of both sides of a comparison.",
        ),
        (Table("Runs that did not keep the track to the end", ["method", *recordings], rows),),
    )


@overload
def tracked(
    recording: ArmRecording, method: ArmMethod, seed: int, sightings: Sightings
) -> tuple[ArmTrack | None, str]: ...


@overload
def tracked(recording: BodyRecording, method: BodyMethod, seed: int) -> tuple[BodyTrack | None, str]: ...


def tracked(
    recording: Recording, method: Method, seed: int, sightings: Sightings | None = None
) -> tuple[Track | None, str]:
    """A single run for a picture, with the frames before a loss; and what was said of the loss."""
    try:
        return track(recording, method, seed, sightings=sightings), ""
    except TrackingError as error:
        return error.track, str(error)
