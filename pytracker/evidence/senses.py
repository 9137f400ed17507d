"""All that a body's camera shows at a frame: what is seen in the picture, and what a detector found in it."""

from __future__ import annotations

import dataclasses

import numpy as np

from pytracker.evidence.picture.background import median_of, sampled, without_person
from pytracker.evidence.picture.complexion import gains_of_face, is_grey, red_is_blue
from pytracker.evidence.picture.silhouette import BodyEvidence, Silhouette, check_order
from pytracker.evidence.picture.smaller import place_in_smaller, smaller, smaller_frames, times_smaller
from pytracker.evidence.picture.thresholds import SilhouetteParameters
from pytracker.evidence.points.keypoints import PointsEvidence
from pytracker.evidence.points.on_skin import WristsOnSkin
from pytracker.evidence.points.subject import points_of_subject
from pytracker.formats.video import Frame, frames
from pytracker.recording.recording import BodyRecording
from pytracker.rotation import Array

__all__ = ["Senses", "senses_of"]


class Senses:
    """Frame by frame, in the order of the video or not."""

    def __init__(
        self, recording: BodyRecording, silhouette: Silhouette | None, shrunk: int = 1, *, red_is_blue: bool = False
    ) -> None:
        """Of a recording, whose pictures, if any, `silhouette` reads, made so many times smaller.

        `run_s` adds up the time of that; `red_is_blue` is what the first face says of the pictures.
        """
        self.red_is_blue = red_is_blue
        view = recording.view
        self.silhouette = silhouette
        self.shrunk = shrunk
        self.run_s = 0.0
        self._has_seen = False
        self._keypoints: dict[int, Array] = {}
        if view.keypoints is not None:
            self._keypoints = points_of_subject(recording, view.keypoints)
        root = recording.skeleton.joints(recording.initial[None])["root"]
        self._is_odd_light = silhouette is not None and silhouette.parameters.gains != (1.0, 1.0, 1.0)
        self.wrists = WristsOnSkin(float(view.camera.px_per_m(root)[0]) / shrunk)

    def __call__(self, frame: Frame) -> BodyEvidence:
        """What is known of it. Raises `InputError` as `Silhouette`, and for a first frame that is RGB."""
        assert self.silhouette is not None
        image = smaller(frame.image, self.shrunk)
        found = self.silhouette(image)
        if not self._has_seen:
            check_order(image, self.silhouette.background)
            self._has_seen = True
        keypoints = self._points_on_skin(frame.index, found)
        return dataclasses.replace(found, keypoints=keypoints, image=frame.image, shrunk=self.shrunk)

    def _points_on_skin(self, index: int, found: BodyEvidence) -> Array | None:
        keypoints = self._keypoints.get(index)
        if keypoints is None:
            return None
        if self._is_odd_light:
            return keypoints  # skin that is lost in it says nothing of points
        kept = keypoints.copy()
        for person in kept:
            pixels = np.column_stack([place_in_smaller(person[:, :2], self.shrunk), person[:, 2] / self.shrunk])
            person[self.wrists.beside(pixels, found.skin_region)] = np.nan
        return kept

    def without_picture(self, index: int) -> PointsEvidence:
        """What is known of the frame of that number where there are keypoints alone."""
        return PointsEvidence(self._keypoints.get(index))


def senses_of(recording: BodyRecording) -> Senses:
    """The senses of this recording; without a background it takes the video's median, without the person."""
    view = recording.view
    if view.video is None:
        return Senses(recording, None)
    joints = recording.skeleton.joints(recording.initial[None])
    first = next(frames(view.video)).image
    times = times_smaller(float(view.camera.px_per_m(joints["root"])[0]), first)
    camera = view.camera.of_smaller(times)
    samples = sampled(smaller_frames(frames(view.background or view.video), times))
    background = median_of(samples)
    px_per_m, head = float(camera.px_per_m(joints["root"])[0]), camera.project(joints["head"])[0]
    # Of a median, before the person is taken out: of a head that stands still the hair would be taken for its face.
    gains = gains_of_face(smaller(first, times), background, head, px_per_m)
    is_exchanged = red_is_blue(smaller(first, times), background, head, px_per_m)
    if view.background is None:
        starts, ends, _ = recording.skeleton.core.pose(np.ascontiguousarray(recording.initial[None]))
        hands = np.stack([recording.skeleton.below(forearm) for forearm in ("lradius", "rradius")])
        bones = np.stack([starts[0], ends[0]], axis=1)
        background = without_person(samples, smaller(first, times), camera, bones, hands)
    parameters = SilhouetteParameters(gains=gains)
    if is_grey(smaller(first, times)) and is_grey(background):
        # Without colour all that is darker than what is behind it would be its shadow.
        parameters = dataclasses.replace(parameters, shadow_chroma=0)
    silhouette = Silhouette(background, px_per_m, parameters)
    return Senses(recording, silhouette, times, red_is_blue=is_exchanged)
