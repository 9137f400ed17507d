"""Whether a method can track a recording."""

from __future__ import annotations

from pytracker._core import InputError
from pytracker.methods.method import Method
from pytracker.recording.recording import Recording

__all__ = ["check_fits", "why_unfit"]


def why_unfit(recording: Recording, method: Method) -> str:
    """Why the method cannot track it: it is another kind's, or weighs by nothing that is there; empty where it can."""
    name = type(method).__name__
    if method.kind != recording.kind:
        return f"{name} tracks a recording of kind {method.kind!r}, this one is {recording.kind!r}"
    if method.needs_picture and not recording.has_picture:
        return (
            f"{name} weighs by what a video shows and the recording has keypoints alone, expected a video, or a method "
            "with keypoints among its cues"
        )
    needed = method.needs_one_of
    if needed is not None and not set(needed) & set(recording.points):
        return (
            f"{name} is corrected by {' and '.join(needed) or 'nothing'} and the recording has "
            f"{' and '.join(recording.points) or 'no keypoints and no sensors'}, expected [[camera]] keypoints "
            "(pytracker keypoints FOLDER finds them in the video) or [[imu]] (orientation) and a method for them"
        )
    return ""


def check_fits(recording: Recording, method: Method) -> None:
    """Raise `InputError` where the method cannot track the recording, or is none."""
    if not isinstance(method, Method):
        raise InputError(f"method is {method!r}, expected a method object, such as pytracker.Layered(particles=500)")
    if why := why_unfit(recording, method):
        raise InputError(why)
