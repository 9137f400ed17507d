"""Both papers' tables and figures, run again: `reproduce("tao-hu", out)` and `reproduce("li-kulic", out)`.

What the papers filmed is simulated, every run is a run of a study (`out/study`, gone on with where it stopped), and
`out/index.html` shows our figures beside the numbers that the papers print.
"""

from __future__ import annotations

from pytracker.reproduce.reproduce import PAPERS, SEEDS, reproduce

__all__ = ["PAPERS", "SEEDS", "reproduce"]
