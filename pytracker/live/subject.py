"""What an arm or a body takes of a camera's frame, and what speaks against an estimate."""

from __future__ import annotations

import dataclasses
from functools import singledispatch
from typing import Protocol, cast

from pytracker._core import Estimate, InputError, Observation
from pytracker.evidence.patch.camshift import PatchTracker
from pytracker.evidence.senses import senses_of
from pytracker.formats.video import Frame, probe
from pytracker.formats.video import frames as frames_of
from pytracker.methods.body import BodyMethod
from pytracker.methods.method import Method
from pytracker.recording.recording import ArmRecording, BodyRecording, Recording, View, Worn
from pytracker.tracking.body_watch import BodyWatch, Words
from pytracker.tracking.fits import check_fits

__all__ = ["Subject", "live_subject"]


ABOUT_THERE = {"position_start_sd_m": 0.15, "velocity_start_sd": 0.3}
"""How well an arm begins as in the recording's first frame, at best, m and m/s."""


class Subject(Protocol):
    """Somebody who is followed live."""

    @property
    def recording(self) -> Recording:
        """What sets up the tracker."""

    @property
    def worn(self) -> Worn | None:
        """How the sensor is worn, without which nothing is known; None where none is needed."""

    def see(self, frame: Frame) -> Observation:
        """What a frame shows. Raises `InputError` for one of another size."""

    def words(self, estimate: Estimate) -> Words:
        """What speaks against each joint of an estimate, `""` for the frame, of an arm for the frame alone.

        Each is empty where nothing does. It is asked about once and in order of time.
        """


@singledispatch
def live_subject(recording: Recording, method: Method) -> Subject:
    """Of a recording that was made with the same camera, sensor and person; `method` can track it.

    Raises `InputError`.
    """
    raise InputError(f"{type(recording).__name__} is no recording of an arm or a body, expected one")


@live_subject.register
def _(recording: ArmRecording, method: Method) -> Subject:
    check_fits(recording, method)
    return LiveArm(recording)


@live_subject.register
def _(recording: BodyRecording, method: Method) -> Subject:
    check_fits(recording, method)
    return LiveBody(recording, cast(BodyMethod, method))


class LiveArm:
    """An arm whose patch has the colour that it had in the recording's first frame."""

    def __init__(self, recording: ArmRecording) -> None:
        view = recording.views[0]
        if len(recording.views) > 1 or view.patch_box is None or view.video is None:
            raise InputError(
                f"the recording has {len(recording.views)} cameras, the first {_of(view)}; live an arm is followed by "
                "the patch that one camera sees: expected a recording with one video and patch_box"
            )
        self.worn = recording.imus[0].worn
        known = recording.spreads
        spreads = {**known, **{name: max(sd, known.get(name, 0.0)) for name, sd in ABOUT_THERE.items()}}
        self.recording = dataclasses.replace(recording, imus=recording.imus[:1], landmarks=(), spreads=spreads)
        self._size = probe(view.video)
        self._patch = PatchTracker(next(frames_of(view.video)).image, view.patch_box)
        self._reasons: dict[float, str] = {}

    def see(self, frame: Frame) -> Observation:
        """Where the patch is. Raises `InputError` for a frame of another size."""
        height, width = frame.image.shape[:2]
        if (width, height) != (self._size.width, self._size.height):
            raise InputError(
                f"frame {frame.index} is {width} x {height} px, expected {self._size.width} x {self._size.height} as "
                "in the recording: its calibration is of that size"
            )
        found = self._patch.update(frame.image)
        self._reasons[frame.time_s] = found.reason
        return Observation.patch(frame.time_s, list(found.pixel) if found.valid else None, frame.index)

    def words(self, estimate: Estimate) -> Words:
        """What the tracker doubts, or why the patch was not seen."""
        reason = self._reasons.get(estimate.time_s, "")
        self._reasons = {time_s: later for time_s, later in self._reasons.items() if time_s > estimate.time_s}
        return {"": "; ".join(filter(None, [estimate.doubt, reason]))}


class LiveBody:
    """A body before the recording's background, in the pose of its first frame at first."""

    worn = None

    def __init__(self, recording: BodyRecording, method: BodyMethod) -> None:
        if recording.video is None:
            raise InputError("the recording has keypoints alone, expected a video: live a body is followed by pictures")
        alone = dataclasses.replace(recording.view, keypoints=None)
        self.recording = dataclasses.replace(recording, view=alone, imus=(), imu_sds_rad=())
        self._senses = senses_of(self.recording)
        self._watch = BodyWatch(self.recording, method)

    def see(self, frame: Frame) -> Observation:
        """Edges, skin and person. Raises `InputError` for a frame of another size."""
        observation = Observation.picture(frame.time_s, self._senses(frame), frame.index)
        self._watch.take(observation)
        return observation

    def words(self, estimate: Estimate) -> Words:
        """What its frames show against it."""
        said = self._watch.reasons(estimate)
        # In the order in which a recording says it.
        return {**said, **{joint: "" for joint in ("", *estimate.places) if joint not in said}}


def _of(view: View) -> str:
    if view.video is None:
        return "has no video"
    return "has keypoints in place of patch_box" if view.patch_box is None else "has a patch_box"
