"""What a video's container says of the file: one that was cut short, or damaged inside, is told from its own sizes.

| container | what says it | source |
|---|---|---|
| MP4, MOV | every top-level box begins with its size | ISO/IEC 14496-12, 4.2 |
| AVI | every RIFF chunk does | Microsoft, AVI RIFF File Reference |
| MKV, WebM | so does the segment (`matroska`) | RFC 8794, 6.2; RFC 9559 |
| TS, MTS | only when its pictures are (`transport`) | ISO/IEC 13818-1, 2.4.3 |
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from pytracker.formats.matroska import end_of_segment, is_matroska, span_of_matroska
from pytracker.formats.transport import span_of_transport

__all__ = ["AviFrames", "frames_of_avi", "is_fragmented", "missing_bytes", "span_s"]

LISTS = (b"movi", b"rec ")
"""An AVI's lists that hold frames."""
FRAMES = (b"dc", b"db")
"""What the names of a video's chunks end with, after the number of the stream."""
UNKNOWN = (0, 0xFFFFFFFF)
"""A length that was not known as it was written, as into a pipe."""
BOXES = (b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"moof", b"styp", b"sidx", b"uuid", b"meta", b"udta")


def missing_bytes(path: Path) -> int:
    """How many bytes the container says there are beyond the file's end; 0 where it says none, or nothing."""
    size = path.stat().st_size
    with path.open("rb") as file:
        start = file.read(12)
        file.seek(0)
        if start[4:8] in BOXES:
            return max(0, _end_of_boxes(file, size) - size)
        if start[:4] == b"RIFF":
            return max(0, _end_of_chunks(file, size) - size)
        if is_matroska(path):
            return max(0, end_of_segment(path) - size)
    return 0


def span_s(path: Path) -> tuple[float, float] | None:
    """When the first picture is and when the last, s; None where the container's own length is that of the pictures."""
    return span_of_matroska(path) or span_of_transport(path)


def is_fragmented(path: Path) -> bool:
    """Whether it is an MP4 in fragments, whose header may count the pictures of the first alone (8.8)."""
    with path.open("rb") as file:
        return any(name == b"moof" for name, _ in _boxes(file, path.stat().st_size))


@dataclass(frozen=True)
class AviFrames:
    """What the chunks of an AVI hold.

    An AVI's frames have no times but their order: where some cannot be found all after them come too early.

    Attributes:
        count: how many frames stand in it, the empty ones too.
        empty: those that hold no picture: the camera, or who cut the file, left them out.
        broken_at: the byte where the chain of chunks breaks; None where it does not.
    """

    count: int
    empty: int
    broken_at: int | None


def frames_of_avi(path: Path) -> AviFrames | None:
    """Counted chunk by chunk; None where it is no AVI."""
    stat = path.stat()
    return _frames_of_avi(path, stat.st_size, stat.st_mtime_ns)


@functools.lru_cache(maxsize=8)  # a file is probed by all who want to know its size
def _frames_of_avi(path: Path, size: int, _: int) -> AviFrames | None:
    count, empty, stream = 0, 0, b""
    with path.open("rb") as file:
        at = 0
        while at + 12 <= size:
            file.seek(at)
            name, length, form = struct.unpack("<4sI4s", file.read(12))
            if name != b"RIFF" or form not in (b"AVI ", b"AVIX"):
                break
            is_whole = length not in UNKNOWN and at + 8 + length <= size
            end = at + 8 + length if is_whole else size
            for name, length, begins in _chunks(file, at + 12, end):
                if not _is_name(name) or (is_whole and begins + 8 + length > end + 1):
                    return AviFrames(count, empty, begins)
                if name[2:] in FRAMES:
                    stream = stream or name
                    count, empty = count + (name == stream), empty + (name == stream and length == 0)
            at = end + end % 2
    return AviFrames(count, empty, None) if at else None


def _chunks(file: BinaryIO, at: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Name, length and place of the chunks from `at` to `end`, of those in lists too; the last may have no name."""
    while at + 8 <= end:
        file.seek(at)
        name, length, form = struct.unpack("<4sI4s", file.read(12).ljust(12, b"\0"))
        if not _is_name(name):
            padded = _after_zeros(file, at, end)
            if padded == at:
                yield name, length, at
                return
            at = padded
            continue
        if name == b"LIST" and form in LISTS:
            at += 12
            continue
        yield name, length, at
        # Some write no padding byte after an odd length.
        after = at + 8 + length
        file.seek(after)
        bare = file.read(4)
        at = after if length % 2 and _is_name(bare) and after + 8 <= end else after + length % 2


def _after_zeros(file: BinaryIO, at: int, end: int) -> int:
    """Where zeros end that a chunk follows, or nothing: some fill files up with them. The same place where none do."""
    begin = at
    file.seek(at)
    while at < end and (block := file.read(min(1 << 20, end - at))):
        left = block.lstrip(b"\0")
        at += len(block) - len(left)
        if left:
            # A name begins at an even place.
            at -= at % 2
            file.seek(at)
            return at if at > begin and _is_name(file.read(4)) else begin
    return end


def _is_name(name: bytes) -> bool:
    """Whether it may name a chunk: four characters that can be printed."""
    return len(name) == 4 and all(0x20 <= byte < 0x7F for byte in name)


def _end_of_boxes(file: BinaryIO, size: int) -> int:
    return max((end for _, end in _boxes(file, size)), default=0)


def _boxes(file: BinaryIO, size: int) -> Iterator[tuple[bytes, int]]:
    """The names of the boxes of a file, and where each ends, which may be beyond the file's end."""
    at = 0
    while at + 8 <= size:
        file.seek(at)
        length, name = struct.unpack(">I4s", file.read(8))
        if length == 1:
            large = file.read(8)
            length = struct.unpack(">Q", large)[0] if len(large) == 8 else size + 1 - at
        if length == 0 or length < 8 or name not in BOXES:  # to the end; or something that is no box
            yield name, size
            return
        at += length
        yield name, at


def _end_of_chunks(file: BinaryIO, size: int) -> int:
    at = 0
    while at + 8 <= size:
        file.seek(at)
        name, length = struct.unpack("<4sI", file.read(8))
        if name != b"RIFF" or length in UNKNOWN:
            return size
        at += 8 + length + length % 2
    # The last padding byte is often left out.
    return at - 1 if at == size + 1 else at
