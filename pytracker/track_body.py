"""A body's recording to a `BodyTrack`: frames decoded, evidence extracted, particles weighed, in constant memory."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from pytracker._core import KEY_JOINTS, BodyEstimate, BodyTracker, TrackingError
from pytracker.body_methods import BodyMethod
from pytracker.evidence.borne_out import BorneOut, head_off
from pytracker.evidence.senses import Senses, senses_of
from pytracker.evidence.sightings import Progress
from pytracker.evidence.silhouette import BodyEvidence
from pytracker.formats.video import frames
from pytracker.joint_track import JointTrack, Track
from pytracker.recording import BodyRecording
from pytracker.rotation import Array
from pytracker.skeleton import UPPER_BODY, upper_body_parts

__all__ = ["BodyTrack", "make_tracker", "track_body"]

LOOK_EVERY = 10
"""In every so many frames it is looked whether the skeleton stands on the person."""
ABOUT_M = 0.08
"""Clothes of the wall's colour leave holes in the foreground, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyTrack(Track):
    """What a method made of a body's recording; joints are the paper's eight key joints.

    Attributes:
        method: the method with its parameters.
        recording: what was tracked.
        poses: expected pose of every frame `(T, C)`, m and rad, in the order of `recording.skeleton.channels`.
        free: names of the channels that were tracked `(D,)`.
        angles: mean, mode, standard deviation, 2.5 % and 97.5 % quantile of each `(5, T, D)`, m and rad.
        blobs: the blob given to head, left and right hand `(T, 3, 2)`, px; NaN where none was.
        on_person: share of the key joints that have foreground about them, at every tenth frame `(K,)`.
        head_off_m: how far the person's head is right of and below the skeleton's at the first frame `(2,)`, m.
    """

    method: BodyMethod
    recording: BodyRecording
    poses: Array
    free: tuple[str, ...]
    angles: Array
    blobs: Array
    on_person: Array
    head_off_m: Array


def make_tracker(recording: BodyRecording, method: BodyMethod, seed: int = 0) -> BodyTracker:
    """The online tracker of this body, at its first pose. Raises `InputError`."""
    skeleton = recording.skeleton
    return BodyTracker(
        skeleton.core,
        recording.initial.tolist(),
        skeleton.columns(method.free or UPPER_BODY),
        skeleton.limits_rad,
        list(upper_body_parts()),
        recording.view.camera,
        method,
        seed,
    )


def track_body(
    recording: BodyRecording,
    method: BodyMethod,
    seed: int = 0,
    *,
    progress: Progress | None = None,
    threads: int | None = None,
) -> BodyTrack:
    """Track a body: see `pytracker.track`."""
    began = time.perf_counter()
    senses = senses_of(recording)
    tracker = make_tracker(recording, method, seed)
    stage_s = {"background": time.perf_counter() - began, "evidence": 0.0, "filter": 0.0}
    estimates: list[BodyEstimate] = []
    times: list[float] = []
    lost = ""
    on_person: list[float] = []
    borne_out, at_first = BorneOut(recording.view.camera), np.full(2, np.nan)
    for frame_time_s, evidence in _ahead(recording, senses, stage_s):
        times.append(frame_time_s)
        if lost:
            continue
        at = time.perf_counter()
        try:
            estimates.append(tracker.update(frame_time_s, evidence, threads=threads))
        except TrackingError as error:
            lost = f"frame {len(times) - 1}: {error}"
        stage_s["filter"] += time.perf_counter() - at
        if len(times) == 1:
            first = recording.skeleton.joints(recording.initial[None])
            at_first = head_off(recording.view.camera, {name: rows[0] for name, rows in first.items()}, evidence)
        if not lost:
            mean, _, sd, *_ = estimates[-1].joints
            means, sds = (dict(zip(KEY_JOINTS, rows, strict=True)) for rows in (mean, sd))
            borne_out.look(frame_time_s, means, sds, evidence)
        if not lost and len(estimates) % LOOK_EVERY == 1:
            on_person.append(_share_on_person(recording, estimates[-1], evidence))
        if progress is not None and len(times) % 30 == 0:
            progress("track", len(times))
    if not estimates:
        raise TrackingError(lost)
    track = _assemble(
        recording, method, seed, tracker, np.array(times), estimates, on_person, at_first, borne_out, stage_s, lost
    )
    if lost:
        loss = TrackingError(lost)
        loss.track = track
        raise loss
    return track


