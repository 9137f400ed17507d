"""What is odd about a whole video, in words: a camera that moves, frames that are lacking, a piece of a longer one.

And one that was compressed until too little is left.
"""

from __future__ import annotations

from pathlib import Path

import cv2

from pytracker.formats.container import frames_of_avi
from pytracker.formats.matroska import begins_s
from pytracker.formats.transport import lacking_bytes, lost_packets
from pytracker.formats.video import MOST_FRAMES, opened
from pytracker.formats.video_steady import CameraMoves
from pytracker.formats.video_times import counted

__all__ = ["compression", "video_oddities"]

FEW_LACKING = 2
"""Encoders keep a frame or two back."""
LEAST_BITS, SIDE_PX = 0.03, 480
"""A pixel of a frame made smaller to this longer side: people's videos had 0.08 and more, wrists were lost at 0.022."""
THRIFTY, THRIFTY_BITS = ("h264", "avc1", "hevc", "hvc1", "hev1", "vp90", "vp09", "av01"), 0.01
"""Later codecs, which need fewer: wrists were as right as of the whole at 0.012 to 0.014 (x264 and x265 at 28), and
more of them wrong from 0.008 on."""
LATE_S = 0.5
"""A container's first frame may be that much after 0, s, as where the sound began first."""


def video_oddities(path: Path, start_s: float, moves: CameraMoves | None = None) -> list[str]:
    """A word each, of one whose first frame is said to be at `start_s`. Raises `InputError`.

    `moves` is what was seen of its camera.
    """
    found = ("" if moves is None else moves.words, _lacks(path), _lost(path), _begins_late(path, start_s))
    return [f"{path}: {words}" for words in found if words]


def compression(path: Path) -> list[str]:
    """A word on one that was compressed until skin and edges are smeared. Raises `InputError`."""
    info = counted(path)
    smaller = min(1.0, SIDE_PX / max(info.width, info.height)) ** 2
    bits = THRIFTY_BITS if info.codec in THRIFTY else LEAST_BITS
    least_kbit_s = bits * info.width * info.height * smaller * info.rate_hz / 1000.0
    kbit_s = 8.0 * path.stat().st_size * info.rate_hz / max(info.frame_count, 1) / 1000.0
    if not kbit_s < least_kbit_s:
        return []
    return [
        f"{path}: was compressed to {kbit_s:.0f} kbit/s, expected at least {least_kbit_s:.0f} of {info.width} x "
        f"{info.height} px at {info.rate_hz:.0f} Hz: skin and edges are smeared, and hands may be tens of centimetres "
        "off, beside their bands; take the video as the camera wrote it, or a detector's keypoints of that"
    ]


def _lacks(path: Path) -> str:
    """How many frames an AVI's header says that are not there."""
    capture = opened(path)
    said, avi = int(capture.get(cv2.CAP_PROP_FRAME_COUNT)), frames_of_avi(path)
    capture.release()
    if avi is None or not 0 < avi.count < said - FEW_LACKING or said >= MOST_FRAMES:
        return ""
    return (
        f"its header says {said} frames and {avi.count} are there: where some are missing within, all after come early"
    )


def _lost(path: Path) -> str:
    """Where a transport stream has holes, and whether it was cut off."""
    count = lost_packets(path)
    if count:
        places = "one place" if count == 1 else f"{count} places"
        return f"packets are missing, or pieces were joined, at {places} within: frames there may be damaged or missing"
    return "it ends within a packet, as a recording that was cut off does" if lacking_bytes(path) else ""


def _begins_late(path: Path, start_s: float) -> str:
    """When a piece of a longer recording begins, where nobody says so."""
    late_s = begins_s(path)
    if start_s != 0.0 or late_s < LATE_S:
        return ""
    return (
        f"its first frame is at {late_s:.3f} s of its container's clock, as in a piece of a longer recording, and is "
        "taken to be at 0 s: start_s says when it was"
    )
