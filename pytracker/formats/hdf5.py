"""HDF5 files, by h5py, which is an extra: opened, and told from what is none."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pytracker._core import InputError

__all__ = ["is_hdf5", "opened"]

HEAD = b"\x89HDF\r\n\x1a\n"
UNREADABLE = (
    *(OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError, IndexError, EOFError),
    *(MemoryError, OverflowError, pickle.UnpicklingError),
)
"""What h5py, and pickle within it, raise for bytes, groups and types that are not as they should be."""


def is_hdf5(path: Path) -> bool:
    """Whether it begins as such files do."""
    try:
        with path.open("rb") as file:
            return file.read(len(HEAD)) == HEAD
    except OSError:
        return False


@contextmanager
def opened(path: Path, expected: str) -> Iterator[Any]:
    """The file, to be read within; `expected` says what it should be.

    Raises `InputError` without h5py, and for whatever it cannot read.
    """
    try:
        import h5py  # noqa: PLC0415 - an extra
    except ImportError:
        raise InputError(f"{path}: reading HDF5 needs h5py: pip install h5py") from None
    try:
        with h5py.File(path, "r") as file:
            yield file
    except InputError:
        raise
    except UNREADABLE as error:
        raise InputError(f"{path}: is no {expected} that can be read: {str(error)[:200]}") from None
