"""Videos: the container's own times, and files that are no videos."""

from __future__ import annotations

import base64
import os
import shutil
import struct
import subprocess
import zlib
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest

import pytracker as pt
from pytracker.formats import video, video_write
from pytracker.formats import video_oddities as video_oddities_module
from pytracker.formats.container import AviFrames, frames_of_avi, missing_bytes
from pytracker.formats.transport import span_of_transport
from pytracker.formats.video import frames
from pytracker.formats.video_oddities import compression, video_oddities
from pytracker.formats.video_times import frame_times


def write_video(path: Path, count: int = 30, rate: float = 25.0, fourcc: str = "mp4v") -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*fourcc), rate, (64, 48))
    for k in range(count):
        writer.write(np.full((48, 64, 3), 8 * k % 256, dtype=np.uint8))
    writer.release()
    return path


def test_a_webm_is_written_and_nothing_else_is_kept_from_standard_error(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """OpenCV warns of its tag, which a WebM does without; what is said by others meanwhile stays."""
    with video_write.VideoWriter(tmp_path / "a.webm", "VP80", 25.0, (64, 48)) as writer:
        writer.write(np.zeros((48, 64, 3), np.uint8))
    assert len(list(video.frames(tmp_path / "a.webm"))) == 1
    with video_write._without("of a tag"):
        os.write(2, b"of a disk\nof a tag\n")
    assert capfd.readouterr().err == "of a disk\n"


def test_times_are_the_containers(tmp_path: Path) -> None:
    for name, fourcc, rate in (("a.mp4", "mp4v", 25.0), ("b.avi", "MJPG", 29.97)):
        found = list(video.frames(write_video(tmp_path / name, rate=rate, fourcc=fourcc)))
        assert [frame.index for frame in found] == list(range(30))
        assert np.allclose([frame.time_s for frame in found], np.arange(30) / rate, atol=1e-3)
        assert found[0].image.shape == (48, 64, 3)


def test_variable_frame_rate(tmp_path: Path) -> None:
    """The true presentation times, where index / fps would be wrong by seconds."""
    av = pytest.importorskip("av", reason="writes a video of variable rate with PyAV")
    pts = np.cumsum([0, *[20, 40, 40, 120, 33, 400, 40] * 5])
    path = tmp_path / "variable.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, 1000)
        for k, time_ms in enumerate(pts):
            image = np.full((48, 64, 3), 5 * k % 256, dtype=np.uint8)
            frame = av.VideoFrame.from_ndarray(image, format="bgr24")
            frame.pts, frame.time_base = int(time_ms), Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    found = [frame.time_s for frame in video.frames(path)]
    assert np.allclose(found, pts / 1000.0, atol=2e-3)


def message(path: Path) -> str:
    with pytest.raises(pt.InputError) as error:
        list(video.frames(path))
    return str(error.value)


def test_what_is_no_video_is_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert "none.mp4: no such file, expected a video" in message(tmp_path / "none.mp4")
    (tmp_path / "empty.mp4").touch()
    assert "empty.mp4: the file is empty (0 bytes), expected a video" in message(tmp_path / "empty.mp4")
    (tmp_path / "text.mp4").write_text("not a video at all")
    assert "text.mp4: cannot be opened as a video (18 bytes)" in message(tmp_path / "text.mp4")
    whole = write_video(tmp_path / "whole.mp4").read_bytes()
    (tmp_path / "cut.mp4").write_bytes(whole[: len(whole) // 2])
    assert "cut.mp4: cannot be opened as a video" in message(tmp_path / "cut.mp4")
    capfd.readouterr()


def test_unknown_codec_is_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = write_video(tmp_path / "codec.avi", fourcc="MJPG")
    path.write_bytes(path.read_bytes().replace(b"MJPG", b"ZZZZ"))
    text = message(path)
    assert "codec.avi" in text
    assert "cannot be opened as a video" in text or "no frame that can be decoded" in text
    capfd.readouterr()


def test_truncated_video_is_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """An AVI keeps its header when its end is missing: frames come, then no more."""
    path = write_video(tmp_path / "long.avi", count=60, fourcc="MJPG")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    text = message(path)
    assert "long.avi: decoding stopped after frame" in text
    assert "expected 60 frames (2.400 s): the file is cut short or damaged" in text
    capfd.readouterr()


def test_no_frames_is_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = write_video(tmp_path / "none.avi", count=0, fourcc="MJPG")
    assert path.name in message(path)
    capfd.readouterr()


@pytest.mark.parametrize(("count", "is_refused"), [(5, False), (40, True)])
def test_one_picture_throughout_is_refused(tmp_path: Path, count: int, is_refused: bool) -> None:
    """As OpenCV gives of interlaced videos what happened to lie in memory, and says that it was read."""
    path = tmp_path / "still.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (64, 48))
    for _ in range(count):
        writer.write(np.full((48, 64, 3), 90, dtype=np.uint8))
    writer.release()
    if not is_refused:
        assert video.probe(path).frame_count == count
        return
    with pytest.raises(pt.InputError, match=r"same picture, byte for byte.*interlaced.*-vf yadif"):
        video.probe(path)


def test_an_interlaced_video_is_decoded_or_refused(tmp_path: Path) -> None:
    ffmpeg = shutil.which("ffmpeg")
    if ffmpeg is None:
        pytest.skip("ffmpeg, which writes interlaced videos, is not there")
    path = tmp_path / "a.mpg"
    pictures = write_video(tmp_path / "a.avi", 40, fourcc="MJPG")
    codec = ["-vf", "setfield=tff,format=yuv420p", "-c:v", "mpeg2video", "-q:v", "3", "-flags", "+ilme+ildct"]
    subprocess.run([ffmpeg, "-v", "error", "-i", pictures, *codec, path], check=True)  # noqa: S603
    grey = [float(frame.image.mean()) for frame in video.frames(path)]
    if np.allclose(grey[:30], 8 * np.arange(30), atol=6):
        return
    with pytest.raises(pt.InputError, match="interlaced"):
        video.probe(path)


@pytest.mark.parametrize(
    ("size", "codec", "kbit_s", "is_told"),
    [
        ((270, 480), "mjpg", 90, True),
        ((270, 480), "mjpg", 250, False),
        ((1080, 1920), "fmp4", 90, True),
        ((1080, 1920), "fmp4", 250, False),
        ((270, 480), "h264", 90, False),
        ((1080, 1920), "hevc", 70, True),
    ],
)
def test_a_video_that_was_compressed_too_much_is_told(
    size: tuple[int, int], codec: str, kbit_s: float, is_told: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hands were 12 to 24 cm off in valid frames, untold; with the same bits a larger picture is no worse."""
    path = tmp_path / "a.mp4"
    path.write_bytes(bytes(int(1000 * kbit_s / 8)))
    monkeypatch.setattr(video_oddities_module, "counted", lambda _: video.VideoInfo(*size, 60, 60.0, codec))
    said = compression(path)
    assert len(said) == is_told
    least = 78 if codec == "hevc" else 233
    assert all(f"{kbit_s} kbit/s, expected at least {least}" in words for words in said)


def test_streaming_needs_no_memory(tmp_path: Path) -> None:
    frames = video.frames(write_video(tmp_path / "a.mp4"))
    assert next(frames).index == 0
    frames.close()  # type: ignore[attr-defined]


@pytest.mark.parametrize(("name", "fourcc"), [("a.avi", "MJPG"), ("a.mkv", "mp4v")])
@pytest.mark.parametrize("share", [0.02, 0.05, 0.09])
def test_a_little_is_missing_at_the_end(tmp_path: Path, name: str, fourcc: str, share: float) -> None:
    """Less than a tenth: the container's own sizes tell."""
    path = write_video(tmp_path / name, count=100, fourcc=fourcc)
    whole = path.read_bytes()
    assert missing_bytes(path) == 0
    path.write_bytes(whole[: int(len(whole) * (1 - share))])
    with pytest.raises(pt.InputError, match=r"bytes are missing at its end .* expected a whole file: it is cut short"):
        video.probe(path)
    assert "the file is cut short or damaged" in message(path)


def test_a_piece_of_a_longer_matroska_is_whole(tmp_path: Path) -> None:
    """Its duration counts from 0, and its frames begin later: it was refused as cut short."""
    av = pytest.importorskip("av")
    path = tmp_path / "piece.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for k in range(50):
            frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 4 * k, np.uint8), format="bgr24")
            frame.pts = 150 + k
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    assert video.probe(path).frame_count == pytest.approx(50, abs=1)
    assert len(list(video.frames(path))) == 50
    (words,) = video_oddities(path, 0.0)
    assert "its first frame is at 6.000 s of its container's clock" in words
    assert video_oddities(path, 6.0) == []


@pytest.mark.parametrize("before", [0, 4])
def test_a_hole_in_a_transport_stream_is_told(before: int, tmp_path: Path) -> None:
    """200 packets lost within: the wrist was 6.7 cm off, up to 21.6, valid in 90 % of the frames."""
    path = write_video(tmp_path / "a.ts", count=100, fourcc="mp4v")
    whole = path.read_bytes()
    packets = [bytes(before) + whole[k : k + 188] for k in range(0, len(whole), 188)]
    path.write_bytes(b"".join(packets))
    assert video_oddities(path, 0.0) == []
    middle = len(packets) // 2
    path.write_bytes(b"".join(packets[:middle] + packets[middle + 5 :]))
    assert "packets are missing, or pieces were joined, at one place within" in video_oddities(path, 0.0)[0]
    path.write_bytes(b"".join(packets)[:-50])
    assert "it ends within a packet" in video_oddities(path, 0.0)[0]


@pytest.mark.parametrize("first", [50, (1 << 33) * 25 // 90_000 - 30])
def test_a_transport_streams_clock_begins_again_after_a_day(first: int, tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    with av.open(str(tmp_path / "a.ts"), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for k in range(50):
            frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 4 * k, np.uint8), format="bgr24")
            frame.pts = first + k
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    span = span_of_transport(tmp_path / "a.ts")
    assert span is not None
    assert span[1] - span[0] == pytest.approx(49 / 25)


@pytest.mark.parametrize("name", ["a.mkv", "a.ts"])
@pytest.mark.parametrize(("begins", "ends"), [(0.0, 3.0), (-1.0, 2.0), (0.0, 2.0)])
def test_sound_is_no_part_of_a_videos_length(name: str, begins: float, ends: float, tmp_path: Path) -> None:
    """A whole file was refused as cut short where its sound is longer than its pictures."""
    av = pytest.importorskip("av")
    path = tmp_path / name
    with av.open(str(path), "w") as container:
        pictures = container.add_stream("mpeg4", rate=25)
        pictures.width, pictures.height, pictures.pix_fmt = 64, 48, "yuv420p"
        sound = container.add_stream("mp2", rate=32000)
        sound.layout = "mono"
        packets = []
        for k in range(50):
            frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 4 * k, np.uint8), format="bgr24")
            frame.pts = 50 + k
            packets += pictures.encode(frame)
        for at in range(round(32000 * (2.0 + begins)), round(32000 * (2.0 + ends)), 1152):
            frame = av.AudioFrame.from_ndarray(np.zeros((1, 1152), np.int16), format="s16", layout="mono")
            frame.pts, frame.sample_rate = at, 32000
            packets += sound.encode(frame)
        packets += [*pictures.encode(), *sound.encode()]
        for packet in sorted(packets, key=lambda packet: packet.dts * packet.time_base):
            container.mux(packet)
    assert video.probe(path).frame_count == 50
    assert len(list(video.frames(path))) == 50


def test_an_avi_that_is_damaged_inside_is_named(tmp_path: Path) -> None:
    """A tenth of its frames was passed over, and those after came too early: 11.8 cm for 1.3, all valid."""
    path = write_video(tmp_path / "a.avi", count=100, fourcc="MJPG")
    whole = path.read_bytes()
    assert frames_of_avi(path) == AviFrames(100, 0, None)
    middle = len(whole) // 2
    first = whole.index(b"00dc", middle)
    path.write_bytes(whole[:middle] + bytes(len(whole) // 20) + whole[middle + len(whole) // 20 :])
    with pytest.raises(pt.InputError, match=rf"a.avi: is damaged at byte {first} of {len(whole)}: no frame is found"):
        video.probe(path)


def test_an_avi_without_padding_bytes_is_whole(tmp_path: Path) -> None:
    frames = [b"00dc" + struct.pack("<I", 3) + b"abc", b"00dc" + struct.pack("<I", 2) + b"de"]
    movi = b"LIST" + struct.pack("<I4s", 4 + sum(map(len, frames)), b"movi") + b"".join(frames)
    (tmp_path / "a.avi").write_bytes(b"RIFF" + struct.pack("<I4s", 4 + len(movi), b"AVI ") + movi)
    assert frames_of_avi(tmp_path / "a.avi") == AviFrames(2, 0, None)


def test_a_video_of_a_phone_held_upright_is_upright(tmp_path: Path) -> None:
    """Its pictures lie on their side, and its header says so; OpenCV 4.11 did not heed that by itself."""
    path = tmp_path / "phone.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 30.0, (64, 32))
    for _ in range(5):
        lying = np.zeros((32, 64, 3), np.uint8)
        lying[:, :20] = 255  # turned clockwise, that is its top
        writer.write(lying)
    writer.release()
    data = bytearray(path.read_bytes())
    matrix = data.find(b"tkhd") + 4 + 4 + 20 + 16
    one = 1 << 16
    data[matrix : matrix + 36] = struct.pack(">9i", 0, one, 0, -one, 0, 0, 32 * one, 0, 1 << 30)
    path.write_bytes(data)
    info = video.probe(path)
    assert (info.width, info.height) == (32, 64)
    image = next(video.frames(path)).image
    assert image.shape == (64, 32, 3)
    assert image[:16].mean() > 200
    assert image[30:].mean() < 50


@pytest.mark.parametrize("name", ["img", "img/%04d.png"])
def test_a_folder_of_pictures_says_how_it_becomes_a_video(tmp_path: Path, name: str) -> None:
    """There was no such file, though there was."""
    (tmp_path / "img").mkdir()
    for k in range(3):
        cv2.imwrite(str(tmp_path / "img" / f"{k:04d}.png"), np.zeros((8, 8, 3), dtype=np.uint8))
    with pytest.raises(pt.InputError, match=r"img holds 3 pictures, expected a video, such as ffmpeg makes of them"):
        video.probe(tmp_path / name)


AVI_WITH_B_FRAMES = """
eNoL8nRzc5BgYHAM81Tw8QwOsRBiYMhIKcpJLMvMsGBgYFjQxsiwIpEBDAQ4GRg4IEwGRogIEDKAMToAmfUAKFFcUpQDxGCzyjJTit18A0yQ1Y
HM4YKyQWYbAvF/IIDJg2wA6k/TALI1oHYJgPVJMIDNYsa02yvUz1sCqIgFyjcwSElmGAWjYBSMglEwCkbBKBgFo2AUjIJRMApGwYgCZQVFBS5I
fND4A2JcgRGJjRDHNc4BGmtgASrMT8nNAaKMHyM4XEFh8YN5NH2NglEwEgFozDcHWBbm5pdlgsZcDcGijBs+AomtK4UhBSqjAseVXg6GUIYWJh
EJeyB/M4MAO5DaJnDgMcvs/PsMpOsUPvCY++z+erBOCYjObRMPnLRL+CH/vvlB/T7+xn8/7Nh/v0eWnwSWF+BvfuBgx9/I8MOOhfk96TaLHXjM
64tm8xQCNk+lis3iBx6zSQNDKzOlwrCBATLGDaqfQGPehkh8OyQ+yPwKIJZA4s9A4oPU70BT/wlNvRAjqnojRoh6AFJMnIA=
"""
"""Eight frames of 16 x 16 px at 10 a second, grey levels 20, 45, ..., MPEG-4 with two B-frames; zlib, base 64."""


def test_an_avi_with_b_frames_has_times_to_its_end(tmp_path: Path) -> None:
    """Its last frames have none of their own: it was refused."""
    path = tmp_path / "b.avi"
    path.write_bytes(zlib.decompress(base64.b64decode(AVI_WITH_B_FRAMES)))
    found = list(frames(path))
    assert [frame.time_s for frame in found] == pytest.approx([k / 10 for k in range(8)])
    grey = [float(frame.image.mean()) for frame in found]
    assert np.diff(grey).min() > 15.0
    assert np.allclose(frame_times(path), [frame.time_s for frame in found])
