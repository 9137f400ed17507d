"""What a recording.toml that is being made says of its subject: an arm, or a body; and of the camera for its sake."""

from __future__ import annotations

import shlex
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

import tomlkit

__all__ = ["LEVEL", "SUBJECTS", "SubjectEntry", "check_command", "value"]

Known = Mapping[str, object]
"""What is known already, by key of `[[camera]]` and `[arm]`."""

LEVEL = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]
"""A camera held level, in a world whose y axis is up."""


def value(of: object) -> str:
    """As TOML."""
    return tomlkit.item(of).as_string()


def check_command(folder: Path) -> str:
    """The command that finds what is missing."""
    return f"pytracker check {shlex.quote(folder.name)} --write"


class SubjectEntry(ABC):
    """Of one kind of recording.

    Attributes:
        camera_keys: what is written of a camera where it is known, besides its matrix and pose.
    """

    camera_keys: ClassVar[tuple[str, ...]]

    def pose(self, known: Known, turned: str) -> list[str]:
        """Rotation and translation of the camera; `turned` says how they were turned."""
        lines = []
        for key, words in (
            (
                "rotation",
                "world to camera, three rows: pytracker calibrate pose (places in the room) or level (tape) finds it",
            ),
            ("translation_m", "the world's origin in the camera, m: found with it"),
        ):
            lines.append(f"{key} = {value(known[key])}" if key in known else f"# {key} = [...]  # missing: {words}")
            if key == "rotation" and turned:
                lines[-1] += f"  # {turned}"
        return lines

    def patch(self, known: Known, folder: Path) -> list[str]:
        """What a camera follows by colour."""
        return []

    @abstractmethod
    def tables(self, known: Known, folder: Path, *, has_keypoints: bool) -> list[str]:
        """Who is followed."""


class ArmSubject(SubjectEntry):
    """`[arm]`, and the patch that it wears."""

    camera_keys = (
        *("distortion", "focal_sd", "rotation_sd_deg", "distance_sd_m"),
        *("patch_offset_m", "patch_offset_sd_m"),
    )

    def patch(self, known: Known, folder: Path) -> list[str]:
        """Its box in the first frame."""
        if "patch_box" in known:
            return [f"patch_box = {value(known['patch_box'])}"]
        how = f"the patch in the first frame, x, y, width, height, px: {check_command(folder)} finds it"
        return [f"# patch_box = [...]  # missing: {how}"]

    def tables(self, known: Known, folder: Path, *, has_keypoints: bool) -> list[str]:
        """Side, shoulder and lengths."""
        lines = ["[arm]", f"side = {value(known.get('side', 'right'))}"]
        for key, words in (
            ("shoulder_m", "the shoulder joint in the world, x, y, z (up), m"),
            ("upper_arm_m", "shoulder to elbow, m: a tape measure, to 1 cm"),
            ("forearm_m", "elbow to wrist, m: a tape measure, to 1 cm"),
        ):
            lines.append(f"{key} = {value(known[key])}" if key in known else f"# {key} = ...  # missing: {words}")
        spreads = [key for key in ("shoulder_sd_m", "upper_arm_sd_m", "forearm_sd_m") if key in known]
        return [*lines, *(f"{key} = {value(known[key])}" for key in spreads), ""]


class BodySubject(SubjectEntry):
    """`[skeleton]` and `[initial]`."""

    camera_keys = ("distortion", "focal_sd")

    def pose(self, known: Known, turned: str) -> list[str]:
        """Where it is not known, a body is tracked as the camera sees it."""
        if {"rotation", "translation_m"} & set(known):
            return super().pose(known, turned)
        return [
            f"rotation = {value(LEVEL)}  # guessed, a camera held level: check --write finds its pitch",
            "translation_m = [0.0, 0.0, 0.0]  # joints are told from the camera: x right of it, y up, z towards it",
        ]

    def tables(self, known: Known, folder: Path, *, has_keypoints: bool) -> list[str]:
        """Height and first pose."""
        found = f"keypoints, which pytracker keypoints {shlex.quote(folder.name)} finds in the video"
        them = "keypoints" if has_keypoints else found
        return [
            "[skeleton]",
            "# height_m = 1.70  # missing: the person's height; or file, an Acclaim skeleton",
            "",
            "[initial]",
            f'# angles = "initial.toml"  # missing: the first pose; pytracker check --write finds it from {them}',
            "",
        ]


SUBJECTS: Mapping[str, SubjectEntry] = {"arm": ArmSubject(), "body": BodySubject()}
"""By kind of recording."""
