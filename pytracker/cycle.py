"""One cycle of a particle filter, to be looked at: what every layer did with the cloud at one frame of a track.

The recording is tracked up to the frame by the same calls as always; only that frame is recorded. So the clouds are
those of the track with the same method and seed, to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pytracker._core import KEY_JOINTS, ArmTracker, InputError, LayerRecord, TrackingError
from pytracker.body_methods import BodyMethod
from pytracker.evidence.senses import senses_of
from pytracker.evidence.sightings import Progress, Sightings, sight
from pytracker.formats.video import frames
from pytracker.methods import Method, ParticleMethod
from pytracker.recording import ArmRecording, BodyRecording, Recording
from pytracker.rotation import Array
from pytracker.track_body import make_tracker

__all__ = ["Cloud", "Cycle", "CycleLayer", "record_cycle"]

MOVERS = {"inertial": "inertial motion", "walk": "random walk"}


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
    if recording.kind != method.kind:
        raise InputError(
            f"{type(method).__name__} tracks a recording of kind {method.kind!r}, this one is {recording.kind!r}"
        )
    if isinstance(recording, ArmRecording) and isinstance(method, ParticleMethod):
        return _arm(recording, method, seed, frame, sightings or sight(recording, progress=progress))
    if isinstance(recording, BodyRecording) and isinstance(method, BodyMethod):
        if sightings is not None:
            raise InputError("sightings are given for a body, expected them for an arm only")
        return _body(recording, method, seed, frame, progress)
    raise InputError(f"{type(method).__name__} has no particles, expected a particle method")


def _arm(recording: ArmRecording, method: ParticleMethod, seed: int, frame: int, sightings: Sightings) -> Cycle:
    imu = recording.imus[0]
    first = int(np.searchsorted(sightings.time_s, imu.time_s[0]))
    _check_frame(frame, first, len(sightings.time_s))
    tracker = ArmTracker(recording.arm, [view.camera for view in recording.views], method, seed)
    before = slice(first, frame)
    gyr = imu.gyr
    _, used, lost = tracker.run(
        imu.time_s,
        imu.acc,
        imu.q_world_sensor,
        gyr,
        sightings.time_s[before],
        sightings.pixels[before],
        first_frame=first,
    )
    if lost:
        raise TrackingError(lost)
    time_s = float(sightings.time_s[frame])
    for k in range(used, int(np.searchsorted(imu.time_s, time_s, side="right"))):
        tracker.predict(imu.time_s[k], imu.acc[k], imu.q_world_sensor[k], None if gyr is None else gyr[k])
    states, weights = tracker.particles, tracker.weights
    assert states is not None
    assert weights is not None
    estimate, records = tracker.update_recorded(time_s, list(sightings.pixels[frame]))
    # eq. (2): the elbow is where the wrist is, and a forearm further on; the same for every particle.
    forearm = estimate.elbow - estimate.wrist

    def places(rows: Array) -> dict[str, Array]:
        return {"wrist": rows[:, :3], "elbow": rows[:, :3] + forearm}

    words = [(MOVERS[mover], _and(cues)) for mover, cues in method.layers]
    return Cycle(
        recording=recording,
        method=method,
        seed=seed,
        frame=frame,
        time_s=time_s,
        layers=_layers(Cloud(places(states), weights), records, words, places),
        estimate_m={"wrist": estimate.wrist, "elbow": estimate.elbow},
        truth_m=_truth(recording, ("shoulder", "elbow", "wrist"), time_s),
        pixels=sightings.pixels[frame],
    )


def _body(recording: BodyRecording, method: BodyMethod, seed: int, frame: int, progress: Progress | None) -> Cycle:
    if frame < 0:
        _check_frame(frame, 0, 0)
    senses = senses_of(recording)
    tracker = make_tracker(recording, method, seed)
    found = None
    for found in frames(recording.view.video):
        evidence, time_s = senses(found), found.time_s + recording.view.start_s
        if found.index == frame:
            break
        tracker.update(time_s, evidence)
        if progress is not None and found.index % 30 == 0:
            progress("track", found.index)
    else:
        _check_frame(frame, 0, found.index + 1 if found else 0)

    def places(rows: Array) -> dict[str, Array]:
        joints = tracker.joints(np.ascontiguousarray(rows))
        return {name: joints[:, j] for j, name in enumerate(KEY_JOINTS)}

    prior = Cloud(places(tracker.particles), tracker.weights)
    estimate, records = tracker.update_recorded(time_s, evidence)
    words = [(f"diffusion of {_and(groups)}", "edges and skin") for groups, _, _ in method.layers]
    return Cycle(
        recording=recording,
        method=method,
        seed=seed,
        frame=frame,
        time_s=time_s,
        layers=_layers(prior, records, words, places),
        estimate_m={name: estimate.joints[0, j] for j, name in enumerate(KEY_JOINTS)},
        truth_m=_truth(recording, KEY_JOINTS, time_s),
    )


def _check_frame(frame: int, first: int, count: int) -> None:
    if not first <= frame < count:
        raise InputError(f"frame is {frame}, expected {first} to {count - 1}: the recording has {count} frames")


def _layers(
    prior: Cloud,
    records: list[LayerRecord],
    words: list[tuple[str, str]],
    places: Callable[[Array], dict[str, Array]],
) -> tuple[CycleLayer, ...]:
    """Every layer with the cloud that the one before left; the records come island by island."""
    arriving, layers = prior, []
    for number, (moved_by, weighed_by) in enumerate(words):
        parts = records[number :: len(words)]
        at = places(np.concatenate([part.predicted for part in parts]))
        count = len(arriving.weights)
        weighted = Cloud(at, np.concatenate([part.weights * (len(part.weights) / count) for part in parts]))
        resampled = _resampled(parts, weighted)
        # A cue may have had nothing to say.
        said = "" if np.array_equal(weighted.weights, arriving.weights) else weighed_by
        layers.append(CycleLayer(moved_by, said, arriving, Cloud(at, arriving.weights), weighted, resampled))
        arriving = resampled or weighted
    return tuple(layers)


def _resampled(parts: list[LayerRecord], weighted: Cloud) -> Cloud | None:
    """What the islands left, those that did not resample as they were; None where none did."""
    if all(part.ancestors is None for part in parts):
        return None
    chosen, weights, first = [], [], 0
    for part in parts:
        size = len(part.weights)
        stays = part.ancestors is None
        chosen.append(first + (np.arange(size) if part.ancestors is None else part.ancestors))
        weights.append(weighted.weights[first : first + size] if stays else np.full(size, 1 / len(weighted.weights)))
        first += size
    rows = np.concatenate(chosen)
    return Cloud({name: points[rows] for name, points in weighted.points_m.items()}, np.concatenate(weights))


def _truth(recording: Recording, joints: tuple[str, ...], time_s: float) -> dict[str, Array]:
    truth = recording.truth
    if truth is None:
        return {}
    at = {joint: truth.at(joint, np.array([time_s]))[0] for joint in joints if joint in truth.joints_m}
    return {joint: place for joint, place in at.items() if np.isfinite(place).all()}


def _and(words: tuple[str, ...]) -> str:
    return " and ".join(word.replace("_", " ") for word in words)
