"""What frames say of a body's estimates, one by one, as they come: of a stream as of a recording.

A particle filter always has a mean. Pictures and keypoints bear it out, or speak against it, by what was seen in the
last quarter of a second.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pytracker._core import KEY_JOINTS, Estimate, InputError, Observation
from pytracker.evidence.picture.complexion import is_grey
from pytracker.evidence.picture.frozen import HANGS, Frozen
from pytracker.evidence.picture.silhouette import BodyEvidence
from pytracker.evidence.picture.smaller import place_in_smaller
from pytracker.evidence.points.followed import followed
from pytracker.evidence.pose.borne_out import BorneOut
from pytracker.evidence.pose.cut_off import CutOff
from pytracker.evidence.pose.points_borne_out import PointsBorneOut
from pytracker.evidence.pose.stands_apart import StandsApart
from pytracker.evidence.pose.stands_out import StandsOut
from pytracker.evidence.pose.stature import StatureSeen
from pytracker.evidence.pose.trunk import TrunkSeen
from pytracker.methods.body import BodyMethod
from pytracker.recording.recording import BodyRecording
from pytracker.rotation import Array
from pytracker.tracking.fits import check_fits

__all__ = ["NO_BLOB", "BodyWatch", "PictureWatch", "PointsWatch", "Words", "in_words", "is_blob_bound", "together"]

Words = dict[str, str]
"""By joint what speaks against it, `""` for the frame; those are left out that nothing speaks against."""
NO_BLOB = "no skin blob"
NO_COLOUR = "no skin is seen in a picture without colour"


class BodyWatch:
    """What speaks against the estimates of a `Tracker` that is given a body's observations one by one.

        tracker, watch = pytracker.Tracker(recording, method), BodyWatch(recording, method)
        for observation in recording.observations():
            watch.take(observation)
            estimate = tracker.observe(observation)
            if estimate is not None:
                print(estimate.time_s, watch.reasons(estimate))

    Of a filter these are the reasons of `track`, frame by frame, but for what only later frames tell: that the picture
    hung (that it hangs is said after a second), or that the camera moved. What `doubts` asks of a whole recording is
    not asked.

    Args:
        recording: what the tracker was set up by.
        method: the tracker's.

    Raises `InputError` where the method cannot track the recording.
    """

    def __init__(self, recording: BodyRecording, method: BodyMethod) -> None:
        check_fits(recording, method)
        self._recording = recording
        self._asks_blobs = recording.has_picture and is_blob_bound(method)
        self._points = PointsWatch(recording)
        self._pictures: PictureWatch | None = None
        self._frozen = Frozen()
        self._frames: dict[float, Any] = {}

    def take(self, observation: Observation) -> None:
        """Take what the tracker is given; a frame is kept until its estimate, or a later one, is asked about."""
        if observation.is_frame:
            self._frames[observation.time_s] = observation.evidence

    def reasons(self, estimate: Estimate) -> Words:
        """What speaks against it, by key joint, `""` for the frame; empty where nothing does.

        Estimates are asked about once, in order of time. Raises `InputError` for one whose frame was not taken.
        """
        if estimate.time_s not in self._frames:
            raise InputError(f"the frame at {estimate.time_s} s was not taken, or was asked about, expected each once")
        evidence = self._frames[estimate.time_s]
        self._frames = {time_s: later for time_s, later in self._frames.items() if time_s > estimate.time_s}
        places = {name: estimate.places[name] for name in KEY_JOINTS}
        means = {name: np.asarray(place.mean) for name, place in places.items()}
        sds = {name: np.asarray(place.sd) for name, place in places.items()}
        seen: Words = {}
        if self._recording.has_picture:
            if self._pictures is None:
                self._pictures = PictureWatch(self._recording, evidence.shrunk)
            seen = self._pictures.look(estimate.time_s, means, sds, evidence)
            self._frozen.look(estimate.time_s, evidence.image)
            seen = together(seen, {"": HANGS if self._frozen.hangs() else ""})
        words = together(seen, self._points.look(estimate.time_s, means, evidence.keypoints))
        if self._asks_blobs and not words and not np.isfinite(estimate.blobs).any():
            words = {"": NO_BLOB}
        return together(words, {"": estimate.doubt})


def is_blob_bound(method: BodyMethod) -> bool:
    """Whether a method sees blobs and nothing else of the skin, as a paper's filter."""
    return "blobs" in method.cues and "regions" not in method.cues


