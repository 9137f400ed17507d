"""The edit list of an MP4 or MOV: which part of its pictures is shown (ISO/IEC 14496-12, 8.6.6).

Who trims a video without coding it anew, as phones and lossless cutters do, leaves pictures in the file that are never
shown. Decoders heed that; the count of the container does not.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Iterator
from pathlib import Path

__all__ = ["shown_s"]

MOST_BYTES = 1 << 26
"""No index of a recording is larger."""
CUT = 0.002
"""Share of the pictures' time; less is rounding, or the delay of a coder."""


def shown_s(path: Path) -> float | None:
    """How long the pictures are shown, s; None where all are, or it is no MP4."""
    stat = path.stat()
    return _shown_s(path, stat.st_size, stat.st_mtime_ns)


@functools.lru_cache(maxsize=8)  # a file is probed by all who want to know its size
def _shown_s(path: Path, size: int, _: int) -> float | None:
    movie = _movie(path, size)
    try:
        per_s, _ = _times(next(_boxes(movie, b"mvhd")))
        for track in _boxes(movie, b"trak"):
            media = next(_boxes(track, b"mdia"), b"")
            edits = next(_boxes(next(_boxes(track, b"edts"), b""), b"elst"), None)
            if next(_boxes(media, b"hdlr"), b"")[8:12] == b"vide" and edits is not None and per_s:
                media_per_s, whole = _times(next(_boxes(media, b"mdhd")))
                if not media_per_s:
                    return None
                # What an edit asks for beyond the pictures is not there.
                parts = [
                    (length / per_s, (whole - begins) / media_per_s) for length, begins in _edits(edits) if begins >= 0
                ]
                shown = sum(max(0.0, min(part)) for part in parts)
                return shown if 0 < shown < (1.0 - CUT) * whole / media_per_s else None
    except (StopIteration, struct.error):
        pass
    return None


def _movie(path: Path, size: int) -> bytes:
    """The box that describes what is in the file; empty where there is none."""
    at = 0
    with path.open("rb") as file:
        while at + 8 <= size:
            file.seek(at)
            length, name = struct.unpack(">I4s", file.read(8))
            head = 8
            if length == 1:
                length, head = int.from_bytes(file.read(8), "big"), 16
            if name == b"moov":
                return file.read(min(length - head, MOST_BYTES)) if length > head else b""
            if length < head or not name.isalnum():
                break
            at += length
    return b""


def _boxes(within: bytes, name: bytes) -> Iterator[bytes]:
    """What the boxes of that name hold."""
    at = 0
    while at + 8 <= len(within):
        length, found = struct.unpack_from(">I4s", within, at)
        if length < 8:
            return
        if found == name:
            yield within[at + 8 : at + length]
        at += length


def _times(header: bytes) -> tuple[int, int]:
    """Units a second, and a length in them."""
    return struct.unpack_from(*((">20xIQ", header) if header[:1] == b"\1" else (">12xII", header)))


def _edits(listed: bytes) -> Iterator[tuple[int, int]]:
    """How long each part is shown, and where in the pictures it begins; -1: nothing is shown for so long."""
    (count,) = struct.unpack_from(">4xI", listed)
    entry = struct.Struct(">Qq4x" if listed[:1] == b"\1" else ">Ii4x")
    for k in range(min(count, (len(listed) - 8) // entry.size)):
        yield entry.unpack_from(listed, 8 + k * entry.size)
