"""A check of clock, heading and mount of a forearm's IMU against what the camera saw."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pytracker._core import InputError
from pytracker.evidence.patch.lag import Lag
from pytracker.evidence.sightings import Sightings
from pytracker.recording.recording import ArmRecording
from pytracker.rotation import Array, conjugate, rotate
from pytracker.setup.checks.findings import Finding
from pytracker.setup.heading import heading_of
from pytracker.setup.worn import (
    CLEAR,
    GIVEN_STAYS,
    KIND,
    MOST_FRAMES,
    Worn,
    find_worn,
    is_same,
    lags_of,
    mount_of,
    weighed,
)

__all__ = ["check_clock", "check_worn", "given_axis"]

STEP_S = 0.02
"""Of the clock, from whose cost its standard deviation is taken."""
LEAST_SD_S = 0.02
"""So well the clock of a worn sensor is found where the movement tells it best."""
LEAST_OFFSET_SD_S = 0.05
"""Clock and heading lean on each other: what is written leaves the smoother room."""
SAME_CLOCK_S = 0.2
"""Where all that explains the recording is nearer, the clock is told, whatever is not."""
LAGS_MIRRORED = 12
"""So many of the clocks are tried of a mirrored picture, which moves as the IMU does by the same ones."""
WELL = -6.0
"""Log evidence of a frame, at least, of what is explained: right ways have -2.6 to -4.0; wrong ones, of a camera that
is turned by 3°, -9 to -20."""
FROM_HEADING_DEG, MOST_FROM_HEADING_DEG = 7.0, 15.0
FROM_Y_DEG = 25.0
"""A heading, and a forearm's axis, that are nearer to what is given are as they are given; of a heading that is told
less well it may be somewhat more."""


def check_clock(lags: tuple[Lag, ...], offset_s: float | None) -> Finding:
    """From the movement alone, where camera or arm are not known yet."""
    if not lags:
        words = "the patch is hardly seen, or patch and IMU never move alike for long enough or never overlap"
        return Finding("clock", "cannot be told", words)
    best = lags[0]
    words = (
        f"the patch moves as the IMU does with an offset of {best.offset_s:+.2f} s: {best.explained:.0%} of its way in "
        f"the picture is explained, over {best.overlap_s:.0f} s"
    )
    others = [lag for lag in lags[1:] if abs(lag.offset_s - best.offset_s) > 0.3]
    if others and others[0].worth > 0.8 * best.worth:
        words += f"; but {others[0].offset_s:+.2f} s explains as much: the movement repeats itself"
        return Finding("clock", "cannot be told", words)
    if offset_s is not None and abs(best.offset_s - offset_s) < 0.1:
        return Finding("clock", "right", words)
    writes = {"imu.offset_s": round(best.offset_s, 3), "imu.offset_sd_s": 0.05}
    return Finding("clock", "missing" if offset_s is None else "wrong", words, writes)


def check_worn(
    recording: ArmRecording,
    sightings: Sightings,
    given: Worn,
    has: tuple[bool, bool, bool],
    width_px: int,
) -> tuple[list[Finding], Worn | None]:
    """Clock, heading, mount; `has`: which of them are given at all. The IMU of `recording` is as the file has it.

    `width_px` is the picture's, which may be mirrored: then some mount and heading explain it too, and none is right.
    """
    lags = lags_of(recording, sightings)
    if not lags:
        return [check_clock(lags, None)], None
    same_axis = find_worn(recording, sightings, lags, [given.axis])
    found = find_worn(recording, sightings, lags)
    stays = weighed(recording, sightings, given)
    if not found and not same_axis:
        words = "no clock, heading and mount explain what the camera saw: check camera, arm and patch first"
        return [Finding("clock, heading and mount", "cannot be told", words)], None
    best = max((*found, *same_axis), key=lambda one: one.log_evidence)
    if said := _mirrored(recording, sightings, lags, max(stays, best, key=lambda one: one.log_evidence), width_px):
        return [check_clock(lags, given.offset_s if has[0] else None), said], None
    aligned = max(same_axis, key=lambda one: one.log_evidence, default=best)
    # What is given stands unless something else is better, the mount before clock and heading.
    if stays.log_evidence > best.log_evidence - GIVEN_STAYS:
        chosen, rivals = stays, tuple[Worn, ...]()
    elif aligned.log_evidence > best.log_evidence - GIVEN_STAYS:
        # One that nobody gave is no better than any other.
        chosen, rivals = aligned, same_axis if has[2] else (*same_axis, *found)
    else:
        chosen, rivals = best, (*found, stays)
    near = [one for one in rivals if one.log_evidence > chosen.log_evidence - CLEAR]
    rival = next((one for one in near if not is_same(one, chosen, KIND)), None)
    if rival is not None:
        return _undecided(chosen, rival, best, near, given if has[0] else None), chosen
    kin = [one for one in near if is_same(one, chosen, KIND)]
    return _words(recording, sightings, given, has, chosen, kin, best), chosen


def _mirrored(
    recording: ArmRecording, sightings: Sightings, lags: tuple[Lag, ...], best: Worn, width_px: int
) -> Finding | None:
    """Where what was seen, left and right exchanged, is explained better than by any way to wear the IMU."""
    u, v = sightings.pixels[:, 0].T
    picture = Sightings.of(sightings.time_s, np.stack([width_px - 1 - u, v], axis=1))
    least = best.log_evidence + CLEAR
    ways = find_worn(recording, picture, lags[:LAGS_MIRRORED], least=least)
    evidence = max((one.log_evidence for one in ways), default=-np.inf)
    if evidence < least:
        return None
    seen = int(np.isfinite(picture.first(MOST_FRAMES).pixels[:, 0]).all(axis=1).sum())
    if evidence < WELL * seen:
        now, then = best.log_evidence / seen, evidence / seen
        words = (
            f"neither as it is nor mirrored does it agree with the IMU (log evidence {now:.1f} and {then:.1f} a frame, "
            f"expected {WELL:g} at least): check the camera's pose and matrix, the arm's lengths and the patch. "
            "Neither heading nor mount is written"
        )
        return Finding("picture", "wrong", words)
    words = (
        f"mirrored, left and right exchanged, it agrees with the IMU (log evidence {evidence:.0f}), as it is "
        f"{best.log_evidence:.0f} at best: is it a selfie camera's, does the camera's pose have a sign wrong, or "
        "do, where the file has no orientation of its own, its accelerations, as an iPhone's do (lying face up it "
        'reads -1 g along z: imu.acc_reads = "gravity")? Neither heading nor mount is written'
    )
    return Finding("picture", "wrong", words)


def _undecided(chosen: Worn, rival: Worn, best: Worn, near: list[Worn], given: Worn | None) -> list[Finding]:
    """Of ways of several kinds that explain it as well: the clock, where all have the same, and that there are more."""
    words = (
        f"{_in_words(chosen)} and {_in_words(rival)} explain the recording as well ({_evidence(chosen, best)}, the "
        f"other's {rival.log_evidence:.0f}): move in ways that do not repeat, or give imu.mount"
    )
    offsets = [chosen.offset_s, *(one.offset_s for one in near)]
    if np.ptp(offsets) > SAME_CLOCK_S:
        return [Finding("clock, heading and mount", "cannot be told", words)]
    offset_s, sd_s = float(np.mean(offsets)), max(LEAST_OFFSET_SD_S, float(np.ptp(offsets)))
    said = f"offset {offset_s:+.3f} ± {sd_s:.3f} s, however the sensor is worn"
    if given is not None and abs(given.offset_s - offset_s) < sd_s:
        clock = Finding("clock", "right", said)
    else:
        writes = {"imu.offset_s": round(offset_s, 3), "imu.offset_sd_s": round(sd_s, 3)}
        clock = Finding("clock", "missing" if given is None else "wrong", said, writes)
    return [clock, Finding("heading and mount", "cannot be told", words)]


def _evidence(chosen: Worn, best: Worn) -> str:
    return f"log evidence {chosen.log_evidence:.0f}, the best of all {best.log_evidence:.0f}"


def _words(
    recording: ArmRecording,
    sightings: Sightings,
    given: Worn,
    has: tuple[bool, bool, bool],
    chosen: Worn,
    kin: list[Worn],
    best: Worn,
) -> list[Finding]:
    """A finding each of clock, heading and mount."""
    sd_s = _clock_sd_s(recording, sightings, chosen)
    heading_rad, heading_sd = heading_of(recording, sightings, chosen)
    headed = replace(chosen, heading_rad=heading_rad)
    degrees = _degrees(headed)
    apart_s = max((abs(one.offset_s - chosen.offset_s) for one in kin), default=0.0)
    turned = max((abs(_turned(one, chosen)) for one in kin), default=0.0)
    alike = f"; as good with up to {turned:.0f}° and {apart_s:.2f} s less or more" if turned > 1.0 else ""
    off = float(np.degrees(np.arccos(np.clip(chosen.axis @ given.axis, -1.0, 1.0))))
    is_right = (
        abs(chosen.offset_s - given.offset_s) < max(3 * sd_s, 0.04),
        abs(_turned(headed, given)) < np.clip(2.0 * np.degrees(heading_sd), FROM_HEADING_DEG, MOST_FROM_HEADING_DEG),
        off < FROM_Y_DEG,
    )
    said = (
        f"offset {chosen.offset_s:+.3f} ± {sd_s:.3f} s ({_evidence(chosen, best)})",
        f"{degrees:+.1f} ± {np.degrees(heading_sd):.1f}° to the world{alike}",
        f"from wrist to elbow points the sensor's {_axis(chosen.axis)}, {off:.0f}° from the one that is given",
    )
    writes: tuple[dict[str, object], ...] = (
        {
            "imu.offset_s": round(chosen.offset_s, 3),
            "imu.offset_sd_s": round(max(2.0 * sd_s, LEAST_OFFSET_SD_S, apart_s), 3),
        },
        {"imu.heading_deg": round(degrees, 1)},
        {"imu.mount": [round(float(x), 5) for x in mount_of(chosen.axis)]},
    )
    return [
        Finding(what, "right", sentence)
        if right
        else Finding(what, "wrong" if was_given else "missing", sentence, written)
        for what, right, was_given, sentence, written in zip(
            ("clock", "heading", "mount"), is_right, has, said, writes, strict=True
        )
    ]


def _in_words(worn: Worn) -> str:
    axis = _axis(worn.axis)
    return f"offset {worn.offset_s:+.2f} s, heading {_degrees(worn):+.0f}° and the sensor's {axis} towards the elbow"


def _degrees(worn: Worn) -> float:
    return float(np.degrees((worn.heading_rad + np.pi) % (2 * np.pi) - np.pi))


def _turned(one: Worn, other: Worn) -> float:
    return float((np.degrees(one.heading_rad - other.heading_rad) + 180.0) % 360.0 - 180.0)


def _axis(axis: Array) -> str:
    k = int(np.argmax(np.abs(axis)))
    return f"{'+' if axis[k] > 0 else '-'}{'xyz'[k]}"


def _clock_sd_s(recording: ArmRecording, sightings: Sightings, at: Worn) -> float:
    """Standard deviation of the clock, by how the log evidence falls beside it; no less than it errs by otherwise."""
    beside = [
        weighed(recording, sightings, replace(at, offset_s=at.offset_s + by)).log_evidence for by in (STEP_S, -STEP_S)
    ]
    fall = at.log_evidence - float(np.mean(beside))
    return max(LEAST_SD_S, STEP_S / np.sqrt(2.0 * fall) if fall > 0.05 else 5.0 * STEP_S)


def given_axis(mount: list[float] | None) -> Array:
    """Of the sensor: from wrist to elbow, by the mount that is given."""
    q = np.array([1.0, 0.0, 0.0, 0.0] if mount is None else mount, dtype=float)
    if not 0.5 < np.linalg.norm(q) < 2.0:
        raise InputError(f"imu.mount has norm {np.linalg.norm(q):.4f}, expected a unit quaternion")
    return rotate(conjugate(q / np.linalg.norm(q)), np.array([0.0, 1.0, 0.0]))
