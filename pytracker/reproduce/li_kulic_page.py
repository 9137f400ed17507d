"""Li & Kulić (2010): the page. Averages come from the study's table, pictures from the recording of seed 1."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from pytracker.recording.load import load
from pytracker.recording.recording import BodyRecording
from pytracker.report.study.page import Section, render_study_page
from pytracker.reproduce import printed
from pytracker.reproduce.endings import endings, tracked
from pytracker.reproduce.li_kulic import ALPHAS, METHODS, PAPER, RUNS, with_alpha
from pytracker.reproduce.li_kulic_curves import cue_weights, error_of, gains, joints, of_recordings, particles, shipped
from pytracker.reproduce.li_kulic_pictures import evidence, frames_shown, over_frames, projection, rate
from pytracker.reproduce.words import averaged, cm
from pytracker.scores.intervals import paired_difference
from pytracker.simulate import BodyScene, simulate_body
from pytracker.study import StudyTable
from pytracker.tracking.track import track

__all__ = ["make_page"]

RUNS_OF_FIG_6 = 10


def make_page(table: StudyTable, seeds: int, duration_s: float) -> str:
    """The page as text."""
    with tempfile.TemporaryDirectory() as scratch:
        recording = load(simulate_body(Path(scratch) / "person", BodyScene(duration_s=duration_s), seed=1))
        assert isinstance(recording, BodyRecording)
        began = time.perf_counter()
        tracks = [track(recording, PAPER, 1)]
        took_s = time.perf_counter() - began
        others = (tracked(recording, PAPER, seed)[0] for seed in range(2, RUNS_OF_FIG_6 + 1))
        tracks += [found for found in others if found is not None]
        return render_study_page(
            title="Li & Kulić (2010), run again",
            lead=f"{seeds} simulated recordings, each tracked {RUNS} times · ± is the 95 % interval of a mean over them (Student's t)",
            summary=_summary(table, len(tracks[0].time_s) / took_s),
            sections=[
                _differences(duration_s),
                projection(recording, tracks[0]),
                evidence(tracks[0]),
                particles(table),
                over_frames(tracks),
                joints(table),
                cue_weights(table),
                shipped(table),
                frames_shown(tracks[0]),
                rate(tracks[0], took_s),
                endings(table, METHODS, {"all recordings": [f"person {k + 1}" for k in range(seeds)]}),
            ],
            source=(
                "Z. Li, D. Kulić: Particle Filter Based Human Motion Tracking, International Conference on Control, "
                "Automation, Robotics and Vision (ICARCV), 2010."
            ),
        )


def _summary(table: StudyTable, rate_hz: float) -> str:
    first, second, share = gains(table)
    spread = averaged(of_recordings(table, "average_sd_m", PAPER))
    best = min(ALPHAS, key=lambda alpha: averaged(error_of(table, with_alpha(alpha))).value)
    against = paired_difference(error_of(table, with_alpha(best)), error_of(table, with_alpha(1.0)))
    alpha = (
        "The smallest error over the weights of the cues is at equal weights (alpha = 1), as in the paper."
        if best == 1.0
        else f"The smallest error of nine weights of the cues is at alpha = {best:g}, {cm(against)} cm from that of the paper's 1."
    )
    return (
        f"With 300 particles the eight joints are {cm(averaged(error_of(table, PAPER)))} cm off on average (paper: "
        f"{printed.FIG_5_CM[300]:g} cm; standard deviation {cm(spread)} cm, paper {printed.FIG_5_SD_CM:g} cm). The gain from 10 to 300 particles is {first} (paper: "
        f"{printed.FIG_5_CM[10] - printed.FIG_5_CM[300]:g}), that from 300 to 3 000 {second} (paper: "
        f"{printed.FIG_5_CM[300] - printed.FIG_5_CM[3000]:.1f}){share}. {alpha} A frame takes {1000 / rate_hz:.1f} ms, {rate_hz:.0f} frames a second against the paper's "
        f"{printed.RATE_HZ}."
    )


def _differences(duration_s: float) -> Section:
    return Section(
        "differences",
        "What differs from the paper in kind",
        (
            "The paper tracked one recording of the CMU database, “little tea pot”, with Vicon's motion as the truth, ten "
            f"times. Here there are many recordings, each tracked {RUNS} times: {duration_s:g} s, 320x240 at 30 frames/s, a person who moves "
            "both arms from pose to pose, "
            "in one of six sets of clothes, before a textured wall, with image noise; the skeleton is the package's average "
            "one, and the truth is known exactly. So the intervals are over motions and clothes, not only over the filter's "
            "chance, and the errors are those of larger and faster motion, with both arms often pointing at the camera.",
            "The paper gives neither A of the weighting function, nor the diffusion, nor the outer shape's widths, nor the "
            "thresholds of its image processing; ours are written down as defaults of BodyPlain and SilhouetteParameters and "
            "were chosen on recordings of seeds from 101 on. All joints of the person move, 11 of them are tracked, as in the "
            "paper. The background image is given.",
        ),
    )
