"""Tao & Hu (2008): what the page draws and times: runs over time, particle clouds, video."""

from __future__ import annotations

import numpy as np

from pytracker.evidence.sightings import Sightings
from pytracker.formats.video import frames
from pytracker.recording.recording import ArmRecording
from pytracker.report.arm import figures as arm_figures
from pytracker.report.arm.overlay import draw_arm
from pytracker.report.cycles.figures import one_cycle, snapshots
from pytracker.report.page import embedded
from pytracker.report.study.figures import sheet
from pytracker.report.study.page import Section, Table
from pytracker.reproduce import printed
from pytracker.reproduce.endings import tracked
from pytracker.reproduce.tao_hu import METHODS, PATTERNS, PIXEL_SD, VIDEO, scene
from pytracker.reproduce.tao_hu_tables import rms
from pytracker.reproduce.words import averaged, cm, share
from pytracker.rotation import Array
from pytracker.simulate import ArmScene
from pytracker.study import StudyRecording, StudyTable
from pytracker.study.execute import open_source
from pytracker.tracking.cycle import Cycle, record_cycle
from pytracker.tracking.track import track

__all__ = ["clouds", "from_video", "over_time", "within_80_frames"]

FRAMES_OF_FIG_7 = 80
FRAMES_OF_FIG_10 = (10, 20, 30, 40)
SHOWN = ("PF with constraint", "PF", "EKF", "EKF with constraint")
"""In the figures over time; the paper's three, and what the constraint gives the EKF."""


def within_80_frames(seeds: int, duration_s: float) -> Section:
    """The largest errors of Fig. 7, on the circles of the study."""
    names = ("EKF", "PF", "PF with constraint")
    largest: dict[str, list[Array]] = {name: [] for name in names}
    for seed in range(1, seeds + 1):
        recording, sightings = recording_of(scene("circle", duration_s), seed)
        first = Sightings.of(sightings.time_s[:FRAMES_OF_FIG_7], sightings.pixels[:FRAMES_OF_FIG_7])
        for name in names:
            found, _ = tracked(recording, METHODS[name], seed, first)
            if found is not None:
                assert recording.truth is not None
                error = found.joints["wrist"].mean - recording.truth.at("wrist", found.time_s)
                largest[name].append(np.nanmax(np.abs(error), axis=0))
    rows = []
    for name in names:
        each = np.array(largest[name])
        ours = [cm(averaged(each[:, d].tolist())) for d in range(3)]
        rows.append([name, *(cell for pair in zip(printed.WORST_AT_80_CM[name], ours, strict=True) for cell in pair)])
    header = ["largest error, cm"] + [f"{axis}, {whose}" for axis in "xyz" for whose in ("paper", "ours")]
    return Section(
        "eighty",
        f"How far it goes within {FRAMES_OF_FIG_7} frames (IV-A, Fig. 7)",
        ("The paper reads these off one recording; ours is the mean over the runs of each run's largest error.",),
        (Table(f"Circle, first {FRAMES_OF_FIG_7} frames", header, rows),),
    )


def from_video(table: StudyTable) -> Section:
    """The same from pixels; the time that a frame takes."""
    rows = []
    for name, method in METHODS.items():
        values = {c: table.values(c, recording=VIDEO, method=method, joint="wrist") for c in ("rms_m", "within_5cm")}
        rows.append([name, cm(averaged(rms(table, name))), cm(averaged(values["rms_m"])),
                     share(averaged(values["within_5cm"]))])  # fmt: skip
    source = open_source(StudyRecording(name=VIDEO, scene=ArmScene(duration_s=4.0)), 1)
    recording = source.recording
    assert isinstance(recording, ArmRecording)
    tracks = [track(recording, METHODS["PF with constraint"], 1, sightings=source.sightings) for _ in range(5)]
    whole = track(recording, METHODS["PF with constraint"], 1)
    view = recording.views[0]
    assert view.video is not None
    assert recording.truth is not None
    shown = [draw_arm(f.image, whole, f.index) for f in frames(view.video) if f.index % 24 == 12]
    off_px = whole.sightings.pixels[:, 0] - view.camera.project(recording.truth.at("wrist", whole.time_s))
    rms_px = float(np.sqrt(np.nanmean(off_px**2)))
    count = len(whole.time_s)
    filter_ms = 1000 * min(t.stage_s["filter"] for t in tracks) / count
    camshift_ms = 1000 * whole.stage_s["evidence"] / count
    ratio = printed.TIME_PER_FRAME_S * 1000 / (filter_ms + camshift_ms)
    return Section(
        "video",
        "From pixels, and how long it takes",
        (
            f"The same circles rendered as video and followed by Camshift: the patch is found {rms_px:.1f} px off the wrist (root "
            f"mean square per axis, seed 1), where the methods assume {PIXEL_SD:g} px.",
            f"Time per frame with 500 particles and the constraint: {filter_ms:.3f} ms for the filter and {camshift_ms:.1f} "
            f"ms for decoding and Camshift, on the machine that made this page; the paper's Pentium 4 took "
            f"{1000 * printed.TIME_PER_FRAME_S:.0f} ms. That is about {ratio:.0f} times faster. Times are of this run of the "
            "page and are compared with nothing else.",
        ),
        (
            Table(
                "Circle: wrist, 3-D root mean square error, cm",
                ["method", f"{PIXEL_SD:g} px noise", "Camshift on video", "within ±5 cm (video)"],
                rows,
            ),
        ),
        (
            embedded(
                "Four frames of the rendered circle of seed 1. Red cross: patch as seen. Blue: tracked arm. Light ellipse: "
                "95 % of the wrist.",
                "Rendered frames of an arm at a table with the tracked arm drawn over it",
                sheet(shown[:4], 2),
            ),
        ),
    )


