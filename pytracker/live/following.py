"""Somebody who is followed live: what arrives, one by one, to estimates and what speaks against them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from pytracker._core import Estimate, InputError, Observation, Tracker
from pytracker.formats.video import Frame
from pytracker.live.subject import Subject
from pytracker.tracking.body_watch import Words, in_words

__all__ = ["FEW", "Estimated", "Following", "Live"]

SILENT_S = 10.0
"""No sensor is waited for longer."""
FEW = 5
"""Of what is left out so many are said one by one."""


@dataclass
class Live:
    """What happened so far.

    Attributes:
        frames: so many were tracked.
        invalid: of these so many with a reason against them.
        skipped: frames that came faster than they were worked on, and were left out.
        refused: observations that the tracker could not use, such as those that came too late.
        unread: lines of the sensor that were left out.
    """

    frames: int = 0
    invalid: int = 0
    skipped: int = 0
    refused: int = 0
    unread: int = 0


@dataclass(frozen=True, eq=False)
class Estimated:
    """An estimate as it comes.

    Attributes:
        estimate: where all is.
        frame: number of its frame.
        words: what speaks against each joint, `""` for the frame; of an arm for the frame alone.
            Each is empty where nothing does.
    """

    estimate: Estimate
    frame: int
    words: Words

    @property
    def reason(self) -> str:
        """All of these words; empty where nothing speaks against any of it."""
        return in_words({joint: why for joint, why in self.words.items() if why})


class Following:
    """A tracker that is given what arrives; an arm's frames count from its sensor's first sample on."""

    def __init__(self, subject: Subject, tracker: Tracker, counts: Live, warn: Callable[[str], None]) -> None:
        self._subject, self._tracker, self._counts, self._warn = subject, tracker, counts, warn
        self._is_waiting = subject.worn is not None
        self._frames: dict[float, int] = {}

    def take(self, found: Frame | Observation) -> Iterator[Estimated]:
        """An estimate where one is due."""
        if isinstance(found, Frame):
            observation = self._subject.see(found)
            if self._is_waiting:
                if found.time_s > SILENT_S:
                    raise InputError(f"no sample of the sensor came within {SILENT_S:.0f} s, expected its lines")
                return
            self._frames[found.time_s] = found.index
        else:
            observation, self._is_waiting = found, False
        try:
            estimate = self._tracker.observe(observation)
        except InputError as error:
            self._frames.pop(observation.time_s, None)
            self._refused(error)
            return
        if estimate is not None:
            yield self._told(estimate)

    def finish(self) -> Iterator[Estimated]:
        """What was still waited for."""
        if self._is_waiting:
            raise InputError("the camera ended before a sample of the sensor came, expected its lines")
        try:
            left = self._tracker.finish()
        except InputError as error:
            self._refused(error)
            return
        yield from map(self._told, left)

    def _told(self, estimate: Estimate) -> Estimated:
        found = Estimated(estimate, self._frames.pop(estimate.time_s), self._subject.words(estimate))
        self._counts.frames, self._counts.invalid = self._counts.frames + 1, self._counts.invalid + bool(found.reason)
        return found

    def _refused(self, error: InputError) -> None:
        self._counts.refused += 1
        if self._counts.refused <= FEW:
            self._warn(str(error))
