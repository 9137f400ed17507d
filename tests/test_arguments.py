"""Arguments of `track` and `write_report` that are of another kind than they take."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

import pytracker as pt
from pytracker.simulate import ArmSimulation


@pytest.fixture(scope="module")
def simulation() -> ArmSimulation:
    return ArmSimulation(pt.ArmScene(duration_s=1.0), 1)


@pytest.fixture(scope="module")
def sightings(simulation: ArmSimulation) -> pt.Sightings:
    return pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, "a", None])
def test_a_seed_is_a_whole_number(simulation: ArmSimulation, sightings: pt.Sightings, seed: object) -> None:
    with pytest.raises(pt.InputError, match="expected a whole number, 0 or larger"):
        pt.track(simulation.recording(), pt.Ekf(), seed, sightings=sightings)  # type: ignore[call-overload]


@pytest.mark.parametrize("method", [pt.Layered, "layered"])
def test_a_method_is_an_object(simulation: ArmSimulation, method: object) -> None:
    with pytest.raises(pt.InputError, match="expected a method object, such as"):
        pt.track(simulation.recording(), method)  # type: ignore[call-overload]


def test_a_report_is_of_a_list_of_tracks(simulation: ArmSimulation, sightings: pt.Sightings, tmp_path: Path) -> None:
    track = pt.track(simulation.recording(), pt.Ekf(), sightings=sightings)
    with pytest.raises(pt.InputError, match=r"expected a list of them: \[track\]"):
        pt.write_report(track, tmp_path / "out")  # type: ignore[arg-type]


def test_every_sensor_of_a_body_says_how_well_it_is_known(body: pt.BodyRecording) -> None:
    with pytest.raises(pt.InputError, match="imu_sds_rad are 1 for 0 imus, expected one of each"):
        dataclasses.replace(body, imu_sds_rad=(0.05,))
