"""A sensor's samples as lines that come one by one, and its clock by when they arrive.

The first line names the columns as `simulate` writes them, in any order: `time_s` by the sensor's own clock, `acc_x` to
`acc_z` (m/s², specific force), `q_w` to `q_z` (sensor to world, z up), and where there is one `gyr_x` to `gyr_z`
(rad/s). Others are passed over.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from pytracker._core import InputError, Observation
from pytracker.formats.imu.table import ACC, GYR, QUATERNION
from pytracker.recording.recording import Worn

__all__ = ["SensorClock", "sensor_samples"]

WARM_UP_S = 1.0
"""So long it is watched how late samples arrive, before the first is used."""
WINDOW_S = 10.0
"""The quickest of so many seconds says how the sensor's clock and ours go together."""
SLEW = 1e-3
"""No clock goes wrong by more; seconds a second."""


class SensorClock:
    """The sensor's clock in ours: what arrives in bursts, or late, was measured when the sensor says.

    The quickest sample of the last ten seconds is taken to come without delay, as network time protocols do; what that
    changes is spread over seconds, so that times increase as the sensor's own do.
    """

    def __init__(self) -> None:
        self._late: deque[tuple[float, float]] = deque()
        self._offset_s = float("nan")
        self._last_s = float("nan")

    def __call__(self, own_s: float, arrived_s: float) -> float:
        """Our time, s, of a sample whose own time is `own_s`; NaN in the first second. Both are finite."""
        self._late.append((arrived_s, arrived_s - own_s))
        while self._late[0][0] < arrived_s - WINDOW_S:
            self._late.popleft()
        quickest = min(late for _, late in self._late)
        if np.isnan(self._offset_s):
            if arrived_s - self._late[0][0] < WARM_UP_S:
                return float("nan")
            self._offset_s = quickest
        else:
            most = SLEW * max(0.0, own_s - self._last_s)
            self._offset_s += float(np.clip(quickest - self._offset_s, -most, most))
        self._last_s = own_s
        return own_s + self._offset_s


def sensor_samples(
    lines: Iterable[str], worn: Worn, clock: Callable[[], float], warn: Callable[[str], None]
) -> Iterator[Observation]:
    """Samples as their lines arrive, in our time by `clock`; `warn` is told of lines that cannot be read.

    Raises `InputError` where the header lacks a column.
    """
    coming = iter(lines)
    names = [name.strip().strip('"').lower() for name in next(coming, "").split(",")]
    groups = [("time_s",), ACC, QUATERNION]
    missing = [name for group in groups for name in group if name not in names]
    if missing:
        raise InputError(
            f"the sensor's first line has no column {', '.join(missing)} (it is {','.join(names)[:200]!r}), expected "
            "time_s,acc_x,acc_y,acc_z,q_w,q_x,q_y,q_z and any of gyr_x,gyr_y,gyr_z"
        )
    if all(name in names for name in GYR):
        groups.append(GYR)
    at = [[names.index(name) for name in group] for group in groups]
    of_sensor = SensorClock()
    for number, line in enumerate(coming, start=2):
        arrived_s, cells = clock(), line.split(",")
        if not line.strip():
            continue
        try:
            own_s, acc, q, *gyr = (np.array([float(cells[k]) for k in group]) for group in at)
        except (ValueError, IndexError):
            warn(f"the sensor's line {number} is {line.strip()[:80]!r}, expected {len(names)} numbers: left out")
            continue
        if not np.isfinite(own_s[0]):
            warn(f"the sensor's line {number} has time {own_s[0]}, expected a number: left out")
            continue
        time_s = of_sensor(float(own_s[0]), arrived_s)
        if np.isfinite(time_s):
            turned = worn.q_world_segment(q[None])[0]
            rate = worn.of_segment(gyr[0]) if gyr else None
            yield Observation.inertial(time_s, worn.of_segment(acc), turned, rate)
