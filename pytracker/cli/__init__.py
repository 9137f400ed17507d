"""The `pytracker` command: a thin face over the Python calls.

| file | what |
|---|---|
| `options` | what several commands share |
| `settings` | `--method` and `--set` |
| `parameters` | what `--help` says of them |
| `tracking` | `demo`, `track`, `report`, `inspect` |
| `live` | `live` |
| `results` | `evaluate`, `export` |
| `setting_up` | `init`, `keypoints`, `check` |
| `calibrating` | `board`, `calibrate camera`, `calibrate pose`, `calibrate level`, `calibrate export` |
| `studies` | `study`, `reproduce` |
| `recordings` | `simulate`, `frame` |
| `terminal` | progress bars and tables |
| `entry` | the application; signals, errors, exit status |
"""

from pytracker.cli.entry import main

__all__ = ["main"]
