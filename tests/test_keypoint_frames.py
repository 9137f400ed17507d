"""Of which frames of a video the rows of a table of keypoints are: by numbers, by pictures' names, by times."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from test_keypoint_tables import PLAIN, plain

import pytracker as pt
from pytracker._core import KEYPOINTS
from pytracker.formats.keypoints.read import read_keypoints
from pytracker.formats.video import VideoInfo
from pytracker.formats.video_times import counted, frame_times
from pytracker.recording.keypoints.load import in_pixels


@pytest.mark.parametrize("named", ["frame", "frame_idx", "Frame#"])
def test_a_column_that_counts_frames_is_read(named: str, tmp_path: Path) -> None:
    rows = ["5,100,50,120,90", "6,101,50,121,90", "9,102,50,122,90"]
    assert plain(tmp_path / "a.csv", rows, f"{named},{PLAIN}").frames.tolist() == [5, 6, 9]
    with pytest.raises(pt.InputError, match="the frame of its row 3 is 6, expected whole numbers that increase"):
        plain(tmp_path / "b.csv", [rows[0], rows[1], rows[1]], f"frame_id,{PLAIN}")


DEEPLABCUT = """scorer,n,n,n,n
bodyparts,left_wrist,left_wrist,right_wrist,right_wrist
coords,x,y,x,y
40,100,50,120,90
41,101,50,121,90
59,102,50,122,90
"""


def test_deeplabcuts_index_says_which_frames(tmp_path: Path) -> None:
    """Rows were counted: of keypoints of every fifth frame the wrists were 20 cm off, and valid."""
    folders = DEEPLABCUT.replace("scorer,", "scorer,,,").replace("parts,", "parts,,,").replace("coords,", "coords,,,")
    named = re.sub(r"^(\d+),", r"labeled-data,trial2,img00\1.png,", folders, flags=re.MULTILINE)
    path = re.sub(r"^(\d+),", r"labeled-data/trial2/img00\1.png,", DEEPLABCUT, flags=re.MULTILINE)
    for text in (DEEPLABCUT, path, named):
        (tmp_path / "a.csv").write_text(text, "utf-8")
        found = read_keypoints(tmp_path / "a.csv")
        assert found.frames.tolist() == [40, 41, 59]
        assert found.points[2, 0, KEYPOINTS.index("right_wrist"), :2].tolist() == [122, 90]
    (tmp_path / "a.csv").write_text(DEEPLABCUT.replace("41,101", ",101"), "utf-8")
    with pytest.raises(pt.InputError, match=r"a\.csv: the frame of its row 2 is not there"):
        read_keypoints(tmp_path / "a.csv")
    (tmp_path / "a.csv").write_text(re.sub(r"^\d+,", ",", DEEPLABCUT, flags=re.MULTILINE), "utf-8")
    assert read_keypoints(tmp_path / "a.csv").frames.tolist() == [0, 1, 2]


@pytest.mark.parametrize("name", ["img{:04d}.jpg", "cam2_{:05d}_1080p.png", "{:04d}_h264.webp", '"frame_{:03d}.png"'])
def test_names_of_pictures_say_which_frames(tmp_path: Path, name: str) -> None:
    rows = [f"{name.format(k)},100,50,120,90" for k in (5, 6, 9)]
    assert plain(tmp_path / "a.csv", rows, f"image_name,{PLAIN}").frames.tolist() == [5, 6, 9]


@pytest.mark.parametrize("named", ["", "index", "Unnamed: 0", "Frame #", "fnum", "video_frame", "frame_no."])
def test_frames_by_other_names_are_counted_too(tmp_path: Path, named: str) -> None:
    """pandas' own index was passed over, and rows counted: 14 cm for 4."""
    rows = [f'"{k}",100,50,120,90' for k in (5, 6, 9)]
    assert plain(tmp_path / "a.csv", rows, f"{named},{PLAIN}").frames.tolist() == [5, 6, 9]


def test_what_counts_and_is_not_known_is_named(tmp_path: Path) -> None:
    rows = [f"{k},100,50,120,90" for k in (5, 6, 9)]
    (said,) = plain(tmp_path / "a.csv", rows, f"tick,{PLAIN}").warnings
    assert "a.csv: tick says nothing that is known, expected frame or time_s: rows are counted" in said


