"""One run of a study: a recording tracked and scored, as rows for the table. Pure: the same run gives the same rows."""

from __future__ import annotations

import functools
import math
import shutil
import tempfile
import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError, TrackingError
from pytracker.doubting.doubts import unbelieved
from pytracker.evidence.observations import shared_sightings
from pytracker.evidence.sightings import Sightings
from pytracker.recording.load import load
from pytracker.recording.recording import Recording
from pytracker.scores.agreement import against_truth
from pytracker.scores.evaluate import evaluate, held
from pytracker.simulate import ArmScene, ArmSimulation, simulate_arm, simulate_body
from pytracker.study.fingerprint import fingerprint
from pytracker.study.plan import Run, StudyRecording
from pytracker.tracking.track import track
from pytracker.tracking.tracks import Track

__all__ = ["COLUMNS", "OTHER_BUILD", "Result", "Row", "Source", "execute", "execute_anywhere", "failed", "open_source"]

AXES = "xyz"
TRIPLES = {"mean": "mean_m", "sd": "sd_m", "coverage": "coverage", "half_width": "half_width_m"}
SINGLES = (
    "frames", "rms_m", "median_m", "across_m", "depth_m", "lost_share",
    "average_m", "average_sd_m", "worst_m", "within_5cm",
)  # fmt: skip
COLUMNS = (
    "joint", *SINGLES,
    *(f"{name}_{axis}" + ("" if name == "coverage" else "_m") for name in TRIPLES for axis in AXES),
    "held_m", "spread_m", "ess_share", "valid_share",
)  # fmt: skip
"""What a row says of a joint; of `all` joints where it stands for all. Empty where there is no value.

`held_m` is the error of the first pose, held: a joint's RMS as `rms_m`, of all of them as `average_m`.
"""

SIMULATE: Mapping[str, Callable[[Path, Any, int], Path]] = {"arm": simulate_arm, "body": simulate_body}

Row = dict[str, str | float | int | None]

OTHER_BUILD = "the worker has another build of pytracker, NumPy, OpenCV or VQF, expected the same everywhere"


@dataclass(frozen=True)
class Result:
    """What became of a run.

    Attributes:
        status: `ok`; `lost`: the track ended early, the rows are of the frames before; `failed`: there are no rows.
        error: why it was lost or failed.
        said: of a recording that was not simulated: what is odd about it, and what speaks against its track.
        rows: one a joint, with `COLUMNS`.
    """

    status: str
    error: str
    said: str
    rows: tuple[Row, ...]


@dataclass(eq=False)
class Source:
    """A recording that is ready to be tracked; a simulated one lives in a folder that goes with it.

    Attributes:
        recording: loaded.
        sightings: of an arm: found once for all methods.
        folder: where it lies.
        name: what to call that in messages, which must not depend on where it happens to lie.
    """

    recording: Recording
    sightings: Sightings | None
    folder: Path | None = None
    name: str = ""


def open_source(recording: StudyRecording, seed: int, scratch: Path | None = None) -> Source:
    """Load or simulate a recording; `seed` is the scene's. Raises `InputError`.

    What is simulated lies below `scratch`, else in the system's folder for such, as long as the result is in use.
    """
    if recording.folder is not None:
        return _loaded(recording.folder, recording.name)
    scene = recording.scene
    assert scene is not None
    pixel_sd = recording.pixel_sd
    if pixel_sd is not None:
        assert isinstance(scene, ArmScene)
        simulation = ArmSimulation(scene, seed)
        seen, landmarks = simulation.sightings(pixel_sd), simulation.landmarks(pixel_sd)
        sightings = Sightings.of(simulation.frame_time_s, seen, landmarks)
        return Source(simulation.recording(), sightings)
    if scratch is not None:
        scratch.mkdir(parents=True, exist_ok=True)
    whole = Path(tempfile.mkdtemp(prefix="pytracker-", dir=scratch))
    folder = whole / "recording"
    try:
        source = _loaded(SIMULATE[scene.kind](folder, scene, seed), recording.name)
    except BaseException:
        shutil.rmtree(whole, ignore_errors=True)
        raise
    weakref.finalize(source, shutil.rmtree, whole, ignore_errors=True)
    return source


