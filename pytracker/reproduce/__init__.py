"""Both papers' tables and figures, run again: `reproduce("tao-hu", out)` and `reproduce("li-kulic", out)`.

What the papers filmed is simulated, every run is a run of a study (`out/study`, gone on with where it stopped), and
`out/index.html` shows our figures beside the numbers that the papers print.

| file | what |
|---|---|
| `tao_hu`, `li_kulic` | what is run |
| `tao_hu_page`, `li_kulic_page` | the page: summary, what differs in kind, the order of its sections |
| `tao_hu_tables`, `li_kulic_curves` | sections that are averaged from the study's table |
| `tao_hu_pictures`, `li_kulic_pictures` | sections that show single runs |
| `printed` | the papers' numbers |
| `words`, `endings` | numbers and comparisons in words; runs that did not end well |
| `reproduce` | all of it |
"""

from __future__ import annotations

from pytracker.reproduce.reproduce import PAPERS, SEEDS, reproduce

__all__ = ["PAPERS", "SEEDS", "reproduce"]
