"""A body's recording to a `BodyTrack`: frames decoded, evidence extracted, particles weighed, in constant memory."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEY_JOINTS, KEYPOINTS, InputError, Observation, Tracker, TrackingError
from pytracker.evidence.borne_out import BorneOut, head_off
from pytracker.evidence.cut_off import CutOff
from pytracker.evidence.facing import FaceSeen
from pytracker.evidence.followed import followed
from pytracker.evidence.points_borne_out import PointsBorneOut
from pytracker.evidence.points_late import points_late_of
from pytracker.evidence.senses import senses_of
from pytracker.evidence.sightings import Progress, Sightings
from pytracker.evidence.silhouette import BodyEvidence
from pytracker.evidence.smaller import place_in_smaller
from pytracker.evidence.stands_out import StandsOut
from pytracker.evidence.stature import StatureSeen
from pytracker.evidence.trunk import TrunkSeen
from pytracker.formats.video import Image
from pytracker.methods.body import BodyMethod
from pytracker.recording.recording import BodyRecording
from pytracker.rotation import Array
from pytracker.tracking.follow import Followed, follow, smoothed
from pytracker.tracking.tracks import Track

__all__ = ["BodyTrack", "Shown", "track_body"]

LOOK_EVERY = 10
"""In every so many frames it is looked whether a face is seen."""


@dataclass(frozen=True, eq=False)
class Shown:
    """What the evidence was at one frame, to be looked at.

    Attributes:
        index: which frame, from 0.
        image: the frame `(H, W, 3)`, blue, green and red.
        foreground: 255 where the person is; this and what follows in a picture that may have been made smaller.
        edges: 255 on a detected edge.
        skin: 255 on skin.
    """

    index: int
    image: Image
    foreground: Image
    edges: Image
    skin: Image


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyTrack(Track):
    """What a method made of a body's recording; joints are the paper's eight key joints.

    Attributes:
        method: the method with its parameters.
        recording: what was tracked.
        poses: expected pose of every frame `(T, C)`, m and rad, in the order of `recording.skeleton.channels`.
        free: names of the channels that were tracked `(D,)`.
        angles: mean, mode, standard deviation, 2.5 % and 97.5 % quantile of each `(5, T, D)`, m and rad; of the root in
            the picture's plane: where the camera looks across the world's z axis, in a world turned about y.
        blobs: the blob given to head, left and right hand `(T, 3, 2)`, px; NaN where none was.
        on_person: share of the lines from joint to joint, of trunk and arms, that lies on the foreground `(T,)`: of the
            first pose in the first frame, of the estimates then, a few times in a window; else NaN.
        floods: in which frames more of the picture than a person differs from the background `(T,)`.
        head_off_m: how far the person's head is right of and below the skeleton's at the first frame `(2,)`, m.
        face_on_back: share of the head that is skin, where most frames have the skeleton seen from behind; else 0.
        points: keypoints of who is tracked: u, v and standard deviation, px `(T, 9, 3)`; NaN where there are none.
        points_off_m: how far keypoints lie from the first pose across the picture, the median of the arms', m.
        points_astray_m: the same of the pose of every frame `(T,)`; NaN where there are none.
        points_late: by how many frames keypoints fit the pictures best if they are taken to be late, and by how much
            nearer to skin wrists then lie than as they are counted, m; 0 and 0 where nothing better was found.
        points_exchanged: in which frames left and right of the keypoints had to be exchanged for that `(T,)`.
        shown: the evidence of a frame about the middle; None without a video.
        gains: of blue, green and red, by which pictures were multiplied to have the face of the first frame as faces
            usually are; all one in usual light.
    """

    method: BodyMethod
    recording: BodyRecording
    poses: Array
    free: tuple[str, ...]
    angles: Array
    blobs: Array
    on_person: Array
    floods: NDArray[np.bool_]
    head_off_m: Array
    face_on_back: float = 0.0
    points: Array = field(default_factory=lambda: np.zeros((0, len(KEYPOINTS), 3)))
    points_off_m: float = float("nan")
    points_astray_m: Array = field(default_factory=lambda: np.zeros(0))
    points_late: tuple[int, float] = (0, 0.0)
    points_exchanged: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    shown: Shown | None = None
    gains: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @property
    def channels(self) -> Mapping[str, Array]:
        """Of the skeleton that were tracked: `<bone>_<dof>_rad`, or `_m`."""
        named = (f"{name}_{'m' if name.split('_')[-1].startswith('t') else 'rad'}" for name in self.free)
        return {name: self.angles[:, :, k] for k, name in enumerate(named)}


class _Watched:
    """What the pictures say of the estimates, frame by frame."""

    def __init__(self, recording: BodyRecording, shrunk: int) -> None:
        self.camera, self.shrunk = recording.view.camera, shrunk
        # What is found in pictures made smaller is seen by their camera.
        self.seen_by = self.camera.of_smaller(shrunk)
        first = recording.skeleton.joints(recording.initial[None])
        self._first = {name: rows[0] for name, rows in first.items()}
        self.borne_out = BorneOut(self.seen_by, self._first, [imu.segment for imu in recording.imus])
        _, ends, _ = recording.skeleton.core.pose(recording.initial[None])
        is_median = recording.view.background is None
        self.face = FaceSeen(self.seen_by)
        self.stature = StatureSeen(self.seen_by, ends[0], self._first["head"], is_median=is_median)
        self.head_off_m = np.full(2, np.nan)
        self.stands_out, self.cut_off = StandsOut(self.seen_by), CutOff(self.seen_by)
        self.people: list[tuple[float, Array | None]] = []
        self.exchanged: list[bool] = []
        self.points: list[Array] = []
        self.points_off_m = float("nan")
        self.points_astray_m = np.zeros(0)
        self._shown: tuple[Shown, ...] = ()
        self.is_alone = not recording.has_picture
        self.has_keypoints = recording.view.keypoints is not None
        self.late = points_late_of(recording.view, shrunk)

    def __call__(self, observation: Observation, row: dict[str, Any]) -> None:
        evidence, is_first = observation.evidence, not self.people
        self.people.append((observation.time_s, evidence.keypoints))
        if is_first:
            at_first = PointsBorneOut(self.camera)
            at_first.look(observation.time_s, self._first, followed(self.camera, self._first, evidence.keypoints)[0])
            self.points_off_m = float(at_first.median_off_m[0])
        if self.is_alone:
            return
        self._show(len(self.people) - 1, observation.index or 0, evidence)
        means, sds = ({name: row[name][quantity] for name in KEY_JOINTS} for quantity in (0, 2))
        if is_first:
            self.head_off_m = head_off(self.seen_by, self._first, evidence)
        if self.late is not None:
            px_per_m = float(self.seen_by.px_per_m(means["root"][None])[0])
            self.late.look(observation.index or 0, evidence, px_per_m)
        points, _ = followed(self.camera, means, evidence.keypoints)
        within = None if points is None else place_in_smaller(points[:, :2], self.shrunk)
        self.borne_out.look(observation.time_s, means, sds, evidence, within)
        if not self.has_keypoints:
            self.stature.look(observation.time_s, means, evidence.foreground)
            self.cut_off.look(observation.time_s, means, evidence.foreground)
        if (len(self.people) - 1) % LOOK_EVERY == 0:
            self.face.look(means, evidence)
        # The first pose is what the first frame is asked about.
        self.stands_out.look(observation.time_s, self._first if is_first else means, evidence.foreground)

    @property
    def shown(self) -> Shown | None:
        """Of a frame between a quarter and three quarters of the way."""
        return self._shown[0] if self._shown else None

    def _show(self, row: int, index: int, evidence: BodyEvidence) -> None:
        """Keep two, as how many frames there will be is not known: the powers of two, the last and the one before."""
        if row & (row - 1) == 0:
            assert evidence.image is not None
            kept = Shown(index, evidence.image, evidence.foreground, evidence.edges, evidence.skin)
            self._shown = (*self._shown[-1:], kept)

    def reasons(self, table: dict[str, Any]) -> list[dict[str, str]]:
        """What speaks against each joint of a frame, `""` for the frame.

        Keypoints are asked of what was made of them in the end, pictures, which are too many to be kept, as they came.
        """
        points, trunk = PointsBorneOut(self.camera), TrunkSeen(self.camera)
        for row, (time_s, people) in enumerate(self.people):
            means = {name: table[name][row][0] for name in KEY_JOINTS}
            theirs, is_exchanged = followed(self.camera, means, people)
            trunk.look(time_s, means, theirs)
            points.look(time_s, means, theirs)
            self.exchanged.append(is_exchanged)
            self.points.append(np.full((len(KEYPOINTS), 3), np.nan) if theirs is None else theirs)
        self.points_astray_m = points.median_off_m
        seen = points.reasons() if self.is_alone else self.borne_out.reasons()
        moved = trunk.reasons() if self.has_keypoints else self.stature.reasons()
        for words, why in zip(seen, moved, strict=True):
            _add(words, why)
        if not (self.is_alone or self.has_keypoints):
            for words, why, hidden in zip(seen, self.stands_out.reasons(), self.cut_off.reasons(), strict=True):
                _add(words, why)
                words.update(hidden | words)
        return seen


def track_body(
    recording: BodyRecording,
    method: BodyMethod,
    seed: int = 0,
    *,
    sightings: Sightings | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> BodyTrack:
    """Track a body: see `pytracker.track`. Raises `InputError` where it is given an arm's sightings."""
    if sightings is not None:
        raise InputError("sightings are given for a body, expected them for an arm only")
    method = method.known_by(recording.spreads)
    began = time.perf_counter()
    senses = senses_of(recording)
    background_s = time.perf_counter() - began
    tracker, watched = Tracker(recording, method, seed), _Watched(recording, senses.shrunk)
    found = follow(tracker, recording.observations(senses), progress=progress, threads=threads, watch=watched)
    began = time.perf_counter()
    found.table |= smoothed(tracker, found.tracked, progress, threads)
    found.filter_s += time.perf_counter() - began
    stage_s = {"background": background_s, "evidence": senses.run_s, "filter": found.filter_s}
    track = _assemble(recording, method, seed, tracker, found, watched, stage_s)
    if senses.silhouette is not None:
        track = replace(track, gains=senses.silhouette.parameters.gains)
    if found.lost:
        loss = TrackingError(found.lost)
        loss.track = track
        raise loss
    return track


