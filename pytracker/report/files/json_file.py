"""JSON as every reader takes it: without NaN, in UTF-8."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

__all__ = ["plain", "write_json"]


def write_json(path: Path, value: Any) -> None:
    """A value to a file, over what was there."""
    path.write_text(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")


def plain(value: Any) -> Any:
    """As JSON can hold it, which has no NaN: what is no number is null."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
