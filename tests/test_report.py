"""What a run leaves behind, as a user sees it: tables, page and video, in a real browser."""

from __future__ import annotations

import csv
import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browser import SIZES, opened
from conftest import load_arm

import pytracker as pt
from pytracker.evidence import sightings_of
from pytracker.formats.video import frames
from pytracker.methods.arm import ArmMethod
from pytracker.report.arm.page import render_arm_page
from pytracker.report.body.page import render_body_page
from pytracker.report.contents import contents_of
from pytracker.report.files.metadata import write_metadata
from pytracker.report.files.tables import read_track
from pytracker.report.labels import HELD, labels
from pytracker.simulate import ArmSimulation
from pytracker.tracking import ArmTrack

if TYPE_CHECKING:
    from playwright.sync_api import Browser

METHODS = (pt.Joint(particles=500, bias=True), pt.Layered(particles=100), pt.Ekf(), pt.Inertial())


@pytest.fixture(scope="module")
def tracks(tmp_path_factory: pytest.TempPathFactory) -> list[pt.Track]:
    folder = tmp_path_factory.mktemp("r") / "occluded"
    pt.simulate_arm(folder, pt.ArmScene(duration_s=4.0, occlusions=((2.0, 2.4),)), seed=3)
    recording = load_arm(folder)
    sightings = sightings_of(recording)
    return [pt.track(recording, method, 1, sightings=sightings) for method in METHODS]


