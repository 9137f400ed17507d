"""Estimates as frames come: a camera and a sensor read in threads of their own, their observations tracked in this."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator

from pytracker._core import InputError, Observation, Tracker
from pytracker.formats.video import Frame
from pytracker.live.camera import camera_frames
from pytracker.live.following import FEW, Estimated, Following, Live
from pytracker.live.sensor import sensor_samples
from pytracker.live.subject import live_subject
from pytracker.methods.method import Method
from pytracker.recording.recording import Recording

__all__ = ["live"]

WAITING = 2
"""Frames that wait; more are left out, as what is said late is of no use."""


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
    following = Following(subject, tracker, counts, warn)
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
