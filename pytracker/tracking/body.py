"""A body's recording to a `BodyTrack`: frames decoded, evidence extracted, particles weighed, in constant memory."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytracker._core import KEY_JOINTS, KEYPOINTS, InputError, Observation, Tracker, TrackingError
from pytracker.evidence.picture.frozen import HUNG, Frozen
from pytracker.evidence.picture.silhouette import BodyEvidence
from pytracker.evidence.points.followed import followed
from pytracker.evidence.points.late import LATE, MIRRORED, PADDED, Counted, points_late_of
from pytracker.evidence.pose.borne_out import head_off
from pytracker.evidence.pose.facing import FaceSeen
from pytracker.evidence.pose.points_borne_out import median_off_m, worst_arm_off_m
from pytracker.evidence.senses import senses_of
from pytracker.evidence.sightings import Progress, Sightings
from pytracker.formats.video import Image
from pytracker.methods.body import BodyMethod
from pytracker.recording.recording import BodyRecording
from pytracker.rotation import Array
from pytracker.tracking.body_watch import NO_BLOB, PictureWatch, PointsWatch, Words, in_words, is_blob_bound, together
from pytracker.tracking.camera_moved import MOVED, camera_moved
from pytracker.tracking.follow import Followed, follow, smoothed
from pytracker.tracking.tracks import Track

__all__ = ["BodyTrack", "Shown", "track_body"]

NOT_TOLD = (float("nan"), float("nan"))
MOSTLY_EXCHANGED = 0.5
"""Of a mirrored picture left and right are exchanged in more of the frames."""
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
        points_off_m: how far keypoints lie from the first pose across the picture, the median of an arm's, m.
        points_astray_m: the same of the pose of every frame `(T,)`; NaN where there are none.
        points_late: how keypoints are counted otherwise, and by how much nearer to skin wrists then lie than as they
            are counted, m; as they are counted and 0 where nothing else is told.
        points_mirrored: whether keypoints lie on skin if the picture they were found in is taken to be mirrored.
        points_padded_m: by how much they lie nearer to skin if that was padded to a square, m; 0 where it was not.
        points_off_skin_m: how far from skin they lie as they are counted, on average, and its standard deviation, m;
            NaN where that is not told.
        points_beside_skin: how many points of wrists lie beside all skin, of one whose other wrist lies on it.
        points_exchanged: in which frames left and right of the keypoints had to be exchanged for that `(T,)`.
        shown: the evidence of a frame about the middle; None without a video.
        gains: of blue, green and red, by which pictures were multiplied to have the face of the first frame as faces
            usually are; all one in usual light.
        is_grey: whether the first frame has no colour.
        red_is_blue: whether the first frame's face is one with red and blue exchanged.
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
    points_late: tuple[Counted, float] = (Counted(), 0.0)
    points_mirrored: bool = False
    points_padded_m: float = 0.0
    points_off_skin_m: tuple[float, float] = NOT_TOLD
    points_beside_skin: int = 0
    points_exchanged: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    shown: Shown | None = None
    gains: tuple[float, float, float] = (1.0, 1.0, 1.0)
    is_grey: bool = False
    red_is_blue: bool = False

    @property
    def channels(self) -> Mapping[str, Array]:
        """Of the skeleton that were tracked: `<bone>_<dof>_rad`, or `_m`."""
        named = (f"{name}_{'m' if name.split('_')[-1].startswith('t') else 'rad'}" for name in self.free)
        return {name: self.angles[:, :, k] for k, name in enumerate(named)}


class _Watched:
    """What is kept of frames as they come: what speaks against them, and what is asked of the whole."""

    def __init__(self, recording: BodyRecording, shrunk: int) -> None:
        self._recording, self._pictures = recording, PictureWatch(recording, shrunk)
        self.face = FaceSeen(self._pictures.seen_by)
        self.late = points_late_of(recording.view, shrunk)
        self.frozen = Frozen()
        self.head_off_m = np.full(2, np.nan)
        self.on_person: list[float] = []
        self.floods: list[bool] = []
        self.people: list[tuple[float, Array | None]] = []
        self.exchanged: list[bool] = []
        self.points: list[Array] = []
        self.points_off_m = float("nan")
        self.points_astray_m: list[float] = []
        self._seen: list[Words] = []
        self._shown: tuple[Shown, ...] = ()

    def __call__(self, observation: Observation, row: dict[str, Any]) -> None:
        evidence, first, camera = observation.evidence, self._pictures.first, self._recording.view.camera
        if not self.people:
            theirs, _ = followed(camera, first, evidence.keypoints)
            self.points_off_m = worst_arm_off_m(camera, first, theirs)
        self.people.append((observation.time_s, evidence.keypoints))
        if self._recording.has_picture:
            means, sds = ({name: row[name][quantity] for name in KEY_JOINTS} for quantity in (0, 2))
            self._see(observation, means, sds)

    def _see(self, observation: Observation, means: dict[str, Array], sds: dict[str, Array]) -> None:
        """Take a frame that has a picture, and its key joints and their standard deviations."""
        frame, index, evidence = len(self._seen), observation.index or 0, observation.evidence
        self._show(frame, index, evidence)
        assert evidence.image is not None
        self.frozen.look(observation.time_s, evidence.image)
        if not frame:
            self.head_off_m = head_off(self._pictures.seen_by, self._pictures.first, evidence)
        if self.late is not None:
            self.late.look(index, evidence, float(self._pictures.seen_by.px_per_m(means["root"][None])[0]))
        if frame % LOOK_EVERY == 0:
            self.face.look(means, evidence)
        self._seen.append(self._pictures.look(observation.time_s, means, sds, evidence))
        self.on_person.append(self._pictures.stands_out.share)
        self.floods.append(self._pictures.stands_out.floods)

    @property
    def are_mirrored(self) -> bool:
        """Whether keypoints are of a mirrored picture: on skin there, and left and right exchanged against the pose."""
        is_other_side = bool(self.exchanged) and float(np.mean(self.exchanged)) > MOSTLY_EXCHANGED
        return is_other_side and self.late is not None and self.late.are_mirrored

    @property
    def is_grey(self) -> bool:
        """Whether the first picture has no colour."""
        return self._pictures.is_grey

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

    def reasons(self, table: dict[str, Any]) -> list[Words]:
        """What speaks against each joint of a frame, `""` for the frame.

        Keypoints are asked of what was made of them in the end, pictures, which are too many to be kept, as they came.
        """
        watch, camera = PointsWatch(self._recording), self._recording.view.camera
        said = []
        for frame, (time_s, people) in enumerate(self.people):
            means = {name: table[name][frame][0] for name in KEY_JOINTS}
            said.append(watch.look(time_s, means, people))
            self.points_astray_m.append(median_off_m(camera, means, watch.points))
            self.exchanged.append(watch.are_exchanged)
            self.points.append(np.full((len(KEYPOINTS), 3), np.nan) if watch.points is None else watch.points)
        seen = self._seen or [{}] * len(said)
        return [together(*words) for words in zip(seen, said, strict=True)]


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
        gains, beside = senses.silhouette.parameters.gains, senses.wrists.left_out
        track = replace(track, gains=gains, red_is_blue=senses.red_is_blue, points_beside_skin=beside)
    if found.lost:
        loss = TrackingError(found.lost)
        loss.track = track
        raise loss
    return track


def _reasons(
    recording: BodyRecording, method: BodyMethod, watched: _Watched, found: Followed, blobs: Array
) -> list[Words]:
    """Why joints of a frame are not to be believed, by joint, `""` for the frame; empty where they are."""
    seen = watched.reasons(found.table)
    if watched.on_person and is_blob_bound(method):
        blind = [not np.isfinite(row).any() for row in blobs]
        seen = [words or ({"": NO_BLOB} if none else {}) for words, none in zip(seen, blind, strict=True)]
    if watched.on_person:
        hung = watched.frozen.hung()
        seen = [together(words, {"": HUNG if hangs else ""}) for words, hangs in zip(seen, hung, strict=True)]
    has_moved = camera_moved(recording.view, found.time_s[: found.tracked], found.table["root"][:, 0])
    of_all = {"": _of_all_points(watched)}
    # From a camera that has moved all else looks otherwise, too.
    said = [
        together({"": MOVED} if moved else words, {"": str(doubt)}, of_all)
        for words, doubt, moved in zip(seen, found.table["doubt"], has_moved, strict=True)
    ]
    return said + [{"": "the track was lost before"}] * (found.count - found.tracked)


def _of_all_points(watched: _Watched) -> str:
    """Why none of a recording's keypoints are to be believed; empty where they are."""
    if watched.are_mirrored:
        return MIRRORED
    if watched.late is None:
        return ""
    return PADDED if watched.late.nearer_without_padding_m else LATE if watched.late.found()[0] != Counted() else ""


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
    said = _reasons(recording, method, watched, found, blobs[: found.tracked])
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
        reason=tuple(in_words(words) for words in said),
        poses=found.rows(tracker.channels(np.ascontiguousarray(angles[: found.tracked, 0]))),
        free=method.channels,
        angles=np.ascontiguousarray(angles.transpose(1, 0, 2)),
        blobs=blobs,
        on_person=found.rows(np.array(watched.on_person)),
        floods=found.rows(np.array(watched.floods, dtype=float)) > 0,
        face_on_back=watched.face.on_back,
        head_off_m=watched.head_off_m,
        is_grey=watched.is_grey,
        points=found.rows(np.array(watched.points).reshape(-1, len(KEYPOINTS), 3)),
        points_off_m=watched.points_off_m,
        points_astray_m=found.rows(np.array(watched.points_astray_m)),
        points_late=(Counted(), 0.0) if watched.late is None else watched.late.found(),
        points_mirrored=watched.are_mirrored,
        points_padded_m=0.0 if watched.late is None else watched.late.nearer_without_padding_m,
        points_off_skin_m=NOT_TOLD if watched.late is None else watched.late.off_skin(),
        points_exchanged=np.array(watched.exchanged + [False] * (found.count - found.tracked)),
        shown=watched.shown,
        stage_s=stage_s,
        lost=found.lost,
    )
