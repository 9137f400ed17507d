"""What a report is made of: tracks, their scores and doubts. Pages and tables are made of this and run nothing.

Doubts that nobody asked a track for before are found here: an arm's recording is tracked again for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytracker._core import InputError
from pytracker.recording.recording import Truth
from pytracker.report.labels import labels
from pytracker.scores.agreement import against_truth
from pytracker.scores.evaluate import Scored, Scores, evaluate, held
from pytracker.tracking.tracks import Track

__all__ = ["Contents", "contents_of"]


@dataclass(frozen=True)
class Contents:
    """Tracks of one recording, the one to look at first.

    Attributes:
        tracks: the tracks.
        labels: what to call each.
        scores: of each; None where there is no truth, or none that covers the frames.
        trivial: of the first pose, held; likewise.
        doubts: what speaks against each, in words.
    """

    tracks: Sequence[Track]
    labels: Sequence[str]
    scores: Sequence[Scores | None]
    trivial: Scores | None
    doubts: Sequence[tuple[str, ...]]

    @property
    def doubts_of_others(self) -> list[tuple[str, str]]:
        """Label and words of what speaks against other tracks than the first, and not against that one."""
        others = zip(self.labels[1:], self.doubts[1:], strict=True)
        return [(label, words) for label, said in others for words in said if words not in self.doubts[0]]


def contents_of(tracks: Sequence[Track]) -> Contents:
    """Of these tracks. Raises `InputError` for none, or for several recordings'."""
    if isinstance(tracks, Track):
        raise InputError("write_report was given a track, expected a list of them: [track]")
    if not tracks:
        raise InputError("write_report was given no track, expected at least one")
    recording = tracks[0].recording
    if any(track.recording is not recording for track in tracks):
        raise InputError("write_report was given tracks of different recordings, expected one recording")
    return Contents(
        tracks=tracks,
        labels=labels(tracks),
        scores=[_scores(track, recording.truth) for track in tracks],
        trivial=_scores(held(tracks[0]), recording.truth),
        doubts=[(*track.doubts, *against_truth(track, recording.truth)) for track in tracks],
    )


def _scores(track: Scored, truth: Truth | None) -> Scores | None:
    """None where there is no truth to compare with: the track is worth keeping all the same."""
    try:
        return evaluate(track, truth)
    except InputError:
        return None