def together(*said: Words) -> Words:
    """What goes for a frame is said in a row, what goes for a joint by the first that says it."""
    words: Words = {}
    for some in said:
        for joint, why in some.items():
            words.setdefault(joint, why)
    words[""] = "; ".join(filter(None, (some.get("") for some in said)))
    return {joint: why for joint, why in words.items() if why}


def in_words(words: Words) -> str:
    """All of a frame's reasons; what goes for all of it is said once."""
    of_joints = [f"{joint.replace('_', ' ')}: {why}" for joint, why in words.items() if joint and why != words.get("")]
    return "; ".join([*filter(None, [words.get("")]), *of_joints])


class PictureWatch:
    """What pictures say of estimates.

    Args:
        recording: whose camera, first pose and senses.
        shrunk: how many times smaller its pictures are made.
    """

    def __init__(self, recording: BodyRecording, shrunk: int) -> None:
        self._camera, self._shrunk = recording.view.camera, shrunk
        self.seen_by = self._camera.of_smaller(shrunk)
        """What is found in pictures made smaller is seen by their camera."""
        self.first = {name: rows[0] for name, rows in recording.skeleton.joints(recording.initial[None]).items()}
        """Key joints of the first pose, `(3,)` each, world, m."""
        self._is_first = True
        self._borne_out = BorneOut(self.seen_by, self.first, [imu.segment for imu in recording.imus])
        _, ends, _ = recording.skeleton.core.pose(recording.initial[None])
        is_median = recording.view.background is None
        self._stature = StatureSeen(self.seen_by, ends[0], self.first["head"], is_median=is_median)
        self._cut_off = CutOff(self.seen_by)
        self.stands_out = StandsOut(self.seen_by)
        self._stands_apart = StandsApart(self.seen_by)
        self.is_grey = False
        """Whether the first picture has no colour."""
        self._has_keypoints = recording.view.keypoints is not None

    def look(
        self, time_s: float, means: Mapping[str, Array], sds: Mapping[str, Array], evidence: BodyEvidence
    ) -> Words:
        """Take a frame's key joints and their standard deviations, `(3,)` each, world, m, and what it shows."""
        points, _ = followed(self._camera, means, evidence.keypoints)
        within = None if points is None else place_in_smaller(points[:, :2], self._shrunk)
        words = self._borne_out.look(time_s, means, sds, evidence, within)
        if self._is_first and evidence.image is not None:
            self.is_grey = is_grey(evidence.image)
        # The first pose is what the first frame is asked about.
        hardly = self.stands_out.look(time_s, self.first if self._is_first else means, evidence.foreground)
        self._is_first = False
        if self._has_keypoints:
            return words
        if self.is_grey:
            return {"": NO_COLOUR}
        person = None if self.stands_out.floods else evidence.foreground
        stature = self._stature.look(time_s, means, person)
        hidden = self._cut_off.look(time_s, means, evidence.foreground)
        things = self._stands_apart.look(time_s, means, evidence)
        return together(words, {"": stature}, {"": hardly}, hidden, things)


class PointsWatch:
    """What keypoints say of estimates: of the trunk, and where there is no picture, of arms.

    Args:
        recording: whose camera; without keypoints nothing is said.
    """

    def __init__(self, recording: BodyRecording) -> None:
        camera = recording.view.camera
        self._camera = camera
        self._trunk = TrunkSeen(camera) if recording.view.keypoints is not None else None
        self._arms = None if recording.has_picture else PointsBorneOut(camera)
        self.points: Array | None = None
        """Of who is followed, in the last frame `(9, 3)`, px; None where nobody is."""
        self.are_exchanged = False
        """Whether their left and right had to be exchanged."""

    def look(self, time_s: float, means: Mapping[str, Array], people: Array | None) -> Words:
        """Take a frame's key joints, `(3,)` each, world, m, and everyone's keypoints `(P, 9, 3)`, px."""
        self.points, self.are_exchanged = followed(self._camera, means, people)
        arms = {} if self._arms is None else self._arms.look(time_s, means, self.points)
        trunk = "" if self._trunk is None else self._trunk.look(time_s, means, self.points).words
        return together(arms, {"": trunk})
