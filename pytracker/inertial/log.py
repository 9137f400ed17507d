"""One kind of IMU log for every file format."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["ImuLog"]

Float = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ImuLog:
    """What an IMU file holds, in its own time and frames, SI units.

    Attributes:
        path: the file.
        lines: line number of every sample, `(M,)`.
        time_s: `(M,)`, s.
        acc: specific force, m/s² `(M, 3)`.
        gyr: turn rate, rad/s `(M, 3)`.
        mag: magnetic field, any unit `(M, 3)`.
        q_world_sensor: sensor to the sensor's earth frame, w first `(M, 4)`.
        rate_hz: as the file states it.
        warnings: what is odd but usable.
        unread: what else the file has, by name.
    """

    path: Path
    lines: NDArray[np.int64]
    time_s: Float
    acc: Float | None = None
    gyr: Float | None = None
    mag: Float | None = None
    q_world_sensor: Float | None = None
    rate_hz: float | None = None
    warnings: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()

    def kept(self, which: NDArray[np.bool_]) -> ImuLog:
        """The samples that are `which` `(M,)`."""

        def of(values: Float | None) -> Float | None:
            return None if values is None else values[which]

        return dataclasses.replace(
            self,
            lines=self.lines[which],
            time_s=self.time_s[which],
            acc=of(self.acc),
            gyr=of(self.gyr),
            mag=of(self.mag),
            q_world_sensor=of(self.q_world_sensor),
        )
