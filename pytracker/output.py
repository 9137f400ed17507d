"""Output folders appear whole or not at all: written beside, then renamed."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pytracker._core import InputError

__all__ = ["whole_folder"]


@contextmanager
def whole_folder(target: Path, *, force: bool = False) -> Iterator[Path]:
    """A new folder to write into, which becomes `target` when the block ends well.

    A killed run leaves nothing under the final name. Raises `InputError` where `target` exists, unless `force`; it
    is then replaced at the end.
    """
    target = target.absolute()
    if target.exists() and not force:
        raise InputError(f"{target}: already exists, expected a new folder (or --force to replace it)")
    if target.exists() and not target.is_dir():
        raise InputError(f"{target}: is a file, expected a folder")
    target.parent.mkdir(parents=True, exist_ok=True)
    beside = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    # mkdtemp makes it private; the result is as open as any folder made here.
    beside.chmod(0o755)
    try:
        yield beside
        if target.exists():
            old = Path(tempfile.mkdtemp(prefix=f".{target.name}-old-", dir=target.parent))
            target.rename(old / target.name)
            beside.rename(target)
            shutil.rmtree(old)
        else:
            beside.rename(target)
    except BaseException:
        shutil.rmtree(beside, ignore_errors=True)
        raise
