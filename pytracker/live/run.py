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

__all__ = ["Live", "live"]

WAITING = 2
"""Frames that wait; more are left out, as what is said late is of no use."""
SILENT_S = 10.0
"""No sensor is waited for longer."""


@dataclass
class Live:
    """What happened so far.

    Attributes:
        frames: so many were tracked.
        invalid: of these so many with a reason against them.
        skipped: frames that came faster than they were worked on, and were left out.
        refused: observations that the tracker could not use, such as those that came too late.
        words: what the first of them was refused for.
    """

    frames: int = 0
    invalid: int = 0
    skipped: int = 0
    refused: int = 0
    words: str = ""


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
) -> Generator[tuple[Estimate, str]]:
    """Estimates and what speaks against each (empty where nothing does), one a frame, until the camera ends.

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
        warn: is told of lines that cannot be read.

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

    coming = _Coming(counts)
    coming.read_camera(camera_frames(camera, clock, late_s))
    if subject.worn is not None and sensor is not None:
        coming.read_sensor(sensor_samples(sensor, subject.worn, clock, warn))
    try:
        for estimate in _estimates(coming, subject, tracker):
            reason = subject.reason(estimate)
            counts.frames, counts.invalid = counts.frames + 1, counts.invalid + bool(reason)
            yield estimate, reason
    finally:
        coming.close()


def _estimates(coming: _Coming, subject: Subject, tracker: Tracker) -> Iterator[Estimate]:
    """Of what arrives; an arm's frames count from its sensor's first sample on."""
    observation: Observation
    is_waiting = subject.worn is not None
    while (found := coming.arrived.get()) is not None:
        if isinstance(found, Exception):
            raise found
        if isinstance(found, Frame):
            coming.waiting.release()
            observation = subject.see(found)
            if is_waiting and found.time_s > SILENT_S:
                raise InputError(f"no sample of the sensor came within {SILENT_S:.0f} s, expected its lines")
        else:
            observation, is_waiting = found, False
        if is_waiting:
            continue
        try:
            estimate = tracker.observe(observation)
        except InputError as error:
            coming.live.refused += 1
            coming.live.words = coming.live.words or str(error)
            continue
        if estimate is not None:
            yield estimate
    yield from tracker.finish()
