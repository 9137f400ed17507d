"""What a study runs: every method on every recording of its kind, once a seed."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np

from pytracker._core import InputError
from pytracker.digest import sha256_of
from pytracker.methods.method import Method
from pytracker.recording.load import load
from pytracker.recording.schema import read_recording_file
from pytracker.simulate import ArmScene, BodyScene

__all__ = ["Run", "Study", "StudyRecording", "plain"]

MOST_RUNS = 1_000_000


@dataclass(frozen=True, kw_only=True)
class StudyRecording:
    """A recording of a study: a folder, or a scene to simulate. Raises `InputError` where it is neither or both.

    Attributes:
        name: as the table calls it; printable.
        folder: a recording folder; on a cluster, one that every worker can read under this path.
        scene: what to simulate instead.
        seed: simulate with this seed for every run; None: with the run's own, so that
            runs differ in recording and in noise.
        pixel_sd: arm only: no video; the patch's centres come with this noise, px per axis.
    """

    name: str
    folder: Path | None = None
    scene: ArmScene | BodyScene | None = None
    seed: int | None = None
    pixel_sd: float | None = None

    def __post_init__(self) -> None:
        """Check that it is one of the two."""
        if not (self.name and self.name.isprintable()):
            raise InputError(f"a recording's name is {self.name!r}, expected printable characters")
        if self.folder is not None:  # a name will do
            object.__setattr__(self, "folder", Path(self.folder))
        if self.seed is not None:
            object.__setattr__(self, "seed", _seed(self.seed))
        if (self.folder is None) == (self.scene is None):
            given = "neither folder nor scene" if self.folder is None else "both folder and scene"
            raise InputError(f"recording {self.name!r} has {given}, expected one of them")
        if self.folder is not None and (self.seed is not None or self.pixel_sd is not None):
            raise InputError(f"recording {self.name!r} is a folder: seed and pixel_sd go with a scene")
        if self.pixel_sd is not None and not (self.kind == ArmScene.kind and 0 <= self.pixel_sd < math.inf):
            raise InputError(f"recording {self.name!r} has pixel_sd {self.pixel_sd!r}, expected an arm's, 0 px or more")

    @property
    def kind(self) -> str:
        """`arm` or `body`; empty where a folder does not say, which its runs will report."""
        if self.scene is not None:
            return self.scene.kind
        assert self.folder is not None
        try:
            return read_recording_file(self.folder / "recording.toml").kind
        except (OSError, InputError):
            return ""

    def digest(self) -> str:
        """Of every file that it is made of, a folder's or a scene's motion: another content is another run.

        Where they cannot be read the runs will say what is the matter, and are tried again.
        """
        try:
            if self.folder is not None:
                files = list(load(self.folder).files)
            else:
                files = [Path(getattr(self.scene, n)) for n in ("skeleton", "motion") if getattr(self.scene, n, "")]
            return " ".join(sha256_of(path) for path in files)
        except (InputError, OSError):
            return f"unreadable: {self.folder or self.scene}"


@dataclass(frozen=True)
class Run:
    """One method on one recording with one seed.

    Attributes:
        recording: what is tracked.
        method: how.
        seed: of the method's random streams, and of a scene that has none of its own.
        digest: of the files that the recording is made of.
        key: tells it from every other run, by content: the same key has the same result.
    """

    recording: StudyRecording
    method: Method
    seed: int
    digest: str
    key: str

    @property
    def source(self) -> tuple[StudyRecording, int, str]:
        """Which recording exactly (with the scene's seed, and the content): runs that share it need it made once."""
        is_own = self.recording.scene is not None and self.recording.seed is None
        return self.recording, self.seed if is_own else self.recording.seed or 0, self.digest


@dataclass(frozen=True, kw_only=True)
class Study:
    """Recordings x methods x seeds. Raises `InputError` where a part is empty, double, or fits nothing.

    Attributes:
        recordings: with different names.
        methods: all different; each tracks the recordings of its kind.
        seeds: all different, 0 to 2^63 - 1.
    """

    recordings: tuple[StudyRecording, ...]
    methods: tuple[Method, ...]
    seeds: Sequence[int]

    def __post_init__(self) -> None:
        """Check that every part has something to do."""
        object.__setattr__(self, "recordings", tuple(self.recordings))
        object.__setattr__(self, "methods", tuple(self.methods))
        object.__setattr__(self, "seeds", tuple(map(_seed, self.seeds)))
        count = len(self.recordings) * len(self.methods) * len(self.seeds)
        if count > MOST_RUNS:
            raise InputError(f"the study has {count} runs, expected at most {MOST_RUNS}")
        names = [recording.name for recording in self.recordings]
        for what, items in (("recording", names), ("method", self.methods), ("seed", self.seeds)):
            if not items:
                raise InputError(f"the study has no {what}, expected at least one")
            double = [item for item, count in Counter(map(repr, items)).items() if count > 1]
            if double:
                raise InputError(f"the study has the {what} {_short(double[0])} twice, expected all to differ")
        kinds = {recording.kind for recording in self.recordings}
        for method in self.methods:
            if not kinds & {method.kind, ""}:
                raise InputError(
                    f"{type(method).__name__} tracks recordings of kind {method.kind!r}, the study has none"
                )
        for recording in self.recordings:
            if recording.kind and recording.kind not in {method.kind for method in self.methods}:
                raise InputError(
                    f"recording {recording.name!r} is of kind {recording.kind!r}, no method of the study is"
                )

    def runs(self, fingerprint: str) -> Iterator[Run]:
        """Every run, in the table's order; `fingerprint` tells what computes them."""
        for recording in self.recordings:
            kind, digest = recording.kind, recording.digest()
            for method in self.methods:
                if kind and method.kind != kind:
                    continue
                for seed in self.seeds:
                    content = {
                        "fingerprint": fingerprint,
                        "scene": recording.scene
                        and {type(recording.scene).__name__: dataclasses.asdict(recording.scene)},
                        "scene_seed": recording.seed,
                        "pixel_sd": recording.pixel_sd,
                        "digest": digest,
                        "method": {type(method).__name__: method.parameters()},
                        "seed": seed,
                    }
                    yield Run(recording, method, seed, digest, _key(content))


def plain(value: Any) -> Any:
    """What JSON knows instead of a number of NumPy's or a path."""
    return value.item() if isinstance(value, np.generic) else str(value)


def _seed(value: Any) -> int:
    """A whole number that every generator takes."""
    if type(value) is bool or not isinstance(value, Integral) or not 0 <= int(value) < 2**63:
        raise InputError(f"the seed is {value!r}, expected a whole number from 0 to 2^63 - 1")
    return int(value)


def _short(words: str) -> str:
    return words if len(words) <= 60 else words[:60] + " ..."


def _key(content: dict[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True, default=plain)
    return hashlib.sha256(text.encode()).hexdigest()[:24]
