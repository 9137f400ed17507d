"""How people hold their arms, learned from captured motion: `rust/body/cues/posture_table.rs`.

`python tests/learn_posture.py` learns it anew from the shared Acclaim files and prints how likely motion of a person is
whom it was not learned from, and of people whose joints were seen otherwise: nats a frame beside any pose whatever.
Data: CMU motion capture (mocap.cs.cmu.edu, funding from NSF EIA-0196217) and HDM05.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytracker.formats.amc import read_amc
from pytracker.formats.asf import read_asf
from pytracker.formats.truth_csv import read_truth_csv

Array = NDArray[np.float64]

SHARED = Path(__file__).resolve().parents[2] / "shared"
TABLE = Path(__file__).resolve().parents[1] / "rust" / "body" / "cues" / "posture_table.rs"

SUBJECTS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "7": (("07-walk.asf", "07_05-walk.amc"),),
    "13": (("16.asf", "13_29.amc"),),
    "16": (("16.asf", "16_15.amc"),),
    "35": (("35.asf", "35_01.amc"),),
    "49": (("49.asf", "49_18.amc"), ("49.asf", "49_19.amc")),
    "131": (("131-dance.asf", "131_04-dance.amc"),),
    "dg": (("hdm05/HDM_dg.asf", "hdm05/HDM_dg_06-03_03_120.amc"),),
}
CLIPS = ("20", "21", "22", "24", "29", "31", "33")
"""Not learned from."""

COMPONENTS = 4
"""More do not make motion of somebody else likelier (leave one out: 1, 2, 4, 8 give 2.4, 2.7, 2.9, 2.9 nats)."""
LEAST_SD = 0.4
"""Of a direction's part: few people were captured."""
ANY = 0.1
"""Share of poses that are as likely as any; also in `posture.rs`."""
EVERY = 4
"""Frames are 1/120 s apart and much alike."""
TURNS = 60


@dataclass(frozen=True)
class Postures:
    """A mixture of Gaussians over the directions of upper arm and forearm.

    Attributes:
        share: of each component `(K,)`.
        mean: `(K, 6)`.
        covariance: `(K, 6, 6)`.
        scale: log of its mean density over any two directions `(K,)`.
    """

    share: Array
    mean: Array
    covariance: Array
    scale: Array

    def log_density(self, x: Array) -> Array:
        """Of directions `(N, 6)`, beside that of any: `(N,)`, nats."""
        each = [
            np.log(share * (1 - ANY)) + _log_normal(x, mean, covariance) - scale
            for share, mean, covariance, scale in zip(self.share, self.mean, self.covariance, self.scale, strict=True)
        ]
        return np.asarray(np.logaddexp.reduce([*each, np.full(len(x), np.log(ANY))], axis=0))


def directions(joints: Mapping[str, Array]) -> Array:
    """Upper arms and forearms by their trunk's axes, outwards, up, forward: left ones, then right ones, `(2 T, 6)`."""
    middle = (joints["left_shoulder"] + joints["right_shoulder"]) / 2
    across = _unit(joints["left_shoulder"] - joints["right_shoulder"])
    spine = middle - joints["root"]
    up = _unit(spine - (spine * across).sum(axis=1, keepdims=True) * across)
    axes = np.stack([across, up, np.cross(across, up)], axis=1)
    sides = []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        shoulder, elbow, wrist = (joints[f"{side}_{joint}"] for joint in ("shoulder", "elbow", "wrist"))
        limbs = [np.einsum("tij,tj->ti", axes, _unit(limb)) for limb in (elbow - shoulder, wrist - elbow)]
        sides.append(np.concatenate([limb * [sign, 1.0, 1.0] for limb in limbs], axis=1))
    found = np.concatenate(sides)
    return np.asarray(found[np.isfinite(found).all(axis=1)])


def captured() -> dict[str, Array]:
    """Directions by subject."""
    folder = SHARED / "data" / "cmu"

    def of(skeleton_file: str, motion_file: str) -> Array:
        skeleton = read_asf(folder / skeleton_file)
        return directions(skeleton.joints(read_amc(folder / motion_file, skeleton).poses[::EVERY]))

    return {name: np.concatenate([of(*files) for files in trials]) for name, trials in SUBJECTS.items()}


def gesturing() -> dict[str, Array]:
    """Directions by clip of people who were not learned from."""
    folder = SHARED / "recordings"
    return {n: directions(read_truth_csv(folder / f"people-gesture-{n}" / "truth.csv").positions_m) for n in CLIPS}