def test_semicolons_and_times_of_day_are_read(tmp_path: Path) -> None:
    rows = [f"00:00:0{k},5;100,5;50;120;90" for k in range(3)]
    found = plain(tmp_path / "a.csv", rows, f"time;{PLAIN.replace(',', ';')}")
    assert found.time_s is not None
    assert found.time_s.tolist() == [0.5, 1.5, 2.5]
    assert np.nanmin(found.points[0, ..., 1]) == 50
    assert np.nanmin(found.points[0, ..., 0]) == 100.5


def test_what_is_the_same_in_all_rows_counts_nothing(tmp_path: Path) -> None:
    rows = [f"300,background.png,{k / 60},100,50,120,90" for k in range(3)]
    found = plain(tmp_path / "a.csv", rows, f"frame_count,image,time_s,{PLAIN}")
    assert found.time_s == pytest.approx(np.arange(3) / 60)
    rows = [f"{5001 + k},{k / 60},100,50,120,90" for k in range(3)]
    assert plain(tmp_path / "b.csv", rows, f"id,time_s,{PLAIN}").time_s is not None


def test_columns_of_other_things_may_be_words(tmp_path: Path) -> None:
    rows = [f"clip.mp4,{k},adult,100,50,120,90" for k in (5, 6, 9)]
    assert plain(tmp_path / "a.csv", rows, f"file,frame,who,{PLAIN}").frames.tolist() == [5, 6, 9]


@pytest.mark.parametrize(
    ("start", "step", "unit", "expected"),
    [
        (0, 1, "time", [0, 1, 2, 3]),  # ms at 59 a second of a video of 60
        (15, 1, "time", [15, 16, 17, 18]),
        (0, 2, "time_s", [0, 2, 4, 6]),
        (4, 2, "timestamp_us", [4, 6, 8, 10]),
    ],
)
def test_a_column_of_times_says_which_frames(
    tmp_path: Path, start: int, step: int, unit: str, expected: list[int]
) -> None:
    """Rows were counted from the first: of keypoints that began late, or of every second frame, all were off."""
    per_s = {"time": 1000 / 59, "time_s": 1 / 60, "timestamp_us": 1e6 / 60}[unit]
    rows = [f"{per_s * (start + step * k)},{100.5 + k},{90 + k}" for k in range(4)]
    (tmp_path / "k.csv").write_text("\n".join([f"{unit},left_wrist_x,left_wrist_y", *rows]) + "\n")
    found = read_keypoints(tmp_path / "k.csv")
    info = VideoInfo(320, 240, 20, 60.0)
    assert in_pixels(tmp_path / "k.csv", found, tmp_path / "v.mp4", info).frames.tolist() == expected


def test_times_may_be_rounded_and_their_rate_mistyped(tmp_path: Path) -> None:
    def frames(step_ms: float, count: int) -> list[int]:
        rows = [f"{round(step_ms * k)},{100.5 + k},90" for k in range(count)]
        (tmp_path / "k.csv").write_text("\n".join(["time,left_wrist_x,left_wrist_y", *rows]) + "\n")
        found = read_keypoints(tmp_path / "k.csv")
        info = VideoInfo(640, 480, 300, 60.0)
        return [int(frame) for frame in in_pixels(tmp_path / "k.csv", found, tmp_path / "v.mp4", info).frames]

    assert frames(1000 / 60, 200) == list(range(200))
    assert frames(1000 / 30, 140) == list(range(0, 280, 2))
    assert frames(1000 / 30, 300) == list(range(300))  # all of the frames, at a rate that somebody typed


def of_times(path: Path, times: list[float], frame_count: int) -> tuple[list[int], tuple[str, ...]]:
    """Which frames of a video of 60 Hz rows at these times are, and what is said of that."""
    rows = [f"{time!r},{100.5 + k},{90 + k}" for k, time in enumerate(times)]
    path.write_text("\n".join(["time,left_wrist_x,left_wrist_y", *rows]) + "\n")
    found = in_pixels(path, read_keypoints(path), path.with_name("v.mp4"), VideoInfo(320, 240, frame_count, 60.0))
    return found.frames.tolist(), found.warnings


def test_times_of_a_clock_are_counted_from_the_first(tmp_path: Path) -> None:
    """Rows were counted, without a word: where frames are missing all after were off."""
    frames, said = of_times(tmp_path / "k.csv", [1.7e9 + k / 60 for k in (0, 1, 2, 7, 8)], 20)
    assert frames == [0, 1, 2, 7, 8]
    assert "its times begin at 1700000000, as a clock's: its first row is taken to be the first frame's" in said[0]


