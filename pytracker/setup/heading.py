"""The heading of a forearm's IMU, and how well the recording tells it.

What is fast (`pytracker.setup.worn`) takes the shoulder to stay and the sensor to be right: it is sure of headings that
are 5 to 15° off. `pytracker.Mixture`, which knows what a worn sensor and a living shoulder do, weighs those about it.
"""

from __future__ import annotations

import dataclasses
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from pytracker._core import InputError, TrackingError
from pytracker.evidence.sightings import Sightings
from pytracker.methods.arm import Mixture
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array
from pytracker.setup.worn import MOST_FRAMES, Worn, put_on
from pytracker.tracking.arm import filter_arm

__all__ = ["heading_of"]

ABOUT = np.radians(np.arange(-18.0, 19.0, 6.0))
"""Headings that are weighed, from what is found fast, rad: that is farther off for circles alone, by 22° at most."""
SHARE = 0.7
"""It errs otherwise than what is found fast, by 7° where a shoulder goes with the hand that reaches, and has so much of
the say."""
LEAST_SD = np.radians(1.0)


def heading_of(recording: ArmRecording, sightings: Sightings, worn: Worn) -> tuple[float, float]:
    """The heading about that of `worn`, clock and mount as they are, and its standard deviation, rad.

    Both by a parabola through the log evidence about its highest. The IMU of `recording` is as the file has it. Where
    nothing tells it, it stays, known to as much as was tried.
    """
    sightings = sightings.first(MOST_FRAMES)
    ways = [dataclasses.replace(worn, heading_rad=worn.heading_rad + about) for about in ABOUT.tolist()]
    with ThreadPoolExecutor(os.cpu_count()) as pool:  # the filter lets the interpreter go
        explained: Array = np.array(list(pool.map(lambda way: _log_evidence(recording, sightings, way), ways)))
    k = int(np.clip(explained.argmax(), 1, len(ABOUT) - 2))
    before, at, after = explained[k - 1 : k + 2]
    step = float(ABOUT[1] - ABOUT[0])
    bends = (before - 2.0 * at + after) / step**2
    if not (np.isfinite(bends) and bends < 0.0):
        return worn.heading_rad, float(ABOUT[-1])
    moved = float(np.clip(-(after - before) / (2.0 * step * bends), -step, step))
    heading_rad = worn.heading_rad + SHARE * (float(ABOUT[k]) + moved)
    return heading_rad, float(max(LEAST_SD, 1.0 / np.sqrt(-bends)))


def _log_evidence(recording: ArmRecording, sightings: Sightings, worn: Worn) -> float:
    """Of the patch, with the better of the places that the wrist may start at."""
    found = [-np.inf]
    for one in put_on(recording, worn, sightings):
        try:
            track = filter_arm(one, Mixture(), sightings=sightings)
        except (InputError, TrackingError):
            continue
        if not track.lost:
            found.append(float(np.nansum(track.log_evidence)))
    return max(found)