def _reasons(method: BodyMethod, watched: _Watched, found: Followed, blobs: Array) -> list[dict[str, str]]:
    """Why joints of a frame are not to be believed, by joint, `""` for the frame; empty where they are."""
    seen = watched.reasons(found.table)
    # A paper's filter sees blobs and nothing else of the skin.
    if "blobs" in method.cues and "regions" not in method.cues and not watched.is_alone:
        blind = [not np.isfinite(row).any() for row in blobs]
        seen = [words or ({"": "no skin blob"} if none else {}) for words, none in zip(seen, blind, strict=True)]
    for words, doubt in zip(seen, found.table["doubt"], strict=True):
        _add(words, str(doubt))
    return seen + [{"": "the track was lost before"}] * (found.count - found.tracked)


def _add(words: dict[str, str], why: str) -> None:
    """Add a reason that goes for all of a frame, where there is one."""
    if why:
        words[""] = "; ".join(filter(None, (words.get(""), why)))


def _in_words(words: dict[str, str]) -> str:
    """All of a frame's reasons; what goes for all of it is said once."""
    of_joints = [f"{joint.replace('_', ' ')}: {why}" for joint, why in words.items() if joint and why != words.get("")]
    return "; ".join([*filter(None, [words.get("")]), *of_joints])


def _assemble(
    recording: BodyRecording,
    method: BodyMethod,
    seed: int,
    tracker: Tracker,
    found: Followed,
    watched: _Watched,
    stage_s: dict[str, float],
) -> BodyTrack:
    """Rows for every frame: those that were not tracked hold NaN and a reason."""
    angles, blobs = found.rows(found.table["state"]), found.rows(found.table["blobs"])
    said = _reasons(method, watched, found, blobs[: found.tracked])
    of_joint = {joint: tuple(words.get(joint) or words.get("", "") for words in said) for joint in KEY_JOINTS}
    return BodyTrack(
        method=method,
        recording=recording,
        seed=seed,
        time_s=found.time_s,
        joints={joint: replace(found.joint(joint), reason=of_joint[joint]) for joint in KEY_JOINTS},
        ess=found.rows(found.table["ess"]),
        log_evidence=found.rows(found.table["log_evidence"]),
        valid=np.array([not words for words in said]),
        reason=tuple(_in_words(words) for words in said),
        poses=found.rows(tracker.channels(np.ascontiguousarray(angles[: found.tracked, 0]))),
        free=method.channels,
        angles=np.ascontiguousarray(angles.transpose(1, 0, 2)),
        blobs=blobs,
        on_person=found.rows(watched.stands_out.shares),
        floods=found.rows(watched.stands_out.floods.astype(float)) > 0,
        face_on_back=watched.face.on_back,
        head_off_m=watched.head_off_m,
        points=found.rows(np.array(watched.points).reshape(-1, len(KEYPOINTS), 3)),
        points_off_m=watched.points_off_m,
        points_astray_m=found.rows(watched.points_astray_m),
        points_late=(0, 0.0) if watched.late is None else watched.late.found(),
        points_exchanged=np.array(watched.exchanged + [False] * (found.count - found.tracked)),
        shown=watched.shown,
        stage_s=stage_s,
        lost=found.lost,
    )
