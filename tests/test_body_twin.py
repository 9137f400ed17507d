"""The Rust core against its NumPy twin: kinematics of many particles, the edge cue."""

from __future__ import annotations

import numpy as np
from numpy_body_twin import NumpyKinematics, missed_edges

import pytracker as pt
from pytracker._core import missed_edges as rust_missed_edges
from pytracker.skeleton import UPPER_BODY
from pytracker.skeleton.skeleton import KEY_BONES


def test_kinematics_of_many_particles(body: pt.BodyRecording) -> None:
    """Through the tracker's own poses, and through the skeleton's."""
    rng = np.random.default_rng(1)
    free = (*UPPER_BODY, "lowerback_rx", "head_ry")
    states = 0.7 * rng.standard_normal((40, len(free)))
    tracker = pt.Tracker(body, pt.BodyPlain(particles=3, free=free))
    joints = body.skeleton.joints(tracker.channels(states))
    ours = tracker.pose(states)
    starts, ends = NumpyKinematics(body.skeleton, body.initial, free)(states)
    for name, (bone, along) in KEY_BONES.items():
        twin = (ends if along else starts)[body.skeleton.bone(bone)]
        assert np.abs(joints[name] - twin).max() < 1e-12, name
        assert np.abs(ours[name] - twin).max() < 1e-12, name


def test_edge_cue() -> None:
    rng = np.random.default_rng(2)
    edges = (rng.random((240, 320)) < 0.3).astype(np.uint8)
    outlines = rng.uniform(-40, 360, (200, 4, 2))
    ours = rust_missed_edges(edges, outlines.reshape(200, 8))
    # Fixed point and floating point may round a point between two pixels to either.
    assert np.abs(ours - missed_edges(edges, outlines)).max() < 0.02
    assert np.abs(ours - missed_edges(edges, outlines)).mean() < 0.002