def learned(subjects: Mapping[str, Array], components: int = COMPONENTS) -> Postures:
    """By expectation maximisation; a subject counts by the root of how many frames it has."""
    x = np.concatenate(list(subjects.values()))
    weight = np.concatenate([np.full(len(rows), len(rows) ** -0.5) for rows in subjects.values()])
    rng = np.random.default_rng(0)
    chosen = [x[rng.choice(len(x), p=weight / weight.sum())]]
    while len(chosen) < components:
        far = weight * np.min([((x - place) ** 2).sum(axis=1) for place in chosen], axis=0)
        chosen.append(x[rng.choice(len(x), p=far / far.sum())])
    share, mean = np.full(components, 1 / components), np.array(chosen)
    covariance = np.stack([0.1 * np.eye(6)] * components)
    for _ in range(TURNS):
        logs = np.stack([np.log(share[k]) + _log_normal(x, mean[k], covariance[k]) for k in range(components)])
        belongs = weight * np.exp(logs - np.logaddexp.reduce(logs, axis=0))
        total = belongs.sum(axis=1)
        share, mean = total / total.sum(), belongs @ x / total[:, None]
        off = x - mean[:, None]
        spread = np.einsum("kn,kni,knj->kij", belongs, off, off) / total[:, None, None]
        covariance = spread + LEAST_SD**2 * np.eye(6)
    order = np.argsort(-share)
    share, mean, covariance = share[order], mean[order], covariance[order]
    anywhere = np.concatenate([_unit(rng.standard_normal((40_000, 3))) for _ in range(2)], axis=1)
    scale = [np.log(np.exp(_log_normal(anywhere, *of)).mean()) for of in zip(mean, covariance, strict=True)]
    return Postures(share, mean, covariance, np.array(scale))


def table(postures: Postures) -> str:
    """The Rust file."""
    rows = []
    for share, mean, covariance, scale in zip(
        postures.share, postures.mean, postures.covariance, postures.scale, strict=True
    ):
        factor = np.linalg.cholesky(covariance)
        log_weight = np.log(share * (1 - ANY)) - np.log(np.diag(factor)).sum() - scale
        whitening = ",\n".join(f"            {_numbers(row)}" for row in np.linalg.inv(factor))
        rows.append(
            f"    Component {{\n        log_weight: {log_weight:.3f},\n        mean: {_numbers(mean)},\n"
            f"        whitening: [\n{whitening},\n        ],\n    }},"
        )
    return HEAD + "\n".join(rows) + "\n];\n"


HEAD = f"""//! How people hold their arms: numbers learned by `tests/learn_posture.py`, which writes this file.
//!
//! From captured motion of seven people who walk, dance, exercise and balance: CMU motion capture (mocap.cs.cmu.edu,
//! created with funding from NSF EIA-0196217) and HDM05 (Müller et al. 2007).

/// A Gaussian over directions of upper arm and forearm, outwards, up, forward each.
pub struct Component {{
    /// Log of its share and scale, beside the density of any two directions.
    pub log_weight: f64,
    /// Its middle.
    pub mean: [f64; 6],
    /// Inverse of the lower factor of its covariance, row by row.
    pub whitening: [[f64; 6]; 6],
}}

/// The heaviest first.
pub const COMPONENTS: [Component; {COMPONENTS}] = [
"""


def _numbers(row: Array) -> str:
    return "[" + ", ".join(f"{x + 0.0:.3f}" for x in np.round(row, 3)) + "]"


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _log_normal(x: Array, mean: Array, covariance: Array) -> Array:
    """Without the constant of six dimensions."""
    factor = np.linalg.cholesky(covariance)
    off = np.linalg.solve(factor, (x - mean).T)
    return np.asarray(-0.5 * (off**2).sum(axis=0) - np.log(np.diag(factor)).sum())


def main() -> None:
    subjects = captured()
    postures = learned(subjects)
    TABLE.write_text(table(postures), "utf-8")
    print(f"{TABLE.name}: {COMPONENTS} components")
    for name, rows in subjects.items():
        others = learned({other: x for other, x in subjects.items() if other != name})
        left_out, told = others.log_density(rows).mean(), postures.log_density(rows).mean()
        print(f"subject {name}: {left_out:.2f} nats a frame left out, {told:.2f} learned from, {len(rows)} arms")
    for name, rows in gesturing().items():
        print(f"clip {name}: {postures.log_density(rows).mean():.2f} nats a frame, {len(rows)} arms")


if __name__ == "__main__":
    main()
