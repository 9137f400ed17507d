"""The loop from observations to a track, for every recording and every method."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pytracker._core import Observation, Tracker, TrackingError
from pytracker.evidence.sightings import Progress
from pytracker.rotation import Array
from pytracker.tracking.tracks import JointTrack

__all__ = ["Followed", "follow", "smoothed"]

Watch = Callable[[Observation, dict[str, Any]], None]
"""Called with every frame that was tracked, and its row of the table."""


@dataclass
class Followed:
    """What a tracker made of observations.

    Attributes:
        first: number of the first frame.
        time_s: recording time of every frame from there on `(T,)`.
        table: as of `Tracker.run`, a row a frame that was tracked.
        lost: why the track ended early; empty where it did not.
        filter_s: run time of the tracker alone.
    """

    first: int = 0
    time_s: Array = field(default_factory=lambda: np.empty(0))
    table: dict[str, Any] = field(default_factory=dict)
    lost: str = ""
    filter_s: float = 0.0

    @property
    def tracked(self) -> int:
        """How many frames were tracked."""
        return len(self.table["time_s"])

    @property
    def count(self) -> int:
        """How many frames there are, those before the first too."""
        return self.first + len(self.time_s)

    def rows(self, values: Array) -> Array:
        """Values of the frames that were tracked, as rows for every frame; NaN for the others."""
        out = np.full((self.count, *values.shape[1:]), np.nan)
        out[self.first : self.first + len(values)] = values
        return out

    def joint(self, name: str) -> JointTrack:
        """A place of the table."""
        rows = self.rows(self.table[name])
        mean, mode, sd, lo, hi = (np.ascontiguousarray(rows[:, quantity]) for quantity in range(5))
        return JointTrack(mean, mode, sd, lo, hi)


def follow(
    tracker: Tracker,
    observations: Iterable[Observation],
    *,
    at_once: int = 1,
    progress: Progress | None = None,
    threads: int | None = None,
    watch: Watch | None = None,
) -> Followed:
    """Let `tracker` take them in order of time, `at_once` frames a call.

    Where the track is lost, frames are only counted from there on. Raises `InputError`, and `TrackingError` where it is
    lost before any frame was tracked. Without any frame there is no table.
    """
    found = Followed()
    tables: list[dict[str, Any]] = []
    times: list[float] = []
    for chunk, frames in _chunks(observations, at_once):
        if frames and not times:
            found.first = frames[0].index or 0
        times += [frame.time_s for frame in frames]
        if found.lost:
            continue
        began = time.perf_counter()
        table, lost = tracker.run(chunk, threads)
        found.filter_s += time.perf_counter() - began
        found.lost = lost or ""
        tables.append(table)
        if watch is not None:
            for row, frame in enumerate(frames[: len(table["time_s"])]):
                watch(frame, {name: values[row] for name, values in table.items()})
        if progress is not None and frames:
            progress("track", found.first + len(times))
    tables = [table for table in tables if len(table["time_s"])]
    if found.lost and not tables:
        raise TrackingError(found.lost)
    found.time_s = np.array(times)
    found.table = {name: np.concatenate([table[name] for table in tables]) for name in (tables[0] if tables else ())}
    return found


def smoothed(tracker: Tracker, frames: int, progress: Progress | None, threads: int | None) -> dict[str, Any]:
    """The columns that smoothing the `frames` that were tracked changes; none for a method that does not smooth."""
    tables: list[dict[str, Any]] = []
    done = 0
    try:
        # Window by window: whoever stops a run does not wait for the whole of it.
        for table in tracker.smoothed(threads=threads):
            tables.append(table)
            done += len(table["ess"])
            if progress is not None:
                progress("smooth", done)
    except TrackingError:
        return {"doubt": ["the recording could not be smoothed: this is the filter's estimate"] * frames}
    return {name: np.concatenate([table[name] for table in tables]) for name in (tables[0] if tables else ())}


def _chunks(observations: Iterable[Observation], at_once: int) -> Iterator[tuple[list[Observation], list[Observation]]]:
    """So many frames at a time with what comes before each, and these frames; and what comes after the last."""
    chunk: list[Observation] = []
    frames: list[Observation] = []
    for observation in observations:
        chunk.append(observation)
        if observation.is_frame:
            frames.append(observation)
            if len(frames) == at_once:
                yield chunk, frames
                chunk, frames = [], []
    if chunk:
        yield chunk, frames
