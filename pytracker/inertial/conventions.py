"""What an IMU file's numbers stand for: units, order and direction of the quaternion, up or down. Turned into ours.

Ours: m/s², rad/s, w first, from the sensor to a world whose z is up.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pytracker.inertial.gravity import GRAVITY
from pytracker.inertial.log import ImuLog
from pytracker.rotation import conjugate, multiply

__all__ = ["OVER", "AccReads", "AccUnit", "Conventions", "Direction", "Earth", "GyrUnit", "Order", "in_our_terms"]

AccUnit = Literal["m/s2", "g"]
AccReads = Literal["force", "gravity"]
GyrUnit = Literal["rad/s", "deg/s"]
Order = Literal["wxyz", "xyzw"]
Direction = Literal["sensor to world", "world to sensor"]
Earth = Literal["z up", "z down"]

OVER = np.array([0.0, 1.0, 0.0, 0.0])
"""Half a turn about x: north-east-down to a world whose z is up."""


@dataclass(frozen=True, kw_only=True)
class Conventions:
    """What the numbers of an IMU file stand for; as they are here by default.

    Attributes:
        acc_unit: of the specific force.
        acc_reads: the specific force, up at rest, or gravity, down, as an iPhone's accelerometer does.
        gyr_unit: of the turn rate.
        quaternion: the order of its four numbers in the columns that are named w, x, y, z.
        quaternion_takes: vectors from where to where.
        earth: whether the earth frame's z is up (ENU, NWU) or down (NED).
    """

    acc_unit: AccUnit = "m/s2"
    acc_reads: AccReads = "force"
    gyr_unit: GyrUnit = "rad/s"
    quaternion: Order = "wxyz"
    quaternion_takes: Direction = "sensor to world"
    earth: Earth = "z up"


def in_our_terms(log: ImuLog, conventions: Conventions) -> ImuLog:
    """The same log in our units and frames."""
    acc, gyr, q = log.acc, log.gyr, log.q_world_sensor
    if acc is not None and conventions.acc_unit == "g":
        acc = acc * GRAVITY
    if acc is not None and conventions.acc_reads == "gravity":
        acc = -acc
    if gyr is not None and conventions.gyr_unit == "deg/s":
        gyr = np.radians(gyr)
    if q is not None:
        if conventions.quaternion == "xyzw":
            q = np.roll(q, 1, axis=1)
        if conventions.quaternion_takes == "world to sensor":
            q = conjugate(q)
        if conventions.earth == "z down":
            q = multiply(np.broadcast_to(OVER, q.shape), q)
    return dataclasses.replace(log, acc=acc, gyr=gyr, q_world_sensor=None if q is None else np.ascontiguousarray(q))
