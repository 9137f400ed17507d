"""What a recording says against its own description, asked once it was tracked.

| file | what |
|---|---|
| `doubts` | of any track: `arm`, `body` by its kind; which frames are not believed |
| `description` | an arm's description against others, `suspects`, each tried by a filter; at its end, too |
| `clocks`, `pauses` | whether clocks go together, and frames are missing |
| `patch_place`, `camera_place` | whether patch and camera are where they are said to be |
| `upper_arm`, `body_sensors`, `swivel` | whether sensors point where an arm is, and elbows hang |
| `foreground` | of a body: whether pose and person are in one place, and the person is told from the rest |
"""

from __future__ import annotations

from pytracker.doubting.doubts import doubts, is_unusable, unbelieved

__all__ = ["doubts", "is_unusable", "unbelieved"]
