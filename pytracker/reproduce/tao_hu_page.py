"""Tao & Hu (2008): the page. Averages come from the study's table, pictures from runs of seed 1."""

from __future__ import annotations

from pytracker.report.study.page import Section, render_study_page
from pytracker.reproduce.endings import endings
from pytracker.reproduce.tao_hu import METHODS, PATTERNS, PIXEL_SD, VIDEO
from pytracker.reproduce.tao_hu_pictures import clouds, from_video, over_time, within_80_frames
from pytracker.reproduce.tao_hu_tables import (
    CLAIMS,
    cloud_claims,
    ordering,
    parameters,
    patterns,
    rms,
    table_i,
    verdict,
)
from pytracker.reproduce.words import averaged, cm, than
from pytracker.study import StudyTable

__all__ = ["make_page"]


def make_page(table: StudyTable, seeds: int, duration_s: float) -> str:
    """The page as text."""
    return render_study_page(
        title="Tao & Hu (2008), run again",
        lead=f"{seeds} simulated runs of every pattern · ± is the 95 % interval of a mean over the runs (Student's t)",
        summary=_summary(table),
        sections=[
            _differences(duration_s),
            table_i(table),
            ordering(table),
            patterns(table),
            over_time(duration_s),
            within_80_frames(seeds, duration_s),
            clouds(duration_s),
            cloud_claims(table),
            from_video(table),
            parameters(),
            endings(table, METHODS, {name: [name] for name in (*PATTERNS, VIDEO)}),
        ],
        source=(
            "Y. Tao, H. Hu: A Novel Sensing and Data Fusion System for 3-D Arm Motion Tracking in Telerehabilitation, "
            "IEEE Transactions on Instrumentation and Measurement 57(5), 2008."
        ),
    )


def _summary(table: StudyTable) -> str:
    """What holds and what does not, from the numbers."""
    constraint, plain = averaged(rms(table, "PF with constraint")), averaged(rms(table, "PF"))
    words = (
        f"On the simulated circle the particle filter with the arm-length constraint is {cm(constraint)} cm off (3-D root "
        f"mean square of the wrist), without it {cm(plain)} cm. "
    )
    holds, fails = [], []
    for first, second, claim in CLAIMS:
        if claim == "–":
            continue
        found = verdict(table, first, second)
        if claim.endswith(found):
            holds.append(f"{first} better than {second}")
        else:
            fails.append(f"{first} better than {second} (here {found})")
    words += f"Of the paper's ordering these hold: {'; '.join(holds) or 'none'}. "
    words += f"These do not: {'; '.join(fails) or 'none'}. "
    gain = verdict(table, "EKF with constraint", "EKF")
    against = verdict(table, "EKF with constraint", "PF with constraint")
    return words + (
        f"Given the same constraint, the extended Kalman filter's error is {than(gain)} without it, and {than(against)} that of "
        "the paper's particle filter with it."
    )


def _differences(duration_s: float) -> Section:
    return Section(
        "differences",
        "What differs from the paper in kind",
        (
            f"The paper filmed one subject with a Qualisys system as the truth; here the arm, the IMU and the camera are "
            f"simulated for {duration_s:g} s a run, and the truth is known exactly. World: x right, y away from the subject, "
            "z up; the camera faces the subject from 30° above, so that its viewing direction, the depth, lies in y and z. "
            "The paper does not say how its axes lie to its camera.",
            "The paper gives no process noise for the inertial motion, no number of repetitions, no frame rate and no "
            "time of a turn; here 25 frames/s, an IMU of 100 Hz, a turn in 4 s, and the process noise of every method tuned "
            "on circles of other seeds. Accelerometer noise 0.03 m/s², bias 0.1 m/s², orientation error 1° RMS, patch seen "
            f"with {PIXEL_SD:g} px noise, as eq. (11) has it. Under “From pixels” the patch is found by Camshift in "
            "rendered video instead.",
            "The length residual of eq. (15) is taken in metres, not squared metres. “EKF, projected to the arm” is the "
            "authors' earlier method (III-E): the arm's length applied after the filter. “EKF with constraint” takes the "
            "length as a measurement, “PF, joint” weighs colour and length in one layer (5 000 particles, bias estimated): "
            "neither is in the paper.",
        ),
    )
