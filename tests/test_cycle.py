"""One cycle, looked at: the recorded clouds are those of the track, and every layer follows from the one before."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from test_cli import run

import pytracker as pt
from pytracker.methods.arm import ArmMethod
from pytracker.methods.body import BodyParticleMethod
from pytracker.report.cycles.figures import one_cycle, snapshots
from pytracker.simulate import ArmSimulation

Simulated = tuple[pt.ArmRecording, pt.Sightings]


@pytest.fixture(scope="module")
def circle() -> Simulated:
    simulation = ArmSimulation(pt.ArmScene(duration_s=2.0, occlusions=((1.0, 1.2),)), 1)
    return simulation.recording(), pt.Sightings.of(simulation.frame_time_s, simulation.sightings(4.0))


ARM = [pt.Plain(), pt.Layered(), pt.LayeredFromConstraint(), pt.Joint(particles=300)]
BODY = [pt.BodyPlain(particles=40), pt.Annealed(particles=40), pt.Partitioned(particles=40)]


@pytest.mark.parametrize("method", ARM, ids=lambda m: m.name)
@pytest.mark.parametrize("frame", [0, 27, 49])
def test_a_cycle_is_that_of_the_track(circle: Simulated, method: ArmMethod, frame: int) -> None:
    recording, sightings = circle
    track = pt.track(recording, method, 3, sightings=sightings)
    cycle = pt.record_cycle(recording, method, 3, frame=frame, sightings=sightings)
    assert cycle.time_s == track.time_s[frame]
    assert (cycle.estimate_m["wrist"] == track.joints["wrist"].mean[frame]).all()
    assert (cycle.estimate_m["elbow"] == track.joints["elbow"].mean[frame]).all()
    cloud = cycle.layers[-1].weighted
    assert cloud.ess == pytest.approx(track.ess[frame], rel=1e-9)
    assert cloud.weights @ cloud.points_m["wrist"] == pytest.approx(track.joints["wrist"].mean[frame], abs=1e-12)
    assert recording.truth is not None
    assert cycle.truth_m["wrist"] == pytest.approx(recording.truth.at("wrist", track.time_s)[frame])


def test_the_next_prior_is_what_the_last_layer_left(circle: Simulated) -> None:
    recording, sightings = circle
    for method in (pt.Layered(), pt.Joint(particles=300)):
        one, two = (pt.record_cycle(recording, method, 3, frame=k, sightings=sightings) for k in (20, 21))
        left = one.layers[-1].resampled or one.layers[-1].weighted
        assert (left.points_m["wrist"] == two.layers[0].arriving.points_m["wrist"]).all()
        assert left.weights == pytest.approx(two.layers[0].arriving.weights, rel=1e-12)


@pytest.mark.parametrize("method", BODY, ids=lambda m: m.name)
def test_a_body_cycle_is_that_of_the_track(body: pt.BodyRecording, method: BodyParticleMethod) -> None:
    """Across the picture to rounding, where nothing is drawn of that; in depth it has a draw of what is not seen."""
    method = dataclasses.replace(method, unseen_across_sd_m=0.0)
    track = pt.track(body, method, 3)
    cycle = pt.record_cycle(body, method, 3, frame=25)
    for joint, rows in track.joints.items():
        assert (cycle.estimate_m[joint] == rows.mean[25]).all()
        cloud = cycle.layers[-1].weighted
        mean = cloud.weights @ cloud.points_m[joint]
        assert mean[:2] == pytest.approx(rows.mean[25, :2], abs=1e-12)
        assert mean[2] == pytest.approx(rows.mean[25, 2], abs=1e-12 + 3 * rows.sd[25, 2] / cloud.ess**0.5)
    left = cycle.layers[-1].resampled
    then = pt.record_cycle(body, method, 3, frame=26).layers[0].arriving
    assert left is not None
    assert left.weights == pytest.approx(then.weights, rel=1e-12)
    assert all((left.points_m[joint] == then.points_m[joint]).all() for joint in track.joints)
    assert [layer.moved_by.startswith("diffusion of ") for layer in cycle.layers] == [True] * len(method.layers)


def test_a_bodys_cloud_is_as_wide_as_its_bands(body: pt.BodyRecording) -> None:
    """What the camera does not see was cut from it: the head's cloud had no depth at all."""
    method = pt.Partitioned(particles=2000)
    head = pt.track(body, method, 3).joints["head"]
    cycle = pt.record_cycle(body, method, 3, frame=40)
    for cloud in (cycle.layers[0].arriving, cycle.layers[-1].weighted):
        at = cloud.points_m["head"]
        off = at - cloud.weights @ at
        assert np.sqrt(cloud.weights @ off**2) == pytest.approx(head.sd[40], rel=0.2)
    weighted = cycle.layers[-1].weighted
    assert weighted.weights @ weighted.points_m["head"] == pytest.approx(head.mean[40], abs=0.01)