@pytest.fixture(scope="module")
def report(tracks: list[pt.Track], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pt.write_report(tracks, tmp_path_factory.mktemp("out") / "report")


def test_files_of_a_run(report: Path, tracks: list[pt.Track]) -> None:
    names = {path.name for path in report.iterdir()}
    assert {"index.html", "overlay.webm", "metadata.json", "scores.json", "track-1-joint.csv"} <= names
    metadata = json.loads((report / "metadata.json").read_text("utf-8"))
    assert metadata["pytracker"] == pt.__version__
    assert metadata["tracks"][0]["parameters"]["particles"] == 500
    assert set(metadata["recording"]["files"]) == {"recording.toml", "video.mp4", "imu.csv", "qualisys.tsv"}
    scores = json.loads((report / "scores.json").read_text("utf-8"))
    assert list(scores) == [*labels(tracks), HELD]
    assert scores["PF with constraint (joint), N = 500, bias, patch offset"]["joints"]["wrist"]["rms_m"] > 0


def test_track_csv_has_a_row_a_frame_and_reads_back(report: Path, tracks: list[pt.Track]) -> None:
    path = report / "track-1-joint.csv"
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(tracks[0].time_s)
    expected = ["time_s", "frame", "wrist_x_m", "wrist_y_m", "wrist_z_m", "wrist_x_sd_m"]
    assert list(rows[0])[:6] == expected
    assert list(rows[0])[-4:] == ["ess", "log_evidence", "valid", "reason"]
    assert rows[55]["valid"] == "0"
    assert rows[55]["reason"]
    back = read_track(path, tracks[0].camera)
    assert np.allclose(back.joints["elbow"].mean, tracks[0].joints["elbow"].mean, atol=1e-6)
    truth = tracks[0].recording.truth
    ours, again = pt.evaluate(tracks[0], truth), pt.evaluate(back, truth)
    assert again.joints["wrist"].rms_m == pytest.approx(ours.joints["wrist"].rms_m, abs=1e-6)
    assert again.valid_share == ours.valid_share


def test_overlay_is_a_video_of_the_recording(report: Path, tracks: list[pt.Track]) -> None:
    found = list(frames(report / "overlay.webm"))
    assert found[0].image.shape[1] == 480
    assert found[-1].time_s == pytest.approx(tracks[0].time_s[-1], abs=0.2)


def test_a_folder_is_written_whole_or_not_at_all(tracks: list[pt.Track], tmp_path: Path) -> None:
    out = tmp_path / "out"
    pt.write_report(tracks[:1], out, page=False)
    assert {path.name for path in out.glob("[!.]*")} == {"track.csv", "metadata.json", "scores.json"}
    with pytest.raises(pt.InputError, match="already exists, expected a new folder"):
        pt.write_report(tracks[:1], out)
    (out / "old").touch()
    with pytest.raises(pt.InputError, match="old was not written by pytracker, or was changed since"):
        pt.write_report(tracks[:1], out, force=True, page=False)
    (out / "old").unlink()
    pt.write_report(tracks[:1], out, force=True, page=False)
    assert {path.name for path in out.glob("[!.]*")} == {"track.csv", "metadata.json", "scores.json"}

    def fail(stage: str, done: int) -> None:
        raise RuntimeError(stage)

    with pytest.raises(RuntimeError):
        pt.write_report(tracks, tmp_path / "never", progress=fail)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    with pytest.raises(pt.InputError, match="no track"):
        pt.write_report([], tmp_path / "none")


def test_a_page_is_made_of_what_was_found(
    tracks: list[pt.Track], body: pt.BodyRecording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once it is known what a report is made of nothing is tracked again, and no evidence extracted."""
    arms = [track for track in tracks if isinstance(track, ArmTrack)]
    bodies = [pt.track(body, pt.BodyPlain(particles=20), 1)]
    of_arms, of_bodies = contents_of(arms), contents_of(bodies)

    def never(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr("pytracker.tracking.arm.Tracker", never)
    monkeypatch.setattr("pytracker.tracking.body.Tracker", never)
    monkeypatch.setattr("pytracker.evidence.picture.silhouette.Silhouette.__call__", never)
    assert "Edges and skin" in render_body_page(bodies, of_bodies, has_overlay=False)
    assert "Effective sample size" in render_arm_page(arms, of_arms, has_overlay=False)
    write_metadata(tmp_path / "metadata.json", of_arms)


def test_what_speaks_against_a_track_stands_above_it_and_by_its_method(tracks: list[pt.Track]) -> None:
    """Warnings were below all figures, and another method's as if they were of the recording."""
    contents = contents_of(tracks)
    others = [(), ("shared",), ("shared", "of this one"), ()]
    arms = [track for track in tracks if isinstance(track, ArmTrack)]
    said = dataclasses.replace(contents, doubts=[("shared",), *others[1:]])
    page = render_arm_page(arms, said, has_overlay=False)
    before, after = page.split("<h2>Comparison</h2>")
    assert "<h2>Warnings</h2>" in before
    assert before.count("<li>shared</li>") == 1
    assert "of this one" not in before
    assert f"<li>{contents.labels[2]}: of this one</li>" in after
    assert "shared" not in after
    none = dataclasses.replace(contents, doubts=[()] * len(tracks))
    assert "speaks against the other methods" not in render_arm_page(arms, none, has_overlay=False)


@pytest.mark.parametrize(
    ("method", "words"),
    [
        (pt.Smooth(), "to stay within ±8 cm of its place"),
        (pt.Smooth(shoulder_motion_sd_m=0.15), "to stay within ±31 cm of its place"),
        (pt.Mixture(), "to stay within ±4 cm of its place"),
        (pt.Ekf(corrections=("colour", "arm_length")), "not to move"),
        (pt.Joint(particles=50), "not to move"),
        (pt.Ekf(), ""),
    ],
    ids=["smooth", "leans", "mixture", "ekf", "joint", "unheld"],
)
def test_a_page_says_what_a_trunk_that_leans_does(method: ArmMethod, words: str) -> None:
    simulation = ArmSimulation(pt.ArmScene(duration_s=2.0), 3)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    track = pt.track(simulation.recording(), method, sightings=sightings)
    page = render_arm_page([track], contents_of([track]), has_overlay=False)
    assert ("hangs on the shoulder" in page) == bool(words)
    assert words in page


@pytest.mark.parametrize("is_right", [True, False])
def test_of_a_track_that_is_wrong_nothing_is_said_of_its_set_up(is_right: bool) -> None:
    """A page of frames that are none valid said that the camera's distance is -137 ± 5 cm off, told by the data."""
    simulation = ArmSimulation(pt.ArmScene(duration_s=4.0, worn=True), 3)
    sightings = pt.Sightings.of(simulation.frame_time_s, simulation.sightings(2.0))
    track = pt.track(simulation.recording(), pt.Smooth(), sightings=sightings)
    if not is_right:
        track = dataclasses.replace(track, valid=np.zeros(len(track.time_s), dtype=bool))
    page = render_arm_page([track], contents_of([track]), has_overlay=False)
    assert ("What the recording says of its set-up" in page) == is_right


@pytest.fixture(scope="module")
def body_report(body: pt.BodyRecording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    tracks = [pt.track(body, method, 1) for method in (pt.Partitioned(particles=100), pt.BodyPlain(particles=100))]
    return pt.write_report(tracks, tmp_path_factory.mktemp("report") / "body")


@pytest.mark.parametrize(("width", "scheme"), SIZES)
@pytest.mark.parametrize(("which", "figures", "rows"), [("report", 4, 5), ("body_report", 8, 3)])
def test_page_in_a_browser(
    browser: Browser, request: pytest.FixtureRequest, which: str, figures: int, rows: int, width: int, scheme: str
) -> None:
    """No error, every image drawn and described, no sideways scrolling, nothing fetched from elsewhere."""
    report: Path = request.getfixturevalue(which)
    page = opened(browser, report / "index.html", width, scheme)
    assert page.locator("img").count() == figures
    assert page.locator("table").first.locator("tbody tr").count() == rows  # the methods, and the first pose held
    page.close()


@pytest.mark.parametrize("which", ["report", "body_report"])
def test_overlay_plays_inside_the_page(browser: Browser, request: pytest.FixtureRequest, which: str) -> None:
    report: Path = request.getfixturevalue(which)
    page = browser.new_page()
    page.goto((report / "index.html").as_uri())
    played = page.evaluate(
        """async () => {
            const v = document.querySelector('video');
            v.muted = true;
            await v.play();
            await new Promise(done => setTimeout(done, 1000));
            return {time: v.currentTime, width: v.videoWidth, error: v.error};
        }"""
    )
    page.close()
    assert played["error"] is None
    assert played["width"] == 480
    assert played["time"] > 0.2


def test_page_prints_on_a4(browser: Browser, report: Path) -> None:
    page = browser.new_page()
    page.goto((report / "index.html").as_uri())
    pdf = page.pdf(format="A4")
    page.close()
    assert pdf.startswith(b"%PDF")
    assert 1 <= pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page/") + pdf.count(b"/Type /Page ") <= 6


def test_labels_are_told_apart(tracks: list[pt.Track]) -> None:
    assert labels([tracks[0], tracks[0]]) == [
        "PF with constraint (joint), N = 500, bias, patch offset, seed 1 [1]",
        "PF with constraint (joint), N = 500, bias, patch offset, seed 1 [2]",
    ]


def test_a_shared_recording_makes_tables(shared: Callable[[str], Path], tmp_path: Path) -> None:
    recording = load_arm(shared("recordings/arm-circle"))
    out = pt.write_report([pt.track(recording, pt.Layered(), 1)], tmp_path / "out", page=False)
    assert (out / "track.csv").stat().st_size > 50_000
