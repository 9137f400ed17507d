"""What a run leaves behind: `write_report` makes a folder of CSV, JSON, figures, overlay video and one HTML page.

| in the folder | what |
|---|---|
| `track.csv` (`track-<n>-<method>.csv` where there are several) | one row a frame, see `tables` |
| `metadata.json` | version, methods with every parameter, seeds, files with hashes, machine, run time |
| `scores.json` | where the recording has truth |
| `overlay.webm` | the video with what was tracked drawn over it |
| `index.html` | one page that a clinician can print |

`export` writes a track's joints for other programs.
"""

from __future__ import annotations

from pytracker.report.export import export
from pytracker.report.write import write_report

__all__ = ["export", "write_report"]
