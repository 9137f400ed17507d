"""Tao & Hu (2008): the tables of the page, from the study's table."""

from __future__ import annotations

from pytracker.report.study.page import Section, Table
from pytracker.reproduce import printed
from pytracker.reproduce.tao_hu import METHODS, PATTERNS
from pytracker.reproduce.words import averaged, cm, comparison, share
from pytracker.study import StudyTable

__all__ = ["CLAIMS", "cloud_claims", "ordering", "parameters", "patterns", "rms", "table_i", "verdict"]

CLAIMS = (
    ("PF with constraint", "PF", "smaller"),
    ("PF with constraint", "EKF", "smaller"),
    ("PF with constraint", "Inertial only", "smaller"),
    ("PF", "EKF", "slightly smaller"),
    ("EKF", "Inertial only", "smaller"),
    ("EKF with constraint", "EKF", "–"),
    ("EKF with constraint", "PF with constraint", "–"),
    ("EKF, projected to the arm", "EKF", "–"),
    ("EKF, projected to the arm", "PF with constraint", "–"),
    ("PF, joint", "PF with constraint", "–"),
    ("PF, joint", "EKF with constraint", "–"),
)
"""Pairs of methods, and what the paper says of the error of the first."""


def rms(table: StudyTable, method: str, recording: str = "circle") -> list[float]:
    """3-D root mean square error of the wrist of every run, m."""
    return table.values("rms_m", recording=recording, method=METHODS[method], joint="wrist")


def verdict(table: StudyTable, first: str, second: str) -> str:
    """Whether the first method's error is `smaller`, `larger` or `not told apart` on the circle."""
    return comparison(rms(table, first), rms(table, second))[3]


def table_i(table: StudyTable) -> Section:
    """Table I, the printed numbers beside ours."""
    rows = []
    for name, method in METHODS.items():
        row = [name]
        for d, axis in enumerate("xyz"):
            in_print = printed.TABLE_I_CM.get(name)
            row.append("–" if in_print is None else f"{in_print[d][0]:g} / {in_print[d][1]:g}")
            mean, sd = (
                averaged(table.values(f"{what}_{axis}_m", recording="circle", method=method, joint="wrist"))
                for what in ("mean", "sd")
            )
            row.append(f"{cm(mean)} / {cm(sd)}")
        rows.append(row)
    header = ["mean error / standard deviation, cm"]
    header += [f"{axis}, {whose}" for axis in "xyz" for whose in ("paper", "ours")]
    return Section(
        "table-i",
        "Table I: error of each axis, circle",
        (
            "Mean error and standard deviation of the wrist within a run, averaged over the runs. Mean errors of either sign "
            "cancel over runs, in the paper's table as in ours; the root mean squares of the next section do not.",
        ),
        (Table("Circle: the paper's printed numbers beside ours", header, rows),),
    )


def ordering(table: StudyTable) -> Section:
    """What the paper says of pairs of methods, paired."""
    rows = []
    for first, second, claim in CLAIMS:
        ratio, difference, count, verdict = comparison(rms(table, first), rms(table, second))
        rows.append([f"{first} : {second}", claim, verdict, ratio, difference, count])
    words = [
        "3-D root mean square error of the wrist; both methods on the same recordings with the same seeds, run by run. The "
        "verdict is that of the ratio's interval: errors that drift run over orders of magnitude, where the difference "
        "is that of the worst run.",
    ]
    return Section(
        "ordering",
        "The ordering, paired",
        words,
        (
            Table(
                "Circle: the first method's error against the second's",
                ["pair", "paper: the first is", "ours: the first is", "ratio of errors (95 %)", "difference, cm",
                 "first smaller in"],
                rows,
            ),
        ),
    )  # fmt: skip


def patterns(table: StudyTable) -> Section:
    """Error, share within ±5 cm and coverage, pattern by pattern."""
    errors = [[name, *(cm(averaged(rms(table, name, pattern))) for pattern in PATTERNS)] for name in METHODS]
    within = [
        [
            name,
            *(
                share(averaged(table.values("within_5cm", recording=pattern, method=method, joint="wrist")))
                for pattern in PATTERNS
            ),
        ]
        for name, method in METHODS.items()
    ]
    coverage = [
        [
            name,
            *(
                share(
                    *(
                        averaged(table.values(f"coverage_{axis}", recording=p, method=method, joint="wrist"))
                        for axis in "xyz"
                    )
                )
                for p in PATTERNS
            ),
        ]
        for name, method in METHODS.items()
    ]
    return Section(
        "patterns",
        "Circle, rectangle, reaching",
        (
            "IV-C says that errors with the constraint were mainly within ±5 cm. A frame counts as within where all three "
            "axes are. The paper states no error bars; ours should hold the truth in 95 % of the frames.",
        ),
        (
            Table("3-D root mean square error of the wrist, cm", ["method", *PATTERNS], errors),
            Table("Share of frames within ±5 cm", ["method", *PATTERNS], within),
            Table("Share of frames whose 95 % band holds the truth (x, y, z)", ["method", *PATTERNS], coverage),
        ),
    )


def parameters() -> Section:
    """With what the methods ran."""
    rows = []
    for name, method in METHODS.items():
        default = type(method)()
        given = {key: value for key, value in method.parameters().items() if value != getattr(default, key)}
        words = ", ".join(f"{key} = {value}" for key, value in given.items()) or "its defaults"
        particles = method.sample_size
        rows.append([name, type(method).__name__, "–" if particles is None else f"{particles}",
                     "yes" if method.bias else "no", f"{method.accel_density:g}", words])  # fmt: skip
    return Section(
        "methods",
        "The methods",
        (
            "Every method with what did best for it on circles of other seeds: the Kalman filters and the joint filter gain "
            "from estimating the accelerometer's bias, the filters of 500 particles do not, a state of nine dimensions being "
            "too much for them.",
        ),
        (
            Table(
                "Parameters",
                [
                    "method",
                    "class",
                    "particles",
                    "bias estimated",
                    "process noise, m/s/√s",
                    "not at its class's default",
                ],
                rows,
            ),
        ),
    )


def cloud_claims(table: StudyTable) -> Section:
    """IV-B, claims 2 and 3."""
    columns = {"ess_share": "effective sample size, share of the particles", "spread_m": "spread of the cloud, cm"}
    rows = []
    for column, words in columns.items():
        with_it, without = (
            table.values(column, recording="circle", method=METHODS[name], joint="wrist")
            for name in ("PF with constraint", "PF")
        )
        show = share if column == "ess_share" else cm
        ratio, _, count, change = comparison(with_it, without)
        rows.append([words, show(averaged(without)), show(averaged(with_it)), ratio, count, change])
    return Section(
        "cloud-claims",
        "Effective particles and spread, with and without the constraint (IV-B)",
        (
            "IV-B claims that with the constraint more particles are effective, and that they are spread more widely and "
            "evenly. Effective sample size is 1 / Σ w² before the last resampling, averaged over a run; spread is the root "
            "mean square distance of the wrist's cloud from its middle. The last column says what became of each with the "
            "constraint. A cloud that drifts along the viewing ray is wide without being right: the two layers also count "
            "their effective particles differently, colour having been resampled away before the length weighs.",
        ),
        (
            Table(
                "Circle, 500 particles",
                ["of the clouds", "without", "with", "ratio (95 %)", "smaller with it in", "with the constraint"],
                rows,
            ),
        ),
    )
