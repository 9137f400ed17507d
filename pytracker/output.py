"""Output files and folders appear whole or not at all: written beside, then renamed."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pytracker._core import InputError

__all__ = ["MADE_HERE", "PARTIAL", "check_target", "whole_folder", "write_whole"]

PARTIAL = ".partial"
"""How the name of a file ends that is not whole yet."""

MADE_HERE = ".made-by-pytracker"
"""Stands in every folder that is written here; only such a folder is ever replaced."""


def check_target(target: Path, *, force: bool = False, is_recording: bool = False) -> Path:
    """`target` with links followed, if it may be written. Raises `InputError` before any work is done.

    An existing folder is replaced only with `force`, and only when it was made here, holds no folder that was not,
    and is no recording unless another one (`is_recording`) takes its place: a mistyped name must not cost anybody one.
    """
    target = target.resolve()
    if not target.exists():
        return target
    if not force:
        raise InputError(f"{target}: already exists, expected a new folder (or --force to replace it)")
    if not target.is_dir():
        raise InputError(f"{target}: is a file, expected a folder")
    inside = list(target.iterdir())
    if inside and not (target / MADE_HERE).is_file():
        raise InputError(f"{target}: was not written by pytracker, expected a folder that was; it is not replaced")
    if (target / "recording.toml").exists() and not is_recording:
        raise InputError(f"{target}: holds a recording (recording.toml), expected another folder; it is not replaced")
    if any(path.is_dir() and not _is_replaceable(path) for path in inside) or target in (
        Path.cwd(),
        *Path.cwd().parents,
    ):
        raise InputError(f"{target}: holds other folders or is the current one; it is not replaced")
    return target


def _is_replaceable(folder: Path) -> bool:
    """Whether a folder inside may go with the one that holds it: made here, and no recording."""
    return (folder / MADE_HERE).is_file() and not (folder / "recording.toml").exists()


@contextmanager
def whole_folder(target: Path, *, force: bool = False, is_recording: bool = False) -> Iterator[Path]:
    """A new folder to write into, which becomes `target` when the block ends well.

    A killed run leaves nothing under the final name. Raises `InputError` as `check_target`.
    """
    target = check_target(target, force=force, is_recording=is_recording)
    target.parent.mkdir(parents=True, exist_ok=True)
    beside = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    # mkdtemp makes it private; the result is as open as any folder made here.
    beside.chmod(0o755)
    try:
        (beside / MADE_HERE).touch()
        yield beside
        if target.exists():
            shutil.rmtree(target)
        beside.rename(target)
    except BaseException:
        shutil.rmtree(beside, ignore_errors=True)
        raise


def write_whole(path: Path, text: str) -> None:
    """A text file that is under its name only when it is whole."""
    partial = path.with_name(f"{path.name}.{os.getpid()}{PARTIAL}")
    partial.write_text(text, "utf-8", newline="")
    partial.replace(path)
