"""What an MPEG transport stream (TS, MTS) says of itself: its packets are of one size, and counted (ISO 13818-1)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["lacking_bytes", "lost_packets"]

SYNC = 0x47
PACKETS = {188: 0, 192: 4, 204: 0}
"""Sizes of packets, and at which of their bytes `SYNC` stands; Blu-ray's have four bytes before each."""
EMPTY = 0x1FFF
"""The identity of packets that fill up."""
COUNTS = 16


def lacking_bytes(path: Path) -> int:
    """How much of its last packet is missing; 0 where none is, or it is no such stream."""
    length = _packet(path)
    return -path.stat().st_size % length if length else 0


def lost_packets(path: Path) -> int:
    """At how many places packets of its largest stream, the video, were lost, by their counters (2.4.3.3)."""
    length = _packet(path)
    if not length:
        return 0
    count = path.stat().st_size // length
    packets = np.memmap(path, np.uint8, "r", shape=(count * length,)).reshape(count, length)
    head = packets[:, PACKETS[length] : PACKETS[length] + 6].astype(np.int64)
    identity, has_payload = ((head[:, 1] & 0x1F) << 8) | head[:, 2], (head[:, 3] & 0x10) > 0
    # A stream that begins anew says so in its adaptation field.
    begins = ((head[:, 3] & 0x20) > 0) & (head[:, 4] > 0) & ((head[:, 5] & 0x80) > 0)
    streams, sizes = np.unique(identity[has_payload & (identity != EMPTY)], return_counts=True)
    if not len(streams):
        return 0
    video = (identity == streams[np.argmax(sizes)]) & has_payload
    return _breaks(head[video, 3] & 0x0F, begins[video])


def _breaks(counter: NDArray[np.int64], begins: NDArray[np.bool_]) -> int:
    """Where a counter neither goes on by one nor is that of a packet that came twice."""
    steps = np.diff(counter) % COUNTS
    return int(np.count_nonzero((steps > 1) & ~begins[1:]))


def _packet(path: Path) -> int:
    """The size of its packets; 0 where it is no transport stream."""
    with path.open("rb") as file:
        start = file.read(4 * max(PACKETS))
    for length, sync in PACKETS.items():
        if len(start) >= 4 * length and all(start[sync + k * length] == SYNC for k in range(4)):
            return length
    return 0
