"""Both papers' tables and figures, run again: `reproduce("tao-hu", out)` and `reproduce("li-kulic", out)`.

What the papers filmed is simulated, every run is a run of a study (`out/study`, gone on with where it stopped), and
`out/index.html` shows our figures beside the numbers that the papers print.

| file | what |
|---|---|
| `tao_hu.py`, `li_kulic.py` | what is run |
| `..._page.py` | the page: summary, what differs in kind, the order of its sections |
| `..._tables.py`, `..._curves.py` | sections that are averaged from the study's table |
| `..._pictures.py` | sections that show single runs |
| `printed.py` | the papers' numbers |
| `words.py` | numbers and comparisons in words |
"""

from __future__ import annotations

from pytracker.reproduce.reproduce import PAPERS, SEEDS, reproduce

__all__ = ["PAPERS", "SEEDS", "reproduce"]
