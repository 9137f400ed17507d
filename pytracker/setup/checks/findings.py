"""What a check says: one line for everything that was looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pytracker.rotation import Array

__all__ = ["Examined", "Finding", "Verdict"]

Verdict = Literal["right", "doubtful", "wrong", "cannot be told", "missing"]


@dataclass(frozen=True)
class Finding:
    """One line.

    Attributes:
        what: was looked at.
        verdict: on it.
        evidence: a sentence with numbers.
        writes: what should stand in recording.toml, by place such as `imu.offset_s`; empty where nothing changes.
        files: new files beside it that this needs, by name.
    """

    what: str
    verdict: Verdict
    evidence: str
    writes: Mapping[str, object] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        written = "".join(f"\n    {place} = {_short(value)}" for place, value in self.writes.items())
        return f"{self.verdict:>14}  {self.what}: {self.evidence}{written}"


Examined = tuple[list[Finding], tuple[Array, Array, Array] | None, tuple[int, ...] | None]
"""Line by line, picture's and IMU's way laid over each other, and the patch's box (`pytracker.setup.check.Checkup`)."""


def _short(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value) if isinstance(value, str) else str(value)