def recording_of(of: ArmScene, seed: int) -> tuple[ArmRecording, Sightings]:
    """As the study has it."""
    source = open_source(StudyRecording(name=of.pattern, scene=of, pixel_sd=PIXEL_SD), seed)
    assert isinstance(source.recording, ArmRecording)
    assert source.sightings is not None
    return source.recording, source.sightings


def over_time(duration_s: float) -> Section:
    """Figs. 6, 7 and 8."""
    recording, sightings = recording_of(scene("circle", duration_s), 1)
    runs = {name: tracked(recording, METHODS[name], 1, sightings) for name in SHOWN}
    shown = {name: found for name, (found, _) in runs.items() if found is not None}
    names, tracks = list(shown), list(shown.values())
    lost = [f"{name}: {words}." for name, (_, words) in runs.items() if words]
    paths = []
    for name in PATTERNS:
        there, seen = recording_of(scene(name, duration_s), 1)
        found, _ = tracked(there, METHODS["PF with constraint"], 1, seen)
        if found is None:
            continue
        paths.append(
            embedded(
                f"Fig. 8: {name} in space, PF with constraint and truth.",
                f"Path of the wrist in space, {name}: the tracked and the true one",
                arm_figures.path_3d([found], ["PF with constraint"]),
                is_wide=False,
            )
        )
    return Section(
        "over-time",
        "Figs. 6, 7, 8: one run over time",
        (
            "The circle of seed 1. What leaves the frame has run away: without the constraint nothing holds the depth. "
            "The paper shows 80 frames; here all are shown.",
            *lost,
        ),
        (),
        (
            embedded(
                "Fig. 6: wrist per axis.",
                "Wrist position per axis over time by several methods, with the band of the first and the truth",
                arm_figures.trajectories(tracks, names),
            ),
            embedded(
                "Fig. 7: error per axis, with lines at ±5 cm.",
                "Error per axis over time by several methods, with lines at plus and minus five centimetres",
                arm_figures.errors(tracks, names),
            ),
            *paths,
        ),
    )


def clouds(duration_s: float) -> Section:
    """Figs. 9, 10 and 11."""
    recording, sightings = recording_of(scene("circle", duration_s), 1)

    def cycle(name: str, frame: int) -> Cycle:
        return record_cycle(recording, METHODS[name], 1, frame=frame, sightings=sightings)

    rows = [[cycle(name, frame) for frame in FRAMES_OF_FIG_10] for name in ("PF", "PF with constraint")]
    return Section(
        "clouds",
        "Figs. 9, 10, 11: particle clouds",
        (
            "Seen in the plane that holds the viewing ray and the middle of the sphere on which the arm's length holds "
            "the wrist. Colour draws the cloud to the ray, length to the sphere; they meet in two places, and the cloud "
            "may be in either. The paper draws the clouds in space; the plane shows the same, and why.",
        ),
        (),
        (
            embedded(
                "Fig. 9: one cycle of the layered filter at frame 40, from the prior (1a) to the set that the next frame "
                "starts from (2d).",
                "Particle clouds of one filter cycle: prior, predicted, weighed and resampled, once for colour and once for "
                "the arm's length",
                one_cycle(cycle("PF with constraint", FRAMES_OF_FIG_10[-1])),
            ),
            embedded(
                "Figs. 10 and 11: posteriors at frames 10 to 40, above without, below with the constraint.",
                "Particle clouds at four frames beside viewing ray and sphere, without and with the constraint",
                snapshots(rows, ["PF", "PF with constraint"]),
            ),
        ),
    )
