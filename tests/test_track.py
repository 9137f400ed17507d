"""Tracking through the Python calls: same bits however it is called, and honest rows where nothing is known."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import threading
import time
import tracemalloc

import numpy as np
import pytest
from conftest import arm_tracker, estimated, shown

import pytracker as pt
from pytracker.methods.arm import METHODS, ArmMethod
from pytracker.simulate import ArmSimulation
from pytracker.tracking import default_method, resample

ALL: list[ArmMethod] = [
    pt.Inertial(),
    pt.Ekf(),
    pt.Ekf(corrections=("colour", "arm_projection"), bias=True),
    pt.Plain(particles=300, outlier_fraction=0.01),
    pt.Layered(particles=300, resampling="systematic", ess_threshold=0.5),
    pt.LayeredFromConstraint(particles=300),
    pt.Joint(particles=300, bias=True, patch_offset=True),
]

SUM = ("sum", 1.0)


@pytest.fixture(scope="module")
def simulation() -> ArmSimulation:
    return ArmSimulation(pt.ArmScene(duration_s=2.0, occlusions=((1.0, 1.2),)), seed=9)


@pytest.fixture(scope="module")
def sightings(simulation: ArmSimulation) -> pt.Sightings:
    return pt.Sightings.of(simulation.frame_time_s, simulation.sightings())


@pytest.mark.parametrize("method", ALL, ids=lambda method: method.name)
def test_online_gives_the_same_bytes(simulation: ArmSimulation, sightings: pt.Sightings, method: ArmMethod) -> None:
    track = pt.track(simulation.recording(), method, seed=3, sightings=sightings)
    tracker = pt.Tracker(simulation.recording(), method, seed=3)
    source = simulation.recording().observations(sightings)
    estimates = [estimate for observed in source if (estimate := tracker.observe(observed))]
    assert len(estimates) == len(sightings.time_s)
    for k, estimate in enumerate(estimates):
        assert np.array_equal(estimate.places["wrist"].mean, track.joints["wrist"].mean[k])
        assert np.array_equal(estimate.places["elbow"].hi, track.joints["elbow"].hi[k])
        assert np.array_equal(estimate.covariance[:3, :3], track.wrist_covariance[k])
        assert np.array_equal(np.sqrt(np.diag(estimate.covariance)), track.state_sd[k])
    assert (estimates[-1].ess is None) == (method.name in {"ekf", "inertial"})


def test_threads_and_repeats_give_the_same_bytes(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    method = pt.Joint(particles=36_000, bias=True)
    runs = [pt.track(simulation.recording(), method, 5, sightings=sightings, threads=n) for n in (1, 2, 7, None)]
    for run in runs[1:]:
        assert np.array_equal(run.state_mean, runs[0].state_mean)
        assert np.array_equal(run.state_sd, runs[0].state_sd)
        assert np.array_equal(run.wrist_covariance, runs[0].wrist_covariance)
        assert np.array_equal(run.joints["wrist"].mode, runs[0].joints["wrist"].mode)
    other = pt.track(simulation.recording(), method, 6, sightings=sightings)
    assert not np.array_equal(other.state_mean, runs[0].state_mean)


def test_copies_and_pickles_go_on_where_they_stand(simulation: ArmSimulation) -> None:
    tracker = arm_tracker(simulation.arm, list(simulation.cameras), pt.Layered(particles=200), seed=1)
    imu = simulation.imu
    for k in range(20):
        tracker.observe(pt.Observation.inertial(imu.time_s[k], imu.acc[k], imu.q_world_segment[k]))
    tracker.observe(pt.Observation.patch(0.195, simulation.sightings()[4, 0]))
    others = [copy.copy(tracker), pickle.loads(pickle.dumps(tracker)), pt.Tracker.restore(tracker.save())]  # noqa: S301
    for each in (tracker, *others):
        each.observe(pt.Observation.inertial(imu.time_s[20], imu.acc[20], imu.q_world_segment[20]))
    expected = estimated(tracker, pt.Observation.patch(0.21, [300.0, 250.0])).mean
    for each in others:
        assert np.array_equal(estimated(each, pt.Observation.patch(0.21, [300.0, 250.0])).mean, expected)
    assert tracker.particles is not None
    assert tracker.particles.shape == (200, 6)


@pytest.mark.parametrize("method", [pt.Ekf(), pt.Plain(particles=5000)], ids=["ekf", "plain"])
def test_hidden_patch_widens_the_band_and_has_a_reason(
    simulation: ArmSimulation, sightings: pt.Sightings, method: ArmMethod
) -> None:
    track = pt.track(simulation.recording(), method, 1, sightings=sightings)
    hidden = ~sightings.valid
    assert hidden.sum() == 5
    assert [bool(words) for words in track.reason] == hidden.tolist()
    before, last = np.flatnonzero(hidden)[0] - 1, np.flatnonzero(hidden)[-1]
    assert track.joints["wrist"].sd[last].max() > track.joints["wrist"].sd[before].max()


def test_a_lost_track_keeps_what_came_before(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    recording = simulation.recording()
    behind = pt.Arm(shoulder_m=(0.1, 9.0, 0.25), upper_arm_m=0.3, forearm_m=0.25, wrist_start_m=(0.2, 9.3, 1.0))
    lost = pt.ArmRecording(views=recording.views, imus=recording.imus, arm=behind, truth=recording.truth)
    unseen = pt.Sightings.of(sightings.time_s, np.where(np.arange(50)[:, None, None] < 7, np.nan, sightings.pixels))
    with pytest.raises(pt.TrackingError, match=r"frame 7: all 100 particle weights are zero at 0\.28") as error:
        pt.track(lost, pt.Plain(particles=100), sightings=unseen)
    track = error.value.track
    assert track is not None
    assert np.isfinite(track.joints["wrist"].mean[:7]).all()
    assert np.isnan(track.joints["wrist"].mean[7:]).all()
    assert track.reason[7] == "the track was lost before"
    assert "frame 7" in track.lost


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (
            lambda: pt.Layered(particles="many"),  # type: ignore[arg-type]
            "Layered.particles is 'many', expected a whole number, 0 or more",
        ),
        (
            lambda: pt.Joint(bias=1),  # type: ignore[arg-type]
            "Joint.bias is 1, expected true or false",
        ),
        (lambda: tracker_of(pt.Layered(particles=0)), "particles is 0, expected 1 to 100000000"),
        (lambda: tracker_of(pt.Layered(resampling="resedual")), "resampling 'resedual' is not known, expected one of"),
        (lambda: tracker_of(pt.Layered(ess_threshold=2.0)), "ess_threshold is 2, expected 0 to 1"),
        (lambda: tracker_of(pt.Layered(pixel_sd=0.0)), "pixel_sd is 0, expected a positive number of pixels"),
        (lambda: tracker_of(pt.Ekf(outlier_fraction=0.1)), "outlier_fraction is 0.1, expected 0 for a Gaussian method"),
        (lambda: tracker_of(pt.Ekf(corrections=("color",))), "correction 'color' is not known"),
        (lambda: tracker_of(pt.Plain(layers=(("inertial", ("colours",), SUM),))), "cue 'colours' is not known"),
        (
            lambda: tracker_of(pt.Plain(layers=(("inertial", ("colour",), ("rescaled", 1.0)),))),
            "blend 'rescaled' is not known, expected one of: sum",
        ),
        (
            lambda: tracker_of(pt.Plain(layers=(("inertial", ("colour",), ("sum", 0.0)),))),
            "sharpness of a layer is 0, expected positive",
        ),
        (lambda: resample("residual", np.array([0.5, -0.5]), 3), "a weight is -0.5, expected a finite number"),
        (lambda: resample("residual", np.zeros(3), 3), "the sum of weights is 0, expected positive"),
        (lambda: pt.ArmScene(pattern="spiral"), "pattern is 'spiral', expected one of: circle, rectangle, reach"),
        (lambda: ArmSimulation(pt.ArmScene(radius_m=0.5)), "m from the shoulder, expected less than 0.550 m"),
        (lambda: pt.Sightings.of(np.arange(3.0), np.zeros((4, 2))), "expected (T, 2) or (T, C, 2)"),
        (lambda: pt.Sightings.of(np.zeros(3), np.zeros((3, 2))), "expected (T,), finite and increasing"),
        (lambda: pt.Sightings.of(np.zeros(0), np.zeros((0, 2))), "expected (T,), finite and increasing"),
    ],
)
def test_bad_arguments_are_named(make: object, expected: str) -> None:
    with pytest.raises(pt.InputError) as error:
        make()  # type: ignore[operator]
    assert expected in str(error.value)


def tracker_of(method: ArmMethod) -> pt.Tracker:
    simulation = ArmSimulation(pt.ArmScene(duration_s=1.0))
    return arm_tracker(simulation.arm, simulation.cameras[0], method)


def test_wrong_shapes_are_named(simulation: ArmSimulation) -> None:
    imu, one = simulation.imu, np.zeros(1)
    inertials, patches = pt.Observation.inertials, pt.Observation.patches
    for expected, call in (
        ("acc has 2 columns, expected 3", lambda: inertials(imu.time_s, imu.acc[:, :2].copy(), imu.q_world_segment)),
        ("acc has 5 rows, expected 201", lambda: inertials(imu.time_s, imu.acc[:5], imu.q_world_segment)),
        ("pixels has 2 rows, expected 1", lambda: patches(one, np.zeros((2, 1, 2)))),
        ("pixels has 3 coordinates, expected 2", lambda: patches(one, np.zeros((1, 1, 3)))),
        ("pixels has 2 cameras, expected 1", lambda: tracker_of(pt.Ekf()).run(patches(one, np.zeros((1, 2, 2))))),
    ):
        with pytest.raises(pt.InputError, match=expected):
            call()


def test_an_observation_of_another_subject_is_refused(body: pt.BodyRecording) -> None:
    turned = pt.Observation.orientation(0.0, "left_forearm", (1.0, 0.0, 0.0, 0.0), 0.1)
    with pytest.raises(pt.InputError, match="orientation of a forearm is not what this tracker takes"):
        tracker_of(pt.Ekf()).observe(turned)
    # Where late ones are waited for, at once too, and not at the next observation.
    waits = pt.Tracker(body, pt.BodyPlain(particles=5), delay_s=1.0)
    with pytest.raises(pt.InputError, match="frame 3: frame is not what this tracker takes"):
        waits.observe(pt.Observation.patch(0.0, None, 3))
    odd = pt.Observation.picture(0.0, shown(np.zeros((240, 320), np.uint8), np.array([[np.nan, 1.0]])), 4)
    with pytest.raises(pt.InputError, match="frame 4: blob at 0 s is NaN"):
        waits.observe(odd)
    assert waits.finish() == []
    tracker = pt.Tracker(body, pt.BodyPlain(particles=5))
    for other in (pt.Observation.patch(0.0, None), pt.Observation.inertial(0.0, (0.0, 0.0, 9.8), (1.0, 0.0, 0.0, 0.0))):
        with pytest.raises(pt.InputError, match="is not what this tracker takes"):
            tracker.observe(other)
    with pytest.raises(pt.InputError, match="time between frames is not what"):
        tracker.estimate(1.0)
    with pytest.raises(pt.InputError, match="Layered tracks a recording of kind 'arm', this one is 'body'"):
        pt.Tracker(body, pt.Layered())


def test_every_method_has_a_name_and_documented_parameters() -> None:
    assert set(METHODS) == {
        "inertial",
        "ekf",
        "plain",
        "layered",
        "layeredfromconstraint",
        "joint",
        "mixture",
        "smooth",
    }
    for name, cls in METHODS.items():
        assert cls().name == name
        described = " ".join(c.__doc__ or "" for c in cls.__mro__)
        assert all(f"{parameter}:" in described or f"`{parameter}" in described for parameter in cls().parameters())


def test_a_run_lets_the_interpreter_go(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    """While one thread tracks, another goes on."""
    done = threading.Event()

    def work() -> None:
        pt.track(simulation.recording(), pt.Joint(particles=60_000), sightings=sightings)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    ticks = 0
    while not done.is_set():
        ticks += 1
        time.sleep(0.001)
    thread.join()
    assert ticks > 20


def test_a_gap_in_the_imu_has_a_reason(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    recording = simulation.recording()
    imu = recording.imus[0]
    keep = (imu.time_s < 0.5) | (imu.time_s > 0.9)
    assert imu.gyr is not None
    cut = pt.Imu(
        time_s=imu.time_s[keep], acc=imu.acc[keep], q_world_segment=imu.q_world_segment[keep], gyr=imu.gyr[keep]
    )
    track = pt.track(dataclasses.replace(recording, imus=(cut,)), pt.Layered(particles=200), sightings=sightings)
    assert track.reason[18] == "no IMU sample for 0.23 s"
    assert not track.valid[18]


def test_what_was_tracked_before_a_refusal_comes_with_it(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    recording = simulation.recording()
    observed = list(recording.observations(sightings))
    bad = pt.Observation.inertial(1.0, (np.nan, 0.0, 9.8), (1.0, 0.0, 0.0, 0.0), index=7)
    with pytest.raises(pt.InputError, match="IMU sample 7: acceleration at") as error:
        pt.Tracker(recording, pt.Ekf()).run([*observed[:100], bad, *observed[100:]])
    assert len(error.value.table["time_s"]) == sum(o.is_frame for o in observed[:100])


def test_a_lost_tracker_knows_nothing_between_frames(simulation: ArmSimulation) -> None:
    imu = simulation.imu
    behind = dataclasses.replace(simulation.arm, wrist_start_m=(0.2, 9.3, 1.0))
    tracker = arm_tracker(behind, simulation.cameras[0], pt.Plain(particles=50))
    tracker.observe(pt.Observation.inertial(0.0, imu.acc[0], imu.q_world_segment[0]))
    with pytest.raises(pt.TrackingError):
        tracker.observe(pt.Observation.patch(0.0, (320.0, 240.0)))
    with pytest.raises(pt.TrackingError, match="after the track was lost at 0 s"):
        tracker.estimate(0.01)


def test_a_flat_layer_weighs_less_and_is_no_evidence(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    """Annealing is a list of layers for an arm as for a body."""
    recording = simulation.recording()
    sharp, flat = (pt.Plain(layers=(("inertial", ("colour",), ("sum", share)),)) for share in (1.0, 0.1))
    tracks = [pt.track(recording, method, 1, sightings=sightings) for method in (sharp, flat)]
    assert np.isfinite(tracks[0].log_evidence).any()
    assert not np.isfinite(tracks[1].log_evidence).any()
    assert np.nanmedian(tracks[1].ess) > 1.5 * np.nanmedian(tracks[0].ess)


def test_an_observation_says_who_observed(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    """In order of time, of the same time a sample first; what several sources number is told apart in an error."""
    source = list(simulation.recording().observations(sightings))
    assert {observed.source for observed in source} == {"forearm", "cameras"}
    keys = [(observed.time_s, observed.is_frame) for observed in source]
    assert keys == sorted(keys)
    for what in ("forearm", "cameras"):
        indices = [observed.index for observed in source if observed.source == what]
        assert indices == list(range(len(indices)))
    q = [1.0, 0.0, 0.0, 0.0]
    worn = pt.Observation.orientation(0.0, "left_upper_arm", q, 0.1, index=17)
    assert worn.source == "left_upper_arm"
    assert pt.Observation.landmark(0.0, "elbow", [1.0, 2.0], 1.0, camera=1).source == "camera[1]"
    with pytest.raises(pt.InputError, match="orientation 17 of left_upper_arm: "):
        pt.Tracker(simulation.recording(), pt.Mixture()).observe(worn)


def test_a_long_recording_is_made_as_it_is_taken(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    recording = simulation.recording()
    imu = recording.imus[0]
    many = np.arange(100_000) / 100
    long = dataclasses.replace(
        imu, time_s=many, acc=np.tile(imu.acc[:1], (len(many), 1)), gyr=None,
        q_world_segment=np.tile(imu.q_world_segment[:1], (len(many), 1)),
    )  # fmt: skip
    tracemalloc.start()
    first = next(dataclasses.replace(recording, imus=(long,)).observations(sightings))
    least = dataclasses.replace(recording, imus=(imu,)).observations(sightings)
    assert (first.index, next(least).index) == (0, 0)
    assert tracemalloc.get_traced_memory()[1] < 2**20
    tracemalloc.stop()


def test_doubts_are_found_once(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    track = pt.track(simulation.recording(), pt.Mixture(), sightings=sightings)
    assert track.doubts is track.doubts
    assert track.doubts == pt.doubts(track)


def test_without_a_method_the_best_is_taken(simulation: ArmSimulation, sightings: pt.Sightings) -> None:
    recording = simulation.recording()
    track = pt.track(recording, sightings=sightings)
    same = pt.track(recording, default_method(recording), sightings=sightings)
    assert isinstance(track.method, pt.Smooth)
    assert np.array_equal(track.joints["wrist"].mean, same.joints["wrist"].mean, equal_nan=True)
