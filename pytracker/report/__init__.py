"""What a run leaves behind: `write_report` makes a folder of CSV, JSON, figures, overlay video and one HTML page.

| in the folder | what |
|---|---|
| `track.csv` (`track-<n>-<method>.csv` where there are several) | one row a frame, see `tables` |
| `metadata.json` | version, methods with every parameter, seeds, files with hashes, machine, run time |
| `scores.json` | where the recording has truth |
| `overlay.webm` | the video with what was tracked drawn over it |
| `index.html` | one page that a clinician can print |

| file | what |
|---|---|
| `write` | all of it, whole or not at all; `files` what other programs read, `export` among them |
| `page`, `kinds` | `index.html`, and what it is made by, kind of recording by kind: `arm`, `body` |
| `contents`, `labels`, `stretches` | tracks with scores and doubts; what they are called; frames that are not valid |
| `drawing`, `overlay` | what all figures, and all videos, share |
| `cycles` | clouds of particles |
| `index`, `study`, `check_page`, `board` | other pages: of the demo, of a study, of a check, a board to print |
"""

from __future__ import annotations

from pytracker.report.files.export import export
from pytracker.report.write import write_report

__all__ = ["export", "write_report"]
