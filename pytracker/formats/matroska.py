"""What a Matroska or a WebM says of itself: where its segment ends, and of when its pictures are (RFC 8794, 9559)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

__all__ = ["begins_s", "end_of_segment", "is_matroska", "span_of_matroska"]

EBML, SEGMENT, INFO, TRACKS, CLUSTER = 0x1A45DFA3, 0x18538067, 0x1549A966, 0x1654AE6B, 0x1F43B675
TIMESTAMP_SCALE, TIMESTAMP = 0x2AD7B1, 0xE7
TRACK, TRACK_NUMBER, TRACK_TYPE = 0xAE, 0xD7, 0x83
BLOCK_GROUP, BLOCK, SIMPLE_BLOCK = 0xA0, 0xA1, 0xA3
"""Identities of elements, with the mark of their own length."""
VIDEO = 1
USUAL_SCALE_NS = 1_000_000


def is_matroska(path: Path) -> bool:
    """Whether it is a Matroska or a WebM."""
    with path.open("rb") as file:
        return file.read(4) == EBML.to_bytes(4, "big")


def end_of_segment(path: Path) -> int:
    """The byte after its segment; 0 where it does not say, as one that was written into a pipe."""
    with path.open("rb") as file:
        for name, begins, length in _elements(file, 0, path.stat().st_size):
            if name == SEGMENT:
                return 0 if length is None else begins + length
    return 0


def begins_s(path: Path) -> float:
    """The time of its first cluster, s: pieces of one long recording go on from each other. 0 where it says none."""
    size, scale_ns = path.stat().st_size, USUAL_SCALE_NS
    with path.open("rb") as file:
        segment = next((begins for name, begins, _ in _elements(file, 0, size) if name == SEGMENT), size)
        for name, begins, length in _elements(file, segment, size):
            inside = size if length is None else begins + length
            if name == INFO:
                scale_ns = _number(file, TIMESTAMP_SCALE, begins, inside) or USUAL_SCALE_NS
            elif name == CLUSTER:
                return 1e-9 * scale_ns * _number(file, TIMESTAMP, begins, inside)
    return 0.0


def span_of_matroska(path: Path) -> tuple[float, float] | None:
    """When its first picture is and when its last, s; None where that cannot be told, as of one that is none.

    Its duration is of all its tracks, from 0 on: sound goes on, or begins before.
    """
    size, scale_ns, clusters, video = path.stat().st_size, USUAL_SCALE_NS, list[tuple[int, int]](), 0
    with path.open("rb") as file:
        segment = next((begins for name, begins, _ in _elements(file, 0, size) if name == SEGMENT), size)
        for name, begins, length in _elements(file, segment, size):
            if length is None:
                return None  # a live one: how long its clusters are nobody says
            end = begins + length
            if name == INFO:
                scale_ns = _number(file, TIMESTAMP_SCALE, begins, end) or USUAL_SCALE_NS
            elif name == TRACKS:
                video = _video_track(file, begins, end)
            elif name == CLUSTER:
                clusters.append((begins, min(end, size)))
        first = next((times[0] for at in clusters if (times := _pictures(file, *at, video))), None)
        last = next((times[-1] for at in reversed(clusters) if (times := _pictures(file, *at, video))), None)
    return None if first is None or last is None else (1e-9 * scale_ns * first, 1e-9 * scale_ns * last)


def _video_track(file: BinaryIO, at: int, end: int) -> int:
    """The number of the first track of pictures; 0 where there is none."""
    for name, begins, length in _elements(file, at, end):
        if name == TRACK and length is not None and _number(file, TRACK_TYPE, begins, begins + length) == VIDEO:
            return _number(file, TRACK_NUMBER, begins, begins + length)
    return 0


def _pictures(file: BinaryIO, at: int, end: int, track: int) -> list[int]:
    """Times of a track's blocks in the cluster from `at` to `end`, sorted."""
    cluster, found = 0, []
    for name, begins, length in _elements(file, at, end):
        inside = begins + (length or 0)
        if name == TIMESTAMP:
            cluster = _unsigned(file, begins, inside)
        elif name in (SIMPLE_BLOCK, BLOCK_GROUP):
            grouped = (place for inner, place, _ in _elements(file, begins, inside) if inner == BLOCK)
            block = begins if name == SIMPLE_BLOCK else next(grouped, end)
            file.seek(block)
            head = file.read(12)
            number, width = _vint(head, 0)
            if width and number == track:
                found.append(cluster + int.from_bytes(head[width : width + 2], "big", signed=True))
    return sorted(found)


def _elements(file: BinaryIO, at: int, end: int) -> Iterator[tuple[int, int, int | None]]:
    """Identity, first byte and length of the elements from `at` to `end`; the last may be of unknown length."""
    while at < end:
        file.seek(at)
        head = file.read(12)
        width = 9 - head[0].bit_length() if head else 9
        length, more = _vint(head, width)
        if width > 4 or not more:
            return
        begins = at + width + more
        is_unknown = length == (1 << (7 * more)) - 1
        yield int.from_bytes(head[:width], "big"), begins, None if is_unknown else length
        if is_unknown:
            return
        at = begins + length


def _number(file: BinaryIO, wanted: int, at: int, end: int) -> int:
    """An unsigned number among the elements from `at` to `end`; 0 where it is not there."""
    for name, begins, length in _elements(file, at, end):
        if name == wanted and length is not None:
            return _unsigned(file, begins, begins + length)
    return 0


def _unsigned(file: BinaryIO, at: int, end: int) -> int:
    file.seek(at)
    return int.from_bytes(file.read(min(end - at, 8)), "big")


def _vint(data: bytes, at: int) -> tuple[int, int]:
    """A variable-size integer and its width in bytes; (0, 0) where there is none."""
    first = data[at] if at < len(data) else 0
    width = 9 - first.bit_length()
    if not first or at + width > len(data):
        return 0, 0
    return int.from_bytes(data[at : at + width], "big") & ((1 << (7 * width)) - 1), width
