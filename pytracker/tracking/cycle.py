"""One cycle of a particle filter, to be looked at: what every layer did with the cloud at one frame of a track.

The recording is tracked up to the frame by the same calls as always; only that frame is recorded. So the clouds are
those of the track with the same method and seed, to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytracker._core import InputError, LayerRecord, Observation, Tracker, TrackingError
from pytracker.evidence.observations import read_evidence
from pytracker.evidence.sightings import Progress, Sightings
from pytracker.methods.method import Method
from pytracker.recording.recording import Recording
from pytracker.rotation import Array
from pytracker.tracking.fits import check_fits
from pytracker.tracking.follow import follow

__all__ = ["Cloud", "Cycle", "CycleLayer", "record_cycle"]


@dataclass(frozen=True, eq=False)
class Cloud:
    """Particles as places of joints.

    Attributes:
        points_m: by joint, world, m `(N, 3)`.
        weights: normalised `(N,)`.
    """

    points_m: Mapping[str, Array]
    weights: Array

    @property
    def ess(self) -> float:
        """Effective sample size, 1 to N."""
        return float(1 / (self.weights**2).sum())


@dataclass(frozen=True, eq=False)
class CycleLayer:
    """What one layer did.

    Attributes:
        moved_by: what moved the particles, in words.
        weighed_by: what weighed them, in words; empty where nothing did.
        arriving: the cloud that it was given: for the first layer the prior.
        predicted: after the motion, with the weights that arrived.
        weighted: with the weights of the likelihoods.
        resampled: what it left; None where it did not resample.
    """

    moved_by: str
    weighed_by: str
    arriving: Cloud
    predicted: Cloud
    weighted: Cloud
    resampled: Cloud | None


@dataclass(frozen=True, eq=False)
class Cycle:
    """One cycle of a filter (Tao & Hu, Figs. 4 and 9, for any list of layers).

    Attributes:
        recording: what was tracked.
        method: the method with its parameters.
        seed: of the random streams.
        frame: which frame, from 0.
        time_s: its recording time, s.
        layers: in order.
        estimate_m: mean of every joint before the last resampling, world, m `(3,)`.
        truth_m: where the joints really were; empty where that is not known.
        pixels: arm: where each camera saw the patch `(C, 2)`, px, NaN where it did not; None for a body.
    """

    recording: Recording
    method: Method
    seed: int
    frame: int
    time_s: float
    layers: tuple[CycleLayer, ...]
    estimate_m: Mapping[str, Array]
    truth_m: Mapping[str, Array]
    pixels: Array | None = None


def record_cycle(
    recording: Recording,
    method: Method,
    seed: int = 0,
    *,
    frame: int,
    sightings: Sightings | None = None,
    progress: Progress | None = None,
) -> Cycle:
    """Track up to `frame` and record it.

    `sightings` (arm) are patch centres found before or elsewhere. Raises `InputError` for a method without particles or
    a frame that the recording does not have, and `TrackingError` where the track is lost before.
    """
    check_fits(recording, method)
    words = method.layers_in_words()
    tracker = Tracker(recording, method, seed)
    evidence = read_evidence(recording, progress) if sightings is None else sightings
    before = _Before(frame, recording.observations(evidence))
    if lost := follow(tracker, before, progress=progress).lost:
        raise TrackingError(lost)
    observed = before.at
    states, weights = tracker.particles, tracker.weights
    estimate, records = tracker.observe_recorded(observed)
    after = tracker.particles
    assert estimate is not None
    assert states is not None
    assert weights is not None
    assert after is not None
    # Layers move and weigh what is seen; what is not, goes with every particle.
    unseen = after[:, len(estimate.mean) :]

    def places(seen: Array) -> dict[str, Array]:
        return tracker.pose(np.ascontiguousarray(np.hstack([seen, unseen])))

    prior = Cloud(tracker.pose(states), weights)
    pixels = [pixel or (np.nan, np.nan) for pixel in observed.pixels]
    return Cycle(
        recording=recording,
        method=method,
        seed=seed,
        frame=frame,
        time_s=observed.time_s,
        layers=_layers(prior, records, words, places),
        estimate_m={name: place.mean for name, place in estimate.places.items()},
        truth_m=_truth(recording, observed.time_s),
        pixels=np.array(pixels) if pixels else None,
    )


class _Before:
    """Observations before a frame; that of the frame itself is kept."""

    def __init__(self, frame: int, source: Iterable[Observation]) -> None:
        self._frame, self._source = frame, iter(source)
        self._first: int | None = None
        self._count = 0
        self._at: Observation | None = None

    def __iter__(self) -> Iterator[Observation]:
        for observation in self._source:
            if observation.is_frame:
                self._count = (observation.index or 0) + 1
                self._first = self._count - 1 if self._first is None else self._first
                if observation.index == self._frame:
                    self._at = observation
                if observation.index == self._frame or self._first > self._frame:
                    return
            yield observation

    @property
    def at(self) -> Observation:
        """Of the frame, once all before it were taken. Raises `InputError` where there is none."""
        if self._at is None:
            last = self._count + sum(observation.is_frame for observation in self._source) - 1
            raise InputError(
                f"frame is {self._frame}, expected {self._first or 0} to {last}: the recording has {last + 1} frames"
            )
        return self._at


def _layers(
    prior: Cloud,
    records: list[LayerRecord],
    words: list[tuple[str, str]],
    places: Callable[[Array], dict[str, Array]],
) -> tuple[CycleLayer, ...]:
    """Every layer with the cloud that the one before left; of each there is a record an island."""
    arriving, layers = prior, []
    for number, (moved_by, weighed_by) in enumerate(words):
        parts = [record for record in records if record.layer == number]
        states = np.concatenate([part.predicted for part in parts])
        at, count = places(states), len(states)
        weighted = Cloud(at, np.concatenate([part.weights * (len(part.weights) / count) for part in parts]))
        left = _left(parts, weighted.weights)
        resampled = None if left is None else Cloud(places(states[left[0]]), left[1])
        # A cue may have had nothing to say.
        said = "" if np.array_equal(weighted.weights, arriving.weights) else weighed_by
        layers.append(CycleLayer(moved_by, said, arriving, Cloud(at, arriving.weights), weighted, resampled))
        arriving = resampled or weighted
    return tuple(layers)


def _left(parts: list[LayerRecord], weights: Array) -> tuple[NDArray[np.intp], Array] | None:
    """Which rows the islands left with what weights, those that did not resample as they were; None where none did."""
    if all(part.ancestors is None for part in parts):
        return None
    rows, of_rows, first = [], [], 0
    for part in parts:
        size = len(part.weights)
        stays = part.ancestors is None
        rows.append(first + (np.arange(size) if part.ancestors is None else part.ancestors))
        of_rows.append(weights[first : first + size] if stays else np.full(size, 1 / len(weights)))
        first += size
    return np.concatenate(rows), np.concatenate(of_rows)


def _truth(recording: Recording, time_s: float) -> dict[str, Array]:
    truth = recording.truth
    if truth is None:
        return {}
    at = {joint: truth.at(joint, np.array([time_s]))[0] for joint in truth.joints_m}
    return {joint: place for joint, place in at.items() if np.isfinite(place).all()}
