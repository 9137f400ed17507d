"""The clock of an IMU from claps: which of the blows that it felt the frames show, and what is told where none is."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import pytracker as pt
from pytracker.cli.entry import app
from pytracker.inertial.log import ImuLog
from pytracker.rotation import Array
from pytracker.setup.clap import clock_by_claps, find_claps

FRAME_S = 1 / 30


def moving(blows: dict[float, float], rate_hz: float = 100.0) -> ImuLog:
    """A minute of an arm that moves, and blows of so many m/s² at IMU times, 20 ms long."""
    time_s = np.arange(0.0, 60.0, 1 / rate_hz)
    acc = np.random.default_rng(3).normal((0.0, 0.0, 9.81), 0.3, (len(time_s), 3))
    acc[:, 0] += 6.0 * np.sin(2 * np.pi * 1.5 * time_s)
    for at_s, size in blows.items():
        acc[:, 2] += size * np.exp(-(((time_s - at_s) / 0.01) ** 2))
    return ImuLog(Path("imu.csv"), np.arange(len(time_s)) + 2, time_s, acc=acc)


def in_frames(times_s: list[float]) -> Array:
    """When a camera first shows them."""
    return np.ceil(np.array(times_s) / FRAME_S) * FRAME_S


@given(
    st.floats(-40.0, 40.0), st.lists(st.floats(0.4, 2.0), min_size=2, max_size=3), st.sampled_from([50.0, 100.0, 240.0])
)
def test_claps_are_told_from_a_harder_bang(offset_s: float, between_s: list[float], rate_hz: float) -> None:
    at_s = [12.0, *(12.0 + np.cumsum(between_s))]
    log = moving({**dict.fromkeys(at_s, 50.0), 2.0: 90.0, 55.3: 70.0}, rate_hz)
    found = find_claps(in_frames([t + offset_s for t in at_s]), log, FRAME_S)
    assert np.allclose(found.blow_s, at_s, atol=1 / rate_hz)
    assert abs(found.offset_s - offset_s) < FRAME_S / 2 + 1 / rate_hz
    assert 0.02 <= found.offset_sd_s < 0.05


def test_one_clap_must_stand_out() -> None:
    found = find_claps(np.array([4.0]), moving({20.0: 60.0, 40.0: 10.0}), FRAME_S)
    assert found.offset_s == pytest.approx(-16.0 - FRAME_S / 2, abs=0.011)
    with pytest.raises(
        pt.InputError, match=r"at 40.00 s and one at 20.00 s may both be it, .* name the frames of three"
    ):
        find_claps(np.array([4.0]), moving({20.0: 50.0, 40.0: 60.0}), FRAME_S)


def test_harder_bangs_at_the_same_interval_are_told() -> None:
    log = moving({12.0: 30.0, 13.0: 30.0, 30.0: 90.0, 31.0: 90.0})
    with pytest.raises(pt.InputError, match=r"at 30.00 s and one at 12.00 s may both be it"):
        find_claps(np.array([4.0, 5.0]), log, FRAME_S)


def test_claps_at_other_intervals_are_none() -> None:
    with pytest.raises(pt.InputError, match=r"has no claps, expected"):
        find_claps(np.array([]), moving({20.0: 60.0}), FRAME_S)
    with pytest.raises(pt.InputError, match=r"no 2 blows that are 1.50 s apart, .*\(felt: .* at 20.00 s"):
        find_claps(np.array([4.0, 5.5]), moving({20.0: 60.0, 21.0: 60.0}), FRAME_S)
    with pytest.raises(pt.InputError, match=r"no blow of 5 m/s², expected the claps that were seen: clap, .* harder$"):
        find_claps(np.array([4.0]), moving({}), FRAME_S)


def test_the_clock_of_a_recording_is_written(tmp_path: Path, simulated: Path) -> None:
    folder = tmp_path / "circle"
    shutil.copytree(simulated, folder)
    head, *rows = (folder / "imu.csv").read_text().splitlines()
    cells = np.array([row.split(",") for row in rows], dtype=float)
    for clap_s in (0.7, 1.1):
        cells[np.abs(cells[:, 0] - clap_s) < 0.006, 3] += 60.0
    cells[:, 0] += 17.3
    (folder / "imu.csv").write_text("\n".join([head, *(",".join(f"{x:.6f}" for x in row) for row in cells)]) + "\n")
    done = CliRunner().invoke(app, ["clap", str(folder), "18", "28"])  # at 25 frames a second
    assert done.exit_code == 0, done.output
    assert "offset -17.300 ± 0.020 s" in done.output
    text = (folder / "recording.toml").read_text()
    assert "offset_s = -17.3\n" in text
    assert "offset_sd_s = 0.02\n" in text
    assert 'file = "imu.csv"' in text
    with pytest.raises(pt.InputError, match=r"video.mp4: has frames 0 to \d+, expected one numbered 9999"):
        clock_by_claps(folder, [9999])
    with pytest.raises(pt.InputError, match=r"imu.csv: the sensor felt no 2 blows that are 0.80 s apart"):
        clock_by_claps(folder, [18, 38])
    assert (folder / "recording.toml").read_text() == text


def test_a_bodys_sensor_has_no_spread(tmp_path: Path, simulated_body: Path) -> None:
    folder = tmp_path / "body"
    shutil.copytree(simulated_body, folder)
    with pytest.raises(pt.InputError, match=r"recording.toml: imu.file is missing, expected the sensor's"):
        clock_by_claps(folder, [1])
    log = moving({0.8: 60.0})
    assert log.acc is not None
    rows = [
        f"{t:.3f},{','.join(f'{x:.4f}' for x in a)},0,0,0,1,0,0,0" for t, a in zip(log.time_s, log.acc, strict=True)
    ]
    head = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q_w,q_x,q_y,q_z"
    (folder / "wrist.csv").write_text("\n".join([head, *rows[:300]]) + "\n")
    with (folder / "recording.toml").open("a") as file:
        file.write('\n[[imu]]\nfile = "wrist.csv"\nsegment = "left_forearm"\n')
    clock_by_claps(folder, [30])
    text = (folder / "recording.toml").read_text()
    assert "offset_s = " in text
    assert "offset_sd_s" not in text
