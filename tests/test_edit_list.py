"""MP4 videos that were trimmed without coding them anew: pictures that are in the file and not shown."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_video import write_video

from pytracker.formats.edit_list import shown_s
from pytracker.formats.video import frames, probe
from pytracker.formats.video_times import counted


@pytest.mark.parametrize(("begins", "shown"), [(0, 60), (0, 30), (30, 30), (6, 48), (30, 300)])
def test_of_a_trimmed_video_what_is_shown_is_all_that_is_expected(begins: int, shown: int, tmp_path: Path) -> None:
    """As a phone trims it: it was called cut short or damaged, as half of its pictures were missing."""
    path = write_video(tmp_path / "trimmed.mp4", 60, 30.0)
    data = bytearray(path.read_bytes())
    edits, media = data.index(b"elst"), data.index(b"mdhd")
    per_s, whole = struct.unpack_from(">II", data, media + 16)
    assert whole == 2 * per_s
    struct.pack_into(">Ii", data, edits + 12, round(1000 * shown / 30), per_s * begins // 30)
    path.write_bytes(data)
    shown = min(shown, 60 - begins)
    assert shown_s(path) == (None if shown == 60 else pytest.approx(shown / 30, abs=1e-3))
    found = list(frames(path))
    assert len(found) == counted(path).frame_count == probe(path).frame_count == shown
    assert found[0].time_s == 0.0


@settings(max_examples=200)
@given(st.binary(max_size=60), st.sampled_from([b"mvhd", b"trak", b"edts", b"elst", b"mdia", b"hdlr"]))
def test_what_is_no_edit_list_tells_nothing(tmp_path_factory: pytest.TempPathFactory, junk: bytes, name: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "junk.mp4"
    inner = struct.pack(">I4s", len(junk) + 8, name) + junk
    path.write_bytes(struct.pack(">I4s", len(inner) + 8, b"moov") + inner)
    assert shown_s(path) is None
