"""`write_report(tracks, folder)`: everything of a run, whole or not at all."""

from __future__ import annotations

import re
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event

from pytracker.evidence.sightings import Progress
from pytracker.output import whole_folder
from pytracker.report.contents import Contents, contents_of
from pytracker.report.files.metadata import write_metadata
from pytracker.report.files.tables import write_motion, write_scores, write_track
from pytracker.report.labels import HELD
from pytracker.tracking.tracks import Track

__all__ = ["write_report"]


def write_report(
    tracks: Sequence[Track],
    folder: Path | str,
    *,
    force: bool = False,
    page: bool = True,
    progress: Progress | None = None,
) -> Path:
    """Write tables, overlay and page of `tracks` (of one recording, the one to look at first) into `folder`.

    Without `page` only the tables. Returns the folder. Raises `InputError` for no tracks, tracks of different
    recordings, or a folder that exists, unless `force`.
    """
    contents = contents_of(tracks)
    with whole_folder(Path(folder), force=force) as out:
        for number, track in enumerate(tracks):
            name = _track_name(number, track, len(tracks))
            write_track(out / name, track)
            write_motion(track, (out / name).with_suffix(".amc"))
        write_metadata(out / "metadata.json", contents)
        if any(contents.scores):
            write_scores(out / "scores.json", [*contents.scores, contents.trivial], [*contents.labels, HELD])
        if page:
            _write_page(out, contents, progress)
    return Path(folder)


def _track_name(number: int, track: Track, count: int) -> str:
    return "track.csv" if count == 1 else f"track-{number + 1}-{re.sub('[^a-z]+', '-', track.method.name)}.csv"


def _write_page(out: Path, contents: Contents, progress: Progress | None) -> None:
    if progress is not None:
        progress("report", 0)
    from pytracker.report.kinds import PAGES  # noqa: PLC0415 - Matplotlib is slow

    main = contents.tracks[0]
    page = PAGES[main.recording.kind]
    # The encoder releases the interpreter: the figures are drawn beside it. Whoever leaves early does not wait for it.
    stop = Event()
    with ThreadPoolExecutor(1) as pool:
        try:
            overlay = pool.submit(page.write_overlay, out / "overlay.webm", main, stop)
            text = page.render(contents.tracks, contents, has_overlay=main.recording.video is not None)
            (out / "index.html").write_text(text, "utf-8")
            overlay.result()
        except BaseException:
            stop.set()
            raise
