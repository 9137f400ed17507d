"""Tracks as TRC and C3D: read back they are the means, and what is not valid is a gap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_cli import run

import pytracker as pt
from pytracker.formats.c3d import read_c3d
from pytracker.formats.markers import Markers
from pytracker.formats.trc import read_trc
from pytracker.report import export
from pytracker.report.files.tables import read_rows
from pytracker.simulate import ArmSimulation
from pytracker.tracking import BodyTrack

READERS: dict[str, Callable[[Path], Markers]] = {".trc": read_trc, ".c3d": read_c3d}


@pytest.fixture(scope="module")
def arm() -> pt.Track:
    """An arm whose patch is hidden for a second."""
    simulation = ArmSimulation(pt.ArmScene(duration_s=4.0), 3)
    pixels = simulation.sightings()
    pixels[40:65] = np.nan
    return pt.track(simulation.recording(), pt.Mixture(), 1, sightings=pt.Sightings.of(simulation.frame_time_s, pixels))


@pytest.mark.parametrize("suffix", READERS)
def test_read_back_it_is_the_means_with_gaps_where_not_valid(tmp_path: Path, arm: pt.Track, suffix: str) -> None:
    gaps = export(arm, tmp_path / f"arm{suffix}")
    found = READERS[suffix](tmp_path / f"arm{suffix}")
    assert list(found.positions_m) == ["wrist", "elbow"]
    assert 0 < (~arm.valid).sum() < len(arm.valid)
    assert gaps == dict.fromkeys(("wrist", "elbow"), (~arm.valid).sum())
    for joint, places in found.positions_m.items():
        assert np.allclose(places[arm.valid], arm.joints[joint].mean[arm.valid], atol=1e-6)
        assert np.isnan(places[~arm.valid]).all()
    assert np.allclose(np.diff(found.time_s), np.diff(arm.time_s), atol=2e-6)


def test_a_body_has_gaps_joint_by_joint_from_the_table_too(tmp_path: Path, body: pt.BodyRecording) -> None:
    track = pt.track(body, pt.Partitioned(particles=50), 1)
    assert isinstance(track, BodyTrack)
    reason = ("", *("hidden",) * (len(track.time_s) - 1))
    joints = {**track.joints, "left_wrist": replace(track.joints["left_wrist"], reason=reason)}
    track = replace(track, joints=joints, reason=reason, valid=np.array([not words for words in reason]))
    pt.write_report([track], tmp_path / "out", page=False)
    done = run("export", tmp_path / "out", tmp_path / "body.TRC")
    assert f"left_wrist {len(track.time_s) - 1}" in done.stderr
    export(read_rows(tmp_path / "out" / "track.csv"), tmp_path / "again.trc")
    export(track, tmp_path / "direct.trc")
    names = ("body.TRC", "again.trc", "direct.trc")
    texts = [(tmp_path / name).read_text().splitlines()[1:] for name in names]
    assert texts[0] == texts[1] == texts[2]
    found = read_trc(tmp_path / "body.TRC").positions_m
    assert np.isnan(found["left_wrist"][1:]).all()
    is_right = track.joints["right_elbow"].valid
    assert np.isfinite(found["right_elbow"][is_right]).all()


def test_a_c3d_begins_with_the_frame_that_the_track_does(tmp_path: Path, arm: pt.Track) -> None:
    """It was told nowhere that a track begins late: 2.5 s early beside its TRC."""
    ezc3d = pytest.importorskip("ezc3d")
    export(replace(arm, time_s=arm.time_s - arm.time_s[0] + 2.5), tmp_path / "late.c3d")
    points = ezc3d.c3d(str(tmp_path / "late.c3d"))["header"]["points"]
    assert points["first_frame"] == round(2.5 * points["frame_rate"])


def test_what_a_file_cannot_hold_is_refused(tmp_path: Path, arm: pt.Track) -> None:
    uneven = replace(arm, time_s=arm.time_s + np.where(np.arange(len(arm.time_s)) > 30, 0.5, 0.0))
    with pytest.raises(pt.InputError, match=r"frame \d+ is at .* write .trc"):
        export(uneven, tmp_path / "a.c3d")
    export(uneven, tmp_path / "a.trc")
    assert np.allclose(read_trc(tmp_path / "a.trc").time_s, uneven.time_s, atol=1e-6)
    with pytest.raises(pt.InputError, match=r"expected a name that ends in .trc or .c3d"):
        export(arm, tmp_path / "a.bvh")
    assert "expected a new file" in run("export", tmp_path, tmp_path / "a.trc").stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.trc"]
