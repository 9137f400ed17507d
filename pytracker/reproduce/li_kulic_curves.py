"""Li & Kulić (2010): the curves and tables of the page, from the study's table."""

from __future__ import annotations

import numpy as np

from pytracker._core import KEY_JOINTS
from pytracker.methods.body import BodyMethod
from pytracker.report.page import embedded
from pytracker.report.study.figures import curve, joint_intervals
from pytracker.report.study.page import Section, Table
from pytracker.reproduce import printed
from pytracker.reproduce.li_kulic import ALPHAS, COUNTS, PAPER, RUNS, SHIPPED, with_alpha, with_particles
from pytracker.reproduce.words import averaged, cm, comparison, plain_number
from pytracker.scores.intervals import paired_difference
from pytracker.study import StudyTable

__all__ = ["cue_weights", "error_of", "gains", "joints", "of_recordings", "particles", "shipped"]


def error_of(table: StudyTable, method: BodyMethod) -> list[float]:
    """Overall average error of every recording, m."""
    return of_recordings(table, "average_m", method)


def of_recordings(table: StudyTable, column: str, method: BodyMethod, joint: str = "all") -> list[float]:
    """A column of every recording: the mean of its runs that have one; NaN where none has."""
    runs = np.array(table.values(column, method=method, joint=joint)).reshape(-1, RUNS)
    known = np.isfinite(runs)
    with np.errstate(invalid="ignore"):
        return [float(x) for x in np.where(known, runs, 0.0).sum(axis=1) / known.sum(axis=1)]


def gains(table: StudyTable) -> tuple[str, str, str]:
    """From 10 to 300 particles and from 300 to 3 000, cm, and the second's share of the first, where both are gains."""
    few, paper, many = (error_of(table, with_particles(n)) for n in (10, 300, 3000))
    first, second = paired_difference(few, paper), paired_difference(paper, many)
    both = first.low > 0 and second.low > 0
    share = f": {plain_number(second.value / first.value)} of the first" if both else ""
    none = " (not told apart from none)"
    words = [f"{cm(gain)} cm" + ("" if gain.low > 0 else none) for gain in (first, second)]
    return words[0], words[1], share


def particles(table: StudyTable) -> Section:
    """Fig. 5."""
    intervals = [averaged(error_of(table, with_particles(n))) for n in COUNTS]
    rows = [
        [f"{n}", f"{printed.FIG_5_CM[n]:g}" if n in printed.FIG_5_CM else "–", cm(interval)]
        for n, interval in zip(COUNTS, intervals, strict=True)
    ]
    first, second, share = gains(table)
    return Section(
        "particles",
        "Fig. 5: error against the number of particles",
        (
            f"Gain from 10 to 300 particles: {first}; from 300 to 3 000: {second}{share} (paired: the same recordings and "
            "seeds). The paper: 11 cm and 0.1 cm on its one recording.",
        ),
        (Table("Overall average error, cm", ["particles", "paper", "ours"], rows),),
        (
            embedded(
                "Fig. 5: overall average error against the number of particles.",
                "Curve of the error against 10 to 3000 particles, with intervals and the paper's numbers",
                curve(COUNTS, intervals, printed.FIG_5_CM, "number of particles", is_log=True),
            ),
        ),
    )


def joints(table: StudyTable) -> Section:
    """Fig. 7."""
    of = {
        column: [averaged(of_recordings(table, column, PAPER, joint)) for joint in KEY_JOINTS]
        for column in ("average_m", "average_sd_m")
    }
    rows = [
        [joint.replace("_", " "), cm(mean), cm(sd)]
        for joint, mean, sd in zip(KEY_JOINTS, of["average_m"], of["average_sd_m"], strict=True)
    ]
    return Section(
        "joints",
        "Fig. 7: error of the joints",
        ("In the paper small at root, head and shoulders, larger along the arms, where the depth is missing.",),
        (Table("Joint average error, cm", ["joint", "average", "standard deviation"], rows),),
        (
            embedded(
                "Fig. 7: joint average error and its standard deviation.",
                "Bars of the average error and its standard deviation for eight joints, from root to wrists",
                joint_intervals(KEY_JOINTS, of["average_m"], of["average_sd_m"]),
            ),
        ),
    )


def cue_weights(table: StudyTable) -> Section:
    """Fig. 8."""
    intervals = [averaged(error_of(table, with_alpha(alpha))) for alpha in ALPHAS]
    equal = error_of(table, with_alpha(1.0))
    rows = []
    for alpha, interval in zip(ALPHAS, intervals, strict=True):
        against = "–"
        if alpha != 1.0:
            difference = paired_difference(error_of(table, with_alpha(alpha)), equal)
            against = cm(difference)
        rows.append([f"{alpha:g}", cm(interval), against])
    return Section(
        "alpha",
        "Fig. 8: error against the weight of the edge cue",
        (
            "alpha weighs the edges, 2 - alpha the blobs of skin. In the paper's figure the error is smallest at 1; it prints "
            "no numbers. Where the difference's interval holds 0, the two weights are not told apart here; each interval is for "
            "itself, not corrected for their number.",
        ),
        (Table("Overall average error, cm", ["alpha", "error", "difference to alpha = 1, paired"], rows),),
        (
            embedded(
                "Fig. 8: overall average error against alpha.",
                "Curve of the error against the weight of the edge cue from 0.2 to 1.8, with intervals",
                curve(ALPHAS, intervals, {}, "alpha, weight of the edge cue"),
            ),
        ),
    )


def shipped(table: StudyTable) -> Section:
    """Not in the paper: what the package offers besides."""
    rows = []
    for name, method in SHIPPED.items():
        cells = ["–"] * 4 if method is PAPER else list(comparison(error_of(table, method), error_of(table, PAPER)))
        rows.append([name, cm(averaged(error_of(table, method))), *cells])
    header = ["method, 300 particles a layer", "error, cm", "ratio to the paper's (95 %)", "difference, cm", "smaller in",
              "against the paper's"]  # fmt: skip
    return Section(
        "methods",
        "Other lists of layers on the same cues",
        ("Not in the paper. Same recordings and seeds, paired.",),
        (Table("Overall average error", header, rows),),
    )
