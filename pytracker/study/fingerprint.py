"""What computes the numbers of a study: another build may give others."""

from __future__ import annotations

import functools
import hashlib
from importlib.metadata import version
from pathlib import Path

import numpy as np

from pytracker._core import __version__
from pytracker.digest import sha256_of
from pytracker.formats.video import OPENCV

__all__ = ["fingerprint"]

NO_NUMBERS = ("report", "reproduce", "cli", "live", "__main__.py")
"""Parts of the package that change no result."""


@functools.cache
def fingerprint() -> str:
    """Of every file of the package that has a part in the numbers, and of NumPy, OpenCV and VQF."""
    root = Path(__file__).parents[1]
    found = hashlib.sha256(f"{__version__} {np.__version__} {OPENCV} {version('vqf')}".encode())
    for path in sorted([*root.rglob("*.py"), *root.glob("_core*")]):
        name = path.relative_to(root)
        if name.parts[0] not in NO_NUMBERS and path.suffix in (".py", ".so", ".pyd", ".dylib"):
            found.update(f"{name.as_posix()} {sha256_of(path)}\n".encode())
    return found.hexdigest()
