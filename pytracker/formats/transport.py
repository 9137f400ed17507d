"""What an MPEG transport stream (TS, MTS) says of itself: its packets are of one size, and counted (ISO 13818-1)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["lacking_bytes", "lost_packets", "span_of_transport"]

SYNC = 0x47
PACKETS = {188: 0, 192: 4, 204: 0}
"""Sizes of packets, and at which of their bytes `SYNC` stands; Blu-ray's have four bytes before each."""
COUNTS = 16
FEW = 50
"""Pictures are not stored in the order in which they are shown: first and last are among so many."""
EDGE = 50_000
"""And these, among so many packets at either end."""
CLOCK_HZ, TICKS = 90_000, 1 << 33


def lacking_bytes(path: Path) -> int:
    """How much of its last packet is missing; 0 where none is, or it is no such stream."""
    length = _packet(path)
    return -path.stat().st_size % length if length else 0


def lost_packets(path: Path) -> int:
    """At how many places the counters of its pictures' stream do not go on (2.4.3.3)."""
    packets = _packets(path)
    of = _of_pictures(packets)
    head = np.asarray(packets[of, :6], dtype=np.int64)
    if not len(head):
        return 0
    # A stream that begins anew says so in its adaptation field.
    begins = ((head[:, 3] & 0x20) > 0) & (head[:, 4] > 0) & ((head[:, 5] & 0x80) > 0)
    return _breaks(head[:, 3] & 0x0F, begins)


def span_of_transport(path: Path) -> tuple[float, float] | None:
    """When its first picture is and when its last, s; None where that cannot be told, as of one that is none (2.4.3.6).

    Its duration is of all its streams: sound begins before, or goes on.
    """
    packets = _packets(path)
    ticks = [*_times_in(packets[:EDGE], slice(FEW)), *_times_in(packets[-EDGE:], slice(-FEW, None))]
    if not ticks:
        return None
    # The clock begins again after a day.
    since = [(tick - ticks[0] + TICKS // 2) % TICKS - TICKS // 2 for tick in ticks]
    first_s = (ticks[0] + min(since)) / CLOCK_HZ
    return first_s, first_s + (max(since) - min(since)) / CLOCK_HZ


def _times_in(packets: NDArray[np.uint8], some: slice) -> list[int]:
    """When some of the pictures that begin in packets are shown, ticks."""
    of = _of_pictures(packets)
    starts = of[(packets[of, 1] & 0x40) > 0][some]
    return [time for k in starts if (time := _time_of(bytes(packets[k]))) is not None]


def _time_of(packet: bytes) -> int | None:
    """When a picture that begins in a packet is shown, ticks; None where it does not say."""
    pes = _payload(packet)
    if len(pes) < 14 or not pes[7] & 0x80:
        return None
    a, b, c, d, e = pes[9:14]
    return (a >> 1 & 7) << 30 | b << 22 | (c >> 1) << 15 | d << 7 | e >> 1


def _payload(packet: bytes) -> bytes:
    return packet[4 + (1 + packet[4] if packet[3] & 0x20 else 0) :]


def _packets(path: Path) -> NDArray[np.uint8]:
    """All packets `(N, L)`; none of what is no transport stream."""
    length = _packet(path)
    if not length:
        return np.empty((0, min(PACKETS)), dtype=np.uint8)
    count = path.stat().st_size // length
    return np.memmap(path, np.uint8, "r", shape=(count * length,)).reshape(count, length)[:, PACKETS[length] :]


def _of_pictures(packets: NDArray[np.uint8]) -> NDArray[np.intp]:
    """Which are of the largest stream of pictures, with a payload."""
    identity = (packets[:, 1].astype(np.uint16) & 0x1F) << 8 | packets[:, 2]
    has_payload = (packets[:, 3] & 0x10) > 0
    streams, sizes = np.unique(identity[has_payload], return_counts=True)
    for stream in streams[np.argsort(-sizes)]:
        of = np.flatnonzero((identity == stream) & has_payload)
        begins = of[(packets[of, 1] & 0x40) > 0]
        if len(begins) and _is_picture(_payload(bytes(packets[begins[0]]))):
            return of
    return np.empty(0, dtype=np.intp)


def _is_picture(payload: bytes) -> bool:
    """Whether what begins is of a stream of pictures (table 2-22)."""
    return payload[:3] == b"\0\0\1" and 0xE0 <= int.from_bytes(payload[3:4], "big") <= 0xEF


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
