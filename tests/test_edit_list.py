"""MP4 videos whose header does not count what is shown: trimmed without coding them anew, or in fragments."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_video import write_video

from pytracker.formats.container import is_fragmented
from pytracker.formats.edit_list import shown_s
from pytracker.formats.video import VideoInfo, frames, probe
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


def test_frames_of_a_video_in_fragments_are_counted_by_decoding_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its header may count those before the first alone: keypoints of the others were called another clip's."""
    path = write_video(tmp_path / "whole.mp4", 20, 30.0)
    assert not is_fragmented(path)
    path.write_bytes(path.read_bytes() + struct.pack(">I4s", 8, b"moof"))
    assert is_fragmented(path)
    monkeypatch.setattr("pytracker.formats.video_times.probe", lambda _: VideoInfo(64, 48, 6, 30.0))
    assert counted(path).frame_count == 20


@settings(max_examples=200)
@given(st.binary(max_size=60), st.sampled_from([b"mvhd", b"trak", b"edts", b"elst", b"mdia", b"hdlr"]))
def test_what_is_no_edit_list_tells_nothing(tmp_path_factory: pytest.TempPathFactory, junk: bytes, name: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "junk.mp4"
    inner = struct.pack(">I4s", len(junk) + 8, name) + junk
    path.write_bytes(struct.pack(">I4s", len(inner) + 8, b"moov") + inner)
    assert shown_s(path) is None
