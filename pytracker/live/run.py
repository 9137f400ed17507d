"""Estimates as frames come: a camera and a sensor read in threads of their own, their observations tracked in this."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass

from pytracker._core import Estimate, InputError, Observation, Tracker
from pytracker.formats.video import Frame
from pytracker.live.camera import camera_frames
from pytracker.live.sensor import sensor_samples
from pytracker.live.subject import Subject, live_subject
from pytracker.methods.method import Method
from pytracker.recording.recording import Recording
from pytracker.tracking.body_watch import Words

__all__ = ["Estimated", "Live", "live"]

WAITING = 2
"""Frames that wait; more are left out, as what is said late is of no use."""
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
        words: what speaks against each joint, `""` for the frame; of an arm for the frame alone. Empty where nothing
            does.
    """

    estimate: Estimate
    frame: int
    words: Words

    @property
    def is_valid(self) -> bool:
        """Whether nothing speaks against any of it."""
        return not any(self.words.values())


class _Coming:
    """What arrives, in order of arrival; None at the end of the camera.

    Each source is read in a thread of its own. A sensor's may wait for a line for ever; the camera's is waited for, as
    OpenCV does not bear that its thread ends with the program.
    """

    def __init__(self, live: Live) -> None:
        self.live = live
        self.waiting = threading.Semaphore(WAITING)
        self.arrived: queue.SimpleQueue[Frame | Observation | Exception | None] = queue.SimpleQueue()
        self._is_over = threading.Event()
        self._camera: threading.Thread | None = None

    def read_camera(self, frames: Iterator[Frame]) -> None:
        """Until it ends, or this is over."""
        self._camera = threading.Thread(target=self._read, args=(self._of_camera(frames),))
        self._camera.start()

    def read_sensor(self, samples: Iterator[Observation]) -> None:
        """As long as there are some."""
        threading.Thread(target=self._read, args=(samples,), daemon=True).start()

    def close(self) -> None:
        """The camera is let go."""
        self._is_over.set()
        if self._camera is not None:
            self._camera.join()

    def _of_camera(self, frames: Iterator[Frame]) -> Iterator[Frame | None]:
        for frame in frames:
            if self._is_over.is_set():
                return
            if self.waiting.acquire(blocking=False):
                yield frame
            else:
                self.live.skipped += 1
        yield None

    def _read(self, source: Iterator[Frame | Observation | None]) -> None:
        try:
            for found in source:
                self.arrived.put(found)
        except Exception as error:
            self.arrived.put(error)  # raised where it is taken


def live(
    recording: Recording,
    method: Method,
    camera: str,
    sensor: Iterable[str] | None = None,
    *,
    seed: int = 0,
    delay_s: float = 0.1,
    late_s: float = 0.0,
    progress: Live | None = None,
    warn: Callable[[str], None] = print,
) -> Generator[Estimated]:
    """Estimates, one a frame, until the camera ends.

    Args:
        recording: made with this camera where it stands now, this sensor as it is worn now, and this person, who now
            begins as in its first frame.
        method: one that filters.
        camera: its number, address, or a video that is played at its own pace.
        sensor: an arm's: lines as they come (`pytracker.live.sensor`).
        seed: of the random streams.
        delay_s: what comes so much later than what was observed after it is put in order; estimates come as much later.
        late_s: how long after it was seen a frame arrives.
        progress: counts while it goes on.
        warn: is told of what is left out, the first few times.

    Raises `InputError` for what cannot be followed live, and `TrackingError` where the track is lost.
    """
    if getattr(method, "filter", "") == "smoother":
        raise InputError("a method that smooths needs the whole recording, expected one that filters, such as mixture")
    subject = live_subject(recording, method)
    if subject.worn is not None and sensor is None:
        raise InputError("an arm is followed live by its sensor too, expected its lines")
    counts, began_s = progress or Live(), time.monotonic()
    tracker = Tracker(subject.recording, method.known_by(subject.recording.spreads), seed, delay_s)

    def clock() -> float:
        return time.monotonic() - began_s

    def unread(words: str) -> None:
        counts.unread += 1
        if counts.unread <= FEW:
            warn(words)

    coming = _Coming(counts)
    coming.read_camera(camera_frames(camera, clock, late_s))
    if subject.worn is not None and sensor is not None:
        coming.read_sensor(sensor_samples(sensor, subject.worn, clock, unread))
    following = _Following(subject, tracker, counts, warn)
    try:
        while (found := coming.arrived.get()) is not None:
            if isinstance(found, Exception):
                raise found
            if isinstance(found, Frame):
                coming.waiting.release()
            yield from following.take(found)
        yield from following.finish()
    finally:
        coming.close()


class _Following:
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
        self._counts.frames, self._counts.invalid = self._counts.frames + 1, self._counts.invalid + (not found.is_valid)
        return found

    def _refused(self, error: InputError) -> None:
        self._counts.refused += 1
        if self._counts.refused <= FEW:
            self._warn(str(error))
