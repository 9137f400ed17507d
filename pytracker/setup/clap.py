"""The clock of an IMU from claps, taps or jumps: frames in which hands or feet met, and the blows that the sensor felt.

An alternative to the clock that `check` finds by movement, for who moves too little or repeats it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pytracker._core import InputError
from pytracker.formats.video_times import frame_times
from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.rotation import Array
from pytracker.setup.checks.findings import Finding
from pytracker.setup.checks.imu import read_log
from pytracker.setup.draft import Draft

__all__ = ["Claps", "clock_by_claps", "find_claps"]

ESTIMATED = {"arm": ("imu",)}
"""Sensors whose clock is estimated from what is given and its spread; of others it is taken as it is given."""
WINDOW_S = 0.3
"""A blow is shorter than half of it, a movement longer."""
APART_S = 0.1
"""Between two blows; a hand that springs back is none."""
LEAST_BLOW = 5.0
"""m/s² beside what was felt just before and after."""
CLEAR = 4.0
"""Times as hard as the next that it might be, a blow is told from it."""
SLACK_S = 0.05
"""Frames that were picked by eye are so far off, beside the step between them."""
LEAST_SD_S = 0.02
"""So long do two hands meet."""
AT_ONCE = 4096
"""Samples of which each has its median: their windows are copied."""
MOST_BLOWS = 200
"""The hardest; claps are among them."""
NAMED = 6
"""So many blows are named where it is not told which of them it was."""


@dataclass(frozen=True, eq=False)
class Claps:
    """Claps that both saw.

    Attributes:
        offset_s: recording time = IMU time + offset.
        offset_sd_s: how well it is known.
        blow_s: IMU time of each, s `(N,)`.
        hard: how hard each was, m/s² `(N,)`.
    """

    offset_s: float
    offset_sd_s: float
    blow_s: Array
    hard: Array


def clock_by_claps(folder: Path | str, numbers: Sequence[int], imu: int = 0) -> Claps:
    """The clock of sensor `imu` by the first camera's first frames in which hands touch, put into recording.toml.

    Raises `InputError` where the frames or the sensor's file are not there, or it is not told which blows they were.
    """
    draft = Draft(Path(folder))
    video = draft.file("camera.video")
    if video is None:
        raise InputError(f"{draft.path}: camera[0].video is missing, expected the video in which the claps are seen")
    time_s = frame_times(video)
    for number in numbers:
        if not 0 <= number < len(time_s):
            raise InputError(f"{video}: has frames 0 to {len(time_s) - 1}, expected one numbered {number}")
    table = f"imu[{imu}]" if imu else "imu"
    file = draft.file(f"{table}.file")
    if file is None:
        raise InputError(f"{draft.path}: {table}.file is missing, expected the sensor's")
    log = read_log(draft, table, file)
    if isinstance(log, Finding):
        raise InputError(log.evidence)
    if log.acc is None or not np.isfinite(log.acc).any():
        raise InputError(f"{file}: has no acceleration, expected one: claps are told by it")
    if np.isfinite(log.acc).all(axis=1).sum() < 2:
        raise InputError(f"{file}: has acceleration in one row, expected a recording of it")
    log = log.kept(np.asarray(np.isfinite(log.acc).all(axis=1)))
    drift = 1e-6 * float(draft.get(f"{table}.drift_ppm") or 0.0)
    log = replace(log, time_s=log.time_s + drift * (log.time_s - log.time_s[0]))
    step_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    start_s = float(draft.get("camera.start_s") or 0.0)
    try:
        found = find_claps(start_s + time_s[np.unique(numbers)], log, step_s)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    draft.set(f"{table}.offset_s", round(found.offset_s, 4))
    if table in ESTIMATED.get(draft.kind, ()):
        draft.set(f"{table}.offset_sd_s", round(found.offset_sd_s, 4))
    draft.save()
    return found


def find_claps(clap_s: Array, log: ImuLog, step_s: float) -> Claps:
    """Which blows of a log are claps at recording times `(N,)`, s, of the first frames, `step_s` apart, that show them.

    Several must come at the same intervals. Raises `InputError` where none do, or others as well.
    """
    if not len(clap_s):
        raise InputError("has no claps, expected the time of one at least")
    blow_s, hard = _blows(log)
    slack_s = SLACK_S + step_s
    sets = [near for first in blow_s if (near := _along(clap_s - clap_s[0] + first, blow_s, slack_s)) is not None]
    if not sets:
        between = ", ".join(f"{b - a:.2f}" for a, b in pairwise(clap_s))
        asked = f"{len(clap_s)} blows that are {between} s apart, each" if between else "blow"
        raise InputError(
            f"the sensor felt no {asked} of {LEAST_BLOW:g} m/s², expected the claps that were seen: "
            f"clap, tap or jump harder{_named(blow_s, hard)}"
        )
    weakest = np.array([hard[near].min() for near in sets])
    order = np.argsort(-weakest)
    best = sets[order[0]]
    if len(order) > 1 and weakest[order[0]] < CLEAR * weakest[order[1]]:
        raise InputError(
            f"a blow at {blow_s[best[0]]:.2f} s and one at {blow_s[sets[order[1]][0]]:.2f} s may both be it, "
            f"expected one {CLEAR:g} times as hard as any other: name the frames of three claps{_named(blow_s, hard)}"
        )
    # The first frame in which hands touch comes half a step later, on average.
    offset_s = float(np.mean(clap_s - blow_s[best])) - step_s / 2
    sd_s = max(LEAST_SD_S, float(np.ptp(clap_s - blow_s[best])) / 2, step_s / 2)
    return Claps(offset_s, sd_s, blow_s[best], hard[best])


def _blows(log: ImuLog) -> tuple[Array, Array]:
    """Times and sizes of what is felt for a moment only, the hardest first, s and m/s² `(N,)`."""
    assert log.acc is not None
    norm = np.linalg.norm(log.acc, axis=1)
    norm *= GRAVITY / max(float(np.median(norm)), 1e-9)  # whatever its unit
    half = max(1, round(WINDOW_S / 2 / float(np.median(np.diff(log.time_s)))))
    windows = sliding_window_view(np.pad(norm, half, mode="edge"), 2 * half + 1)
    around = np.concatenate([np.median(windows[k : k + AT_ONCE], axis=1) for k in range(0, len(norm), AT_ONCE)])
    felt = np.abs(norm - around)
    before, after = np.pad(felt, (1, 0))[:-1], np.pad(felt, (0, 1))[1:]
    peaks = np.flatnonzero((felt >= LEAST_BLOW) & (felt >= before) & (felt > after))
    blows: list[int] = []
    for k in peaks[np.argsort(-felt[peaks], kind="stable")]:
        if (np.abs(log.time_s[blows] - log.time_s[k]) >= APART_S).all():  # else it is a harder one's echo
            blows.append(int(k))
        if len(blows) == MOST_BLOWS:
            break
    return log.time_s[blows], felt[blows]


def _along(wanted_s: Array, blow_s: Array, slack_s: float) -> list[int] | None:
    """The blow nearest to each time; None where there is none within the slack."""
    near = [int(np.argmin(np.abs(blow_s - time_s))) for time_s in wanted_s]
    is_each = len(set(near)) == len(near)
    return near if is_each and (np.abs(blow_s[near] - wanted_s) <= slack_s).all() else None


def _named(blow_s: Array, hard: Array) -> str:
    """The hardest, in words."""
    felt = [f"{size:.0f} m/s² at {time_s:.2f} s" for time_s, size in zip(blow_s[:NAMED], hard[:NAMED], strict=True)]
    return f" (felt: {', '.join(felt)})" if felt else ""