def _share_on_person(recording: BodyRecording, estimate: BodyEstimate, evidence: BodyEvidence) -> float:
    """Of the key joints, how many have foreground about them."""
    camera, joints = recording.view.camera, estimate.joints[0]
    pixels, reach = camera.project(joints), ABOUT_M * camera.px_per_m(joints)
    on_person = 0
    for (u, v), px in zip(pixels, reach, strict=True):
        if np.isfinite([u, v, px]).all():
            rows, columns = (slice(max(0, round(x - px)), max(0, round(x + px) + 1)) for x in (v, u))
            on_person += bool(evidence.foreground[rows, columns].any())
    return on_person / len(joints)


def _ahead(recording: BodyRecording, senses: Senses, stage_s: dict[str, float]) -> Iterator[tuple[float, BodyEvidence]]:
    """Time and evidence of every frame, one frame ahead of whoever asks: decoding and OpenCV let the interpreter go."""
    source = frames(recording.view.video)

    def work() -> tuple[float, BodyEvidence] | None:
        at = time.perf_counter()
        frame = next(source, None)
        found = None if frame is None else (frame.time_s + recording.view.start_s, senses(frame))
        stage_s["evidence"] += time.perf_counter() - at
        return found

    with ThreadPoolExecutor(1) as pool:
        coming = pool.submit(work)
        while (found := coming.result()) is not None:
            coming = pool.submit(work)
            yield found


def _assemble(
    recording: BodyRecording,
    method: BodyMethod,
    seed: int,
    tracker: BodyTracker,
    time_s: Array,
    estimates: list[BodyEstimate],
    on_person: list[float],
    head_off_m: Array,
    borne_out: BorneOut,
    stage_s: dict[str, float],
    lost: str,
) -> BodyTrack:
    """Rows for every frame: those that were not tracked hold NaN and a reason."""
    frames_count = len(time_s)

    def rows(values: Array) -> Array:
        out = np.full((frames_count, *values.shape[1:]), np.nan)
        out[: len(values)] = values
        return out

    joints = rows(np.array([estimate.joints for estimate in estimates]))
    angles = rows(np.array([estimate.state for estimate in estimates]))
    blobs = rows(np.array([estimate.blobs for estimate in estimates]))
    seen = np.atleast_1d(np.isfinite(blobs).any(axis=(1, 2)))
    # A paper's filter sees blobs and nothing else of the skin.
    needs_blobs = getattr(method, "skin_loss", 0.0) == 0.0
    reason = ["no skin blob" if needs_blobs and not any_blob else "" for any_blob in seen]
    for k, words in enumerate(borne_out.reasons()):
        reason[k] = words or reason[k]
    reason[len(estimates) :] = ["the track was lost before"] * (frames_count - len(estimates))
    return BodyTrack(
        method=method,
        recording=recording,
        seed=seed,
        time_s=time_s,
        joints={
            joint: JointTrack(*(np.ascontiguousarray(joints[:, quantity, j]) for quantity in range(5)))
            for j, joint in enumerate(KEY_JOINTS)
        },
        ess=rows(np.array([estimate.ess for estimate in estimates])),
        log_evidence=np.full(frames_count, np.nan),
        valid=np.array([not words for words in reason]),
        reason=tuple(reason),
        poses=rows(tracker.poses(np.ascontiguousarray(angles[: len(estimates), 0]))),
        free=method.free or UPPER_BODY,
        angles=np.ascontiguousarray(angles.transpose(1, 0, 2)),
        blobs=blobs,
        on_person=np.array(on_person),
        head_off_m=head_off_m,
        stage_s=stage_s,
        lost=lost,
    )