def _loaded(folder: Path, name: str) -> Source:
    try:
        recording = load(folder)
        sightings = shared_sightings(recording)
    except InputError as error:
        raise InputError(str(error).replace(str(folder), name)) from None
    return Source(recording, sightings, folder, name)


def execute(run: Run, source: Source) -> Result:
    """Track and score. A run that fails says so in its result, whatever it was."""
    try:
        result = track(source.recording, run.method, run.seed, sightings=source.sightings)
        return Result("ok", "", _said(run, source, result), _rows(result))
    except TrackingError as error:
        try:
            lost = error.track
            said, rows = ("", ()) if lost is None else (_said(run, source, lost), _rows(lost))
            return Result("lost", _line(str(error)), said, rows)
        except Exception as worse:
            return failed(worse, source)
    except Exception as error:
        return failed(error, source)


def failed(error: Exception, source: Source | None = None) -> Result:
    """What is recorded of a run that could not be done."""
    words = f"{type(error).__name__}: {error}"
    if source is not None and source.folder is not None:
        words = words.replace(str(source.folder), source.name)
    return Result("failed", _line(words), "", ())


def _said(run: Run, source: Source, result: Track) -> str:
    """What `track` would warn of; of what is simulated nothing: it is as it is described."""
    recording = source.recording
    if run.recording.folder is None:
        return ""
    words = (*recording.warnings, *unbelieved(result), *result.doubts, *against_truth(result, recording.truth))
    return _line(" | ".join(words).replace(str(source.folder), source.name))


def _line(words: str) -> str:
    """On one line, as a cell of a table is."""
    return " ".join(words.split())


@functools.lru_cache(maxsize=2)
def _kept(recording: StudyRecording, seed: int, digest: str, scratch: Path) -> Source:
    del digest  # another content is another entry
    return open_source(recording, seed, scratch)


def execute_anywhere(run: Run, expected: str, scratch: Path) -> Result:
    """The same in a process that has nothing yet; it keeps the last recordings for the runs that come next.

    What is simulated for them is written below `scratch`.

    Fails where the process runs another build than the one whose fingerprint is `expected`.
    """
    if fingerprint() != expected:
        return failed(InputError(OTHER_BUILD))
    try:
        source = _kept(*run.source, scratch)
    except Exception as error:
        return failed(error)
    return execute(run, source)


def _rows(result: Track) -> tuple[Row, ...]:
    """A row a joint, then one for all."""
    truth = result.recording.truth
    scores, still = (None, None) if truth is None else (evaluate(result, truth), evaluate(held(result), truth))
    particles = result.method.sample_size
    tracked = np.isfinite(result.ess)
    whole: Row = {
        "ess_share": float(result.ess[tracked].mean()) / particles if particles and tracked.any() else None,
        "valid_share": float(result.valid.mean()),
    }
    rows = []
    for name, joint in result.joints.items():
        row: Row = {"joint": name}
        if scores is not None and still is not None and name in scores.joints:
            score = scores.joints[name]
            row |= {column: getattr(score, column) for column in SINGLES} | {"held_m": still.joints[name].rms_m}
            for column, attribute in TRIPLES.items():
                unit = "" if column == "coverage" else "_m"
                row |= {f"{column}_{a}{unit}": x for a, x in zip(AXES, getattr(score, attribute), strict=True)}
        else:
            half = np.nanmean((joint.hi - joint.lo) / 2, axis=0)
            row |= {f"half_width_{a}_m": float(x) for a, x in zip(AXES, half, strict=True)}
        # RMS distance of the cloud from its own middle.
        row["spread_m"] = float(np.nanmean(np.sqrt((joint.sd**2).sum(axis=1))))
        rows.append(row | whole)
    if scores is not None and still is not None:
        rows.append({
            "joint": "all", "frames": scores.frames - scores.frames_untracked, "held_m": still.average_m,
            "average_m": scores.average_m, "average_sd_m": scores.average_sd_m, **whole,
        })  # fmt: skip
    return tuple({column: _plain(row.get(column)) for column in COLUMNS} for row in rows)


def _plain(value: Any) -> str | float | int | None:
    """JSON has no NaN."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
