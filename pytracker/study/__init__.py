"""Studies: recordings x methods x seeds to one tidy table, on threads or on a Dask cluster, resumable.

| file | what |
|---|---|
| `plan` | what is to be run: `Study`, and its runs with their keys |
| `file` | a study from a TOML file |
| `execute` | one run: recording, track, scores, a row a joint |
| `fingerprint` | what computes the numbers: another build runs everything again |
| `schedule` | many runs: on threads, on Dask |
| `store` | what is done, on disk; the table |
| `page` | the page: errors, bands, what is said |
| `study` | all of it |
"""

from __future__ import annotations

from pytracker.study.file import read_study
from pytracker.study.plan import Study, StudyRecording
from pytracker.study.store import StudyTable
from pytracker.study.study import run_study

__all__ = ["Study", "StudyRecording", "StudyTable", "read_study", "run_study"]