def test_layers_say_what_they_did(circle: Simulated) -> None:
    recording, sightings = circle
    first, second = pt.record_cycle(recording, pt.Layered(), 3, frame=20, sightings=sightings).layers
    assert (first.moved_by, first.weighed_by) == ("inertial motion", "colour")
    assert (second.moved_by, second.weighed_by) == ("random walk", "arm length")
    assert second.resampled is not None
    assert len(np.unique(second.resampled.points_m["wrist"], axis=0)) < 500
    # Hidden: the patch says nothing, and the layer says so.
    hidden = pt.record_cycle(recording, pt.Layered(), 3, frame=27, sightings=sightings).layers[0]
    assert hidden.weighed_by == ""
    assert hidden.resampled is None
    assert (hidden.predicted.weights == hidden.weighted.weights).all()


def test_what_has_no_cycle(circle: Simulated, body: pt.BodyRecording) -> None:
    recording, sightings = circle
    with pytest.raises(pt.InputError, match="Ekf has no particles, expected a particle method"):
        pt.record_cycle(recording, pt.Ekf(), frame=1, sightings=sightings)
    with pytest.raises(pt.InputError, match=r"frame is 50, expected 0 to 49"):
        pt.record_cycle(recording, pt.Layered(), frame=50, sightings=sightings)
    with pytest.raises(pt.InputError, match=r"frame is 99, expected 0 to 59"):
        pt.record_cycle(body, pt.BodyPlain(particles=10), frame=99)
    with pytest.raises(pt.InputError, match=r"frame is -1, expected 0"):
        pt.record_cycle(body, pt.BodyPlain(particles=10), frame=-1)
    with pytest.raises(pt.InputError, match="Layered tracks a recording of kind 'arm', this one is 'body'"):
        pt.record_cycle(body, pt.Layered(), frame=1)


def test_figures_show_ray_sphere_and_every_layer(circle: Simulated, body: pt.BodyRecording) -> None:
    recording, sightings = circle
    cycle = pt.record_cycle(recording, pt.Layered(), 3, frame=20, sightings=sightings)
    drawn = one_cycle(cycle)
    for words in ("viewing ray", "sphere of the arm", "truth", "estimate", "1a", "2d", "weighed: colour"):
        assert words in drawn
    hidden = one_cycle(pt.record_cycle(recording, pt.Layered(), 3, frame=27, sightings=sightings))
    assert "weighed: nothing seen" in hidden
    assert "not resampled" in hidden
    drawn = snapshots([[cycle, cycle], [cycle, cycle]], ["one", "two"])
    assert drawn.count("frame 20: ESS") == 4
    cycle = pt.record_cycle(body, pt.Partitioned(particles=40), 3, frame=10)
    of_body = one_cycle(cycle)
    for words in ("particles: left wrist", "3d", "depth, towards the camera", "predicted: diffusion of", "right arm"):
        assert words in of_body
    # A truth of markers may lack head and root.
    assert cycle.truth_m is not None
    few = {joint: place for joint, place in cycle.truth_m.items() if joint not in {"head", "root"}}
    assert "truth" in one_cycle(dataclasses.replace(cycle, truth_m=few))


def test_inspect_a_track(simulated: Path, tmp_path: Path) -> None:
    out, again, file = tmp_path / "out", tmp_path / "other.svg", tmp_path / "cycle.svg"
    options = ("--method", "layered", "--particles", "100", "--set", "bias=true", "--seed", "7")
    assert run("track", simulated, *options, "--out", out, "--no-report").returncode == 0
    shown = run("inspect", simulated, "--frame", "40", "--of", out, "--out", file)
    assert shown.returncode == 0, shown.stderr
    assert "viewing ray" in file.read_text("utf-8")
    assert run("inspect", simulated, "--frame", "40", *options, "--out", again).returncode == 0
    assert again.read_bytes() == file.read_bytes()
    svg = tmp_path / "x.svg"
    for arguments, message in (
        ((simulated, "--frame", "40", "--out", file), "already exists, expected a new file"),
        ((simulated, "--frame", "40", "--out", tmp_path / "x.png"), "expected a name that ends in .svg"),
        ((simulated, "--frame", "400", "--out", svg), "frame is 400, expected 0 to 74"),
        (
            (simulated, "--frame", "4", "--of", out, "--seed", "3", "--out", svg),
            "--of says method and seed",
        ),
        ((simulated, "--frame", "4", "--of", tmp_path, "--out", svg), "holds no metadata.json"),
        ((simulated, "--frame", "4", "--of", out, "--track", "2", "--out", svg), "has 1 tracks"),
    ):
        failed = run("inspect", *arguments)
        assert failed.returncode == 2
        assert message in failed.stderr


def test_inspect_wants_the_recording_that_was_tracked(simulated: Path, simulated_body: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("track", simulated, "--method", "layered", "--out", out, "--no-report").returncode == 0
    failed = run("inspect", simulated_body, "--frame", "4", "--of", out, "--out", tmp_path / "x.svg")
    assert failed.returncode == 2
    assert "recording.toml was another file in that run" in failed.stderr