def test_times_at_which_pictures_arrived_are_those_of_the_nearest_frames(tmp_path: Path) -> None:
    late = np.random.default_rng(0).uniform(-0.4, 0.4, 200)
    there = [k for k in range(250) if k % 5]
    times = [max(0.0, (k + float(late[n])) / 60) for n, k in enumerate(there)]
    assert of_times(tmp_path / "k.csv", times, 250) == (there, ())


def written_avi(path: Path, count: int, empty: set[int]) -> Path:
    """An AVI of 60 Hz of which some frames hold no picture, as cameras write that leave some out."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 60.0, (320, 240))
    for k in range(count):
        writer.write(np.full((240, 320, 3), k, dtype=np.uint8))
    writer.release()
    whole = path.read_bytes()
    at = whole.index(b"movi") + 4
    head, chunks = whole[: at - 12], b""
    for k in range(count):
        length = struct.unpack("<I", whole[at + 4 : at + 8])[0]
        after = at + 8 + length + length % 2
        chunks += whole[at : at + 4] + bytes(4) if k in empty else whole[at:after]
        at = after
    movi = b"LIST" + struct.pack("<I4s", 4 + len(chunks), b"movi") + chunks
    path.write_bytes(head[:4] + struct.pack("<I", len(head) - 8 + len(movi)) + head[8:] + movi)
    return path


@pytest.mark.parametrize("by", ["rows", "frame", "time_s"])
def test_of_frames_that_an_avi_left_out_there_are_no_keypoints(tmp_path: Path, by: str) -> None:
    """All after them were too late: wrists 17 cm off, all valid, without a word."""
    empty = {3, 4, 9}
    video = written_avi(tmp_path / "v.avi", 20, empty)
    info = counted(video)
    assert (info.frame_count, len(frame_times(video))) == (17, 17)
    named = {"rows": "", "frame": "frame,", "time_s": "time_s,"}[by]
    cells = {"rows": "", "frame": "{k},", "time_s": "{t:.6f},"}[by]
    rows = [cells.format(k=k, t=k / 60) + f"{100 + k},90" for k in range(20)]
    (tmp_path / "k.csv").write_text("\n".join([f"{named}left_wrist_x,left_wrist_y", *rows]), "utf-8")
    found = in_pixels(tmp_path / "k.csv", read_keypoints(tmp_path / "k.csv"), video, info)
    assert found.frames.tolist() == list(range(17))
    assert found.points[:, 0, KEYPOINTS.index("left_wrist"), 0].tolist() == [
        100 + k for k in range(20) if k not in empty
    ]


def test_frames_of_a_matroska_are_counted(tmp_path: Path) -> None:
    """Its own count is an estimate: good keypoints were "another clip's"."""
    writer = cv2.VideoWriter(str(tmp_path / "v.mkv"), cv2.VideoWriter.fourcc(*"MJPG"), 60.0, (320, 240))
    for k in range(12):
        writer.write(np.full((240, 320, 3), k, dtype=np.uint8))
    writer.release()
    assert counted(tmp_path / "v.mkv").frame_count == 12
    assert frame_times(tmp_path / "v.mkv") == pytest.approx(np.arange(12) / 60, abs=1e-3)


def test_times_with_a_typed_rate_say_which_frames_are_there(tmp_path: Path) -> None:
    there = [k for k in range(200) if k % 7]
    assert of_times(tmp_path / "k.csv", [k / 25 for k in there], 200) == (there, ())


@pytest.mark.parametrize("rate_hz", [50, 40, 25, 24])
def test_rows_of_a_rate_that_is_no_part_of_the_videos_are_of_the_nearest_frames(tmp_path: Path, rate_hz: int) -> None:
    """They were squeezed together: at 50 Hz wrists were 15 cm off in a quarter of the frames, all valid."""
    times = [k / rate_hz for k in range(4 * rate_hz)]
    frames, said = of_times(tmp_path / "k.csv", times, 240)
    assert np.abs(np.array(frames) - 60 * np.array(times)).max() <= 0.5 + 1e-9
    assert not said
    assert of_times(tmp_path / "k.csv", times, 4 * rate_hz) == (list(range(4 * rate_hz)), ())  # a rate that was typed


@pytest.mark.parametrize("typed_hz", [29, 31, 58, 62])
def test_a_rate_that_was_typed_nearly_right_counts_frames(tmp_path: Path, typed_hz: int) -> None:
    every = round(60 / typed_hz)
    there = [k for k in range(0, 140, every) if k % 7]
    assert of_times(tmp_path / "k.csv", [k / every / typed_hz for k in there], 140) == (there, ())


def test_rows_of_frames_that_a_video_lost_are_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As a phone writes it, converted to a steady rate for the detector: it was another clip's."""
    shown = [k for k in range(100) if k % 10 != 3]
    monkeypatch.setattr("pytracker.recording.keypoints.frames.frame_times", lambda _: np.array(shown) / 60)
    (tmp_path / "v.mp4").touch()
    frames, said = of_times(tmp_path / "k.csv", [k / 60 for k in range(100)], len(shown))
    assert frames == list(range(90))
    assert "10 of its 100 rows are of no frame of v.mp4 by their times: left out" in said[0]
    frames, _ = of_times(tmp_path / "k.csv", [k / 30 for k in range(50)], len(shown))
    assert np.abs(np.array(shown)[frames] - 2 * np.arange(50)).max() <= 1


