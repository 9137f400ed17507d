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
from pytracker.formats.text import cells_of
from pytracker.recording.recording import Worn

__all__ = ["SensorClock", "sensor_samples"]

WARM_UP_S = 1.0
"""So long it is watched how late samples arrive, before the first is used."""
WINDOW_S = 10.0
"""The quickest of so many seconds says how the sensor's clock and ours go together."""
SLEW = 1e-3
"""No clock goes wrong by more; seconds a second."""
LEAPT_S = 0.1
"""A clock that is farther off than its window says was set anew."""
EARLY_S, LATE_S = 0.1, 3.0
"""No sample is measured after it arrives, nor is on its way so long."""
STRANGE_S = 0.5
"""A clock that says so for longer was set anew; for less it is one time that is wrong."""
AS_FAST = (0.02, 50.0)
"""Seconds of the sensor in a second of ours, in the first of which what was waiting comes at once: others are no
seconds."""


class SensorClock:
    """The sensor's clock in ours: what arrives in bursts, or late, was measured when the sensor says.

    The quickest sample of the last ten seconds is taken to come without delay, as network time protocols do; what that
    changes is spread over seconds, so that times increase as the sensor's own do. A clock that was set anew is found
    anew.
    """

    def __init__(self) -> None:
        self._find_anew()

    def _find_anew(self) -> None:
        self._late: deque[tuple[float, float, float]] = deque()
        self._offset_s = self._last_s = self._strange_since_s = float("nan")

    @property
    def is_known(self) -> bool:
        """Whether it was watched for long enough."""
        return bool(np.isfinite(self._offset_s))

    def __call__(self, own_s: float, arrived_s: float) -> float:
        """Our time, s, of a sample whose own time is `own_s`; NaN where it is not known, or cannot be. Both are finite.

        Raises `InputError` for times that are not in seconds.
        """
        if self.is_known and self._is_strange(own_s, arrived_s):
            return float("nan")
        self._late.append((arrived_s, arrived_s - own_s, own_s))
        while self._late[0][0] < arrived_s - WINDOW_S:
            self._late.popleft()
        quickest = min(late for _, late, _ in self._late)
        if not self.is_known:
            if arrived_s - self._late[0][0] < WARM_UP_S:
                return float("nan")
            self._check_unit()
            self._offset_s = quickest
        elif abs(quickest - self._offset_s) > LEAPT_S:
            self._offset_s = quickest
        else:
            most = SLEW * max(0.0, own_s - self._last_s)
            self._offset_s += float(np.clip(quickest - self._offset_s, -most, most))
        self._last_s = own_s
        return own_s + self._offset_s

    def _is_strange(self, own_s: float, arrived_s: float) -> bool:
        """Whether it was measured after it arrived, or long before; a clock that goes on so is found anew."""
        if -LATE_S <= own_s + self._offset_s - arrived_s <= EARLY_S:
            self._strange_since_s = float("nan")
            return False
        if np.isnan(self._strange_since_s):
            self._strange_since_s = arrived_s
        if arrived_s - self._strange_since_s > STRANGE_S:
            self._find_anew()
            return False
        return True

    def _check_unit(self) -> None:
        (first_s, _, own_first_s), (last_s, _, own_last_s) = self._late[0], self._late[-1]
        speed = (own_last_s - own_first_s) / (last_s - first_s)
        if not AS_FAST[0] < speed < AS_FAST[1]:
            raise InputError(
                f"the sensor's times go on by {own_last_s - own_first_s:.6g} in {last_s - first_s:.1f} s, expected "
                "time_s in seconds, of samples that come as they are measured"
            )


def sensor_samples(
    lines: Iterable[str], worn: Worn, clock: Callable[[], float], warn: Callable[[str], None]
) -> Iterator[Observation]:
    """Samples as their lines arrive, in our time by `clock`; `warn` is told of lines that are left out.

    Raises `InputError` where the header lacks a column, times are not in seconds, and where the lines end before the
    sensor's clock is known.
    """
    coming = iter(lines)
    names = [name.strip().lower() for name in cells_of(next(coming, "").strip())]
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
    of_sensor, has_begun = SensorClock(), False
    for number, line in enumerate(coming, start=2):
        arrived_s, cells = clock(), cells_of(line.strip())
        if not line.strip():
            continue
        try:
            values = [float(cell) for cell in cells]
        except ValueError:
            values = []
        if len(values) != len(names) or not np.isfinite(values).all():
            warn(f"the sensor's line {number} is {line.strip()[:80]!r}, expected {len(names)} numbers: left out")
            continue
        (own_s,), acc, q, *gyr = (np.array([values[k] for k in group]) for group in at)
        was_known, time_s = of_sensor.is_known, of_sensor(float(own_s), arrived_s)
        if np.isnan(time_s):
            if was_known:
                anew = "" if of_sensor.is_known else ": its clock was set anew, and is found anew"
                warn(f"the sensor's line {number} has time {own_s}, not after what came before it as it arrives{anew}")
            continue
        has_begun = True
        rate = worn.of_segment(gyr[0]) if gyr else None
        yield Observation.inertial(time_s, worn.of_segment(acc), worn.q_world_segment(q[None])[0], rate)
    if not has_begun:
        raise InputError(
            f"the sensor's lines ended before {WARM_UP_S:g} s had passed, expected them as they are measured, a line a "
            "sample"
        )
