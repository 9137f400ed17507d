"""Output files and folders appear whole or not at all: written beside, then renamed.

A folder that is written here holds a list of its files with their digests (`MADE_HERE`). Only what is on it, and is
still what was written, is ever deleted. A killed process leaves hidden folders; the next one that writes there sweeps
them.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pytracker._core import InputError
from pytracker.digest import sha256_of

__all__ = ["MADE_HERE", "PARTIAL", "check_target", "is_alive", "whole_file", "whole_folder", "write_whole"]

PARTIAL = ".partial"
"""How the name of a file ends that is not whole yet."""

MADE_HERE = ".made-by-pytracker"
"""Stands in every folder that is written here: which files were written, and their digests."""

ASIDE = "-aside"
"""Ends the name of an old result that is about to be replaced, where the file system cannot swap two folders."""


def check_target(target: Path, *, force: bool = False, is_recording: bool = False) -> Path:
    """`target` with links followed, if it may be written. Raises `InputError` before any work is done.

    An existing folder is replaced only with `force`, and only when it was made here, holds nothing that was not or that
    was changed since, and is no recording unless another one (`is_recording`) takes its place: a mistyped name must not
    cost anybody one.
    """
    try:
        target = target.resolve()
    except (OSError, RuntimeError) as error:
        raise InputError(f"{target}: cannot be followed to a folder: {error}") from None
    if blocked := next((parent for parent in target.parents if parent.is_file()), None):
        raise InputError(f"{target}: {blocked} is a file, expected a folder to write into")
    _sweep(target)
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
    if strange := _not_as_written(target):
        raise InputError(
            f"{target}: {strange[0]} was not written by pytracker, or was changed since ({len(strange)} such files), "
            "expected nothing but what was; it is not replaced"
        )
    return target


def _is_replaceable(folder: Path) -> bool:
    """Whether a folder inside may go with the one that holds it: made here, and no recording."""
    return (folder / MADE_HERE).is_file() and not (folder / "recording.toml").exists()


@contextmanager
def whole_folder(target: Path, *, force: bool = False, is_recording: bool = False) -> Iterator[Path]:
    """A new folder to write into, which becomes `target` when the block ends well.

    A killed run leaves nothing under the final name, or the old result whole. Raises `InputError` as `check_target`;
    where something has appeared under the final name meanwhile that may not be replaced, it stays, and the message
    says where the new result is.
    """
    target = check_target(target, force=force, is_recording=is_recording)
    target.parent.mkdir(parents=True, exist_ok=True)
    beside = Path(tempfile.mkdtemp(prefix=_hidden(target, os.getpid()), dir=target.parent))
    # mkdtemp makes it private; the result is as open as any folder made here.
    beside.chmod(0o755)
    try:
        (beside / MADE_HERE).touch()
        yield beside
        written = {path.relative_to(beside).as_posix(): sha256_of(path) for path in _files(beside)}
        (beside / MADE_HERE).write_text(json.dumps({"files": written}, indent=1) + "\n", "utf-8")
    except BaseException:
        shutil.rmtree(beside, ignore_errors=True)
        raise
    _publish(beside, target, force=force, is_recording=is_recording)


def _publish(beside: Path, target: Path, *, force: bool, is_recording: bool) -> None:
    """`beside` under its final name, the old one deleted after that. Raises `InputError`."""
    try:
        with contextlib.suppress(OSError):  # onto nothing, or a folder that is empty; onto nothing else
            beside.rename(target)
            return
        check_target(target, force=force, is_recording=is_recording)
    except InputError as error:
        kept = _free_name(target)
        beside.rename(kept)
        raise InputError(f"{error}. It appeared while this ran: the new result is in {kept}") from None
    if not target.exists():
        beside.rename(target)
        return
    if not _swapped(beside, target):
        aside = beside.with_name(beside.name + ASIDE)
        target.rename(aside)
        beside.rename(target)
        beside = aside
    _delete(beside, target)


def _delete(old: Path, target: Path) -> None:
    """What pytracker wrote of an old result; anything else is kept beside, under a name that is seen."""
    strange = set(_not_as_written(old))
    for path in _files(old):
        if path.relative_to(old).as_posix() not in strange:
            path.unlink()
    for folder in sorted((path for path in old.rglob("*") if path.is_dir()), reverse=True):
        with contextlib.suppress(OSError):
            folder.rmdir()
    (old / MADE_HERE).unlink(missing_ok=True)
    try:
        old.rmdir()
    except OSError:
        old.rename(_free_name(target))


def _files(folder: Path) -> list[Path]:
    """All files in it and below, but for its own mark."""
    return sorted(path for path in folder.rglob("*") if not path.is_dir() and path != folder / MADE_HERE)


def _not_as_written(folder: Path) -> list[str]:
    """Files that are not on the folder's list, or differ from what was written."""
    try:
        written = json.loads((folder / MADE_HERE).read_text("utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError):
        written = {}
    return [
        name
        for path in _files(folder)
        if (name := path.relative_to(folder).as_posix()) not in written
        or path.is_symlink()
        or sha256_of(path) != written[name]
    ]


def _free_name(target: Path) -> Path:
    """`target-1`, or the next number that is free."""
    number = 1
    while (found := target.with_name(f"{target.name}-{number}")).exists():
        number += 1
    return found


def _hidden(target: Path, pid: int | str) -> str:
    return f".{target.name}-{platform.node()}-{pid}-"


def _sweep(target: Path) -> None:
    """What killed processes left beside `target`: an old result is put back where there is none, the rest goes."""
    start = _hidden(target, "")[:-1]
    for left in target.parent.iterdir() if target.parent.is_dir() else ():
        pid = left.name.removeprefix(start).partition("-")[0]
        if not left.name.startswith(start) or is_alive(pid) or not left.is_dir():
            continue
        if left.name.endswith(ASIDE) and not target.exists():
            left.rename(target)
        elif (left / MADE_HERE).is_file() and (left / MADE_HERE).stat().st_size:
            _delete(left, target)  # an old result that was being deleted
        elif (left / MADE_HERE).is_file() or not any(left.iterdir()):
            shutil.rmtree(left, ignore_errors=True)  # a new one that was being written


def is_alive(pid: str) -> bool:
    """Whether a process of this machine is; where that cannot be asked, it is taken to be."""
    if sys.platform == "win32" or not pid.isdigit():
        return True
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


def _swapped(a: Path, b: Path) -> bool:
    """Swap the names of two folders at once; False where system or file system cannot."""
    try:
        libc = ctypes.CDLL(None, use_errno=True)
        ends = os.fsencode(a), os.fsencode(b)
        if sys.platform == "darwin":
            return bool(libc.renamex_np(*ends, 2) == 0)  # RENAME_SWAP
        here = -100  # AT_FDCWD; 2: RENAME_EXCHANGE
        return bool(libc.renameat2(here, ends[0], here, ends[1], 2) == 0)
    except (OSError, AttributeError, TypeError):
        return False


@contextmanager
def whole_file(path: Path, *, force: bool = True) -> Iterator[Path]:
    """A file to write, which becomes `path` when the block ends well.

    Raises `InputError` where `path` has appeared meanwhile, unless `force`.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}{PARTIAL}")
    try:
        yield partial
        if force:
            partial.replace(path)
        else:
            _place(partial, path)
    except FileExistsError:
        raise InputError(f"{path}: appeared while this ran, expected a new file; it is not replaced") from None
    finally:
        partial.unlink(missing_ok=True)


def _place(partial: Path, path: Path) -> None:
    """`partial` under its final name too, or `FileExistsError`: at once where the file system knows hard links."""
    try:
        path.hardlink_to(partial)
    except FileExistsError:
        raise
    except OSError:  # such as on a memory stick
        path.touch(exist_ok=False)
        partial.replace(path)


def write_whole(path: Path, text: str, *, force: bool = True) -> None:
    """A text file that is under its name only when it is whole. Raises `InputError` as `whole_file`."""
    with whole_file(path, force=force) as partial:
        partial.write_text(text, "utf-8", newline="")