@pytest.mark.parametrize("rate_hz", [100, 120, 240])
def test_rows_that_are_denser_than_frames_are_of_the_nearest(tmp_path: Path, rate_hz: int) -> None:
    """A detector's 60 Hz beside a video of 30: refused as another clip's."""
    times = np.arange(4 * rate_hz) / rate_hz
    path = tmp_path / "k.csv"
    rows = [f"{time_s},{100 + k},90" for k, time_s in enumerate(times)]
    path.write_text("\n".join(["time_s,left_wrist_x,left_wrist_y", *rows]), "utf-8")
    found = in_pixels(path, read_keypoints(path), tmp_path / "v.mp4", VideoInfo(1000, 240, 240, 60.0))
    assert found.frames.tolist() == list(range(240))
    row = found.points[:, 0, KEYPOINTS.index("left_wrist"), 0] - 100
    assert np.abs(row / rate_hz - found.frames / 60).max() <= 0.5 / rate_hz + 1e-9
    assert f"has {4 * rate_hz} rows for 240 frames of v.mp4: the 240 nearest are taken" in found.warnings[-1]
    # Those that end elsewhere are another clip's.
    with pytest.raises(pt.InputError, match="expected below the 240 frames"):
        in_pixels(path, read_keypoints(path), tmp_path / "v.mp4", VideoInfo(1000, 240, 240, 50.0))


def test_frames_counted_from_one_may_begin_late(tmp_path: Path) -> None:
    rows = [f"{k},{100 + k},90" for k in range(4, 21)]
    (tmp_path / "k.csv").write_text("\n".join(["frame,left_wrist_x,left_wrist_y", *rows]), "utf-8")
    info = VideoInfo(320, 240, 20, 60.0)
    found = in_pixels(tmp_path / "k.csv", read_keypoints(tmp_path / "k.csv"), tmp_path / "v.mp4", info)
    assert found.frames.tolist() == list(range(3, 20))


@pytest.mark.parametrize("times", [[0.0, 0.1, 0.1, 0.2], [0.0, 0.01, 0.012, 0.041]])
def test_times_that_are_of_no_frames_count_nothing(tmp_path: Path, times: list[float]) -> None:
    frames, said = of_times(tmp_path / "k.csv", times, 20)
    assert frames == [0, 1, 2, 3]
    assert "counted as frames instead" in said[0]
    assert of_times(tmp_path / "k.csv", times, 4) == ([0, 1, 2, 3], ())  # one of each


def test_files_that_are_numbered_from_one_and_end_early_are_so_counted(tmp_path: Path) -> None:
    """A frame late, without a word, where the last file was not the video's last."""
    for k in range(1, 60):
        person = {"pose_keypoints_2d": [x for joint in range(25) for x in (100 + joint, 50 + k, 0.9)]}
        (tmp_path / f"frame_{k:06d}.json").write_text(json.dumps({"people": [person]}))
    info = VideoInfo(640, 480, 64, 30.0)
    found = in_pixels(tmp_path, read_keypoints(tmp_path), tmp_path / "v.mp4", info)
    assert found.frames.tolist() == list(range(59))
    assert "numbered from 1 to 59: taken to be counted from one" in found.warnings[-1]
    # Of a list, or rows of a table, a frame in which nobody is seen may be left out, as the first here.
    path = tmp_path / "k.csv"
    path.write_text("\n".join([f"frame,{PLAIN}", *(f"{k},100,50,120,90" for k in range(1, 60))]))
    for count in (60, 64):
        info = VideoInfo(640, 480, count, 30.0)
        assert in_pixels(path, read_keypoints(path), tmp_path / "v.mp4", info).frames.tolist() == list(range(1, 60))
