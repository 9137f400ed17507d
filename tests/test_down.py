"""Gravity that is turned over: an earth frame with z down, or a sensor that reads gravity; the picture tells."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import load_arm

import pytracker as pt
from pytracker.inertial.conventions import OVER
from pytracker.inertial.log import ImuLog
from pytracker.recording.recording import ArmRecording, Imu
from pytracker.rotation import multiply
from pytracker.setup.checks.down import which_is_down
from pytracker.setup.draft import Draft
from pytracker.simulate import ArmSimulation


@pytest.mark.parametrize("reads_gravity", [True, False])
def test_a_gesture_tells_which(reads_gravity: bool, tmp_path: Path) -> None:
    """By "z down", a clock and a mount 75° off, an arm was 18 to 42 cm off, all of it valid, and nothing said."""
    simulation = ArmSimulation(pt.ArmScene(worn=True, pattern="gesture", duration_s=7.0), 101)
    recording = simulation.recording()
    imu = recording.imus[0]
    # As the file is read by "z down".
    over = np.broadcast_to(OVER, imu.q_world_segment.shape)
    acc, q = (-imu.acc, multiply(over, imu.q_world_segment)) if reads_gravity else (imu.acc, imu.q_world_segment)
    log = ImuLog(Path("imu.csv"), np.arange(len(acc)), imu.time_s, acc=acc, gyr=imu.gyr, q_world_sensor=q)

    def recording_with(of: ImuLog) -> ArmRecording:
        assert of.acc is not None
        assert of.q_world_sensor is not None
        worn = Imu(time_s=of.time_s, acc=of.acc, q_world_segment=of.q_world_sensor, gyr=of.gyr)
        return dataclasses.replace(recording, imus=(worn,))

    (tmp_path / "recording.toml").write_text('kind = "arm"\n[[imu]]\nearth = "z down"\n')
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    said, told = which_is_down(Draft(tmp_path), log, recording_with, sightings)
    assert told is not None
    assert told.acc is not None
    assert told.q_world_sensor is not None
    assert np.allclose(told.acc, imu.acc)
    assert np.allclose(np.abs((told.q_world_sensor * imu.q_world_segment).sum(axis=1)), 1.0)
    if not reads_gravity:
        assert said is None
        return
    assert said is not None
    assert said.verdict == "wrong"
    assert said.writes == {"imu.acc_reads": "gravity", "imu.earth": "z up"}


def test_an_accelerometer_that_reads_gravity_is_turned_over(tmp_path: Path, simulated: Path) -> None:
    folder = tmp_path / "circle"
    shutil.copytree(simulated, folder)
    head, *rows = (folder / "imu.csv").read_text().splitlines()
    table = np.array([row.split(",") for row in rows], dtype=float)
    table[:, 1:4] *= -1.0
    lines = [head, *(",".join(f"{x:.6f}" for x in row) for row in table)]
    (folder / "imu.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(pt.InputError, match=r'here it is down: is earth "z down" .*, or acc_reads "gravity"'):
        pt.load(folder)
    text = (folder / "recording.toml").read_text()
    (folder / "recording.toml").write_text(text.replace("[[imu]]", '[[imu]]\nacc_reads = "gravity"'))
    assert np.allclose(load_arm(folder).imus[0].acc, load_arm(simulated).imus[0].acc)
