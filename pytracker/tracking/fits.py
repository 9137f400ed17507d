"""Whether a method can track a recording."""

from __future__ import annotations

from pytracker._core import InputError
from pytracker.methods.method import Method
from pytracker.recording.recording import Recording

__all__ = ["check_fits"]


def check_fits(recording: Recording, method: Method) -> None:
    """Raise `InputError` where the method is another kind's, or weighs by nothing that the recording has."""
    if method.kind != recording.kind:
        raise InputError(
            f"{type(method).__name__} tracks a recording of kind {method.kind!r}, this one is {recording.kind!r}"
        )
    if method.needs_picture and not recording.has_picture:
        raise InputError(
            f"{type(method).__name__} weighs by what a video shows and the recording has keypoints alone, expected a "
            "video, or a method with keypoints among its cues"
        )
